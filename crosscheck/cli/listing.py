"""`crosscheck list`: what other commands accept. It waits for no engine and no numbers."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from crosscheck.cost.engines import load_engines
from crosscheck.models.errors import format_line
from crosscheck.models.files import builtin_arms, builtin_robots, builtin_scenarios, builtin_title
from crosscheck.registry import MODELS


def list_command() -> None:
    """Print what `ARM`, `ROBOT`, `--model` and `--scenario` accept."""
    table = Table("", "name", "title", box=None)
    for name in builtin_arms():
        table.add_row("arm", name, builtin_title("arms", name))
    for name in builtin_robots():
        table.add_row("robot", name, builtin_title("robots", name))
    for name, entry in MODELS.items():
        limit = "" if "simulate" in entry.promises else "states only"
        table.add_row("model", *_format_model(name, limit, entry.title))
    for name, engine in load_engines().items():
        limit = f"{' and '.join(engine.levels)} only" if engine.levels else ""
        table.add_row("robot model", *_format_model(name, limit, engine.title))
    for name in builtin_scenarios():
        table.add_row("scenario", name, builtin_title("scenarios", name))
    Console().print(table)


def _format_model(name: str, limit: str, title: str) -> tuple[Text, Text]:
    """Name and title of a model, as a package may have chosen them."""
    return Text(format_line(name)), Text(format_line(", ".join(filter(None, (limit, title)))))
