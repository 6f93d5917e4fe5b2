"""What the hypotheses' tables and drawings call things."""

from __future__ import annotations

from crosscheck.audit.hypotheses.evidence import rungs

SYMBOLS = {"theta_1": "θ₁", "theta_2": "θ₂", "tip": "tip"}
LEVELS = {
    "links": "links, payload",
    "carriers": "links, payload, joint masses",
    "armature": "these, reflected inertia",
    "coupled": "these, its coupling",
}
RUNGS = {
    rungs.MASSES: "joint masses and carriers",
    rungs.DIAGONAL: "reflected inertia, diagonal",
    rungs.COUPLING: "rotor spin coupled with base rotation",
    rungs.COMPLIANCE: "mesh compliance and damping",
    rungs.BACKLASH: "backlash",
    rungs.STIFFNESS: "stiffness variation",
    rungs.ERROR: "tooth error",
    rungs.SLIPS: "errors of the printed matrices",
    rungs.CLOCK: "the paper's phase law",
}
GROUPS = {
    rungs.CARRIED: "joint masses",
    rungs.INERTIA: "reflected inertia",
    rungs.MESHES: "the meshes",
    rungs.SLIPPED: "printed matrices",
}
SCENARIOS = {"constant-torque": "100 N m on both joints, 0.5 s", "pd": "PD 1000/400 to 30°, 3 s"}
