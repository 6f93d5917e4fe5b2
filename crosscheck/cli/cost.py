"""`crosscheck cost`: what the usual shortcuts in a robot's gears cost."""

from __future__ import annotations

from pathlib import Path

from crosscheck.cli.answer import answer
from crosscheck.cost.cost import FULL, QUICK, cost_of
from crosscheck.cost.motion import given
from crosscheck.cost.output import cost_json, cost_page, lines
from crosscheck.kinds import COST, COST_PAGE
from crosscheck.measured.record import read_record
from crosscheck.models.robot.file import load_robot
from crosscheck.output import require_files, require_writable
from crosscheck.runner.progress import progress_bar

PAGE = "cost.html"


def cost_command(
    name: str,
    motion: Path | None,
    seed: int,
    quick: bool,
    json_file: Path | None,
    out: Path | None,
) -> int:
    """Work out what shortcuts in a robot's gears cost; returns the exit code.

    It is 0 if the engines agree, else 1. Raises InputError.
    """
    robot = load_robot(name)
    page = None if out is None else out / PAGE
    if out is not None:
        require_writable(out)
    require_files((json_file, COST), (page, COST_PAGE))
    along = None if motion is None else given(read_record(motion, len(robot.coordinates)))
    with progress_bar() as told:
        found = cost_of(robot, seed, QUICK if quick else FULL, told, along)
    made = (json_file, lambda: cost_json(found)), (page, lambda: cost_page(found))
    answer(lines(found), *made)
    return 0 if found.agrees else 1
