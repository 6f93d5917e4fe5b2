"""The arm as data: what the file holds, validated, and nothing derived from it.

Radii, ratios and inertias are worked out by each model on its own side; the only arithmetic here
decides whether a gear set can be assembled at all, and whether numbers of 16 digits can hold the
arm's inertias beside each other.
"""

from __future__ import annotations

import math
from typing import Annotated, Self

from pydantic import FailFast, model_validator

from models.quantities import (
    Area,
    Damping,
    DampingRatio,
    Data,
    Density,
    GearMass,
    Inertia,
    Length,
    Mass,
    Module,
    Name,
    Phase,
    Place,
    PlanetCount,
    Play,
    PressureAngle,
    SchemaVersion,
    Sharpness,
    Stiffness,
    StiffnessPart,
    Title,
    ToothCount,
    UpToSeven,
    short,
)

# Numbers of 16 digits must hold the parts of an arm beside each other. Within these limits each of
# 6000 random arms over all ranges kept nine digits of its accelerations in every engine.
LEAST_ROD = 1e-9  # inertia of a rod over that of all that its joint turns
LEAST_PLANET = 1e-6  # equivalent mass of a planet over the sun's
LEAST_GYRATION = (
    1e-4  # equivalent mass over mass: a radius of gyration of a hundredth of the radius
)
LONGEST_REACH = 3e4  # of the arm over its smallest gear
LARGEST_RING_M = 50.0


class Joint(Data):
    """One 2K-H planetary joint: sun driven, ring on the previous body, carrier on the next link.

    An *equivalent mass* is an inertia over a base radius squared, the paper's M = J / r^2: base
    radius of the gear for sun and planet, carrier radius times cos(pressure angle) for the carrier.
    """

    sun_teeth: ToothCount
    planet_teeth: ToothCount
    ring_teeth: ToothCount
    planet_count: PlanetCount = 3
    module_m: Module
    pressure_angle_deg: PressureAngle
    sun_equivalent_mass_kg: GearMass
    planet_equivalent_mass_kg: GearMass
    carrier_equivalent_mass_kg: Mass
    sun_mass_kg: Mass
    planet_mass_kg: Mass
    carrier_mass_kg: Mass
    ring_mass_kg: Mass
    ring_inertia_kg_m2: Inertia = 0.0
    backlash_m: Play
    mesh_stiffness_N_per_m: Stiffness
    mesh_stiffness_amplitude_N_per_m: StiffnessPart
    tooth_error_m: Play
    ring_mesh_phase_rad: Phase = 0.0
    damping_ratio: DampingRatio | None = None
    sun_planet_damping_N_s_per_m: Damping | None = None
    planet_ring_damping_N_s_per_m: Damping | None = None
    tanh_sharpness_per_m: Sharpness = 1e8

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
    def _gears_have_a_size(self) -> Self:
        if self.module_m * self.ring_teeth / 2 > LARGEST_RING_M:
            most = short(2 * LARGEST_RING_M / self.ring_teeth)
            raise ValueError(
                f"module_m|must be at most {most} for a ring of {self.ring_teeth} teeth, whose"
                f" radius is then {LARGEST_RING_M:g} m"
            )
        return self

    @model_validator(mode="after")
    def _gears_have_inertia(self) -> Self:
        sun = self.sun_equivalent_mass_kg
        for field, part, whole, of in (
            ("sun", LEAST_GYRATION, self.sun_mass_kg, "sun_mass_kg"),
            ("planet", LEAST_GYRATION, self.planet_mass_kg, "planet_mass_kg"),
            ("planet", LEAST_PLANET, sun, "sun_equivalent_mass_kg"),
        ):
            if getattr(self, f"{field}_equivalent_mass_kg") < part * whole:
                raise ValueError(
                    f"{field}_equivalent_mass_kg|must be at least {short(part)} {of} ="
                    f" {part * whole:.3g}"
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

    length_m: Length
    com_m: Place
    cross_section_m2: Area
    density_kg_per_m3: Density

    @model_validator(mode="after")
    def _com_on_the_link(self) -> Self:
        if self.com_m > self.length_m:
            raise ValueError(f"com_m|must be at most length_m = {self.length_m:g}")
        return self


class Arm(Data):
    """A planar arm of 1 to 7 geared joints, on a fixed base, with a point payload at its tip."""

    schema_version: SchemaVersion
    name: Name
    title: Title = ""
    payload_mass_kg: Mass
    joints: Annotated[tuple[Joint, ...], UpToSeven, FailFast()]
    links: Annotated[tuple[Link, ...], UpToSeven, FailFast()]

    @model_validator(mode="after")
    def _a_link_per_joint(self) -> Self:
        if len(self.joints) != len(self.links):
            raise ValueError(f"links|must be as many as joints, {len(self.joints)}")
        return self

    @model_validator(mode="after")
    def _gears_suit_the_links(self) -> Self:
        reach = sum(link.length_m for link in self.links)
        smallest = min(j.module_m * min(j.sun_teeth, j.planet_teeth) / 2 for j in self.joints)
        if reach > LONGEST_REACH * smallest:
            raise ValueError(
                f"links|must not be longer together than {LONGEST_REACH * smallest:.3g} m,"
                f" {short(LONGEST_REACH)} radii of the smallest gear; they are {reach:.3g} m"
            )
        return self

    @model_validator(mode="after")
    def _rods_have_inertia(self) -> Self:
        for place in range(len(self.links)):
            own, load = _own_inertia(self, place), _turned_inertia(self, place)
            if own < LEAST_ROD * load:
                raise ValueError(
                    f"links[{place}]|must have at least {short(LEAST_ROD)} of the inertia that its"
                    f" joint turns: it has {own:.3g} of {load:.3g} kg m^2"
                )
        return self


def _own_inertia(arm: Arm, place: int) -> float:
    """Of a rod about its centre, of the last one with the payload [kg m^2]."""
    end = arm.payload_mass_kg if place + 1 == len(arm.links) else 0.0
    return (_rod_mass(arm.links[place]) / 12 + end) * arm.links[place].length_m ** 2


def _turned_inertia(arm: Arm, place: int) -> float:
    """Bound of what a joint turns [kg m^2], arm stretched out, its own gears as it feels them."""
    stage = arm.joints[place]
    gears = 4 * stage.sun_equivalent_mass_kg + stage.planet_count * stage.planet_equivalent_mass_kg
    total, reach = gears * _carrier_radius(stage) ** 2, 0.0
    for number in range(place, len(arm.links)):
        if number > place:
            joint = arm.joints[number]
            total += _joint_mass(joint) * reach**2 + _spun_inertia(joint)
        reach += arm.links[number].length_m
        total += _rod_mass(arm.links[number]) * reach**2
    return total + arm.payload_mass_kg * reach**2


def _spun_inertia(joint: Joint) -> float:
    gears = joint.sun_equivalent_mass_kg + joint.carrier_equivalent_mass_kg
    gears += joint.planet_count * joint.planet_equivalent_mass_kg
    return gears * _carrier_radius(joint) ** 2 + joint.ring_inertia_kg_m2


def _joint_mass(joint: Joint) -> float:
    planets = joint.planet_count * joint.planet_mass_kg
    return joint.sun_mass_kg + planets + joint.carrier_mass_kg + joint.ring_mass_kg


def _rod_mass(link: Link) -> float:
    return link.density_kg_per_m3 * link.cross_section_m2 * link.length_m


def _carrier_radius(joint: Joint) -> float:
    return joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2
