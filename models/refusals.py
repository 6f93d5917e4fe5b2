"""Options and arguments that one kind of mechanism cannot have, and why."""

from __future__ import annotations

from typing import NamedTuple

from crosscheck.models.errors import InputError

TEETH = "the teeth of robots follow their joints' angles"
STATES = "equations of robots are judged at states, and no run is made"


class Refusal(NamedTuple):
    """An option or argument that one kind of mechanism cannot have."""

    command: str
    option: str
    section: str
    reason: str


REFUSALS = (
    Refusal("trial", "--scenario", "robot", STATES),
    Refusal("trial", "--after", "robot", "its first answers name every term that is judged"),
    Refusal("trial", "--run-code", "robot", "only an FMU needs it"),
    Refusal("trial", "co_simulation", "robot", f"{STATES}; export the unit for Model Exchange"),
    Refusal("init", "--joints", "robot", "--urdf has its own joints"),
    Refusal("init", "--direct", "robot", "a robot's joints are direct already"),
    Refusal("build", "switches", "robot", TEETH),
    Refusal("try_equations", "scenarios", "robot", STATES),
    Refusal("try_equations", "switches", "robot", TEETH),
    Refusal("study", "switches", "robot", TEETH),
    Refusal("study", "level", "arm", "an arm's model has its gears"),
)


def refuse(section: str, command: str, where: str = "", **given: object) -> None:
    """Raise InputError for the first value given that a sort of mechanism cannot have.

    section: of its file; where: the file that has the value, if one has; given: by argument.
    """
    rows = [each for each in REFUSALS if (each.section, each.command) == (section, command)]
    for _, option, _, reason in rows:
        if given.get(option.removeprefix("--").replace("-", "_")):
            allowed = f"is for {'robots' if section == 'arm' else 'arms'}: {reason}"
            raise InputError(where or option, option if where else "", None, allowed)
