"""A planar arm as a robot: its URDF, and the robot's file with its planetary stages."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from html import escape
from typing import NamedTuple

from crosscheck.models.arm.arm import Arm, Direct, FreeArm, Planetary
from crosscheck.models.arm.gears import PlanetaryStage
from crosscheck.models.files import format_toml_fields, parse_toml
from crosscheck.models.loading import validate_record
from crosscheck.models.robot.file import RobotFile, build_robot
from crosscheck.models.robot.robot import Level, Robot

URDF_HEAD = """\
<?xml version="1.0"?>
<!-- Written by crosscheck export. The planar arm turns about z. Inertias about x and y, which no
     motion in the plane asks for, are those of thin rods and discs. -->
<robot name={name}>
"""
FILE_HEAD = """\
# Written by crosscheck export. Sun and planets turn by these stages; their masses, the carriers and
# the rings are bodies of {urdf}. The level links has them as dead weight: an arm's level carriers.
"""


class RobotText(NamedTuple):
    """The texts of a robot's URDF and of its own file."""

    urdf: str
    file: str


class UrdfPart(NamedTuple):
    """A body of the arm as a link of a URDF: inertia [kg m^2] about z, com [m] along x."""

    name: str
    mass: float
    inertia: float
    com: float = 0.0
    is_rod: bool = False


def build_planar_robot(arm: Arm, *, has_gears: bool = True) -> Robot:
    """The robot that is written of an arm; without gears it is links and payload alone.

    Raises InputError.
    """
    text = write_arm_as_robot(arm, "arm.urdf", has_gears=has_gears)
    file = validate_record(RobotFile, parse_toml(text.file), arm.name)
    return build_robot(file, text.urdf, arm.name, arm.name, is_bounded=False)


@lru_cache(maxsize=64)
def build_level_robots(arm: Arm) -> dict[str, tuple[Robot, Level]]:
    """The robot of each level of an arm, and the robot's own level that it is.

    Kept, since every model of an arm asks for it. Raises InputError.
    """
    bare, whole = (build_planar_robot(arm, has_gears=has_gears) for has_gears in (False, True))
    return {
        "links": (bare, "links"),
        "carriers": (whole, "links"),
        "armature": (whole, "armature"),
        "coupled": (whole, "coupled"),
        "geared": (whole, "geared"),
    }


def write_arm_as_robot(arm: Arm, urdf: str, *, has_gears: bool = True) -> RobotText:
    """The texts of an arm as a robot; urdf: name of the URDF."""
    heads = URDF_HEAD.format(name=f'"{escape(arm.name)}"'), FILE_HEAD.format(urdf=urdf)
    lines = _urdf_lines(arm, has_gears), _file_lines(arm, urdf, has_gears)
    pairs = zip(heads, lines, strict=True)
    return RobotText(*("".join([head, "\n".join(each), "\n"]) for head, each in pairs))


def _urdf_lines(arm: Arm, has_gears: bool) -> Iterator[str]:
    """Lines of a URDF's links and joints, and its end."""
    if isinstance(arm, FreeArm):
        yield '  <link name="inertial_frame"/>'
        yield from _joint_lines("base", "planar", "inertial_frame", "base", 0.0)
        yield from _link_lines(UrdfPart("base", arm.base.mass_kg, arm.base.inertia, arm.base.com))
    else:
        yield '  <link name="base"/>'
    before, reach = "base", 0.0
    for number, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True), 1):
        rotor = joint.rotor_inertia_kg_m2 if has_gears and isinstance(joint, Direct) else 0.0
        yield from _link_lines(
            UrdfPart(f"link_{number}", link.mass, link.inertia + rotor, link.com_m, True)
        )
        yield from _joint_lines(f"joint_{number}", "continuous", before, f"link_{number}", reach)
        for part, bearer, place in (
            (_find_standing_part(joint, number), before, reach),
            (_find_turning_part(joint, number), f"link_{number}", 0.0),
        ):
            if has_gears and part is not None and (part.mass or part.inertia):
                yield from _link_lines(part)
                yield from _joint_lines(f"to_{part.name}", "fixed", bearer, part.name, place)
        before, reach = f"link_{number}", link.length_m
    yield from _link_lines(UrdfPart("payload", arm.payload_mass_kg, 0.0))
    yield from _joint_lines("to_payload", "fixed", before, "payload", reach)
    yield "</robot>"


