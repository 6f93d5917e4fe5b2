"""What the hypotheses' tables and drawings call things."""

from __future__ import annotations

from crosscheck.audit.hypotheses.evidence import level_ablation

SYMBOLS = {"theta_1": "θ₁", "theta_2": "θ₂", "tip": "tip"}
LEVELS = {
    "links": "links, payload",
    "carriers": "links, payload, joint masses",
    "armature": "these, reflected inertia",
    "coupled": "these, its coupling",
}
MODEL_CHANGES = {
    level_ablation.MASSES: "joint masses and carriers",
    level_ablation.DIAGONAL: "reflected inertia, diagonal",
    level_ablation.COUPLING: "rotor spin coupled with base rotation",
    level_ablation.COMPLIANCE: "mesh compliance and damping",
    level_ablation.BACKLASH: "backlash",
    level_ablation.STIFFNESS: "stiffness variation",
    level_ablation.ERROR: "tooth error",
    level_ablation.SLIPS: "errors of the printed matrices",
    level_ablation.CLOCK: "the paper's phase law",
}
GROUPS = {
    level_ablation.CARRIED: "joint masses",
    level_ablation.INERTIA: "reflected inertia",
    level_ablation.MESHES: "the meshes",
    level_ablation.SLIPPED: "printed matrices",
}
SCENARIOS = {"constant-torque": "100 N m on both joints, 0.5 s", "pd": "PD 1000/400 to 30°, 3 s"}
