"""The file of a robot: which URDF, and what turns each joint."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, get_args

import numpy as np
from pydantic import Field

from crosscheck.models.arm import quantities
from crosscheck.models.arm.arm import FreeArm
from crosscheck.models.arm.gears import PlanetaryStage
from crosscheck.models.arm.planets import find_unlike_fields
from crosscheck.models.arm.quantities import Data
from crosscheck.models.errors import InputError
from crosscheck.models.file_kind import XmlKind, describe_xml_kind
from crosscheck.models.files import (
    HERE,
    LARGEST_FILE,
    builtin_robots,
    is_urdf,
    parse_toml,
    read_raw_arm,
    read_raw_robot,
)
from crosscheck.models.inputs import convert_read_errors, read_content
from crosscheck.models.loading import validate_record
from crosscheck.models.robot import robot
from crosscheck.models.robot.inertias import describe_heavy_rotors
from crosscheck.models.robot.robot import BASE, Joint, LinkFrame, Robot
from crosscheck.models.robot.tree import Tree, build_tree
from crosscheck.models.robot.urdf import Urdf, read_urdf

if TYPE_CHECKING:
    from crosscheck.models.robot.mjcf.reading import MjcfRobot
    from crosscheck.models.robot.planar import RobotText

Ratio = Annotated[float, quantities.NumberRange(-1e6, 1e6)]
Component = Annotated[float, quantities.NumberRange(-1e3, 1e3)]
_, LINK_MASS = get_args(quantities.GearMass)  # which masses the file may state
UrdfPath = Annotated[str, quantities.PrintableText(400)]
Vector = Annotated[tuple[Component, Component, Component], Field(strict=False)]


class DirectDrive(Data):
    """A joint whose motor turns its link without gears: the rotor is a part of that link."""

    kind: Literal["direct"]
    """Which sort of transmission this is."""
    friction_N_m_s_per_rad: quantities.Friction | None = None
    """c of the torque -c q' on the link; N s/m if prismatic; else as friction."""


class Geared(Data):
    """A rotor that spins against its stator at a multiple of the joint's rate."""

    kind: Literal["geared"]
    """Which sort of transmission this is."""
    ratio: Ratio
    """The rotor's rate against its stator over the joint's, signed; rad/m if prismatic."""
    rotor_inertia_kg_m2: quantities.GearInertia
    """J of the rotor about its axis."""
    stator: quantities.Name | None = None
    """Link that carries the motor; the joint's parent if left out."""
    rotor_axis: Vector | None = None
    """Axis in the frame of the stator's link; the joint's axis if both are left out."""
    mesh: robot.RotorMesh | None = None
    """Teeth that give way, for the level geared; rigid if left out."""
    friction_N_m_s_per_rad: quantities.Friction | None = None
    """As for a direct joint."""


class PlanetaryTransmission(PlanetaryStage):
    """A 2K-H stage: sun driven, ring on the link before, planets' carrier on the link after.

    An inertia is given as it is, or as the paper's *equivalent mass* M = J / r^2, r the base
    radius.
    """

    friction_N_m_s_per_rad: quantities.Friction | None = None
    """As for a direct joint."""
    planets: Literal["lumped", "free"] | None = None
    """Planets at the level geared: as one or each by itself; free if they differ."""


Transmission = Annotated[DirectDrive | Geared | PlanetaryTransmission, Field(discriminator="kind")]


class LinkChange(Data):
    """Numbers of a link that replace those of the URDF."""

    mass_kg: quantities.GearMass
    """Mass that replaces the URDF's; centre of mass and inertia stay."""


