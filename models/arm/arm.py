"""The arm as data: what the file holds, validated.

Radii, ratios and inertias are worked out by each model on its own side. The arithmetic here decides
whether a gear set can be assembled at all, and whether numbers of 16 digits can hold the arm's
inertias beside each other; ``Link.mass`` and ``Link.inertia`` are for users, and for the robot that
an arm is written as.
"""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Self

from pydantic import FailFast, Field, model_validator

from crosscheck.models.arm import quantities
from crosscheck.models.arm.gears import PlanetaryGears, PlanetaryStage
from crosscheck.models.arm.quantities import Data, UpToSeven, format_number

if TYPE_CHECKING:
    import numpy as np

# Numbers of 16 digits must hold the parts of an arm beside each other. Within these limits each of
# 6000 random arms over all ranges kept nine digits of its accelerations in every engine.
LEAST_LINK = 1e-9  # inertia of a link about its joint over that of all that the joint turns
LEAST_PLANET = 1e-6  # equivalent mass of a planet over the sun's
LEAST_GYRATION = (
    1e-4  # equivalent mass over mass: a radius of gyration of a hundredth of the radius
)
LONGEST_REACH = 3e4  # largest reach of the arm, over its smallest gear
ROD, BODY = ("cross_section_m2", "density_kg_per_m3"), ("mass_kg", "inertia_kg_m2")


class StageMasses(PlanetaryGears):
    """Masses and inertias of a stage that move with the links beside it, and friction."""

    carrier_equivalent_mass_kg: quantities.Mass | None = None
    """Its J / r^2, or carrier_inertia_kg_m2."""
    carrier_inertia_kg_m2: quantities.Inertia | None = None
    """J of the carrier without planets, about the joint's axis."""
    sun_mass_kg: quantities.Mass
    """At the joint's axis."""
    planet_mass_kg: quantities.Mass
    """Of one planet, at its centre on the carrier."""
    carrier_mass_kg: quantities.Mass
    """At the joint's axis."""
    ring_mass_kg: quantities.Mass
    """Ring and housing, at the joint's axis."""
    ring_inertia_kg_m2: quantities.Inertia = 0.0
    """J of ring and housing, which turn with the previous body."""
    friction_N_m_s_per_rad: quantities.Friction = 0.0
    """c of the torque -c theta' on the link; its reaction is on the previous body."""

    @model_validator(mode="after")
    def _check_carrier_inertia(self) -> Self:
        if (self.carrier_equivalent_mass_kg is None) == (self.carrier_inertia_kg_m2 is None):
            mass, inertia = "carrier_equivalent_mass_kg", "carrier_inertia_kg_m2"
            raise ValueError(f"{mass}|give either {mass} or {inertia}")
        return self


class Planetary(PlanetaryStage, StageMasses):
    """One 2K-H planetary joint: sun driven, ring on the previous body, carrier on the next link.

    An inertia is given as it is, or as the paper's *equivalent mass* M = J / r^2, r the base radius
    of sun or planet, or the carrier radius times cos(pressure angle).
    """

    @model_validator(mode="after")
    def _check_gear_inertias(self) -> Self:
        sun, planet = _equivalent_mass(self, "sun"), _equivalent_mass(self, "planet")
        gyration = format_number(LEAST_GYRATION)
        for part, mass, least, why in (
            ("sun", sun, LEAST_GYRATION * self.sun_mass_kg, f"{gyration} sun_mass_kg"),
            ("planet", planet, LEAST_GYRATION * self.planet_mass_kg, f"{gyration} planet_mass_kg"),
            ("planet", planet, LEAST_PLANET * sun, f"{format_number(LEAST_PLANET)} of the sun's"),
        ):
            if mass < least:
                as_mass = getattr(self, f"{part}_equivalent_mass_kg") is not None
                field = f"{part}_{'equivalent_mass_kg' if as_mass else 'inertia_kg_m2'}"
                needed = least * getattr(self, field) / mass
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
    motor_mass_kg: quantities.Mass
    """At the joint's axis."""
    rotor_inertia_kg_m2: quantities.Inertia
    """J about the joint's axis."""
    friction_N_m_s_per_rad: quantities.Friction = 0.0
    """c of the torque -c theta' on the link; its reaction is on the previous body."""

    @property
    def planet_count(self) -> int:
        """Number of planets: 0, as a joint without gears has none."""
        return 0


