"""Groups, examples and types that `--help` shows beside each command's own words."""

from __future__ import annotations

import re
from collections import ChainMap
from typing import Any

import typer

# A runnable command line for each command, by group; groups and commands in the order of the help.
GROUPS: dict[str, dict[str, str]] = {
    "Start": {
        "init": "init my-arm.toml --direct",
        "list": "list",
        "show": "show my-arm.toml",
        "validate": "validate my-arm.toml --quick",
        "run": "run my-arm.toml --open",
    },
    "Your equations": {
        "trial": "trial my_model.py:pendulum my-arm.toml --quick",
        "baseline": "baseline accept my-arm.toml",
        "baseline accept": "baseline accept my-arm.toml",
        "baseline check": "baseline check my-arm.toml",
        "export": "export my-arm.toml --model analytic:physical --out arm.c",
    },
    "Your robot": {
        "cost": "cost my.urdf --ratio 101 --rotor-inertia 1e-4",
        "compare": "compare recording.csv my-arm.toml --out compared",
    },
    "Runs and studies": {
        "simulate": "simulate my-arm.toml --model analytic:physical --scenario pd --out run.nc",
        "view": "view run.nc --open",
        "sweep": "sweep study.toml --out study.nc",
        "plot": "plot study.nc",
        "cache": "cache clear",
        "cache clear": "cache clear",
    },
    "The paper": {"errata": "errata", "paper": "paper --figure 7"},
}
# Types as people call them; a switch has none, and an argument's name says enough.
TYPES = {
    "bool": "",
    "str": "TEXT",
    **dict.fromkeys(("path", "Path"), "FILE"),
    **dict.fromkeys(("int", "float"), "NUMBER"),
}
HELP_NAMES = ["-h", "--help"]


def arrange_help(group: Any) -> None:
    """Sort a program's commands into groups, and give each its example and readable types.

    Commands without a group, of installed packages, come first.
    """
    panels = {name: panel for panel, examples in GROUPS.items() for name in examples}
    order = list(panels)
    names = sorted(group.commands, key=lambda name: order.index(name) if name in panels else -1)
    group.commands = {name: group.commands[name] for name in names}
    for name, command in group.commands.items():
        command.rich_help_panel = panels.get(name)
    _describe_command(group, "", dict(ChainMap(*GROUPS.values())))


def _describe_command(command: Any, path: str, examples: dict[str, str]) -> None:
    """Add the example of a command and of those below it; path: its words after the program's."""
    if path in examples:
        command.epilog = f"Example: crosscheck {examples[path]}"
    command.context_settings["help_option_names"] = HELP_NAMES
    help_option = command.get_help_option(typer.Context(command, help_option_names=HELP_NAMES))
    for parameter in (*command.params, help_option):
        _simplify_type(parameter)
    for name, inner in getattr(command, "commands", {}).items():
        _describe_command(inner, f"{path} {name}".strip(), examples)


def _simplify_type(parameter: Any) -> None:
    """Show an option's type in a word, and none of an argument, whose name says it."""
    show = getattr(parameter, "display_type_rich", None)  # older releases of Typer have none

    def describe_type(ctx: typer.Context) -> str:
        if parameter.param_type_name == "argument":
            return ""
        label = re.sub(r"[<>\]]|list\[| range", "", show(ctx=ctx)) if show else ""
        word = TYPES.get(label, label)
        return "DIR" if word == "FILE" and parameter.help.startswith("Folder") else word

    parameter.display_type_rich = describe_type
