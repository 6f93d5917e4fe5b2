"""The robot as data: bodies on moving joints in space, and the rotors that gears turn."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np

from crosscheck.models.arm.gears import PlanetaryStage
from crosscheck.models.arm.layout import Meaning
from crosscheck.models.arm.quantities import Damping, Data, Length, Play, Stiffness
from crosscheck.models.experiment.scenario import switches

if TYPE_CHECKING:
    from crosscheck.models.robot.file import RobotFile

BASE = -1  # number of the ground, in place of a body's
Level = Literal["links", "armature", "coupled", "geared"]
LEVELS: dict[Level, str] = {
    "links": "links alone",
    "armature": "links, and rotors' inertia times ratio squared on the diagonal, uncoupled",
    "coupled": "links, and rotors, suns and planets as bodies that turn by rigid gears",
    "geared": "the same, but where a gear has meshes, their springs alone move the joint",
}
WITH_ROTORS: tuple[Level, ...] = ("coupled", "geared")  # levels that have rotors as bodies
# Laws of planetary meshes: dampers act in contact, and varying springs do all their work.
MESH_LAWS = switches(damping="contact", mesh_work="conservative")
RIGID: tuple[Level, ...] = ("links", "armature", "coupled")  # equal where nothing is geared


@dataclass(frozen=True)
class Placement:
    """Place of a frame in another: rotation (3, 3), its axes as columns, and position (3,) [m]."""

    rotation: np.ndarray
    position: np.ndarray


@dataclass(frozen=True)
class RobotBody:
    """A body that a moving joint carries, with all that is fixed to it.

    In the frame of the link that the joint moves: com (3,) [m], inertia (3, 3) [kg m^2] about com.
    """

    mass: float
    com: np.ndarray
    inertia: np.ndarray


def compute_point_inertia(mass: float, place: np.ndarray) -> np.ndarray:
    """Inertia (3, 3) [kg m^2] about the origin of a point mass [kg] at a place (3,) [m].

    By it a body's inertia about another point follows from that about its centre of mass
    (parallel axis theorem).
    """
    return mass * (place @ place * np.eye(3) - np.outer(place, place))


@dataclass(frozen=True)
class Mimic:
    """A law by which a joint follows another: multiplier times its coordinate, plus offset."""

    joint: int
    multiplier: float
    offset: float


@dataclass(frozen=True)
class JointLimits:
    """Limits of a joint in rad, m, N m or N; infinite where the URDF states none."""

    lower: float
    upper: float
    velocity: float
    effort: float


@dataclass(frozen=True)
class Joint:
    """A joint that moves the body of the same number.

    parent: the body that it stands on, or BASE; placement: of the joint's link at coordinate 0 in
    that body's frame; axis (3,): a unit vector in that link's frame; friction: c of the effort -c
    times the joint's rate on the body and of its reaction on the parent [N m s/rad], [N s/m];
    armature [kg m^2], [kg]: reflected inertia of a rotor of which nothing else is known, on the
    diagonal of M at every level but links; has_motor: False of a passive joint, as of a free base.
    """

    name: str
    kind: Literal["revolute", "prismatic"]
    parent: int
    placement: Placement
    axis: np.ndarray
    limits: JointLimits
    mimic: Mimic | None
    friction: float = 0.0
    armature: float = 0.0
    has_motor: bool = True


class RotorMesh(Data):
    """Teeth between a rotor and its joint: a spring along the line of action, with backlash.

    x is how far the pinion is ahead: its base radius times the rotor's angle less ratio times the
    joint's coordinate. Beyond b the force is k (x -+ b) + d x'; within there is none.
    """

    pinion_base_radius_m: Length
    """Base radius of the rotor's pinion; the wheel's is that times the ratio."""
    stiffness_N_per_m: Stiffness
    """Stiffness k along the line of action."""
    damping_N_s_per_m: Damping = 0.0
    """Damping d along the line of action, while teeth touch."""
    backlash_m: Play = 0.0
    """b, half the clearance along the line of action."""


@dataclass(frozen=True)
class Rotor:
    """A balanced rotor that spins against its stator at ratio times its joint's rate.

    ratio: dimensionless, or [rad/m] of a prismatic joint; inertia [kg m^2]: about its axis, which
    the stator's link does not contain; axis (3,): a unit vector in the frame of the URDF's link
    stator. Its mass and its other inertias are that link's. mesh: None where the gear is rigid.
    """

    joint: int
    ratio: float
    inertia: float
    stator: str
    axis: np.ndarray
    mesh: RotorMesh | None = None


@dataclass(frozen=True)
class JointStage:
    """A planetary stage that turns a revolute joint, about its axis.

    The ring is fixed to the link before the joint, the carrier to the link after it, and the motor
    turns the sun against the link before. What of sun and planets no link contains is their inertia
    about their own axes: their masses and other inertias are the links', those of planets, at their
    places, the link's after the joint.

    has_free_planets: whether each planet has a coordinate at the level geared; else all are equal
    and move as one. Coordinates are x_sp and x_pr, or the sun's advance x_s = x_sp + x_pr and the
    x_pr of each planet.
    """

    joint: int
    gears: PlanetaryStage
    has_free_planets: bool = False

    @property
    def groups(self) -> range:
        """Planets that move by themselves, from 0: the first if it represents all."""
        return range(self.gears.planet_count if self.has_free_planets else 1)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the stage's coordinates at the level geared [m]."""
        if not self.has_free_planets:
            return "x_sp", "x_pr"
        return "x_s", *(f"x_pr{planet + 1}" for planet in self.groups)

    def displacement(self, mesh: Meaning, planet: int) -> np.ndarray:
        """Row that gives x of a planet's mesh by the stage's coordinates; planet from 0.

        Of planets that move as one it is the same for each.
        """
        row = np.zeros(len(self.coordinates))
        if not self.has_free_planets:
            row[self.coordinates.index(mesh)] = 1.0
            return row
        if mesh == "x_sp":
            row[0] = 1.0
        row[1 + planet] = -1.0 if mesh == "x_sp" else 1.0
        return row


