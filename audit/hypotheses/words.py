"""What the hypotheses' tables and drawings call things."""

from __future__ import annotations

from crosscheck.audit.hypotheses.evidence.rungs import (
    BACKLASH,
    CARRIED,
    CLOCK,
    COMPLIANCE,
    COUPLING,
    DIAGONAL,
    ERROR,
    INERTIA,
    MASSES,
    MESHES,
    SLIPPED,
    SLIPS,
    STIFFNESS,
)

SYMBOLS = {"theta_1": "θ₁", "theta_2": "θ₂", "tip": "tip"}
LEVELS = {
    "links": "links, payload",
    "carriers": "links, payload, joint masses",
    "armature": "these, reflected inertia",
    "coupled": "these, its coupling",
}
RUNGS = {
    MASSES: "joint masses and carriers",
    DIAGONAL: "reflected inertia, diagonal",
    COUPLING: "rotor spin coupled with base rotation",
    COMPLIANCE: "mesh compliance and damping",
    BACKLASH: "backlash",
    STIFFNESS: "stiffness variation",
    ERROR: "tooth error",
    SLIPS: "errors of the printed matrices",
    CLOCK: "the paper's phase law",
}
GROUPS = {
    CARRIED: "joint masses",
    INERTIA: "reflected inertia",
    MESHES: "the meshes",
    SLIPPED: "printed matrices",
}
SCENARIOS = {"constant-torque": "100 N m on both joints, 0.5 s", "pd": "PD 1000/400 to 30°, 3 s"}
