"""`crosscheck trial` of a robot: its levels, and the smallest explanation of a difference."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import wraps
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck import __version__
from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.cli.answer import answer
from crosscheck.cost.agreement import TOLERANCE, DrawnStates, compared, drawn
from crosscheck.kinds import EXPLAINED
from crosscheck.models.errors import InputError
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import LEVELS, RIGID, Level, Robot, RobotBody
from crosscheck.output import require_files
from crosscheck.report.records import document, plain
from crosscheck.trial.input.loading import object_named, user_code
from crosscheck.trial.robots.candidates import confusions, link_of, numbers, steiner, with_part

STATES = 12
# What an explanation may leave, of the largest difference; and of a quantity's size, by rounding.
LEFT, ROUNDING = 1e-5, 1e-12
LARGEST = 1e50  # of a number that can be compared
PARTS = ("mass_matrix", "bias", "gravity")
MOST_ENTRIES, MOST_EXPLANATIONS = 5, 8


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
    """What a user's equations of a robot are, and what explains them.

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
        """Whether the equations agree with their level."""
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
        """The entries of the project's own derivation, in one row."""
        terms = AnalyticRobot(robot, level).terms(self.states.q, self.states.v)
        return self._row([terms[PARTS.index(part)] for part in self.parts])

    def of_user(self, own: OwnEquations, where: str) -> np.ndarray:
        """The entries of the user's equations, in one row.

        Raises InputError for what is not finite or of another shape.
        """
        found = []
        for part in self.parts:
            function, shape = getattr(own, part), self.sizes[part].shape[1:]
            rows = zip(self.states.q, self.states.v, strict=True)
            values = []
            for q, v in rows:
                own_answer = function(q, v) if part == "bias" else function(q)
                try:
                    given = np.asarray(own_answer)
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
        for part, block in self.blocks(difference).items():
            letter = {"mass_matrix": "M", "bias": "bias", "gravity": "gravity"}[part]
            largest = np.abs(block).max(axis=0)
            for place in np.ndindex(largest.shape):
                if part != "mass_matrix" or place[0] <= place[1]:
                    names = ", ".join(joints[n] for n in place)
                    yield WrongEntry(part, f"{letter}[{names}]", float(largest[place]))

    def _row(self, found: list[np.ndarray]) -> np.ndarray:
        scaled = [value / self.sizes[part] for part, value in zip(self.parts, found, strict=True)]
        return np.concatenate([np.ravel(each) for each in scaled])

    def blocks(self, row: np.ndarray) -> dict[str, np.ndarray]:
        """The entries of a row by part, each in the shape of its sizes."""
        shapes = {part: self.sizes[part].shape for part in self.parts}
        ends = np.cumsum([int(np.prod(shape)) for shape in shapes.values()])
        pieces = zip(shapes.items(), np.split(row, ends[:-1]), strict=True)
        return {part: each.reshape(shape) for (part, shape), each in pieces}


def explained(own: OwnEquations, robot: Robot, seed: int, where: str = "yours") -> Explained:
    """What a user's equations of a robot are.

    Raises InputError for equations that cannot be compared, or whatever they raise.
    """
    parts = tuple(part for part in PARTS if getattr(own, part) is not None)
    if not parts:
        raise InputError(where, "", None, f"has none of {', '.join(PARTS)}")
    question = _Question(robot, parts, drawn(robot, STATES, seed))
    asked = question.of_user(own, where)
    apart = {level: asked - question.of_robot(robot, level) for level in RIGID}
    sizes = {level: float(np.abs(row).max()) for level, row in apart.items()}
    nearest = sorted(RIGID, key=lambda each: sizes[each])
    chosen, found, links = nearest[0], tuple[str, ...](), tuple[str, ...]()
    if sizes[chosen] > TOLERANCE:
        chosen, found = _first(_explanations, question, apart, nearest)
    if sizes[chosen] > TOLERANCE and not found:
        chosen, links = _first(_links, question, apart, nearest)
    worst = sorted(question.entries(apart[chosen]), key=lambda entry: -entry.share)
    wrong = tuple(entry for entry in worst if entry.share > TOLERANCE)
    return Explained(parts, chosen, sizes[chosen], wrong, found, links)


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
    """Words on every single change at a level that leaves nothing of its difference."""
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
    """Couplings of two joints by a rotor or stage, if M lacks one of these and nothing else."""
    robot, q = question.robot, question.states.q
    missing = question.blocks(difference)["mass_matrix"]
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
    """Names of links whose mass, first moments and inertia about the joint make the difference."""
    robot = question.robot
    base = question.of_robot(robot, level)
    for number, body in enumerate(robot.bodies):
        changed = [with_part(robot, "bodies", number, other) for other in _ten(body)]
        columns = np.stack([question.of_robot(each, level) - base for each in changed], axis=1)
        fit = np.linalg.lstsq(columns, difference, rcond=1e-10)[0]
        if _is_all(difference - columns @ fit, difference):
            yield link_of(robot, number)