Joint = Annotated[Planetary | Direct, Field(discriminator="kind")]


class Link(Data):
    """A body between two joints, its centre of mass on the line through them.

    A slender uniform rod, whose centre may be stated elsewhere than at half length; or a body of
    given mass and inertia about its centre of mass.
    """

    length_m: quantities.Length
    """From its joint's axis to the next one's, or to the payload."""
    com_m: quantities.Place
    """From its joint's axis to the centre of mass."""
    cross_section_m2: quantities.Area | None = None
    """Section of a rod: mass = section x density x length, J = mass x length^2 / 12."""
    density_kg_per_m3: quantities.Density | None = None
    """Density of a rod."""
    mass_kg: quantities.GearMass | None = None
    """Mass of a body that is no rod."""
    inertia_kg_m2: quantities.Inertia | None = None
    """J of that body about its centre of mass; 0 of a point mass."""

    @property
    def mass(self) -> float:
        """Mass [kg], of a rod as of a body."""
        if self.mass_kg is not None:
            return self.mass_kg
        assert self.density_kg_per_m3 is not None  # as validation has seen
        assert self.cross_section_m2 is not None
        return self.density_kg_per_m3 * self.cross_section_m2 * self.length_m

    @property
    def inertia(self) -> float:
        """Inertia [kg m^2] about the centre of mass, of a rod as of a body."""
        if self.inertia_kg_m2 is not None:
            return self.inertia_kg_m2
        return self.mass * self.length_m**2 / 12

    @model_validator(mode="after")
    def _check_rod_or_body(self) -> Self:
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
        if self.com_m > self.length_m:
            raise ValueError(f"com_m|must be at most length_m = {self.length_m:g}")
        return self


