"""The gallery of the docs: examples that are run when the site is built, each with a picture.

``examples/gallery/gallery.toml`` lists them. A page, a notebook and a picture of each are written;
an example whose equations do not agree, or whose mistake is not seen, stops the build.
"""

from __future__ import annotations

import ast
import json
import os
import tempfile
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crosscheck.output import write_files
from crosscheck.provenance import ROOT
from crosscheck.report.trials.output import make_trial_maps
from crosscheck.trial.result import Trial
from tools.notebook import Cell, format_notebook, format_page, read_cells, run_cells
from tools.readme_picture import draw_maps

EXAMPLES = ROOT / "examples"
SCRIPTS = EXAMPLES / "gallery"


@dataclass(frozen=True)
class Entry:
    """An example: a script of cells, or a model that is tried with and without a mistake."""

    file: Path
    arm: str = ""
    mistake: str = ""
    right: str = ""
    wrong: str = ""

    @property
    def name(self) -> str:
        """Of its page."""
        return self.file.stem


@dataclass(frozen=True)
class Example:
    """An entry that was run; finding: what it says of the mistake, or prints last."""

    entry: Entry
    title: str
    cells: list[Cell]
    picture: str
    finding: str


def read_entries() -> list[Entry]:
    """The entries in the gallery's order."""
    listed = tomllib.loads((SCRIPTS / "gallery.toml").read_text(encoding="utf-8"))["entries"]
    return [
        Entry(SCRIPTS / each["script"])
        if "script" in each
        else Entry(EXAMPLES / each.pop("trial"), **each)
        for each in listed
    ]


def run_entry(entry: Entry) -> Example:
    """An example with what it shows. Raises what its code raises."""
    with tempfile.TemporaryDirectory() as folder:
        before = Path.cwd()
        os.chdir(folder)
        try:
            return _run_trials(entry) if entry.arm else _run_script(entry)
        finally:
            os.chdir(before)


def _run_script(entry: Entry) -> Example:
    names: dict[str, Any] = {}
    cells = run_cells(read_cells(entry.file.read_text(encoding="utf-8")), names)
    title = cells[0].source.partition("\n")[0].removeprefix("# ")
    drawn = [text for cell in cells for kind, text in cell.outputs if kind == "image/svg+xml"]
    trials = [each for each in names["Out"].values() if isinstance(each, Trial)]
    if not (failed := [each for each in trials if each.exit_code]):
        lines = [text for cell in cells for kind, text in cell.outputs if kind == "text/plain"]
        return Example(entry, title, cells, drawn[-1], lines[-1].splitlines()[-1])
    return Example(entry, title, cells, _draw_trial(failed[0]), _describe_mistake(failed[0]))


def _run_trials(entry: Entry) -> Example:
    """The model as it is, then with its mistake."""
    source = entry.file.read_text(encoding="utf-8")
    if source.count(entry.right) != 1:
        raise ValueError(f"{entry.file}: {entry.right!r} is not there once")
    tree = ast.parse(source)
    title, _, about = (ast.get_docstring(tree) or "").partition("\n")
    title, _, more = title.rstrip(".").partition(": ")
    code = "\n".join(source.splitlines()[tree.body[0].end_lineno :]).strip()
    attempt = f'trial = crosscheck.try_equations(model, "{entry.arm}", name="{entry.name}")\ntrial'
    cells = [
        Cell(f"# {title}\n\n{more[:1].upper()}{more[1:]}\n\n{_as_markdown(about)}"),
        Cell(code, is_code=True),
        Cell(f"import crosscheck\n\n{attempt}", is_code=True),
    ]
    names: dict[str, Any] = {}
    cells = run_cells(cells, names)
    if names["trial"].exit_code != 0:
        raise ValueError(f"{entry.file}: does not agree\n{names['trial']}")
    wrong: dict[str, Any] = {}
    (_, shown) = run_cells([Cell(code.replace(entry.right, entry.wrong), True), cells[2]], wrong)
    if wrong["trial"].exit_code == 0:
        raise ValueError(f"{entry.file}: its mistake is not seen")
    change = f"```diff\n-{entry.right}\n+{entry.wrong}\n```"
    cells.append(Cell(f"## {entry.mistake}\n\n{change}\n\nWith this change above, the trial says:"))
    cells.append(Cell("trial", is_code=True, outputs=shown.outputs))
    finding = _describe_mistake(wrong["trial"])
    return Example(entry, title, cells, _draw_trial(wrong["trial"]), finding)


def _describe_mistake(trial: Trial) -> str:
    """The cause that a trial names first, or else its verdict."""
    text = next(iter(trial.causes), trial.verdict.text)
    return f"the model {text}" if text.startswith("is ") else text


def _as_markdown(about: str) -> str:
    """The text of a docstring, its command as a block."""
    lines = [line.strip() for line in about.strip().splitlines()]
    return "\n".join(f"```sh\n{x}\n```" if x.startswith("crosscheck ") else x for x in lines)


def _draw_trial(trial: Trial) -> str:
    """The first map of a trial with an entry that differs."""
    maps = make_trial_maps(trial)
    return draw_maps(
        [next(each for each in maps if any(c.shade for row in each.cells for c in row))]
    )


def write_example(example: Example, pages: Path, files: Path) -> None:
    """Its page, and what the page and its card link to."""
    name, source = example.entry.name, example.entry.file
    head, *rest = example.cells
    title, _, text = head.source.partition("\n")
    download = (
        f'<p class="download"><a download href="../../gallery/{name}.ipynb">Notebook</a>, '
        f'<a download href="../../gallery/{name}.py">script</a></p>'
    )
    page = [Cell(f"{title}\n\n```{{raw}} html\n{download}\n```\n{text}"), *rest]
    write_files(
        {
            pages / f"{name}.md": format_page(page),
            files / f"{name}.svg": example.picture,
            files / f"{name}.py": source.read_text(encoding="utf-8"),
            files / f"{name}.ipynb": json.dumps(format_notebook(example.cells), indent=1),
        }
    )
