"""The arm as data: what the file holds, validated, and nothing derived from it.

Radii, ratios and inertias are worked out by each model on its own side; the only arithmetic here
decides whether a gear set can be assembled at all.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
ToothCount = Annotated[int, Field(ge=5, le=2000)]


class Data(BaseModel):
    """A frozen record that refuses unknown keys and silent conversions."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Joint(Data):
    """One 2K-H planetary joint: sun driven, ring on the previous body, carrier on the next link.

    An *equivalent mass* is an inertia over a base radius squared, the paper's M = J / r^2: base
    radius of the gear for sun and planet, carrier radius times cos(pressure angle) for the carrier.
    """

    sun_teeth: ToothCount
    planet_teeth: ToothCount
    ring_teeth: ToothCount
    planet_count: Annotated[int, Field(ge=2, le=8)] = 3
    module_m: Positive
    pressure_angle_deg: Annotated[float, Field(gt=0, lt=45, allow_inf_nan=False)]
    sun_equivalent_mass_kg: Positive
    planet_equivalent_mass_kg: Positive
    carrier_equivalent_mass_kg: NotNegative
    sun_mass_kg: NotNegative
    planet_mass_kg: NotNegative
    carrier_mass_kg: NotNegative
    ring_mass_kg: NotNegative
    ring_inertia_kg_m2: NotNegative = 0.0
    backlash_m: NotNegative
    mesh_stiffness_N_per_m: Positive
    mesh_stiffness_amplitude_N_per_m: NotNegative
    tooth_error_m: NotNegative
    ring_mesh_phase_rad: Finite = 0.0
    damping_ratio: NotNegative | None = None
    sun_planet_damping_N_s_per_m: NotNegative | None = None
    planet_ring_damping_N_s_per_m: NotNegative | None = None
    tanh_sharpness_per_m: Positive = 1e8

    @model_validator(mode="after")
    def _can_be_assembled(self) -> Self:
        expected = self.sun_teeth + 2 * self.planet_teeth
        if self.ring_teeth != expected:
            raise ValueError(f"ring_teeth|must be sun_teeth + 2 planet_teeth = {expected}")
        if (self.sun_teeth + self.ring_teeth) % self.planet_count:
            raise ValueError(
                "planet_count|must divide sun_teeth + ring_teeth ="
                f" {self.sun_teeth + self.ring_teeth} for equally spaced planets"
            )
        return self

    @model_validator(mode="after")
    def _planets_clear_each_other(self) -> Self:
        spacing = (self.sun_teeth + self.planet_teeth) * math.sin(math.pi / self.planet_count)
        if spacing <= self.planet_teeth + 2:
            raise ValueError(
                "planet_count|neighbouring planets collide: their centres are"
                f" {spacing:.1f} modules apart, their tip diameter is {self.planet_teeth + 2}"
            )
        return self

    @model_validator(mode="after")
    def _stiffness_stays_positive(self) -> Self:
        if self.mesh_stiffness_amplitude_N_per_m >= self.mesh_stiffness_N_per_m:
            raise ValueError(
                "mesh_stiffness_amplitude_N_per_m|must be below mesh_stiffness_N_per_m ="
                f" {self.mesh_stiffness_N_per_m:g}"
            )
        return self

    @model_validator(mode="after")
    def _one_way_to_damp(self) -> Self:
        direct = (self.sun_planet_damping_N_s_per_m, self.planet_ring_damping_N_s_per_m)
        given = sum(value is not None for value in direct)
        if self.damping_ratio is None and given != 2:
            raise ValueError(
                "damping_ratio|give damping_ratio, or both sun_planet_damping_N_s_per_m and"
                " planet_ring_damping_N_s_per_m"
            )
        if self.damping_ratio is not None and given:
            raise ValueError("damping_ratio|give either damping_ratio or the direct dampings")
        return self


class Link(Data):
    """A slender uniform rod; its centre of mass may be stated elsewhere than at half length."""

    length_m: Positive
    com_m: NotNegative
    cross_section_m2: Positive
    density_kg_per_m3: Positive

    @model_validator(mode="after")
    def _com_on_the_link(self) -> Self:
        if self.com_m > self.length_m:
            raise ValueError(f"com_m|must be at most length_m = {self.length_m:g}")
        return self


class Arm(Data):
    """A planar arm of 1 to 7 geared joints, on a fixed base, with a point payload at its tip."""

    schema_version: Literal[1]
    name: Annotated[str, Field(min_length=1, max_length=80)]
    title: str = ""
    payload_mass_kg: NotNegative
    joints: Annotated[tuple[Joint, ...], Field(min_length=1, max_length=7, strict=False)]
    links: Annotated[tuple[Link, ...], Field(min_length=1, max_length=7, strict=False)]

    @model_validator(mode="after")
    def _a_link_per_joint(self) -> Self:
        if len(self.joints) != len(self.links):
            raise ValueError(f"links|must be as many as joints, {len(self.joints)}")
        return self
