"""Equations of a robot compared with its levels, and the smallest explanation of a difference."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.cost.agreement import TOLERANCE, DrawnStates, drawn
from crosscheck.models.errors import InputError
from crosscheck.models.robot.robot import RIGID, Level, Robot, RobotBody
from crosscheck.trial.robots.candidates import confusions, link_of, numbers, with_body

STATES = 12
# What an explanation may leave, of the largest difference; and of a quantity's size, by rounding.
LEFT, ROUNDING = 1e-5, 1e-12
LARGEST = 1e50  # of a number that can be compared
PARTS = ("mass_matrix", "bias", "gravity")


@dataclass(frozen=True)
class OwnEquations:
    """A user's functions of one state, q and v (n,): M (n, n), bias and gravity (n,); or None."""

    mass_matrix: Callable[[np.ndarray], object] | None = None
    bias: Callable[[np.ndarray, np.ndarray], object] | None = None
    gravity: Callable[[np.ndarray], object] | None = None


@dataclass(frozen=True)
class WrongEntry:
    """An entry of a part that differs from the nearest level: by how much of its size."""

    part: str
    name: str
    share: float


@dataclass(frozen=True)
class Explained:
    """What a user's equations are.

    level: the nearest, or the nearest at which there is an explanation; share: the largest
    difference from it, in parts of sizes; entries: those that differ, most first; explanations:
    words that complete `the equations of the level with ...`, each of which alone explains all;
    links: where none does, those of which all ten inertial parameters together would.
    """

    parts: tuple[str, ...]
    level: Level
    share: float
    entries: tuple[WrongEntry, ...]
    explanations: tuple[str, ...]
    links: tuple[str, ...]

    @property
    def agrees(self) -> bool:
        """Whether they agree with their level."""
        return self.share <= TOLERANCE


class _Question:
    """Entries of the parts that a user has, at some states, each over its size."""

    def __init__(self, robot: Robot, parts: tuple[str, ...], states: DrawnStates) -> None:
        self.robot, self.parts, self.states = robot, parts, states
        mass = AnalyticRobot(robot, "coupled").mass_matrix(states.q)
        root = np.sqrt(np.diagonal(mass, axis1=1, axis2=2))
        motion = np.sqrt(np.einsum("si,sij,sj->s", states.v, mass, states.v))
        weight = np.sqrt(sum(body.mass for body in robot.bodies)) * 10.0
        self.sizes = {
            "mass_matrix": root[:, :, None] * root[:, None, :],
            "bias": root * (motion * np.abs(states.v).sum(axis=1))[:, None],
            "gravity": root * weight,
        }

    def of_robot(self, robot: Robot, level: Level) -> np.ndarray:
        """Of the project's own derivation, in one row."""
        terms = AnalyticRobot(robot, level).terms(self.states.q, self.states.v)
        return self._row([terms[PARTS.index(part)] for part in self.parts])

    def of_user(self, own: OwnEquations, where: str) -> np.ndarray:
        """Raises InputError for what is not finite or of another shape."""
        found = []
        for part in self.parts:
            function, shape = getattr(own, part), self.sizes[part].shape[1:]
            rows = zip(self.states.q, self.states.v, strict=True)
            answers = [function(q, v) if part == "bias" else function(q) for q, v in rows]
            values = []
            for answer in answers:
                try:
                    given = np.asarray(answer)
                    value = np.array(np.nan) if given.dtype.kind == "c" else given.astype(float)
                except (TypeError, ValueError):
                    value = np.array(np.nan)
                if value.shape != shape or not (np.abs(value) <= LARGEST).all():
                    allowed = f"must return real numbers up to {LARGEST:g} of shape {shape}"
                    raise InputError(where, part, None, allowed)
                values.append(value)
            found.append(np.array(values))
        return self._row(found)

    def entries(self, difference: np.ndarray) -> Iterator[WrongEntry]:
        """The largest difference of each entry, over the states."""
        joints = [self.robot.joints[number].name for number in self.robot.coordinates]
        for part, block in zip(self.parts, self._blocks(difference), strict=True):
            letter = {"mass_matrix": "M", "bias": "bias", "gravity": "gravity"}[part]
            largest = np.abs(block).max(axis=0)
            for place in np.ndindex(largest.shape):
                if part != "mass_matrix" or place[0] <= place[1]:
                    names = ", ".join(joints[n] for n in place)
                    yield WrongEntry(part, f"{letter}[{names}]", float(largest[place]))

    def block(self, row: np.ndarray, part: str) -> np.ndarray:
        """A part of a row, in the shape of its sizes."""
        return self._blocks(row)[self.parts.index(part)]

    def _row(self, found: list[np.ndarray]) -> np.ndarray:
        scaled = [value / self.sizes[part] for part, value in zip(self.parts, found, strict=True)]
        return np.concatenate([np.ravel(each) for each in scaled])

    def _blocks(self, row: np.ndarray) -> list[np.ndarray]:
        shapes = [self.sizes[part].shape for part in self.parts]
        ends = np.cumsum([int(np.prod(shape)) for shape in shapes])
        return [
            each.reshape(shape)
            for each, shape in zip(np.split(row, ends[:-1]), shapes, strict=True)
        ]