def _find_standing_part(joint: Planetary | Direct, number: int) -> UrdfPart:
    """Masses fixed to the body before a joint: ring and the sun's mass, or the motor's mass."""
    if isinstance(joint, Direct):
        return UrdfPart(f"motor_{number}", joint.motor_mass_kg, 0.0)
    mass = joint.ring_mass_kg + joint.sun_mass_kg
    return UrdfPart(f"ring_{number}", mass, joint.ring_inertia_kg_m2)


def _find_turning_part(joint: Planetary | Direct, number: int) -> UrdfPart | None:
    """Masses that turn with the link after a joint: the carrier, and the planets in place.

    A stage's equivalent mass M is J / (r cos(pressure angle))^2, r the carrier's radius.
    """
    if isinstance(joint, Direct):
        return None
    radius = joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2
    planets = joint.planet_count * joint.planet_mass_kg
    inertia = joint.carrier_inertia_kg_m2
    if inertia is None:
        assert joint.carrier_equivalent_mass_kg is not None  # the arm's own validation
        base_radius = radius * math.cos(math.radians(joint.pressure_angle_deg))
        inertia = joint.carrier_equivalent_mass_kg * base_radius**2
    whole = inertia + planets * radius**2
    return UrdfPart(f"carrier_{number}", joint.carrier_mass_kg + planets, whole)


def _link_lines(part: UrdfPart) -> Iterator[str]:
    """Lines of a link; a thin rod along x, else a disc about z; without mass it is a frame."""
    if not part.mass and not part.inertia:
        yield f'  <link name="{part.name}"/>'
        return
    xx, yy = (0.0, part.inertia) if part.is_rod else (part.inertia / 2, part.inertia / 2)
    yield f'  <link name="{part.name}">'
    yield "    <inertial>"
    yield f'      <origin xyz="{part.com!r} 0 0"/>'
    yield f'      <mass value="{part.mass!r}"/>'
    moments = f'ixx="{xx!r}" ixy="0" ixz="0" iyy="{yy!r}" iyz="0" izz="{part.inertia!r}"'
    yield f"      <inertia {moments}/>"
    yield "    </inertial>"
    yield "  </link>"


def _joint_lines(name: str, kind: str, parent: str, child: str, place: float) -> Iterator[str]:
    """Lines of a joint at a place [m] along x of its parent, about z."""
    yield f'  <joint name="{name}" type="{kind}">'
    yield f'    <parent link="{parent}"/>'
    yield f'    <child link="{child}"/>'
    yield f'    <origin xyz="{place!r} 0 0"/>'
    if kind != "fixed":
        yield '    <axis xyz="0 0 1"/>'
    yield "  </joint>"


def _file_lines(arm: Arm, urdf: str, has_gears: bool) -> Iterator[str]:
    """Lines of the robot's file."""
    gravity = [*arm.gravity_m_per_s2, 0.0]
    head = {"schema_version": 1, "name": arm.name, "title": arm.title, "urdf": urdf}
    yield from format_toml_fields({**head, "tip": "payload", "gravity_m_per_s2": gravity})
    for number, joint in enumerate(arm.joints, 1):
        friction = {"friction_N_m_s_per_rad": joint.friction_N_m_s_per_rad}
        if isinstance(joint, Direct) or not has_gears:
            if not joint.friction_N_m_s_per_rad:
                continue
            yield f"\n[joints.joint_{number}]"
            yield from format_toml_fields({"kind": "direct", **friction})
        else:
            stage = joint.model_dump(mode="json", include={*PlanetaryStage.model_fields})
            meshes = {name: stage.pop(name) for name in ("sun_mesh", "ring_mesh")}
            yield f"\n[joints.joint_{number}]"
            yield from format_toml_fields({**stage, **friction})
            for name, mesh in meshes.items():
                yield f"\n[joints.joint_{number}.{name}]"
                yield from format_toml_fields(mesh)
