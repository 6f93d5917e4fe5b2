"""The switches of the gear model: choices of law, not numbers of an arm."""

from __future__ import annotations

from typing import Any, Literal, Self

from pydantic import model_validator

from crosscheck.models.arm.quantities import Data


class Switches(Data):
    """Which law each model follows.

    phase: ``omega_t`` takes the mesh phase as current mesh frequency times time (Eqs. 8, 14 with
    12, 13), ``angle`` as its integral, proportional to the joint angle.
    ring_rate: meshing frequency of the ring mesh, ``eq13`` as printed or ``corrected`` (equal to
    the sun mesh's). Default: ``eq13`` with ``omega_t``, ``corrected`` with ``angle``.
    dead_zone: ``exact`` (Eq. 5) or ``tanh`` (Eq. 6).
    damping: ``always``, or ``contact`` (none while the teeth are apart).
    planets: ``lumped``, all planets of a stage one coordinate x_sp and x_pr as in the paper, or
    ``free``, a coordinate for each. An arm whose planets differ can only be free.
    mesh_work: ``paper``, or ``conservative``: the potential of teeth whose stiffness and error vary
    with an angle does work on that angle too.
    """

    phase: Literal["angle", "omega_t"] = "angle"
    ring_rate: Literal["eq13", "corrected"]
    dead_zone: Literal["exact", "tanh"] = "exact"
    damping: Literal["always", "contact"] = "always"
    planets: Literal["lumped", "free"] = "lumped"
    mesh_work: Literal["paper", "conservative"] = "paper"

    @model_validator(mode="before")
    @classmethod
    def _ring_rate_follows_phase(cls, data: Any) -> Any:
        if isinstance(data, dict) and data.get("ring_rate") is None:
            rate = "eq13" if data.get("phase") == "omega_t" else "corrected"
            return {**data, "ring_rate": rate}
        return data

    @model_validator(mode="after")
    def _teeth_have_a_potential(self) -> Self:
        if self.mesh_work == "conservative" and self.phase == "omega_t":
            raise ValueError(
                "mesh_work|conservative needs phase = angle: by omega_t the stiffness hangs on time"
                " and speed, and no potential stands behind it"
            )
        if self.mesh_work == "conservative" and self.dead_zone == "tanh":
            raise ValueError(
                "mesh_work|conservative needs dead_zone = exact: the force of Eq. 6 is not the"
                " slope of k f^2 / 2"
            )
        return self


def switches(**chosen: str) -> Switches:
    """Switches with the given choices, the rest at their defaults.

    Raises pydantic.ValidationError for an unknown switch or value.
    """
    return Switches.model_validate(chosen)