def explained(own: OwnEquations, robot: Robot, seed: int, where: str = "yours") -> Explained:
    """Raises InputError for equations that cannot be compared, or whatever they raise."""
    parts = tuple(part for part in PARTS if getattr(own, part) is not None)
    if not parts:
        raise InputError(where, "", None, f"has none of {', '.join(PARTS)}")
    question = _Question(robot, parts, drawn(robot, STATES, seed))
    asked = question.of_user(own, where)
    apart = {level: asked - question.of_robot(robot, level) for level in RIGID}
    sizes = {level: float(np.abs(row).max()) for level, row in apart.items()}
    nearest = sorted(RIGID, key=lambda each: sizes[each])
    chosen = nearest[0]
    found: tuple[str, ...] = ()
    links: tuple[str, ...] = ()
    if sizes[chosen] > TOLERANCE:
        chosen, found = _first(_explanations, question, apart, nearest)
    if sizes[chosen] > TOLERANCE and not found:
        chosen, links = _first(_links, question, apart, nearest)
    worst = sorted(question.entries(apart[chosen]), key=lambda entry: -entry.share)
    return Explained(
        parts,
        chosen,
        sizes[chosen],
        tuple(entry for entry in worst if entry.share > TOLERANCE),
        found,
        links,
    )


def _first(
    search: Callable[[_Question, np.ndarray, Level], Iterator[str]],
    question: _Question,
    apart: dict[Level, np.ndarray],
    nearest: list[Level],
) -> tuple[Level, tuple[str, ...]]:
    """The nearest level at which a search finds anything, and what; else the nearest, and none."""
    for level in nearest:
        found = tuple(search(question, apart[level], level))
        if found:
            return level, found
    return nearest[0], ()


def _is_all(left: np.ndarray, difference: np.ndarray) -> bool:
    return bool(np.abs(left).max() <= max(ROUNDING, LEFT * np.abs(difference).max()))


def _explanations(question: _Question, difference: np.ndarray, level: Level) -> Iterator[str]:
    """Every single change at a level that leaves nothing of its difference."""
    robot = question.robot if level != "links" else replace(question.robot, rotors=(), stages=())
    base = question.of_robot(robot, level)
    for number in numbers(robot):
        up, down = (
            question.of_robot(number.put(number.value + sign * number.step), level) - base
            for sign in (1, -1)
        )
        linear, square = (up - down) / 2, (up + down) / 2
        by = _solved(linear, square, difference)
        if by and _is_all(difference - linear * by - square * by**2, difference):
            value = number.value + by * number.step
            shown = 0.0 if abs(value) < 1e-7 * number.step else value
            own = f"{number.value:.6g} {number.unit}".rstrip()
            yield f"{number.name} = {shown:.6g} {number.unit}".rstrip() + f" (file: {own})"
    for confusion in confusions(robot):
        changed = question.of_robot(confusion.robot, level) - base
        if np.abs(changed).max() > TOLERANCE and _is_all(difference - changed, difference):
            yield confusion.words
    if level == "coupled" and "mass_matrix" in question.parts:
        yield from _missing_pairs(question, difference)


