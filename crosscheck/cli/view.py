"""`crosscheck view`: a self-contained page made from a run's file."""

from __future__ import annotations

from pathlib import Path

from crosscheck.file_types import VIEW
from crosscheck.models.errors import make_printable
from crosscheck.models.inputs import remember
from crosscheck.output import require_file, write_files
from crosscheck.report.rendering import render_page
from crosscheck.report.vendor import read_vendored
from crosscheck.view.scene import build_scene
from crosscheck.view.trajectory_file import Run, read_run


def view_command(file: Path, out: Path | None) -> Path:
    """Write the page of a trajectory; returns its file. Raises InputError."""
    remember(file)
    path = out or file.with_suffix(".html")
    target = require_file(path, VIEW, "--out")
    write_files({target: view_page(read_run(file))})
    print(f"wrote {make_printable(str(path))}")
    return target


def view_page(run: Run) -> str:
    """HTML text with the scene and the scripts that draw it."""
    three = read_vendored("three.module.min.js")
    return render_page("view", scene=build_scene(run), three=three)
