"""`crosscheck init`: a commented file to start from, for an arm or a robot."""

from __future__ import annotations

import json
import os
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from crosscheck.models.arm.arm import Arm, Direct, Link, Planetary, describe_loads
from crosscheck.models.arm.mesh import Mesh
from crosscheck.models.arm.quantities import Data, PrintableText, format_number
from crosscheck.models.arm.stiffness import SineStiffness
from crosscheck.models.errors import InputError, make_printable
from crosscheck.models.files import format_toml_fields
from crosscheck.output import require_new, write_new_text
from crosscheck.report.formatting import format_count, join_words
from crosscheck.schema import describe_fields

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from crosscheck.models.robot.robot import Robot
    from crosscheck.models.robot.urdf_gears import StatedGear

COLUMN = 44  # column where explanations begin
PLACES = ("shoulder", "elbow", "wrist")
HEAD = """\
# An arm to begin with: every number is an example. {joints}, from the base to the tip.
# SI units, at the ends of the names. The fields of later joints and links mean the same as those of
# the first. docs/reference/arm-file.md lists all fields, their ranges and the other stiffness laws.
"""
DIRECT_HEAD = """\
# A plain arm: {joints}, from the base to the tip, no gears, no friction, and gravity.
# Every number is an example. SI units, at the ends of the names. crosscheck init without --direct
# writes an arm with gears. docs/reference/arm-file.md lists all fields and their ranges.
"""
ROBOT_HEAD = """\
# Which rotor turns each joint of {urdf}, whose joints these are. A joint without gears stays
# direct. Of one with gears the ratio, with its sign, and the rotor's inertia are needed:
#     {{ kind = "geared", ratio = 100.0, rotor_inertia_kg_m2 = 1e-4 }}
# The motor stands on the link before its joint, along the joint's axis, unless the file says
# stator = "a link", rotor_axis = [1.0, 0.0, 0.0]. docs/reference/robot-file.md lists all fields.
# A planetary stage stands in a table at the end of the file, instead of the joint's line:
#     [joints.NAME]
#     kind = "planetary"
#     sun_teeth = 27
#     planet_teeth = 36
#     ring_teeth = 99 # sun_teeth + 2 planet_teeth
#     module_m = 0.003
#     pressure_angle_deg = 24.6
#     sun_inertia_kg_m2 = 7e-4 # with the motor's rotor
#     planet_inertia_kg_m2 = 1.6e-3 # of each about its own axis
#     [joints.NAME.sun_mesh]
#     stiffness = {{ law = "sine", mean_N_per_m = 1e8, amplitude_N_per_m = 2e7 }}
#     backlash_m = 50e-6
#     tooth_error_m = 5e-6
#     damping_ratio = 0.05
#     [joints.NAME.ring_mesh]
#     stiffness = {{ law = "sine", mean_N_per_m = 1e8, amplitude_N_per_m = 2e7 }}
#     backlash_m = 50e-6
#     tooth_error_m = 5e-6
#     damping_ratio = 0.05
"""
PASSIVE = 'no motor; with friction: { kind = "direct", friction_N_m_s_per_rad = 0.1 }'
GRAVITY = "gravity_m_per_s2 = [0.0, -9.81]"
CAD = "# A link may be a body instead of a rod, with numbers out of a CAD model:"
DIRECT = (
    "# A joint may be a motor without gears; it too needs a link, in its place among the links:"
)


class JointSize(NamedTuple):
    """Numbers of one joint and its link that do not scale with the others; planets: how many."""

    module_m: float
    sun_teeth: int
    planet_teeth: int
    planets: int
    pressure_angle_deg: float
    length_m: float