class RobotFile(Data):
    """A robot: a URDF, with the rotors that it does not describe."""

    union_tags: ClassVar[frozenset[str]] = frozenset({"direct", "geared"})

    schema_version: quantities.SchemaVersion
    """Version of the file: 1."""
    name: quantities.Name
    """What reports and messages call the robot."""
    title: quantities.Title = ""
    """One line about it."""
    urdf: UrdfPath
    """The URDF, from this file's folder."""
    gravity_m_per_s2: Annotated[
        tuple[quantities.Acceleration, quantities.Acceleration, quantities.Acceleration],
        Field(strict=False),
    ] = (0.0, 0.0, -9.81)
    """Gravity in the frame of the URDF's root link."""
    tip: quantities.Name | None = None
    """Link whose origin is the end effector; if left out, one with most joints before it."""
    friction: Literal["none", "from-urdf"] = "none"
    """Friction of joints that state none: none, or damping of the URDF's dynamics."""
    joints: dict[str, Transmission] = Field(default_factory=dict)
    """Transmissions by the URDF's names of joints; joints left out are direct."""
    links: dict[str, LinkChange] = Field(default_factory=dict)
    """Changes by the URDF's names of links that have a mass."""


class RobotSource(Data):
    """The files of a robot, as the file of a run keeps them."""

    file: RobotFile
    """Content of the robot's file, or what stands for it where there is a URDF alone."""
    urdf_text: str
    """Content of the URDF."""

    def build(self, where: str = "", urdf_where: str = "") -> Robot:
        """The robot; the names are for messages. Raises InputError."""
        return build_robot(
            self.file, self.urdf_text, where or self.file.name, urdf_where or self.file.urdf
        )


def load_robot(name: str) -> Robot:
    """Load the robot of a built-in name, a TOML file, or a URDF alone, without rotors.

    Args:
        name: A built-in name, or the path of a file; a URDF and MJCF are recognised by their
            content, whatever the file is called.

    Returns:
        The robot, with gravity (3,) [m/s^2] in the frame of its base, and joints in an order in
        which parents are before children.

    Raises:
        InputError: There is no such file, or an element of it does not fit.
    """
    return read_source(name, read_robot_file(name))[1]


def load_urdf(name: str) -> tuple[Urdf, str]:
    """The URDF of a robot's name, whether or not a robot can be made of it, and its path.

    Raises InputError.
    """
    urdf = _urdf_path(name, validate_record(RobotFile, read_robot_file(name), name))
    return read_urdf(read_text(urdf), str(urdf)), str(urdf)


def read_robot_file(name: str) -> dict[str, Any]:
    """The content of a robot's file, unvalidated, or the same of a URDF or an arm on a free base.

    Raises InputError.
    """
    path = Path(name)
    if not is_urdf(name):
        content = read_raw_robot(name)
        if "base" in content:
            return parse_toml(_write_free_arm(path, content).file)
        return content
    alone = {"schema_version": 1, "name": path.stem, "urdf": path.name}
    text = _read_xml(path)
    if describe_xml_kind(text) is XmlKind.MJCF:
        alone["gravity_m_per_s2"] = list(_convert_mjcf(path, text).gravity)
    return alone


def fill_masses(content: dict[str, Any], text: str, where: str) -> None:
    """Add the URDF's masses to what a robot's file holds, so that paths lead to them.

    But for masses that the file may not state, such as of a frame on which nothing depends.

    text: the URDF's; where: its file. Raises InputError.
    """
    links = content.setdefault("links", {})
    urdf, _ = _read_mechanism(text, where)
    for link in urdf.links:
        if link.body is not None and LINK_MASS.allows(link.body.mass):
            links.setdefault(link.name, {"mass_kg": link.body.mass})


def read_source(name: str, content: dict[str, Any]) -> tuple[RobotSource, Robot]:
    """A robot by the content of its file and the URDF beside it. Raises InputError."""
    file = validate_record(RobotFile, content, name)
    urdf = _urdf_path(name, file)
    source = RobotSource(file=file, urdf_text=read_text(urdf))
    return source, source.build(name, str(urdf))


def _urdf_path(name: str, file: RobotFile) -> Path:
    """The path of a robot's URDF, which lies beside its file."""
    folder = HERE / "robots" if name in builtin_robots() else Path(name).parent
    return folder / file.urdf