@dataclass(frozen=True)
class LinkFrame:
    """The place of a URDF's link in the frame of a body, or of BASE."""

    body: int
    placement: Placement


@dataclass(frozen=True)
class Robot:
    """A tree of bodies on a fixed base.

    Args:
        name: What reports and messages call the robot.
        title: One line about it.
        urdf: The text of the URDF that it was read from.
        gravity: Gravity (3,) [m/s^2] in the base's frame.
        joints: Joints that move, parents before children.
        bodies: The body that each joint moves, in the order of the joints.
        rotors: Rotors of its motors.
        stages: Planetary stages of its joints.
        frames: Frames of links by the URDF's names of these.
        tip: The link that is the end effector, by the same names.
        notes: What of the files is not used, one line each.
        file_json: JSON of the robot's own file, without omitted fields.
    """

    name: str
    title: str
    urdf: str
    gravity: np.ndarray
    joints: tuple[Joint, ...]
    bodies: tuple[RobotBody, ...]
    rotors: tuple[Rotor, ...]
    stages: tuple[JointStage, ...]
    frames: Mapping[str, LinkFrame]
    tip: str
    notes: tuple[str, ...]
    file_json: str = ""

    section: ClassVar = "robot"

    def __repr__(self) -> str:
        """Describe the robot in five lines."""
        gravity = ", ".join(f"{part:g}" for part in self.gravity)
        names = ", ".join(self.joints[number].name for number in self.coordinates)
        return "\n".join(
            (
                f"Robot {self.name}: {self.title}".rstrip(": "),
                f"{_count(self.coordinates, 'joint')}: {names}",
                f"{_count(self.rotors, 'rotor')}, {_count(self.stages, 'planetary stage')}",
                f"{sum(body.mass for body in self.bodies):.4g} kg in motion, tip {self.tip}",
                f"gravity ({gravity}) m/s^2",
            )
        )

    @property
    def content(self) -> RobotFile:
        """The content of the robot's own file."""
        from crosscheck.models.robot.file import RobotFile

        return RobotFile.model_validate_json(self.file_json)

    @property
    def sections(self) -> dict[str, object]:
        """The content of the robot's own file and its URDF, with a path to every link's mass."""
        from crosscheck.models.robot.file import fill_masses

        content = json.loads(self.file_json)
        fill_masses(content, self.urdf, self.name)
        return {"robot": content, "urdf": self.urdf}

    @property
    def run_attributes(self) -> dict[str, str]:
        """What the file of a run keeps of the robot."""
        from crosscheck.models.robot.file import RobotSource

        return {
            "robot": RobotSource(file=self.content, urdf_text=self.urdf).model_dump_json(),
            "joints": json.dumps([joint.name for joint in self.joints]),
            "kinds": json.dumps([joint.kind for joint in self.joints]),
        }

    @property
    def described(self) -> tuple[str, ...]:
        """The parts of the robot, in lines."""
        return tuple(repr(self).splitlines()[1:])

    @property
    def identity(self) -> str:
        """Text by which two robots are one: that of the robot's own file, and of its URDF."""
        return self.file_json + self.urdf

    @property
    def joint_units(self) -> dict[str, str]:
        """Units of the coordinates of all joints that move, by names of the joints."""
        return {j.name: "m" if j.kind == "prismatic" else "rad" for j in self.joints}

    @property
    def coordinates(self) -> tuple[int, ...]:
        """Numbers of the joints whose coordinates are free: those that mimic no other."""
        return tuple(n for n, joint in enumerate(self.joints) if joint.mimic is None)

    @property
    def slides(self) -> list[int]:
        """Numbers, from 1, of the free coordinates that are lengths."""
        kinds = [self.joints[place].kind for place in self.coordinates]
        return [number for number, kind in enumerate(kinds, 1) if kind == "prismatic"]

    @property
    def motors(self) -> list[int]:
        """Places among the free coordinates of those that have a motor."""
        return [n for n, place in enumerate(self.coordinates) if self.joints[place].has_motor]

    @property
    def passive(self) -> list[int]:
        """Places among the free coordinates of those without a motor."""
        return [n for n in range(len(self.coordinates)) if n not in self.motors]

    @property
    def coordinate_names(self) -> list[str]:
        """Names of the joints whose coordinates are free."""
        return [self.joints[number].name for number in self.coordinates]

    def state_names(self, level: Level) -> list[str]:
        """Names of all coordinates at a level: free joints, then x of meshes by their joints."""
        names = self.coordinate_names
        if level == "geared":
            names += [f"x_{self.joints[rotor.joint].name}" for rotor, _ in self.meshes]
            for stage in self.stages:
                names += [f"{x}_{self.joints[stage.joint].name}" for x in stage.coordinates]
        return names

    @property
    def joint_map(self) -> tuple[np.ndarray, np.ndarray]:
        """Factors (joints, free) and offsets (joints,) of all joints by the free coordinates."""
        free, count = self.coordinates, len(self.joints)
        factors, offsets = np.zeros((count, len(free))), np.zeros(count)
        for number, joint in enumerate(self.joints):
            if joint.mimic is None:
                factors[number, free.index(number)] = 1.0
            else:
                factors[number, free.index(joint.mimic.joint)] = joint.mimic.multiplier
                offsets[number] = joint.mimic.offset
        return factors, offsets

    @property
    def friction(self) -> np.ndarray:
        """Viscous friction (free,) on each free coordinate [N m s/rad], [N s/m]."""
        factors, _ = self.joint_map
        return np.array([joint.friction for joint in self.joints]) @ factors**2

    @property
    def armature(self) -> np.ndarray:
        """Armature (free,) on each free coordinate [kg m^2], [kg]."""
        factors, _ = self.joint_map
        return np.array([joint.armature for joint in self.joints]) @ factors**2

    @property
    def meshes(self) -> tuple[tuple[Rotor, RotorMesh], ...]:
        """Rotors that have a mesh; each adds its x [m] to the coordinates of the level geared.

        After these each stage adds its own.
        """
        return tuple((rotor, rotor.mesh) for rotor in self.rotors if rotor.mesh)

    @property
    def stage_columns(self) -> tuple[slice, ...]:
        """The columns of each stage's coordinates at the level geared, among the robot's."""
        first, columns = len(self.coordinates) + len(self.meshes), []
        for stage in self.stages:
            columns.append(slice(first, first + len(stage.coordinates)))
            first = columns[-1].stop
        return tuple(columns)

    @property
    def planet_counts(self) -> list[int]:
        """The number of planets of each free joint that move by themselves, 0 without any."""
        counts = {each.joint: len(each.groups) for each in self.stages if each.has_free_planets}
        return [counts.get(number, 0) for number in self.coordinates]

    @property
    def mesh_coordinates(self) -> int:
        """The number of coordinates that the level geared adds to the joints'."""
        return len(self.meshes) + sum(len(stage.coordinates) for stage in self.stages)

    @property
    def levels(self) -> tuple[Level, ...]:
        """Levels that differ for this robot: geared only if there are teeth that give way."""
        if self.meshes or self.stages:
            return (*RIGID, "geared")
        if self.rotors:
            return RIGID
        return ("links", "armature") if self.armature.any() else ("links",)

    def find_level(self, name: str) -> Level | None:
        """The level of a name, also one that equals a simpler level; None if there is none."""
        return next((each for each in (*RIGID, *self.levels) if each == name), None)


def remove_friction(robot: Robot) -> Robot:
    """The robot without friction in its joints."""
    if not any(joint.friction for joint in robot.joints):
        return robot
    return replace(robot, joints=tuple(replace(each, friction=0.0) for each in robot.joints))


def _count(things: Sequence[object], noun: str) -> str:
    return f"{len(things)} {noun}{'' if len(things) == 1 else 's'}"
