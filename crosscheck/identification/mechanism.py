"""The mechanism of a comparison: a robot, the rigid levels of its rotors, its files' numbers.

A planar arm is the robot that ``export`` writes of it, with the numbers of its own file.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from itertools import combinations_with_replacement
from typing import Any, NamedTuple

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.errors import InputError
from crosscheck.models.loading import make_rest_scenario, validate_record
from crosscheck.models.paths import assign, find_paths
from crosscheck.models.pinocchio.regressor import BODY_PARAMETERS
from crosscheck.models.robot.planar import build_level_robots
from crosscheck.models.robot.robot import (
    BASE,
    RIGID,
    JointStage,
    Level,
    Robot,
    compute_point_inertia,
)
from crosscheck.models.robot.tree import merge_bodies
from crosscheck.models.robot.urdf import UrdfLink, read_urdf
from crosscheck.registry import build, find_covering_models, find_distinct_levels, find_level_models

# Units of numbers on which torques depend linearly, by the ends of their names.
UNITS = {
    "mass_kg": "kg",
    "inertia_kg_m2": "kg m^2",
    "density_kg_per_m3": "kg/m^3",
    "friction_N_m_s_per_rad": "N m s/rad",
}
STAGE_UNITS = ("equivalent_mass_kg", "inertia_kg_m2")
AXES = tuple(enumerate("xyz"))
# Numbers of a link: path's end, phrase, unit, and where its body has it.
LINK_NUMBERS: tuple[tuple[str, str, str, str, tuple[int, ...]], ...] = (
    ("mass_kg", "mass of {}", "kg", "mass", ()),
    *((f"com_m.{a}", f"centre of mass of {{}} along {a}", "m", "com", (i,)) for i, a in AXES),
    *(
        (f"inertia_kg_m2.{a}{b}", f"inertia I{a}{b} of {{}}", "kg m^2", "inertia", (i, j))
        for (i, a), (j, b) in combinations_with_replacement(AXES, 2)
    ),
)
LIGHTEST = 1e-6  # share of the heaviest body's mass from which on a link counts
STEP = 2.0**-10  # relative, of a number whose slope is asked; of 0, its own unit
LEVEL_PHRASES = {
    "links": "links alone (links)",
    "carriers": "links with the masses at the joints (carriers)",
    "armature": "rotors' inertia on the diagonal (armature)",
    "coupled": "rigid gears (coupled)",
}


class Parameter(NamedTuple):
    """A number of a file by its path, as in ``--set``, its value there, and what people call it.

    is_signed: whether it may be negative.
    """

    path: str
    value: float
    unit: str
    phrase: str
    is_signed: bool = False

    @property
    def step(self) -> float:
        """A small change of it."""
        return STEP * self.value or STEP

    @property
    def is_friction(self) -> bool:
        """Whether it is a joint's friction, which every fit estimates."""
        return self.path.endswith("friction_N_m_s_per_rad")


class RigidLevel(NamedTuple):
    """A rigid level by its name: the level of a robot."""

    name: str
    robot: Robot
    level: Level


class ComparedMechanism(ABC):
    """A mechanism to compare with a record.

    Attributes:
        noun: What messages call its kind.
        robot: It in space, with every body that its files have.
    """

    noun: str
    robot: Robot

    @property
    def name(self) -> str:
        """The name in messages."""
        return self.robot.name

    @property
    @abstractmethod
    def parameters(self) -> tuple[Parameter, ...]:
        """Numbers of its files on which torques depend linearly, or nearly so."""

    @property
    @abstractmethod
    def levels(self) -> tuple[RigidLevel, ...]:
        """The rigid levels that differ, the simplest first."""

    def find_level(self, name: str) -> RigidLevel:
        """The rigid level of a name."""
        return next(each for each in self.levels if each.name == name)

    @abstractmethod
    def change(self, values: Mapping[str, float]) -> ComparedMechanism:
        """The same with other values, by path. Raises InputError for what no file may hold."""

    @abstractmethod
    def turn(self, gravity: np.ndarray) -> ComparedMechanism:
        """The same in another gravity (3,) [m/s^2]."""

    def list_further_models(self, level: str) -> Iterator[tuple[str, Callable[[], Any]]]:
        """Names of models of its own kind at a level, and what builds each."""
        return iter(())

    def describe_level(self, level: str) -> str:
        """A level in a phrase."""
        return LEVEL_PHRASES[level] if self.levels[1:] else f"the rigid {self.noun}"

    def require_parameters(self, paths: Mapping[str, float]) -> None:
        """Raise InputError for a path of ``--tolerance`` that is no parameter's."""
        available = {parameter.path for parameter in self.parameters}
        for path in paths:
            if path not in available:
                allowed = f"must be one of {', '.join(sorted(available))}"
                raise InputError("--tolerance", path, None, allowed)


