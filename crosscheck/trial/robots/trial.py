"""`crosscheck trial` of equations of a robot: handed over, judged, and told."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import wraps
from pathlib import Path
from typing import Any

from crosscheck import __version__
from crosscheck.cli.answer import answer
from crosscheck.cost.agreement import compared, drawn
from crosscheck.kinds import EXPLAINED
from crosscheck.models.errors import InputError
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import LEVELS, Robot
from crosscheck.output import require_files
from crosscheck.report.records import document, plain
from crosscheck.trial.input.loading import object_named, user_code
from crosscheck.trial.robots.explain import PARTS, STATES, Explained, OwnEquations, explained

MOST_ENTRIES, MOST_EXPLANATIONS = 5, 8


def try_robot(text: str, name: str, seed: int, json_file: Path | None) -> int:
    """The exit code: 0 if the equations agree with a level, and the engines do, else 1.

    text: of the user's equations, whose code is run; name: of the robot. Raises InputError.
    """
    robot = load_robot(name)
    require_files((json_file, EXPLAINED))
    found = explained(own_equations(text, robot), robot, seed, text)
    apart = [each for each in compared(robot, drawn(robot, STATES, seed)) if not each.agrees]
    told = ["the engines differ on this robot: `crosscheck cost` tells where"] if apart else []
    answer([*lines(found), *told], (json_file, lambda: explained_json(found, robot, text)))
    return 0 if found.agrees and not apart else 1


def own_equations(text: str, robot: Robot) -> OwnEquations:
    """Of an object with functions called like PARTS, or of a function of the robot that gives one.

    Raises InputError.
    """
    with user_code(text):
        found = object_named(text)
        if callable(found) and not any(hasattr(found, part) for part in PARTS):
            found = found(robot)
        functions = {part: getattr(found, part, None) for part in PARTS}
    for part, function in functions.items():
        if function is not None and not callable(function):
            kind = type(function).__name__
            raise InputError(text, part, None, f"is a {kind}; must be a function")
    return OwnEquations(
        **{
            part: _guarded(function, text)
            for part, function in functions.items()
            if function is not None
        }
    )


def _guarded(function: Callable[..., Any], text: str) -> Callable[..., Any]:
    @wraps(function)
    def called(*arguments: Any) -> Any:
        with user_code(text):
            return function(*(each.copy() for each in arguments))

    return called


def lines(found: Explained) -> Iterator[str]:
    """What they are, which entries differ, and what explains it."""
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
    """Everything."""
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