# From the shoulder on. An arm of few joints has the first of them.
SIZES = (
    JointSize(0.003, 27, 36, 3, 24.0, 1.0),
    JointSize(0.0025, 30, 30, 4, 20.0, 0.75),
    JointSize(0.002, 24, 33, 3, 22.0, 0.55),
    JointSize(0.00175, 28, 28, 4, 20.0, 0.4),
    JointSize(0.0015, 24, 30, 3, 25.0, 0.3),
    JointSize(0.00125, 21, 27, 3, 21.0, 0.2),
    JointSize(0.001, 30, 24, 3, 23.0, 0.15),
)


def init_command(path: Path, joints: int, direct: bool) -> None:
    """Write the template of an arm with 1 to 7 joints. Raises InputError, also if it exists."""
    require_new(path)
    own_name = path.stem if PrintableText(80).allows(path.stem) else "my-arm"
    arm = (make_plain_arm if direct else example_arm)(own_name, joints)
    write_new_text(path, template(arm))
    name, word = make_printable(str(path)), make_printable(shlex.quote(str(path)))
    count = _format_joint_count(joints, direct)
    print(f"wrote {name}: {count}, every number an example")
    print(f"it has {describe_loads(arm)}; edit it, then run")
    for command in ("show", "validate"):
        print(f"  crosscheck {command} {word}")


def template(arm: Arm) -> str:
    """The text of an arm's file, TOML; of one with gears, with what else joints and links may be.

    All its joints are of one kind.
    """
    joints, is_direct = len(arm.joints), isinstance(arm.joints[0], Direct)
    head = DIRECT_HEAD if is_direct else HEAD
    lines = [head.format(joints=_format_joint_count(joints, is_direct)), *_fields(arm, True)]
    for number, joint in enumerate(arm.joints):
        lines += ["", f"# {_place(number, joints)}", *_joint_lines(joint, number == 0)]
    if not is_direct:
        numbers = {"motor_mass_kg": 4.0, "rotor_inertia_kg_m2": 0.02, "friction_N_m_s_per_rad": 1.2}
        direct = _joint_lines(Direct(kind="direct", **numbers), True)
        lines += ["", DIRECT, *(f"# {line}" for line in direct)]
    for number, link in enumerate(arm.links):
        lines += ["", f"[[links]] # from the {_place(number, joints)} on"]
        lines += _fields(link, number == 0)
    if not is_direct:
        from_cad = Link(length_m=0.6, com_m=0.27, mass_kg=11.0, inertia_kg_m2=0.4)
        lines += ["", CAD, *(f"# {line}" for line in ("[[links]]", *_fields(from_cad, True)))]
    return "\n".join(lines) + "\n"


def make_plain_arm(name: str, joints: int) -> Arm:
    """An arm of uniform bodies and motors without mass, under gravity, that shrinks to its tip."""
    motor = Direct(kind="direct", motor_mass_kg=0.0, rotor_inertia_kg_m2=0.0)
    masses = [_two_digits(5 * size.length_m) for size in SIZES[:joints]]
    return Arm(
        schema_version=2,
        name=name,
        title=f"A plain arm of {_format_joint_count(joints, True)}",
        payload_mass_kg=1.0,
        gravity_m_per_s2=(0.0, -9.81),
        joints=(motor,) * joints,
        links=tuple(
            Link(
                length_m=size.length_m,
                com_m=size.length_m / 2,
                mass_kg=mass,
                inertia_kg_m2=_two_digits(mass * size.length_m**2 / 12),
            )
            for size, mass in zip(SIZES, masses, strict=False)
        ),
    )


def example_arm(name: str, joints: int) -> Arm:
    """An arm that shrinks towards its tip; the gears' masses go with the module's square."""
    chosen = SIZES[:joints]
    return Arm(
        schema_version=2,
        name=name,
        title=f"An arm of {_format_joint_count(joints, False)}",
        payload_mass_kg=5.0,
        joints=tuple(_make_joint(size) for size in chosen),
        links=tuple(  # aluminium rods, thinner the shorter they are
            Link(
                length_m=size.length_m,
                com_m=_two_digits(0.48 * size.length_m),
                cross_section_m2=_two_digits(0.01 * size.length_m**0.75),
                density_kg_per_m3=2700.0,
            )
            for size in chosen
        ),
    )


