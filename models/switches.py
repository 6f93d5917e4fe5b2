"""The four switches of the gear model: choices of law, not numbers of an arm."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import model_validator

from models.quantities import Data


class Switches(Data):
    """Which law each model follows.

    phase: ``omega_t`` takes the mesh phase as current mesh frequency times time (Eqs. 8, 14 with
    12, 13), ``angle`` as its integral, proportional to the joint angle.
    ring_rate: meshing frequency of the ring mesh, ``eq13`` as printed or ``corrected`` (equal to
    the sun mesh's). Default: ``eq13`` with ``omega_t``, ``corrected`` with ``angle``.
    dead_zone: ``exact`` (Eq. 5) or ``tanh`` (Eq. 6).
    damping: ``always``, or ``contact`` (none while the teeth are apart).
    """

    phase: Literal["angle", "omega_t"] = "angle"
    ring_rate: Literal["eq13", "corrected"]
    dead_zone: Literal["exact", "tanh"] = "exact"
    damping: Literal["always", "contact"] = "always"

    @model_validator(mode="before")
    @classmethod
    def _ring_rate_follows_phase(cls, data: Any) -> Any:
        if isinstance(data, dict) and data.get("ring_rate") is None:
            rate = "eq13" if data.get("phase") == "omega_t" else "corrected"
            return {**data, "ring_rate": rate}
        return data


def switches(**chosen: str) -> Switches:
    """Switches with the given choices, the rest at their defaults.

    Raises pydantic.ValidationError for an unknown switch or value.
    """
    return Switches.model_validate(chosen)