class PlanarArm(ComparedMechanism):
    """A planar arm."""

    noun = "arm"

    def __init__(self, arm: Arm) -> None:
        self.arm, self._levels = arm, build_level_robots(arm)
        self.robot, _ = self._levels["coupled"]

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Masses, inertias, densities and friction of its file."""
        return tuple(_walk(self.arm.model_dump(), "arm"))

    @cached_property
    def levels(self) -> tuple[RigidLevel, ...]:
        """Links alone, then with what the joints carry, and with gears that turn."""
        return tuple(
            RigidLevel(name, *self._levels[name]) for name in find_distinct_levels(self.arm)
        )

    def change(self, values: Mapping[str, float]) -> PlanarArm:
        """The arm of a changed file."""
        data = {"arm": self.arm.model_dump(mode="json")}
        for path, value in values.items():
            for place in find_paths(data, path, "--tolerance"):
                assign(data, place, value)
        return PlanarArm(validate_record(Arm, data["arm"], self.arm.name))

    def turn(self, gravity: np.ndarray) -> PlanarArm:
        """The arm in a plane of this gravity."""
        return PlanarArm(
            self.arm.model_copy(update={"gravity_m_per_s2": tuple(gravity[:2].tolist())})
        )

    def list_further_models(self, level: str) -> Iterator[tuple[str, Callable[[], Any]]]:
        """Models of planar arms."""
        covering = find_covering_models("rigid", self.arm, usual_switches(self.arm))
        for name in find_level_models(level):
            if name in covering:
                yield f"{name} (planar)", partial(build, name, self.arm, make_rest_scenario())


def _walk(data: Any, path: str) -> Iterator[Parameter]:
    if isinstance(data, Mapping):
        for name, value in data.items():
            if isinstance(value, float) and name.endswith(tuple(UNITS)):
                place = path.split(".")[1:]
                bearer = f"{place[0].removesuffix('s')} {int(place[1]) + 1}" if place else ""
                yield _describe_number(f"{path}.{name}", value, bearer)
            else:
                yield from _walk(value, f"{path}.{name}")
    elif isinstance(data, list | tuple):
        for number, value in enumerate(data):
            yield from _walk(value, f"{path}.{number}")


def _describe_number(path: str, value: float, bearer: str) -> Parameter:
    """A number of a file, called what people call it; bearer: a joint or a link of an arm."""
    field = path.rpartition(".")[2]
    ending = next(each for each in UNITS if field.endswith(each))
    noun = field.removesuffix(ending) + ending.split("_")[0]
    noun = {"payload_mass": "payload", "friction": "viscous_friction"}.get(noun, noun)
    phrase = f"the {noun.replace('_', ' ')}{f' of {bearer}' if bearer else ''}"
    return Parameter(path, value, UNITS[ending], phrase)


Edit = tuple[str, Any, Callable[[Any, float], Any]]  # edit of a table's entry, by a new value


class SpatialRobot(ComparedMechanism):
    """A robot in space.

    links: those of its URDF that move, where they are not as its text has them.
    """

    noun = "robot"

    def __init__(self, robot: Robot, links: Mapping[str, UrdfLink] | None = None) -> None:
        self.robot = robot
        if robot.passive:
            names = ", ".join(robot.coordinate_names[place] for place in robot.passive)
            allowed = "compare needs a torque of each joint, and no motor drives these"
            raise InputError(robot.name, "joints", names, allowed)
        if links is None:
            links = {
                link.name: link
                for link in read_urdf(robot.urdf, robot.name).links
                if link.body is not None and robot.frames[link.name].body != BASE
            }
        self._links = links

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Masses, centres and inertias of links, rotors, suns and planets, friction."""
        return tuple(parameter for parameter, _ in self._list_numbers())

    def _list_numbers(self) -> Iterator[tuple[Parameter, Edit]]:
        """Each parameter, and how it is changed."""
        robot = self.robot
        heaviest = max(body.mass for body in robot.bodies)
        for name, link in self._links.items():
            assert link.body is not None  # as was chosen
            is_frame = link.body.mass < LIGHTEST * heaviest  # what else it says means nothing
            for ending, phrase, unit, field, at in LINK_NUMBERS[: 1 if is_frame else None]:
                value = float(np.asarray(getattr(link.body, field))[at])
                path, is_signed = f"robot.links.{name}.{ending}", unit == "m" or len({*at}) > 1
                number = Parameter(path, value, unit, f"the {phrase.format(name)}", is_signed)
                yield number, ("links", name, partial(_change_body, field, at))
        for place, rotor in enumerate(robot.rotors):
            joint = robot.joints[rotor.joint].name
            path = f"robot.joints.{joint}.rotor_inertia_kg_m2"
            number = Parameter(path, rotor.inertia, "kg m^2", f"the rotor inertia of {joint}")
            yield number, ("rotors", place, partial(_change_field, "inertia"))
        for place, stage in enumerate(robot.stages):
            joint = robot.joints[stage.joint].name
            for field, value in stage.gears:
                if field.endswith(STAGE_UNITS) and value is not None:
                    number = _describe_number(f"robot.joints.{joint}.{field}", value, joint)
                    yield number, ("stages", place, partial(_change_gears, field))
        for place, moved in enumerate(robot.joints):
            path, turns = f"robot.joints.{moved.name}", moved.kind == "revolute"
            if moved.armature:
                unit, phrase = "kg m^2" if turns else "kg", f"the armature of {moved.name}"
                number = Parameter(f"{path}.armature", moved.armature, unit, phrase)
                yield number, ("joints", place, partial(_change_field, "armature"))
            unit, phrase = "N m s/rad" if turns else "N s/m", f"the friction of {moved.name}"
            number = Parameter(f"{path}.friction_N_m_s_per_rad", moved.friction, unit, phrase)
            yield number, ("joints", place, partial(_change_field, "friction"))

    @property
    def levels(self) -> tuple[RigidLevel, ...]:
        """Links alone, and with its rotors if its files have any."""
        robot = self.robot
        has_rotors = robot.rotors or robot.stages or robot.armature.any()
        return tuple(RigidLevel(name, robot, name) for name in RIGID[: 3 if has_rotors else 1])

    def change(self, values: Mapping[str, float]) -> SpatialRobot:
        """The robot with other bodies, rotors and friction; the URDF's text stays as it is."""
        robot = self.robot
        tables: dict[str, Any] = {name: list(getattr(robot, name)) for name in TABLES}
        tables["links"], changed = dict(self._links), set()
        for parameter, (table, entry, edit) in self._list_numbers():
            if parameter.path in values:
                tables[table][entry] = edit(tables[table][entry], values[parameter.path])
                if table == "links":
                    changed.add(robot.frames[entry].body)
        bodies, links = list(robot.bodies), tables["links"]
        for body in changed:
            bodies[body] = merge_bodies(body, list(links.values()), dict(robot.frames))
        parts: dict[str, Any] = {name: tuple(tables[name]) for name in TABLES}
        return SpatialRobot(replace(robot, bodies=tuple(bodies), **parts), links)

    def turn(self, gravity: np.ndarray) -> SpatialRobot:
        """The robot on another base."""
        return SpatialRobot(replace(self.robot, gravity=gravity), self._links)


