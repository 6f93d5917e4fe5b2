"""One of a stage's two kinds of tooth contact as data, for all planets or for each."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Self

from pydantic import model_validator

from crosscheck.models.arm import quantities
from crosscheck.models.arm.quantities import Data, PerPlanet
from crosscheck.models.arm.stiffness import StiffnessLaw

FROM_TEETH = "from-teeth"


@dataclass(frozen=True)
class PlanetMesh:
    """One planet's tooth contact with sun or ring: that of ``Mesh``, a single number each.

    phase_rad: None where the teeth say it.
    """

    stiffness: StiffnessLaw
    backlash_m: float
    tooth_error_m: float
    tooth_error_phase_rad: float
    static_error_m: float
    phase_rad: float | None
    damping_ratio: float | None
    damping_N_s_per_m: float | None
    tanh_sharpness_per_m: float


class Mesh(Data):
    """One of a stage's two kinds of tooth contact: equal for every planet, or a list of each.

    The phase is added to that of the mesh's sines. Damping counts all N planets together:
    directly, or as the ratio zeta of 2 zeta sqrt(N k M), k the mean stiffness and M the equivalent
    mass of the sun, or that of all planets for the ring mesh; in a list, each planet damps an N-th.
    """

    stiffness: PerPlanet[StiffnessLaw]
    """k of one planet's contact."""
    backlash_m: PerPlanet[quantities.Play]
    """b, half the clearance along the line of action."""
    tooth_error_m: PerPlanet[quantities.Play]
    """E of the tooth profile error, a wave E sin(phase + tooth_error_phase_rad)."""
    tooth_error_phase_rad: PerPlanet[quantities.Phase] = 0.0
    """Added to the phase of the tooth error alone."""
    static_error_m: PerPlanet[quantities.Offset] = 0.0
    """Constant part of e: a planet out of its place."""
    phase_rad: quantities.Phases = 0.0
    """Added to the phase; from-teeth takes the planets' places and teeth."""
    damping_ratio: PerPlanet[quantities.DampingRatio] | None = None
    """zeta of d = 2 zeta sqrt(N k M); this or damping_N_s_per_m."""
    damping_N_s_per_m: PerPlanet[quantities.Damping] | None = None
    """d of all N planets together; this or damping_ratio."""
    tanh_sharpness_per_m: quantities.Sharpness = 1e8
    """Sharpness of Eq. 6's corners, for switches.dead_zone=tanh."""

    def planet_mesh(self, place: int) -> PlanetMesh:
        """Tooth contact of a planet, counted from 0; damping is that of N such planets."""
        return _build_planet_mesh(self, place)

    @model_validator(mode="after")
    def _check_damping(self) -> Self:
        if (self.damping_ratio is None) == (self.damping_N_s_per_m is None):
            raise ValueError("damping_ratio|give either this or the damping itself, in N s/m")
        return self


@lru_cache(maxsize=256)
def _build_planet_mesh(mesh: Mesh, place: int) -> PlanetMesh:
    fields = vars(mesh).items()  # a fifth of the time that a record takes to give them
    values = {name: value[place] if isinstance(value, tuple) else value for name, value in fields}
    if values["phase_rad"] == FROM_TEETH:
        values["phase_rad"] = None
    return PlanetMesh(**values)
