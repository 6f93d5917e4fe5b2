"""Pages of the docs site that the program itself answers: `make docs` writes docs/generated."""

from __future__ import annotations

import inspect
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

from benchmarks.suite.report import format_markdown, read
from crosscheck.cli.app import build_commands
from crosscheck.models.experiment.scenario import Switches
from crosscheck.models.trajectory import VARIABLES, meaning_of, unit_of
from crosscheck.output import write_files
from crosscheck.provenance import ROOT
from crosscheck.registry import BUILT_IN


def write_pages(folder: Path) -> None:
    """All of them. Raises InputError."""
    pages = {
        "commands": describe_commands(),
        "models": describe_models(),
        "output-files": describe_output_files(),
        "benchmark": format_benchmark(ROOT / "benchmarks" / "results.json"),
    }
    write_files({folder / f"{name}.md": text for name, text in pages.items()})


def describe_commands() -> str:
    """Every command with its arguments and options, as the program has them."""
    lines: list[str] = ["# Commands and options\n"]
    for name, command in sorted(_list_commands(build_commands(), "crosscheck")):
        lines.append(f"## {name}\n\n{inspect.cleandoc(command.help or '')}\n")
        rows = [
            [f"`{_format_parameter(each)}`", getattr(each, "help", None) or "", _default(each)]
            for each in command.params
            if each.name != "help"
        ]
        if rows:
            lines.append(format_table(["argument or option", "meaning", "default"], rows))
    return "\n".join(lines)


def _list_commands(command: Any, name: str) -> Iterator[tuple[str, Any]]:
    below = getattr(command, "commands", None)
    if below is None:
        yield name, command
        return
    for child_name, each in below.items():
        yield from _list_commands(each, f"{name} {child_name}")


def _format_parameter(parameter: Any) -> str:
    if parameter.param_type_name == "argument":
        return str(parameter.metavar or parameter.name.upper())
    return ", ".join(parameter.opts)


def _default(parameter: Any) -> str:
    value = parameter.default
    if parameter.required:
        return "required"
    return "" if value is None or value is False or callable(value) else f"`{value}`"


def describe_models() -> str:
    """The built-in models and the switches of the gear model."""
    rows = [
        [f"`{name}`", entry.role, entry.title, ", ".join(sorted(entry.promises))]
        for name, entry in BUILT_IN.items()
    ]
    switches = [
        [f"`{name}`", ", ".join(f"`{each}`" for each in get_args(field.annotation))]
        for name, field in Switches.model_fields.items()
    ]
    return "\n".join(
        [
            "# Models and switches\n",
            "A `geared` model must agree with every other geared one; a `form` is the paper's and",
            "is measured against them; a `rigid` one has no gears; a `robot` is an engine of",
            "robots, whose model at a level is called `engine:level`.\n",
            format_table(["model", "role", "what it is", "abilities"], rows),
            "## Switches\n",
            format_table(["switch", "values"], switches),
            inspect.cleandoc(Switches.__doc__ or "").replace("``", "`"),
            "",
        ]
    )


def describe_output_files() -> str:
    """Variables of a trajectory and fields of the JSON files."""
    rows = [[f"`{name}`", unit_of(name), meaning_of(name)] for name in VARIABLES]
    lines = [
        "# Output files\n",
        "## Trajectory: NetCDF of `crosscheck simulate`\n",
        "Over `time` [s] and `joint`; mesh variables over `planet`, too. Attributes: model, step,",
        "arm, scenario, switches, versions, command. `xarray.open_dataset(file)` reads it.\n",
        format_table(["variable", "unit", "meaning"], rows),
    ]
    for name, title in (
        ("agreement", "agreement.json of `crosscheck run` and `validate --json`"),
        ("trial", "JSON of `crosscheck trial --json`"),
        ("measured", "JSON of `crosscheck compare --json`"),
    ):
        file = ROOT / "crosscheck" / "schema" / f"{name}.schema.json"
        fields = _fields(json.loads(file.read_text(encoding="utf-8")), "")
        lines += [f"## {title}\n", format_table(["field", "type", "meaning"], fields)]
    return "\n".join(lines)


def _fields(schema: dict[str, Any], path: str, root: dict[str, Any] | None = None) -> Any:
    """A row for each field, those inside of lists and objects behind theirs."""
    root = root or schema
    for name, field in schema.get("properties", {}).items():
        field_path, about = f"{path}{name}", field
        while "items" in about or "$ref" in about:
            if "items" in about:
                about, field_path = about["items"], f"{field_path}[]"
            else:
                about = root["$defs"][about["$ref"].rpartition("/")[2]] | {
                    key: value for key, value in about.items() if key != "$ref"
                }
        type_names = about.get("enum") or about.get("type") or about.get("const", "")
        listed = type_names if isinstance(type_names, list) else [type_names]
        words = field.get("description") or about.get("description", "")
        yield [f"`{field_path}`", ", ".join(map(str, listed)), words]
        yield from _fields(about, f"{field_path}.", root)


def format_benchmark(file: Path) -> str:
    """The results of `make bench` that are kept, or how to measure them."""
    if file.exists():
        return format_markdown(*read(file))
    return "# Benchmark results\n\nNone are kept here yet: `make bench` measures them.\n"


def format_table(head: list[str], rows: Any) -> str:
    """A table in Markdown."""
    shown = ["| " + " | ".join(map(_cell, line)) + " |" for line in [head, *rows]]
    return "\n".join([shown[0], "|---" * len(head) + "|", *shown[1:]]) + "\n"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