class Arm(Data):
    """A planar arm of 1 to 7 joints, on a fixed base, with a point payload at its tip.

    Gravity [m/s^2] is along the base's x and y; at zero angles x points along the links.
    """

    section: ClassVar = "arm"

    schema_version: quantities.ArmVersion
    """Version of the file: 2."""
    name: quantities.Name
    """What reports and messages call the arm."""
    title: quantities.Title = ""
    """One line about it."""
    payload_mass_kg: quantities.Mass
    """Point mass at the tip."""
    gravity_m_per_s2: Annotated[
        tuple[quantities.Acceleration, quantities.Acceleration], Field(strict=False), FailFast()
    ] = (0.0, 0.0)
    """Along the base's x and y."""
    joints: Annotated[tuple[Joint, ...], UpToSeven, FailFast()]
    """Joints from the base to the tip."""
    links: Annotated[tuple[Link, ...], UpToSeven, FailFast()]
    """Links, one after each joint."""

    def __repr__(self) -> str:
        """Describe the arm, a line for each joint."""
        return "\n".join((f"Arm {self.name}: {describe_loads(self)}", *self.described))

    __str__ = __repr__

    @property
    def content(self) -> Arm:
        """The content of the arm's file."""
        return self

    @property
    def sections(self) -> dict[str, object]:
        """The content of the arm's file as plain data, by section."""
        return {"arm": self.model_dump(mode="json", exclude_none=True)}

    @property
    def run_attributes(self) -> dict[str, str]:
        """What the file of a run keeps of the arm."""
        return {"arm": json.dumps(self.model_dump())}

    @property
    def described(self) -> tuple[str, ...]:
        """Descriptions of each joint with its link, a line for each, and the payload."""
        lines = []
        for number, (joint, link) in enumerate(zip(self.joints, self.links, strict=True), start=1):
            drive = "direct drive"
            if isinstance(joint, Planetary):
                ratio = joint.ring_teeth / joint.sun_teeth + 1
                teeth = f"{joint.sun_teeth}, {joint.planet_teeth} and {joint.ring_teeth}"
                drive = f"sun, {joint.planet_count} planets and ring of {teeth} teeth"
                drive += f", reduction {ratio:.4g}, module {1e3 * joint.module_m:g} mm"
            link_words = f"link {number}: {link.length_m:g} m, {link.mass:.4g} kg"
            lines.append(f"Joint {number}: {drive}; {link_words}")
        return (*lines, f"Payload: {self.payload_mass_kg:g} kg")

    @property
    def identity(self) -> str:
        """Text by which two arms are one: values that are not defaults.

        Defaults are left out so that what the format gains later leaves the text of an arm that
        does not use it; a default does not change within a version of the file.
        """
        return self.model_dump_json(exclude_defaults=True)

    @property
    def coordinate_names(self) -> list[str]:
        """Names of the joints' coordinates."""
        return [f"theta_{number}" for number in range(1, len(self.joints) + 1)]

    @property
    def joint_units(self) -> dict[str, str]:
        """Units of the joints' coordinates, by names of the joints."""
        return {f"joint {number}": "rad" for number in range(1, len(self.joints) + 1)}

    @property
    def joint_map(self) -> tuple[np.ndarray, np.ndarray]:
        """Factors (joints, joints) and offsets (joints,) of the joints by those of a scenario."""
        import numpy as np  # for which the template of a file does not wait

        return np.eye(len(self.joints)), np.zeros(len(self.joints))

    @property
    def motors(self) -> range:
        """Numbers of the joints that have a motor, from 0: all."""
        return range(len(self.joints))

    @property
    def planet_counts(self) -> list[int]:
        """The number of planets of each joint."""
        return [joint.planet_count for joint in self.joints]

    @model_validator(mode="after")
    def _check_link_count(self) -> Self:
        if len(self.joints) != len(self.links):
            raise ValueError(f"links|must be as many as joints, {len(self.joints)}")
        return self

    @model_validator(mode="after")
    def _check_reach(self) -> Self:
        reach = sum(link.length_m for link in self.links)
        geared = [joint for joint in self.joints if isinstance(joint, Planetary)]
        radii = [j.module_m * min(j.sun_teeth, j.planet_teeth) / 2 for j in geared]
        smallest = min(radii, default=reach)
        if reach > LONGEST_REACH * smallest:
            raise ValueError(
                f"links|must not be longer together than {LONGEST_REACH * smallest:.3g} m,"
                f" {format_number(LONGEST_REACH)} radii of the smallest gear; they are"
                f" {reach:.3g} m"
            )
        return self

    @model_validator(mode="after")
    def _check_link_inertias(self) -> Self:
        for place in range(len(self.links)):
            link, is_last = self.links[place], place + 1 == len(self.links)
            inertia = link.inertia + link.mass * link.com_m**2
            inertia += self.payload_mass_kg * link.length_m**2 if is_last else 0.0
            load = _load_inertia(self, place)
            if inertia < LEAST_LINK * load:
                raise ValueError(
                    f"links[{place}]|must have at least {format_number(LEAST_LINK)} of the"
                    " inertia that its"
                    f" joint turns: it has {inertia:.3g} of {load:.3g} kg m^2 about that joint"
                )
        return self


class FreeBase(Data):
    """A body in the plane that carries an arm and that nothing drives: a homogeneous cube, or any.

    Of a cube the shoulder is in the middle of a face, and x at zero angles points out of it.
    """

    mass_kg: quantities.GearMass
    """Mass of the body."""
    side_m: quantities.Length | None = None
    """Side of a cube: J = mass x side^2 / 6, its centre half a side behind the shoulder."""
    inertia_kg_m2: quantities.GearInertia | None = None
    """J of any other body, about its centre of mass."""
    com_m: quantities.Place | None = None
    """How far its centre of mass is behind the shoulder."""

    @model_validator(mode="after")
    def _check_cube_or_body(self) -> Self:
        given = self.inertia_kg_m2 is not None, self.com_m is not None
        if given != (self.side_m is None,) * 2:
            raise ValueError("side_m|give side_m, or inertia_kg_m2 and com_m")
        return self

    @property
    def inertia(self) -> float:
        """Inertia [kg m^2] about the centre of mass."""
        if self.side_m is None:
            return self.inertia_kg_m2 or 0.0
        return self.mass_kg * self.side_m**2 / 6

    @property
    def com(self) -> float:
        """Place [m] of the centre of mass along x from the shoulder."""
        return -(self.com_m or 0.0) if self.side_m is None else -self.side_m / 2