def build_robot(
    file: RobotFile, text: str, where: str, urdf_where: str, *, is_bounded: bool = True
) -> Robot:
    """The robot of its file and its URDF's text; the names are for messages. Raises InputError.

    is_bounded: as of ``read_urdf``.
    """
    masses = {name: link.mass_kg for name, link in file.links.items()}
    is_damped = file.friction == "from-urdf"
    read = partial(_read_mechanism, text, urdf_where, is_damped, is_bounded)
    urdf, (joints, bodies, frames, doubts) = read()
    if masses:
        heavy = [link.name for link in urdf.links if link.body is not None]
        for name in masses:
            if name not in heavy:
                allowed = f"must be a link that has a mass: {', '.join(heavy)}"
                raise InputError(where, "links", name, allowed)
        urdf, (joints, bodies, frames, doubts) = read(tuple(masses.items()))
    if file.tip is not None and file.tip not in frames:
        raise InputError(where, "tip", file.tip, f"must be a link of {urdf_where}")
    moving = {joint.name: number for number, joint in enumerate(joints)}
    for name in file.joints:
        if name not in moving:
            allowed = f"must be a joint that moves: {', '.join(moving)}"
            raise InputError(where, "joints", name, allowed)
        if _is_geared(file.joints[name]) and not joints[moving[name]].has_motor:
            allowed = "must be direct: the URDF says that no motor drives it"
            raise InputError(where, f"joints.{name}.kind", file.joints[name].kind, allowed)
    rotors = [
        _rotor(moving[name], name, given, urdf, frames, where)
        for name, given in file.joints.items()
        if isinstance(given, Geared)
    ]
    return Robot(
        name=file.name,
        title=file.title,
        urdf=urdf.text,
        gravity=np.array(file.gravity_m_per_s2),
        joints=tuple(_add_stated(joint, file.joints.get(joint.name)) for joint in joints),
        bodies=bodies,
        rotors=tuple(rotors),
        stages=tuple(
            _stage(moving[name], joints[moving[name]], given, where)
            for name, given in file.joints.items()
            if isinstance(given, PlanetaryTransmission)
        ),
        frames=frames,
        tip=file.tip or _default_tip(joints, frames),
        notes=(
            *doubts,
            *describe_heavy_rotors(rotors, joints, bodies),
            *urdf.notes,
            *_list_motor_notes(urdf, joints, file),
        ),
        file_json=file.model_dump_json(exclude_defaults=True),
    )


@lru_cache(maxsize=64)
def _read_mechanism(
    text: str,
    where: str,
    is_damped: bool = False,
    is_bounded: bool = True,
    masses: tuple[tuple[str, float], ...] = (),
) -> tuple[Urdf, Tree]:
    """A URDF and its tree; kept, for robots of a study mostly share theirs. Raises InputError."""
    urdf = read_urdf(text, where, dict(masses), include_damping=is_damped, is_bounded=is_bounded)
    return urdf, build_tree(urdf, where)


def _add_stated(joint: Joint, given: Transmission | None) -> Joint:
    """The joint with the friction that its table states, if any, and no armature beside a rotor."""
    stated = None if given is None else given.friction_N_m_s_per_rad
    friction = joint.friction if stated is None else stated
    return replace(joint, friction=friction, armature=0.0 if _is_geared(given) else joint.armature)


def _is_geared(given: Transmission | None) -> bool:
    return isinstance(given, Geared | PlanetaryTransmission)


def _list_motor_notes(urdf: Urdf, joints: Sequence[Joint], file: RobotFile) -> Iterator[str]:
    """Lines on joints without a motor, and armatures and gears without a rotor in the file."""
    if passive := [joint.name for joint in joints if not joint.has_motor]:
        yield f"no motor drives {', '.join(passive)}: drives have values for the others alone"
    direct = [joint for joint in joints if not _is_geared(file.joints.get(joint.name))]
    if names := [joint.name for joint in direct if joint.armature]:
        yield (
            f"armature of {', '.join(names)} is on the diagonal of M at each level but links,"
            " without a ratio"
        )
    names = [joint.name for joint in direct]
    if gears := [words for name, words in urdf.gears if name in names]:
        yield f"{', '.join(gears)} is not used: crosscheck init reads it"


