"""`crosscheck view`: a run's file in, a page out that needs nothing else."""

from __future__ import annotations

from pathlib import Path

from crosscheck.kinds import VIEW
from crosscheck.models.inputs import remember
from crosscheck.output import require_file, write_files
from crosscheck.report.rendering import page
from crosscheck.report.vendor import vendored
from crosscheck.report.words import printable
from crosscheck.view.scene import scene
from crosscheck.view.trajectory_file import Run, run_of


def view_command(file: Path, out: Path | None) -> None:
    """Write the page of a trajectory. Raises InputError."""
    remember(file)
    target = require_file(out or file.with_suffix(".html"), VIEW, "--out")
    write_files({target: view_page(run_of(file))})
    print(f"wrote {printable(str(target))}")


def view_page(run: Run) -> str:
    """HTML text with the scene and all that draws it."""
    return page("view", scene=scene(run), three=vendored("three.module.min.js"))
