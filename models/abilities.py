"""Names of what every model of an arm can say of a state."""

from __future__ import annotations

STATE_ABILITIES = ("mass_matrix", "bias", "generalized_force", "acceleration")
