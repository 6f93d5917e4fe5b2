"""Sun, planets and ring of one stage as data, of an arm's joint and of a robot's."""

from __future__ import annotations

import math
from typing import Literal, Self

from pydantic import model_validator

from crosscheck.models.arm import quantities
from crosscheck.models.arm.mesh import Mesh
from crosscheck.models.arm.quantities import Data, format_number

LARGEST_RING_M = 50.0
PHASE_TOLERANCE = 1e-3  # cycles that given phases of planets may be off what their teeth say


class PlanetaryGears(Data):
    """Teeth and spins of a 2K-H stage."""

    kind: Literal["planetary"]
    """Which sort of joint this is."""
    sun_teeth: quantities.ToothCount
    """Teeth of the sun."""
    planet_teeth: quantities.ToothCount
    """Teeth of each planet."""
    ring_teeth: quantities.ToothCount
    """Teeth of the ring: sun_teeth + 2 planet_teeth."""
    planet_count: quantities.PlanetCount = 3
    """N; it divides sun_teeth + ring_teeth."""
    module_m: quantities.Module
    """Pitch diameter of a gear over its teeth."""
    pressure_angle_deg: quantities.PressureAngle
    """Angle of the line of action to the pitch circles' common tangent."""
    sun_equivalent_mass_kg: quantities.GearMass | None = None
    """Its J / r^2, or sun_inertia_kg_m2."""
    sun_inertia_kg_m2: quantities.GearInertia | None = None
    """J of the sun and the motor's rotor."""
    planet_equivalent_mass_kg: quantities.GearMass | None = None
    """J / r^2 of one planet, or planet_inertia_kg_m2."""
    planet_inertia_kg_m2: quantities.GearInertia | None = None
    """J of one planet about its own axis."""

    @model_validator(mode="after")
    def _check_inertia_forms(self) -> Self:
        for part in ("sun", "planet"):
            mass, inertia = f"{part}_equivalent_mass_kg", f"{part}_inertia_kg_m2"
            if (getattr(self, mass) is None) == (getattr(self, inertia) is None):
                raise ValueError(f"{mass}|give either {mass} or {inertia}")
        return self

    @model_validator(mode="after")
    def _check_assembly(self) -> Self:
        expected = self.sun_teeth + 2 * self.planet_teeth
        if self.ring_teeth != expected:
            raise ValueError(f"ring_teeth|must be sun_teeth + 2 planet_teeth = {expected}")
        if (self.sun_teeth + self.ring_teeth) % self.planet_count:
            raise ValueError(
                "planet_count|must divide sun_teeth + ring_teeth ="
                f" {self.sun_teeth + self.ring_teeth} for equally spaced planets"
            )
        spacing = (self.sun_teeth + self.planet_teeth) * math.sin(math.pi / self.planet_count)
        if spacing <= self.planet_teeth + 2:
            raise ValueError(
                "planet_count|neighbouring planets collide: their centres are"
                f" {spacing:.1f} modules apart, their tip diameter is {self.planet_teeth + 2}"
            )
        if self.module_m * self.ring_teeth / 2 > LARGEST_RING_M:
            most = format_number(2 * LARGEST_RING_M / self.ring_teeth)
            raise ValueError(
                f"module_m|must be at most {most} for a ring of {self.ring_teeth} teeth, whose"
                f" radius is then {LARGEST_RING_M:g} m"
            )
        return self


class PlanetaryStage(PlanetaryGears):
    """A 2K-H stage: sun driven, ring on the link before, planets' carrier on the link after.

    An inertia is given as it is, or as the paper's *equivalent mass* M = J / r^2, r the base
    radius.
    """

    sun_mesh: Mesh
    """Contact of the sun with each planet."""
    ring_mesh: Mesh
    """Contact of each planet with the ring."""

    @model_validator(mode="after")
    def _check_planet_values(self) -> Self:
        for side in ("sun_mesh", "ring_mesh"):
            for name, value in getattr(self, side):
                if isinstance(value, tuple) and len(value) != self.planet_count:
                    raise ValueError(
                        f"{side}.{name}|needs one value, or {self.planet_count}, one for each"
                        f" planet; has {len(value)}"
                    )
        return self

    @model_validator(mode="after")
    def _check_phases(self) -> Self:
        """Check that given phases fit the teeth: planets mesh an N-th of the sun's teeth apart."""
        turns = [-self.sun_teeth * place / self.planet_count for place in range(self.planet_count)]
        for side, mesh in (("sun_mesh", self.sun_mesh), ("ring_mesh", self.ring_mesh)):
            phases = mesh.phase_rad
            if not isinstance(phases, tuple):
                continue
            off = [(p - phases[0]) / (2 * math.pi) - t for p, t in zip(phases, turns, strict=True)]
            if max(abs(o - round(o)) for o in off) > PHASE_TOLERANCE:
                first = ", ".join(f"{2 * math.pi * (t % 1):.4g}" for t in turns)
                raise ValueError(
                    f"{side}.phase_rad|contradicts the teeth, by which the planets mesh {first} rad"
                    " after the first; give those, one number for all, or from-teeth"
                )
        return self
