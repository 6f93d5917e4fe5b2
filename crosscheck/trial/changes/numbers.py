"""Numbers of a robot by their paths in its record, each of which may be another one."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from pydantic import BaseModel

from crosscheck.models.robot.robot import Robot, RobotBody

AXES = "xyz"
INERTIA = {a + b: (AXES.index(a), AXES.index(b)) for a, b in ("xx", "yy", "zz", "xy", "xz", "yz")}
# Orders in which programs list an inertia: rows of the upper triangle, as URDF; MJCF's fullinertia;
# Voigt's of strains; rows of the lower triangle.
INERTIA_ORDERS = (
    ("xx", "xy", "xz", "yy", "yz", "zz"),
    ("xx", "yy", "zz", "xy", "xz", "yz"),
    ("xx", "yy", "zz", "yz", "xz", "xy"),
    ("xx", "xy", "yy", "xz", "yz", "zz"),
)
ALIKE = 1e-6  # relative tolerance between equal numbers
# Values of a number that somebody may have written by mistake, as parts of the right one.
USUAL = {-1.0: "with the opposite sign", 0.0: "left out", 0.5: "half", 2.0: "twice"}
# Factors between units: of a screw's ratio, or of any number.
UNITS = {
    1e3: "1000 times as large: another unit?",
    1e-3: "1/1000 of it: another unit?",
    2 * np.pi: "2 pi times as large: turns taken for radians?",
    0.5 / np.pi: "1/(2 pi) of it: turns taken for radians?",
    np.pi / 180: "pi/180 of it: degrees taken for radians?",
    180 / np.pi: "180/pi times as large: radians taken for degrees?",
}
# The same of numbers of one unit alone.
UNITS_OF = {
    "kg": {
        2.20462: "2.20462 times as large: pounds?",
        1 / 2.20462: "1/2.20462 of it: taken for pounds?",
    },
    "m": {
        1e2: "100 times as large: centimetres?",
        1e-2: "1/100 of it: taken for centimetres?",
    },
}
TYPED = 2e-5  # relative tolerance of unit factors, which are often typed with five digits
ROUNDED = 1e-12  # largest inertia about itself of a point mass by rounding, over mass x distance^2
FAR = 10  # largest distance of a joint or centre, over the longest distance in the file
FIXED = ", with what is fixed to it"  # behind the name of a link, of all in its body
PLACE = re.compile(r"\d+")  # of a part, in the path of its number
Path = tuple[str | int, ...]  # names of fields, numbers of parts, axes of entries


class NumberField(NamedTuple):
    """Numbers of every part of a kind: where they are, what they are called, and their unit.

    entries: those of a vector or matrix by their axes; whole: what all of them are called, which
    may be wrong by one factor; size: the least step, which differences need.
    """

    kind: str
    path: Path
    words: str
    unit: str
    size: float = 0.0
    entries: Sequence[str] = ("",)
    whole: str = ""


LINK_FIELDS = (
    NumberField("bodies", ("mass",), "mass", "kg"),
    NumberField("bodies", ("com",), "centre of mass, {}", "m", 0.01, AXES, "its centre of mass"),
)
FIELDS = (
    *LINK_FIELDS,
    NumberField("bodies", ("inertia",), "I{}", "kg m^2", 0.0, tuple(INERTIA), "its inertia"),
    NumberField("joints", ("placement", "position"), "its place, {}", "m", 0.1, AXES, "its place"),
    NumberField("rotors", ("inertia",), "inertia", "kg m^2"),
    NumberField("rotors", ("ratio",), "ratio", "", 1.0),
    NumberField("stages", ("gears", "sun_inertia_kg_m2"), "inertia of sun", "kg m^2"),
    NumberField("stages", ("gears", "sun_equivalent_mass_kg"), "equivalent mass of sun", "kg"),
    NumberField("stages", ("gears", "planet_inertia_kg_m2"), "inertia of planet", "kg m^2"),
    NumberField(
        "stages", ("gears", "planet_equivalent_mass_kg"), "equivalent mass of planet", "kg"
    ),
)
# What one factor may make of all parts of a kind.
SHARED = (
    ("bodies", "mass", "every link's mass", "kg"),
    ("bodies", "inertia", "every link's inertia", "kg m^2"),
    ("bodies", "com", "every link's centre of mass", "m"),
    ("rotors", "inertia", "every rotor's inertia", "kg m^2"),
    ("rotors", "ratio", "every rotor's ratio", ""),
)
STAGE_VALUES = [field.path[1] for field in FIELDS if field.kind == "stages"]


@dataclass(frozen=True)
class RobotNumber:
    """A number of a robot, on which its equations depend by at most its square.

    path: of the number in the robot's record, such as bodies.1.com.x; step: a size of it, by which
    differences are taken; put: the robot with another value of it. factor: whether the number is a
    factor, 1, of several numbers of the file in the unit.
    """

    path: str
    name: str
    unit: str
    value: float
    step: float
    put: Callable[[float], Robot]
    factor: bool = False

    @property
    def quantity(self) -> str:
        """What it measures: its unit, and of a length its axis too."""
        return f"{self.unit} along {self.path[-1]}" if self.unit == "m" else self.unit

    @property
    def usual_factors(self) -> list[float]:
        """Factors by which somebody may well have written it."""
        units = (*UNITS, *UNITS_OF.get(self.unit, ())) if self.factor else ()
        return [*USUAL, *units] if self.value else []

    def list_counterparts(self, numbers: Iterable[RobotNumber]) -> list[float]:
        """Values of the same field of other parts, with which a part's may be exchanged."""
        if self.factor or not self.unit or not self.step:
            return []
        field = PLACE.sub("", self.path)
        return [each.value for each in numbers if PLACE.sub("", each.path) == field]

    def has_usual_factor(self, value: float, *, above: float = -np.inf) -> bool:
        """Whether a value is the number times a usual factor, of at least so much."""
        return any(abs(value - by * self.value) < ALIKE * self.step for by in USUAL if by >= above)

    def words(self, value: float) -> str:
        """The number with another value, in words that complete `with ...`."""
        shown = 0.0 if abs(value) < 1e-7 * self.step else value
        if self.factor:
            near = [words for usual, words in USUAL.items() if abs(shown - usual) < ALIKE]
            factor = self.describe_unit(shown) or f"{shown:.6g} times as large"
            return f"{self.name} {near[0] if near else factor}"
        file_value = f"{self.value:.6g} {self.unit}".rstrip()
        words = f"{self.name} = {shown:.6g} {self.unit}".rstrip()
        unit = self.describe_unit(shown)
        return f"{words} (file: {file_value}){unit and f', {unit}'}"

    def describe_unit(self, value: float) -> str:
        """Words on a value that is the number in another unit; '' for none."""
        right = self.value
        units = UNITS | UNITS_OF.get(self.unit, {})
        near = (w for by, w in units.items() if right and abs(value / (by * right) - 1) < TYPED)
        return next(near, "")