def _ten(body: RobotBody) -> Iterator[RobotBody]:
    """The body with more of each of the ten parameters on which equations depend linearly."""
    moments = body.mass * body.com
    about = body.inertia + steiner(body.mass, body.com)
    size, inertia = 0.1 * body.mass, 0.1 * float(np.trace(about))
    for number in range(10):
        mass, first, second = body.mass, moments.copy(), about.copy()
        if number == 0:
            mass += size
        elif number < 4:
            first[number - 1] += size * max(float(np.abs(body.com).max()), 0.01)
        else:
            i, j = np.transpose(np.triu_indices(3))[number - 4]
            second[i, j] += inertia
            second[j, i] = second[i, j]
        com = first / mass
        yield RobotBody(mass, com, second - steiner(mass, com))


def try_robot(text: str, name: str, seed: int, json_file: Path | None) -> int:
    """Try a user's equations of a robot: 0 if they agree with a level, and the engines do, else 1.

    text: names the user's equations, whose code is run; name: of the robot. Raises InputError.
    """
    robot = load_robot(name)
    require_files((json_file, EXPLAINED))
    found = explained(own_equations(text, robot), robot, seed, text)
    apart = [each for each in compared(robot, drawn(robot, STATES, seed)) if not each.agrees]
    told = ["the engines differ on this robot: `crosscheck cost` tells where"] if apart else []
    answer([*lines(found), *told], (json_file, lambda: explained_json(found, robot, text)))
    return 0 if found.agrees and not apart else 1


def own_equations(text: str, robot: Robot) -> OwnEquations:
    """The equations that a user names: an object with functions called like PARTS.

    Or a function of the robot that gives such an object. Raises InputError.
    """
    with user_code(text):
        found = object_named(text)
        if callable(found) and not any(hasattr(found, part) for part in PARTS):
            found = found(robot)
        functions = {part: getattr(found, part, None) for part in PARTS}
    given = {part: own for part, own in functions.items() if own is not None}
    for part, own in given.items():
        if not callable(own):
            kind = type(own).__name__
            raise InputError(text, part, None, f"is a {kind}; must be a function")
    return OwnEquations(**{part: _guarded(own, text) for part, own in given.items()})


def _guarded(function: Callable[..., Any], text: str) -> Callable[..., Any]:
    @wraps(function)
    def called(*arguments: Any) -> Any:
        with user_code(text):
            return function(*(each.copy() for each in arguments))

    return called


def lines(found: Explained) -> Iterator[str]:
    """Lines on what the equations are, which entries differ, and what explains it."""
    if found.agrees:
        parts = ", ".join(found.parts)
        yield f"agrees with {found.level} ({LEVELS[found.level]}): {parts}, to {found.share:.1e}"
        return
    wrong = {entry.part for entry in found.entries}
    parts = ", ".join(part for part in found.parts if part in wrong)
    yield f"wrong: {parts} off from {found.level} by up to {found.share:.2g} of an entry's size"
    for entry in found.entries[:MOST_ENTRIES]:
        yield f"  {entry.name}: {entry.share:.2g} of its size"
    if len(found.entries) > MOST_ENTRIES:
        yield f"  and {len(found.entries) - MOST_ENTRIES} more"
    for words in found.explanations[:MOST_EXPLANATIONS]:
        yield f"yours are the equations of {found.level} with {words}"
    if len(found.explanations) > 1:
        yield "each of these alone makes the same equations"
    for link in found.links:
        yield f"all of it is in {link}: its mass, centre of mass and inertia together explain it"
    if not found.explanations and not found.links:
        yield "no single number, frame or place explains it"


def explained_json(found: Explained, robot: Robot, text: str) -> str:
    """JSON text of all that was found."""
    return document(
        {
            "schema_version": 1,
            "robot": robot.name,
            "program": f"geararm-crosscheck {__version__}",
            "equations": text,
            "parts": found.parts,
            "agrees": found.agrees,
            "level": found.level,
            "largest_difference": found.share,
            "entries": plain(found.entries, name="entry", share="difference"),
            "explanations": [{"with": words} for words in found.explanations],
            "links": found.links,
        }
    )