def _rotor(
    number: int, name: str, given: Geared, urdf: Urdf, frames: Mapping[str, LinkFrame], where: str
) -> robot.Rotor:
    """The rotor of a geared joint, as the robot's file gives it. Raises InputError."""
    (joint,) = (each for each in urdf.joints if each.name == name)
    stator, axis = given.stator or joint.parent, joint.placement.rotation @ joint.axis
    if stator not in frames:
        raise InputError(where, f"joints.{name}.stator", stator, "must be a link of the URDF")
    if given.rotor_axis is not None:
        axis = np.array(given.rotor_axis)
    elif given.stator is not None:
        allowed = "is missing; must be a direction in the frame of the stator's link"
        raise InputError(where, f"joints.{name}.rotor_axis", None, allowed)
    length = np.linalg.norm(axis)
    if not length > 1e-3:
        field = f"joints.{name}.rotor_axis"
        raise InputError(where, field, axis.tolist(), "must have a length over 1e-3")
    if not given.ratio:
        allowed = "must not be 0; without gears the joint is direct"
        raise InputError(where, f"joints.{name}.ratio", given.ratio, allowed)
    inertia = given.rotor_inertia_kg_m2
    return robot.Rotor(number, given.ratio, inertia, stator, axis / length, given.mesh)


def _stage(number: int, joint: Joint, given: PlanetaryTransmission, where: str) -> robot.JointStage:
    """The stage of a joint, as the robot's file gives it. Raises InputError."""
    if joint.kind != "revolute":
        allowed = "must be direct or geared: a planetary stage turns its joint, which slides"
        raise InputError(where, f"joints.{joint.name}.kind", given.kind, allowed)
    unlike = next(find_unlike_fields(given), None)
    if given.planets == "lumped" and unlike is not None:
        field, value = unlike
        allowed = "must be equal for all planets, which mesh in phase, or needs planets = free"
        raise InputError(where, f"joints.{joint.name}.{field}", value, allowed)
    has_free_planets = given.planets == "free" or unlike is not None
    return robot.JointStage(number, given, has_free_planets)


def _default_tip(joints: Sequence[Joint], frames: Mapping[str, LinkFrame]) -> str:
    """The link furthest from the base by moving joints; of such, the last one fixed to others."""
    depth: list[int] = []
    for joint in joints:
        depth.append(1 if joint.parent == BASE else depth[joint.parent] + 1)
    furthest = depth.index(max(depth))
    return [name for name, frame in frames.items() if frame.body == furthest][-1]


def read_text(path: Path) -> str:
    """The text of a URDF, or of the URDF made of an MJCF file or of an arm on a free base.

    Raises InputError.
    """
    text = _read_xml(path)
    if describe_xml_kind(text) is None and "base" in text:
        return _write_free_arm(path, read_raw_arm(str(path))).urdf
    return _convert_mjcf(path, text).urdf if describe_xml_kind(text) is XmlKind.MJCF else text


def _convert_mjcf(path: Path, text: str) -> MjcfRobot:
    from crosscheck.models.robot.mjcf.reading import read_mjcf  # for files of that format alone

    return read_mjcf(path, text)


def _write_free_arm(path: Path, content: dict[str, Any]) -> RobotText:
    """The robot that an arm on a free base is, which names the arm's file as its URDF.

    Raises InputError.
    """
    from crosscheck.models.robot.planar import write_arm_as_robot  # which builds robots by this

    return write_arm_as_robot(validate_record(FreeArm, content, str(path)), path.name)


def _read_xml(path: Path) -> str:
    """The text of a file that is not empty. Raises InputError."""
    with convert_read_errors(str(path)):
        text = read_content(path, LARGEST_FILE).decode("utf-8-sig")
    if not text.strip():
        raise InputError(str(path), "", None, "is empty; a URDF is expected")
    return text
