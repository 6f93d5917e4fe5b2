"""What of a command, or of a function of Python's, one sort of mechanism cannot have, and why."""

from __future__ import annotations

from typing import NamedTuple

from crosscheck.models.errors import InputError

TEETH = "the teeth of robots follow their joints' angles"
STATES = "equations of robots are judged at states, and no run is made"


class Refusal(NamedTuple):
    """An option of a command, or an argument of a function, that a sort of mechanism has not."""

    command: str
    option: str
    section: str
    reason: str


REFUSALS = (
    Refusal("simulate", "--phase", "robot", TEETH),
    Refusal("simulate", "--ring-rate", "robot", TEETH),
    Refusal("trial", "--scenario", "robot", STATES),
    Refusal("trial", "--after", "robot", "its first answers name every term that is judged"),
    Refusal("trial", "--run-code", "robot", "only an FMU asks for it"),
    Refusal("init", "--joints", "robot", "--urdf has its own joints"),
    Refusal("init", "--direct", "robot", "a robot's joints are direct already"),
    Refusal("build", "switches", "robot", TEETH),
    Refusal("try_equations", "scenarios", "robot", STATES),
    Refusal("try_equations", "switches", "robot", TEETH),
    Refusal("study", "switches", "robot", TEETH),
    Refusal("study", "level", "arm", "an arm's model has its gears"),
)
OTHERS = {"arm": "robots", "robot": "arms"}


def refuse(section: str, command: str, where: str = "", **given: object) -> None:
    """Raise InputError for the first value given that a sort of mechanism cannot have.

    section: of its file, arm or robot; where: the file that has the value, if one has; given: by
    the names of options, or of arguments.
    """
    for refusal in REFUSALS:
        name = refusal.option.removeprefix("--").replace("-", "_")
        if (refusal.section, refusal.command) == (section, command) and given.get(name):
            allowed = f"is for {OTHERS[section]}: {refusal.reason}"
            place = (where, refusal.option) if where else (refusal.option, "")
            raise InputError(*place, None, allowed)