def list_numbers(robot: Robot, composed: Collection[int] = ()) -> Iterator[RobotNumber]:
    """The numbers of bodies, joints' places, rotors, stages and gravity that may be wrong.

    composed: bodies, from 0, that are made of several links.
    """
    for kind in ("bodies", "joints", "rotors", "stages"):
        for number in range(len(getattr(robot, kind))):
            suffix = FIXED if kind == "bodies" and number in composed else ""
            whose = name_part(robot, kind, number) + suffix
            for field in (each for each in FIELDS if each.kind == kind):
                yield from _list_field(robot, (kind, number, *field.path), field, whose)
            if kind == "bodies":
                both = [(kind, number, field) for field in ("mass", "inertia")]
                yield _make_factor(robot, both, f"{whose}: its mass and inertia", "kg")
            if kind == "joints" and robot.joints[number].kind == "prismatic":
                yield _make_factor(robot, [(kind, number, "axis")], f"{whose}: its axis", "")
    gravity = NumberField("gravity", (), "{}", "m/s^2", 10.0, AXES)
    yield from _list_field(robot, ("gravity",), gravity, "gravity")
    for kind, name, words, unit in SHARED:
        paths = [(kind, number, name) for number in range(len(getattr(robot, kind)))]
        if len(paths) > 1:
            yield _make_factor(robot, paths, words, unit)


def _list_field(robot: Robot, path: Path, field: NumberField, whose: str) -> Iterator[RobotNumber]:
    values = get_value(robot, path)
    if values is None:
        return
    if field.whole:
        yield _make_factor(robot, [path], f"{whose}: {field.whole}", field.unit)
    size = float(np.trace(values)) if np.ndim(values) == 2 else float(np.abs(values).max())
    if field.path == ("inertia",) and field.kind == "bodies":
        body = robot.bodies[int(path[1])]
        of_mass = body.mass * max(float(np.abs(body.com).max()), 0.01) ** 2
        size = size if size > ROUNDED * of_mass else of_mass
    for entry in field.entries:
        place = (*path, entry) if entry else path
        name, value = f"{whose}: {field.words.format(entry)}", float(get_value(robot, place))
        put = partial(put_value, robot, place)
        step = max(size, field.size)
        yield RobotNumber(".".join(map(str, place)), name, field.unit, value, step, put)


