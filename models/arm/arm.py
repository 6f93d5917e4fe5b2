"""The arm as data: what the file holds, validated, and nothing derived from it.

Radii, ratios and inertias are worked out by each model on its own side; the only arithmetic here
decides whether a gear set can be assembled at all, and whether numbers of 16 digits can hold the
arm's inertias beside each other.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import FailFast, Field, model_validator

from crosscheck.models.arm.mesh import Mesh
from crosscheck.models.arm.quantities import (
    Acceleration,
    Area,
    ArmVersion,
    Data,
    Density,
    Friction,
    GearInertia,
    GearMass,
    Inertia,
    Length,
    Mass,
    Module,
    Name,
    Place,
    PlanetCount,
    PressureAngle,
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
PHASES_FIT = 1e-3  # cycles that given phases of planets may be off what their teeth say
ROD, BODY = ("cross_section_m2", "density_kg_per_m3"), ("mass_kg", "inertia_kg_m2")


class Planetary(Data):
    """One 2K-H planetary joint: sun driven, ring on the previous body, carrier on the next link.

    An inertia is given as it is, or as the paper's *equivalent mass* M = J / r^2, r the base radius
    of sun or planet, or the carrier radius times cos(pressure angle).
    """

    kind: Literal["planetary"]
    """Which sort of joint this is."""
    sun_teeth: ToothCount
    """Teeth of the sun."""
    planet_teeth: ToothCount
    """Teeth of each planet."""
    ring_teeth: ToothCount
    """Teeth of the ring: sun_teeth + 2 planet_teeth."""
    planet_count: PlanetCount = 3
    """N, equally spaced: it divides sun_teeth + ring_teeth, and the planets clear each other."""
    module_m: Module
    """Pitch diameter of a gear over its teeth."""
    pressure_angle_deg: PressureAngle
    """Between the line of action and the common tangent of the pitch circles."""
    sun_equivalent_mass_kg: GearMass | None = None
    """J / r^2 of the sun, r its base radius; this or sun_inertia_kg_m2."""
    sun_inertia_kg_m2: GearInertia | None = None
    """J of the sun about its axis, the motor's rotor included."""
    planet_equivalent_mass_kg: GearMass | None = None
    """J / r^2 of one planet, r its base radius; this or planet_inertia_kg_m2."""
    planet_inertia_kg_m2: GearInertia | None = None
    """J of one planet about its own axis."""
    carrier_equivalent_mass_kg: Mass | None = None
    """J / r^2 of the carrier, r its radius x cos(pressure angle); this or carrier_inertia_kg_m2."""
    carrier_inertia_kg_m2: Inertia | None = None
    """J of the carrier about the joint's axis, without the planets."""
    sun_mass_kg: Mass
    """Mass of the sun, at the joint's axis."""
    planet_mass_kg: Mass
    """Mass of one planet, at its centre on the carrier."""
    carrier_mass_kg: Mass
    """Mass of the carrier, at the joint's axis."""
    ring_mass_kg: Mass
    """Mass of ring and housing, at the joint's axis."""
    ring_inertia_kg_m2: Inertia = 0.0
    """J of ring and housing about the joint's axis; they turn with the previous body."""
    friction_N_m_s_per_rad: Friction = 0.0
    """c of the torque -c theta' on the link, and its reaction on the previous body."""
    sun_mesh: Mesh
    """Contact of the sun with each planet."""
    ring_mesh: Mesh
    """Contact of each planet with the ring."""

    @model_validator(mode="after")
    def _one_form_of_each_inertia(self) -> Self:
        for part in ("sun", "planet", "carrier"):
            mass, inertia = f"{part}_equivalent_mass_kg", f"{part}_inertia_kg_m2"
            if (getattr(self, mass) is None) == (getattr(self, inertia) is None):
                raise ValueError(f"{mass}|give either {mass} or {inertia}")
        return self

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
    def _a_value_per_planet(self) -> Self:
        for side in ("sun_mesh", "ring_mesh"):
            for name, value in getattr(self, side):
                if isinstance(value, tuple) and len(value) != self.planet_count:
                    raise ValueError(
                        f"{side}.{name}|needs one value, or {self.planet_count}, one for each"
                        f" planet; has {len(value)}"
                    )
        return self

    @model_validator(mode="after")
    def _phases_fit_the_teeth(self) -> Self:
        """Equally spaced planets meet a tooth after each other by an N-th of the sun's teeth."""
        turns = [-self.sun_teeth * place / self.planet_count for place in range(self.planet_count)]
        for side, mesh in (("sun_mesh", self.sun_mesh), ("ring_mesh", self.ring_mesh)):
            phases = mesh.phase_rad
            if not isinstance(phases, tuple):
                continue
            off = [(p - phases[0]) / (2 * math.pi) - t for p, t in zip(phases, turns, strict=True)]
            if max(abs(o - round(o)) for o in off) > PHASES_FIT:
                first = ", ".join(f"{2 * math.pi * (t % 1):.4g}" for t in turns)
                raise ValueError(
                    f"{side}.phase_rad|contradicts the teeth, by which the planets mesh {first} rad"
                    " after the first; give those, one number for all, or from-teeth"
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
        sun, planet = _equivalent_mass(self, "sun"), _equivalent_mass(self, "planet")
        for part, own, least, why in (
            ("sun", sun, LEAST_GYRATION * self.sun_mass_kg, f"{short(LEAST_GYRATION)} sun_mass_kg"),
            (
                "planet",
                planet,
                LEAST_GYRATION * self.planet_mass_kg,
                f"{short(LEAST_GYRATION)} planet_mass_kg",
            ),
            ("planet", planet, LEAST_PLANET * sun, f"{short(LEAST_PLANET)} of the sun's"),
        ):
            if own < least:
                as_mass = getattr(self, f"{part}_equivalent_mass_kg") is not None
                field = f"{part}_{'equivalent_mass_kg' if as_mass else 'inertia_kg_m2'}"
                needed = least * getattr(self, field) / own
                raise ValueError(
                    f"{field}|must be at least {needed:.3g}, an equivalent mass of {why}"
                )
        return self


class Direct(Data):
    """A joint without gears: a motor between two links, its rotor on the next one.

    The motor's mass is at the joint's axis; the rotor's inertia turns with the next link.
    """

    kind: Literal["direct"]
    """Which sort of joint this is."""
    motor_mass_kg: Mass
    """Mass of the motor, at the joint's axis."""
    rotor_inertia_kg_m2: Inertia
    """J of the rotor about the joint's axis; it turns with the next link."""
    friction_N_m_s_per_rad: Friction = 0.0
    """c of the torque -c theta' on the link, and its reaction on the previous body."""

    @property
    def planet_count(self) -> int:
        """It has none."""
        return 0


Joint = Annotated[Planetary | Direct, Field(discriminator="kind")]


class Link(Data):
    """A body between two joints, its centre of mass on the line through them.

    A slender uniform rod, whose centre may be stated elsewhere than at half length; or a body of
    given mass and inertia about its centre of mass.
    """

    length_m: Length
    """From its joint's axis to the next one's, or to the payload."""
    com_m: Place
    """From its joint's axis to the centre of mass, on the line through both ends."""
    cross_section_m2: Area | None = None
    """Of a rod, whose mass is section x density x length, and J = mass x length^2 / 12."""
    density_kg_per_m3: Density | None = None
    """Of a rod."""
    mass_kg: GearMass | None = None
    """Of a body that is no rod."""
    inertia_kg_m2: GearInertia | None = None
    """J of that body about its centre of mass."""

    @model_validator(mode="after")
    def _rod_or_body(self) -> Self:
        rod = [name for name in ROD if getattr(self, name) is not None]
        body = [name for name in BODY if getattr(self, name) is not None]
        if rod and body:
            raise ValueError(f"{body[0]}|give either {' and '.join(ROD)}, or {' and '.join(BODY)}")
        for given, names in ((rod, ROD), (body, BODY)):
            missing = [name for name in names if name not in given]
            if given and missing:
                raise ValueError(f"{missing[0]}|is missing; {given[0]} needs it beside")
        if not rod and not body:
            raise ValueError(f"{ROD[0]}|give {' and '.join(ROD)}, or {' and '.join(BODY)}")
        return self

    @model_validator(mode="after")
    def _com_on_the_link(self) -> Self:
        if self.com_m > self.length_m:
            raise ValueError(f"com_m|must be at most length_m = {self.length_m:g}")
        return self


class Arm(Data):
    """A planar arm of 1 to 7 joints, on a fixed base, with a point payload at its tip.

    Gravity [m/s^2] is along the base's x and y; at zero angles x points along the links.
    """

    schema_version: ArmVersion
    """Version of the file: 2."""
    name: Name
    """What reports, records and messages call the arm."""
    title: Title = ""
    """One line about it."""
    payload_mass_kg: Mass
    """Point mass at the tip."""
    gravity_m_per_s2: Annotated[
        tuple[Acceleration, Acceleration], Field(strict=False), FailFast()
    ] = (0.0, 0.0)
    """Along the base's x and y; at zero angles x points along the links."""
    joints: Annotated[tuple[Joint, ...], UpToSeven, FailFast()]
    """From the base to the tip."""
    links: Annotated[tuple[Link, ...], UpToSeven, FailFast()]
    """One after each joint, in the same order."""

    @model_validator(mode="after")
    def _a_link_per_joint(self) -> Self:
        if len(self.joints) != len(self.links):
            raise ValueError(f"links|must be as many as joints, {len(self.joints)}")
        return self

    @model_validator(mode="after")
    def _gears_suit_the_links(self) -> Self:
        reach = sum(link.length_m for link in self.links)
        geared = [joint for joint in self.joints if isinstance(joint, Planetary)]
        radii = [j.module_m * min(j.sun_teeth, j.planet_teeth) / 2 for j in geared]
        smallest = min(radii, default=reach)
        if reach > LONGEST_REACH * smallest:
            raise ValueError(
                f"links|must not be longer together than {LONGEST_REACH * smallest:.3g} m,"
                f" {short(LONGEST_REACH)} radii of the smallest gear; they are {reach:.3g} m"
            )
        return self

    @model_validator(mode="after")
    def _links_have_inertia(self) -> Self:
        for place in range(len(self.links)):
            own, load = _own_inertia(self, place), _turned_inertia(self, place)
            if own < LEAST_ROD * load:
                raise ValueError(
                    f"links[{place}]|must have at least {short(LEAST_ROD)} of the inertia that its"
                    f" joint turns: it has {own:.3g} of {load:.3g} kg m^2"
                )
        return self


def _own_inertia(arm: Arm, place: int) -> float:
    """Of a link about its centre, of the last one with the payload [kg m^2]."""
    link = arm.links[place]
    end = arm.payload_mass_kg if place + 1 == len(arm.links) else 0.0
    return _link_inertia(link) + end * link.length_m**2


def _turned_inertia(arm: Arm, place: int) -> float:
    """Bound of what a joint turns [kg m^2], arm stretched out, its own gears as it feels them."""
    total, reach = _felt_inertia(arm.joints[place]), 0.0
    for number in range(place, len(arm.links)):
        if number > place:
            joint = arm.joints[number]
            total += _joint_mass(joint) * reach**2 + _spun_inertia(joint)
        reach += arm.links[number].length_m
        total += _link_mass(arm.links[number]) * reach**2
    return total + arm.payload_mass_kg * reach**2


def _felt_inertia(joint: Planetary | Direct) -> float:
    """Of a joint's own motor and gears [kg m^2]."""
    if isinstance(joint, Direct):
        return joint.rotor_inertia_kg_m2
    planets = joint.planet_count * _equivalent_mass(joint, "planet")
    return (4 * _equivalent_mass(joint, "sun") + planets) * _carrier_radius(joint) ** 2


def _spun_inertia(joint: Planetary | Direct) -> float:
    if isinstance(joint, Direct):
        return joint.rotor_inertia_kg_m2
    gears = _equivalent_mass(joint, "sun") + _equivalent_mass(joint, "carrier")
    gears += joint.planet_count * _equivalent_mass(joint, "planet")
    return gears * _carrier_radius(joint) ** 2 + joint.ring_inertia_kg_m2


def _joint_mass(joint: Planetary | Direct) -> float:
    if isinstance(joint, Direct):
        return joint.motor_mass_kg
    planets = joint.planet_count * joint.planet_mass_kg
    return joint.sun_mass_kg + planets + joint.carrier_mass_kg + joint.ring_mass_kg


def _equivalent_mass(joint: Planetary, part: str) -> float:
    """M = J / r^2 [kg] of sun, planet or carrier."""
    given: float | None = getattr(joint, f"{part}_equivalent_mass_kg")
    if given is not None:
        return given
    inertia: float = getattr(joint, f"{part}_inertia_kg_m2")
    teeth = {"sun": joint.sun_teeth, "planet": joint.planet_teeth}
    pitch = joint.module_m * teeth.get(part, joint.sun_teeth + joint.planet_teeth) / 2
    return inertia / (pitch * math.cos(math.radians(joint.pressure_angle_deg))) ** 2


def _link_mass(link: Link) -> float:
    if link.mass_kg is not None:
        return link.mass_kg
    assert link.density_kg_per_m3 is not None  # as _rod_or_body has seen
    assert link.cross_section_m2 is not None
    return link.density_kg_per_m3 * link.cross_section_m2 * link.length_m


def _link_inertia(link: Link) -> float:
    if link.inertia_kg_m2 is not None:
        return link.inertia_kg_m2
    return _link_mass(link) * link.length_m**2 / 12


def _carrier_radius(joint: Planetary) -> float:
    return joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2