def _make_joint(size: JointSize) -> Planetary:
    scale = size.module_m / SIZES[0].module_m
    area, volume = scale**2, scale**3
    return Planetary(
        kind="planetary",
        sun_teeth=size.sun_teeth,
        planet_teeth=size.planet_teeth,
        ring_teeth=size.sun_teeth + 2 * size.planet_teeth,
        planet_count=size.planets,
        module_m=size.module_m,
        pressure_angle_deg=size.pressure_angle_deg,
        sun_equivalent_mass_kg=_two_digits(0.5 * area),
        planet_equivalent_mass_kg=_two_digits(0.7 * area),
        carrier_equivalent_mass_kg=_two_digits(5.5 * area),
        sun_mass_kg=_two_digits(0.4 * area),
        planet_mass_kg=_two_digits(0.62 * area),
        carrier_mass_kg=_two_digits(6.2 * volume),
        ring_mass_kg=_two_digits(9.5 * volume),
        ring_inertia_kg_m2=_two_digits(0.18 * volume * area),
        friction_N_m_s_per_rad=_two_digits(5 * volume),
        sun_mesh=_make_mesh(1e8, 45e-6, 6e-6, 0.0, scale),
        ring_mesh=_make_mesh(1.2e8, 50e-6, 5e-6, 0.4 + scale, scale),
    )


def _make_mesh(stiffness: float, backlash: float, error: float, phase: float, scale: float) -> Mesh:
    """A mesh from the shoulder's: stiffness as the module times its root, lengths as the module."""
    mean = _two_digits(stiffness * scale**1.5)
    law = SineStiffness(law="sine", mean_N_per_m=mean, amplitude_N_per_m=_two_digits(0.15 * mean))
    return Mesh(
        stiffness=law,
        backlash_m=_two_digits(backlash * scale),
        tooth_error_m=_two_digits(error * scale),
        phase_rad=_two_digits(phase),
        damping_ratio=0.05,
    )


def _joint_lines(joint: Planetary | Direct, explained: bool) -> list[str]:
    """Lines of a joint with its meshes; the fields of both are the same, explained once."""
    lines = ["[[joints]]", *_fields(joint, explained)]
    if isinstance(joint, Planetary):
        lines += ["", "[joints.sun_mesh]", *_fields(joint.sun_mesh, explained)]
        if explained:
            law = joint.sun_mesh.planet_mesh(0).stiffness
            lines += ["", "[joints.sun_mesh.stiffness]", *_fields(law, True)]
        lines += ["", "[joints.ring_mesh]", *_fields(joint.ring_mesh, False)]
    return lines


def _fields(record: Data, explained: bool) -> list[str]:
    """Lines of a record's own numbers and texts, with meaning and unit if ``explained``."""
    lines = []
    for field in describe_fields(type(record)):
        value = getattr(record, field.name)
        has_lines = explained and isinstance(value, Data)
        if value is None or field.lists or isinstance(value, Mesh) or has_lines:
            continue
        is_gravity = field.name == "gravity_m_per_s2"
        line = f"{field.name} = {_toml(value)}" if not is_gravity else GRAVITY
        line = line if not is_gravity or any(value) else f"# {line}"
        meaning = f"[{field.unit}] {field.meaning}" if field.unit else field.meaning
        lines.append(f"{line:<{COLUMN}} # {meaning}" if explained else line)
    return lines


def _toml(value: object) -> str:
    """A value of a field as TOML."""
    if isinstance(value, Data):
        return f"{{ {', '.join(f'{key} = {_toml(entry)}' for key, entry in value)} }}"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, int):
        return str(value)
    assert isinstance(value, float)
    text = format_number(value)
    return text if "." in text or "e" in text else f"{text}.0"


def _two_digits(value: float) -> float:
    return float(f"{value:.2g}")