def _make_factor(robot: Robot, paths: Sequence[Path], name: str, unit: str) -> RobotNumber:
    """A factor of all numbers at some paths."""

    def scale(by: float) -> Robot:
        scaled = robot
        for path in paths:
            scaled = put_value(scaled, path, by * get_value(robot, path))
        return scaled

    # What differs among paths is any of its kind.
    places = (each[0] if len({*each}) == 1 else "*" for each in zip(*paths, strict=True))
    path = ".".join(map(str, places))
    return RobotNumber(path, name, unit, 1.0, 1.0, scale, factor=True)


def get_value(record: Any, path: Path) -> Any:
    """What stands at a path of a record; None where a record on the way has nothing."""
    for key in path:
        if record is None:
            return None
        if isinstance(record, np.ndarray):
            record = record[tuple(map(AXES.index, str(key)))]
        else:
            record = record[key] if isinstance(key, int) else getattr(record, key)
    return record


def put_value(record: Any, path: Path, value: Any) -> Any:
    """A copy of a record with another value at a path; all else is shared with it."""
    if not path:
        return value
    key, *rest = path
    if isinstance(record, np.ndarray):
        return set_entry(record, tuple(map(AXES.index, str(key))), value)
    if isinstance(key, int):
        return *record[:key], put_value(record[key], tuple(rest), value), *record[key + 1 :]
    changed = {key: put_value(getattr(record, key), tuple(rest), value)}
    if isinstance(record, BaseModel):
        return record.model_copy(update=changed)
    return replace(record, **changed)


def set_entry(values: np.ndarray, place: tuple[int, ...], value: float) -> np.ndarray:
    """The values with another at a place; of a symmetric matrix at its mirror image too."""
    changed = values.copy()
    changed[place] = changed[place[::-1]] = value
    return changed


def name_part(robot: Robot, kind: str, number: int) -> str:
    """What sentences call a body, joint, rotor or stage."""
    if kind == "bodies":
        return get_link_name(robot, number)
    joint = number if kind == "joints" else getattr(robot, kind)[number].joint
    begin = {"joints": "joint ", "rotors": "rotor of ", "stages": "stage of "}[kind]
    return f"{begin}{robot.joints[joint].name}"


def get_link_name(robot: Robot, number: int) -> str:
    """The URDF's name of the link that a joint moves."""
    return next(name for name, frame in robot.frames.items() if frame.body == number)


def list_equal_numbers(numbers: Iterable[RobotNumber], value: float) -> list[RobotNumber]:
    """Those of some numbers that have a value, which is not 0."""
    single = (each for each in numbers if value and not each.factor)
    return [each for each in single if abs(each.value - value) <= ALIKE * abs(value)]


def is_physical(robot: Robot, file_robot: Robot) -> bool:
    """Whether a robot is possible: no mass or inertia below that of points, nothing far away.

    A body that is none in the file already may be as little. Of a point or a thin rod in the file
    one moment may be given alone, for the others may turn nothing.
    """
    if _measure_reach(robot) > FAR * _measure_reach(file_robot):
        return False
    for body, file_body in zip(robot.bodies, file_robot.bodies, strict=True):
        positive, triangle = _excesses(body)
        file_positive, file_triangle = _excesses(file_body)
        least = min(positive, triangle) if file_triangle > ALIKE else positive
        if body is not file_body and least < min(file_positive, file_triangle, 0.0) - ALIKE:
            return False
    gears = [get_value(stage.gears, (name,)) for stage in robot.stages for name in STAGE_VALUES]
    return all((value or 0.0) >= 0 for value in (*(r.inertia for r in robot.rotors), *gears))


def _measure_reach(robot: Robot) -> float:
    """The largest distance of a joint from the one before it, or of a centre from its joint [m]."""
    points = [joint.placement.position for joint in robot.joints]
    points += [body.com for body in robot.bodies]
    return max(float(np.linalg.norm(point)) for point in points)


def _excesses(body: RobotBody) -> tuple[float, float]:
    """Least of mass and moments, and two moments less the third, relative; below 0: impossible."""
    moments = np.linalg.eigvalsh(body.inertia)
    size = max(float(np.abs(moments).max()), 1e-300)
    triangle = float(moments[0] + moments[1] - moments[2]) / size
    return float(min(moments[0] / size, np.sign(body.mass))), triangle
