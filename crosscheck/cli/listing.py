"""`crosscheck list`: names that other commands accept. It imports no engine and no NumPy."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table
from rich.text import Text

from crosscheck.models.errors import format_line
from crosscheck.models.files import builtin_arms, builtin_robots, builtin_scenarios, builtin_title
from crosscheck.registry import MODELS


def list_command() -> None:
    """Print what `ARM`, `ROBOT`, `--model` and `--scenario` accept, kind by kind."""
    arms = [(name, builtin_title("arms", name)) for name in builtin_arms()]
    robots = [(name, builtin_title("robots", name)) for name in builtin_robots()]
    scenarios = [(name, builtin_title("scenarios", name)) for name in builtin_scenarios()]
    models, engines = [], []
    for model, entry in MODELS.items():
        only = f"{' and '.join(entry.levels)} only" if entry.levels else ""
        if entry.role == "robot":
            engines.append(_format_model(model, only, entry.title))
        else:
            limit = "" if "simulate" in entry.promises else "states only"
            models.append(_format_model(model, limit, entry.title))
    kinds: dict[str, Sequence[tuple[str | Text, str | Text]]] = {
        "arms (ARM)": arms,
        "robots (ROBOT)": robots,
        "scenarios (--scenario)": scenarios,
        "models of an arm (--model)": models,
        "models of a robot": engines,
    }
    width = max(len(str(name)) for rows in kinds.values() for name, _ in rows)
    console = Console()
    for number, (kind, rows) in enumerate(kinds.items()):
        table = Table.grid(padding=(0, 2))
        table.add_column(min_width=width + 2)
        for name, title in rows:
            table.add_row(Text.assemble("  ", name), title)
        console.print(*([""] if number else []), Text(kind, "bold"), table, sep="\n")


def _format_model(name: str, limit: str, title: str) -> tuple[Text, Text]:
    """Name and title of a model, as a package may have chosen them."""
    return Text(format_line(name)), Text(format_line(", ".join(filter(None, (limit, title)))))