def _solved(linear: np.ndarray, square: np.ndarray, difference: np.ndarray) -> float:
    """x that makes linear x + square x^2 nearest to a difference; 0 if it changes nothing."""
    coefficients = [
        2 * square @ square,
        3 * linear @ square,
        linear @ linear - 2 * square @ difference,
        -linear @ difference,
    ]
    if not coefficients[2] and not coefficients[0]:
        return 0.0
    largest = max(map(abs, coefficients))
    trimmed = [each if abs(each) > 1e-24 * largest else 0.0 for each in coefficients]
    roots = np.roots(np.trim_zeros(trimmed, "f"))
    real = roots[np.abs(roots.imag) <= 1e-6 * (1 + np.abs(roots.real))].real
    if not real.size:
        return 0.0
    left = [np.linalg.norm(difference - linear * x - square * x**2) for x in real]
    return float(real[int(np.argmin(left))])


def _missing_pairs(question: _Question, difference: np.ndarray) -> Iterator[str]:
    """Where M lacks nothing but what the coupling of a rotor, or of a stage, puts at two joints."""
    robot, q = question.robot, question.states.q
    missing = question.block(difference, "mass_matrix")
    names = [robot.joints[number].name for number in robot.coordinates]
    bare = replace(robot, rotors=(), stages=())
    gears = [("rotor", own.joint, replace(bare, rotors=(own,))) for own in robot.rotors]
    gears += [("stage", own.joint, replace(bare, stages=(own,))) for own in robot.stages]
    for kind, joint, alone in gears:
        pair = AnalyticRobot(alone, "coupled").mass_matrix(q)
        pair = (pair - AnalyticRobot(alone, "links").mass_matrix(q)) / question.sizes["mass_matrix"]
        for i, j in zip(*np.triu_indices(len(names), 1), strict=True):
            wanted = np.zeros_like(missing)
            wanted[:, i, j] = wanted[:, j, i] = -pair[:, i, j]
            if np.abs(wanted).max() > TOLERANCE and _is_all(missing - wanted, missing):
                own = robot.joints[joint].name
                yield f"no coupling of {names[i]} and {names[j]} in M by the {kind} of {own}"


def _links(question: _Question, difference: np.ndarray, level: Level) -> Iterator[str]:
    """Links whose mass, first moments and inertia about the joint, all ten, make the difference."""
    robot = question.robot
    base = question.of_robot(robot, level)
    for number, body in enumerate(robot.bodies):
        changed = [with_body(robot, number, other) for other in _ten(body)]
        columns = np.stack([question.of_robot(each, level) - base for each in changed], axis=1)
        fit = np.linalg.lstsq(columns, difference, rcond=1e-10)[0]
        if _is_all(difference - columns @ fit, difference):
            yield link_of(robot, number)


def _ten(body: RobotBody) -> Iterator[RobotBody]:
    """The body with more of each parameter on which equations depend linearly."""
    moments = body.mass * body.com
    about = body.inertia + _steiner(body.mass, body.com)
    size, inertia = 0.1 * body.mass, 0.1 * float(np.trace(about))
    for number in range(10):
        mass, first, second = body.mass, moments.copy(), about.copy()
        if number == 0:
            mass += size
        elif number < 4:
            first[number - 1] += size * max(float(np.abs(body.com).max()), 0.01)
        else:
            i, j = np.triu_indices(3)[0][number - 4], np.triu_indices(3)[1][number - 4]
            second[i, j] += inertia
            second[j, i] = second[i, j]
        com = first / mass
        yield RobotBody(mass, com, second - _steiner(mass, com))


def _steiner(mass: float, com: np.ndarray) -> np.ndarray:
    found: np.ndarray = mass * (com @ com * np.eye(3) - np.outer(com, com))
    return found