TABLES = ("joints", "rotors", "stages")


def _change_body(name: str, at: tuple[int, ...], link: UrdfLink, value: float) -> UrdfLink:
    """A link with another mass, place of its centre or moment, the number at a place."""
    assert link.body is not None
    numbers = np.array(getattr(link.body, name))
    numbers[at] = numbers[at[::-1]] = value
    changed: dict[str, Any] = {name: numbers if at else value}
    return replace(link, body=replace(link.body, **changed))


def _change_field(field: str, record: Any, value: float) -> Any:
    return replace(record, **{field: value})


def _change_gears(field: str, stage: JointStage, value: float) -> JointStage:
    return replace(stage, gears=stage.gears.model_copy(update={field: value}))


def list_body_parameters(robot: Robot, names: Sequence[str]) -> np.ndarray:
    """Ten parameters of each body (10 bodies,) in the order of a regressor's names."""
    values: dict[str, float] = {}
    for joint, body in zip(robot.joints, robot.bodies, strict=True):
        inertia = body.inertia + compute_point_inertia(body.mass, body.com)
        moments = inertia[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]
        numbers = [body.mass, *(body.mass * body.com).tolist(), *moments.tolist()]
        keys = (f"{joint.name}: {key}" for key in BODY_PARAMETERS)
        values |= dict(zip(keys, numbers, strict=True))
    return np.array([values[name] for name in names])