def _format_joint_count(joints: int, direct: bool) -> str:
    return f"{joints} {'direct' if direct else 'geared'} joint{'s' * (joints > 1)}"


def _place(number: int, joints: int) -> str:
    """Name of a joint in the file, such as shoulder; number: counted from 0."""
    if number and number == joints - 1 and joints > 2:
        return PLACES[-1]
    return PLACES[number] if number < 2 else f"joint {number + 1}"


def init_robot_command(path: Path, urdf: Path) -> None:
    """Write a file for the robot of a URDF. Raises InputError, also if the file exists."""
    from crosscheck.models.files import parse_toml
    from crosscheck.models.loading import validate_record
    from crosscheck.models.robot.file import (  # NumPy
        RobotFile,
        build_robot,
        read_robot_file,
        read_text,
    )
    from crosscheck.models.robot.urdf_gears import read_gears

    require_new(path)
    relative_path = os.path.relpath(urdf, path.parent)
    if not PrintableText(400).allows(relative_path):
        allowed = f"must have {PrintableText(400)} from the folder of {path}"
        raise InputError("--urdf", "", relative_path, allowed)
    name = path.stem if PrintableText(80).allows(path.stem) else "my-robot"
    content = {**read_robot_file(str(urdf)), "name": name, "urdf": relative_path}
    file = validate_record(RobotFile, content, str(path))
    urdf_text = read_text(urdf)
    robot = build_robot(file, urdf_text, str(path), str(urdf))
    moving = {joint.name for joint in robot.joints}
    stated, left_out = read_gears(urdf_text, str(urdf))
    gears = {joint: gear for joint, gear in stated.items() if joint in moving}
    lines = list(robot_joint_lines(robot, gears))
    text = robot_template(robot, relative_path, lines)
    validate_record(RobotFile, parse_toml(text), str(path))  # as it will be read
    write_new_text(path, text)
    geared = sum('"geared"' in line.partition("#")[0] for line in lines)
    kinds = f"{geared} geared as {urdf.name} states" if geared else "all direct"
    passive = [robot.coordinate_names[place] for place in robot.passive]
    kinds = make_printable(kinds + f"; no motor drives {join_words(passive)}" * bool(passive))
    print(f"wrote {make_printable(str(path))}: {format_count(len(lines), 'joint')}, {kinds}")
    for joint, gear in gears.items():
        lack = "" if gear.table else "; not enough for a rotor, left direct"
        print(f"  {make_printable(joint)}: {make_printable(gear.elements)}{lack}")
    for line in left_out:
        print(f"  {make_printable(line)}")
    is_whole = geared + len(passive) == len(lines)
    print(f"{'edit it' if is_whole else 'state the missing rotors'}, then run")
    print(f"  crosscheck cost {make_printable(shlex.quote(str(path)))}")


def robot_joint_lines(robot: Robot, gears: Mapping[str, StatedGear]) -> Iterator[str]:
    """Lines of the joints that mimic none, or that the URDF states a gear of."""
    for number, joint in enumerate(robot.joints):
        gear = gears.get(joint.name) if joint.has_motor else None
        if number not in robot.coordinates and gear is None:
            continue
        table = gear.table if gear is not None and gear.table else {"kind": "direct"}
        (line,) = format_toml_fields({joint.name: table})
        remark = make_printable(gear.elements) if gear else PASSIVE * (not joint.has_motor)
        yield f"{line} # {remark}" if remark else line


def robot_template(robot: Robot, urdf: str, joint_lines: Iterable[str]) -> str:
    """The text of a robot's file, TOML."""
    head = {"schema_version": 1, "name": robot.name, "urdf": urdf}
    content = {**head, "gravity_m_per_s2": robot.gravity.tolist(), "tip": robot.tip}
    fields = format_toml_fields(content)
    return "\n".join([ROBOT_HEAD.format(urdf=urdf), *fields, "", "[joints]", *joint_lines, ""])