class FreeArm(Arm):
    """An arm on a free base, which is read as a robot and not by what is for planar arms alone.

    Its URDF has base_x, base_y and base_yaw, which no motor drives, and then joint_1 and so on.
    """

    base: FreeBase
    """The body that carries it."""


def describe_loads(arm: Arm) -> str:
    """The arm's gravity, friction and gears, in words."""
    gravity = "no gravity"
    if any(arm.gravity_m_per_s2):
        gravity = "gravity ({:g}, {:g}) m/s^2".format(*arm.gravity_m_per_s2)
    rates = [joint.friction_N_m_s_per_rad for joint in arm.joints]
    friction = f"friction {', '.join(f'{rate:g}' for rate in rates)} N m s/rad"
    geared = sum(isinstance(joint, Planetary) for joint in arm.joints)
    gears = f"gears in {geared} of {len(rates)} joints" if geared else "no gears"
    return f"{gravity}, {friction if any(rates) else 'no friction'}, {gears}"


def _load_inertia(arm: Arm, place: int) -> float:
    """Upper bound of the inertia [kg m^2] about a joint: arm stretched out, own gears reflected."""
    total, reach = _reflected_inertia(arm.joints[place]), 0.0
    for number in range(place, len(arm.links)):
        if number > place:
            joint = arm.joints[number]
            total += joint_mass(joint) * reach**2 + _joint_inertia(joint)
        reach += arm.links[number].length_m
        total += arm.links[number].mass * reach**2
    return total + arm.payload_mass_kg * reach**2


def _reflected_inertia(joint: Planetary | Direct) -> float:
    """Inertia [kg m^2] of a joint's own motor and gears, reflected to the joint."""
    if isinstance(joint, Direct):
        return joint.rotor_inertia_kg_m2
    planets = joint.planet_count * _equivalent_mass(joint, "planet")
    return (4 * _equivalent_mass(joint, "sun") + planets) * _carrier_radius(joint) ** 2


def _joint_inertia(joint: Planetary | Direct) -> float:
    if isinstance(joint, Direct):
        return joint.rotor_inertia_kg_m2
    gears = _equivalent_mass(joint, "sun") + _equivalent_mass(joint, "carrier")
    gears += joint.planet_count * _equivalent_mass(joint, "planet")
    return gears * _carrier_radius(joint) ** 2 + joint.ring_inertia_kg_m2


def joint_mass(joint: Planetary | Direct) -> float:
    """Mass of all that is centred on a joint's axis [kg]."""
    if isinstance(joint, Direct):
        return joint.motor_mass_kg
    planets = joint.planet_count * joint.planet_mass_kg
    return joint.sun_mass_kg + planets + joint.carrier_mass_kg + joint.ring_mass_kg


def _equivalent_mass(joint: Planetary, part: str) -> float:
    """Equivalent mass M = J / r^2 [kg] of sun, planet or carrier."""
    given: float | None = getattr(joint, f"{part}_equivalent_mass_kg")
    if given is not None:
        return given
    inertia: float = getattr(joint, f"{part}_inertia_kg_m2")
    teeth = {"sun": joint.sun_teeth, "planet": joint.planet_teeth}
    pitch = joint.module_m * teeth.get(part, joint.sun_teeth + joint.planet_teeth) / 2
    return inertia / (pitch * math.cos(math.radians(joint.pressure_angle_deg))) ** 2


def _carrier_radius(joint: Planetary) -> float:
    return joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2
