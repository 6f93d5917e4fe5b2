"""Names of what every model can say of a state, of an arm and of a robot."""

from __future__ import annotations

STATE_ABILITIES = ("mass_matrix", "bias", "generalized_force", "acceleration")
ROBOT_ABILITIES = frozenset(
    (
        *("mass_matrix", "bias", "gravity", "inverse_dynamics", "forward_dynamics"),
        *("energy", "momentum", "tip"),
    )
)
