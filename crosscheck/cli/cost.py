"""`crosscheck cost`: what the usual shortcuts in a robot's gears cost."""

from __future__ import annotations

from pathlib import Path

from crosscheck.cli.files.robot_files import load_as_robot
from crosscheck.cli.output import print_and_write
from crosscheck.cost.motion import fit_motion
from crosscheck.cost.output import cost_json, cost_page, describe_result
from crosscheck.cost.shortcuts import FULL, QUICK, compute_costs
from crosscheck.file_types import COST, COST_PAGE
from crosscheck.models.errors import make_printable
from crosscheck.output import require_files
from crosscheck.recordings.record import read_record
from crosscheck.runner.progress import show_progress

PAGE = "cost.html"


def cost_command(
    name: str,
    motion: Path | None,
    rotors: tuple[float | None, float | None],
    seed: int,
    quick: bool,
    json_file: Path | None,
    out: Path | None,
) -> int:
    """Work out what shortcuts in the gears of a robot or an arm cost; returns the exit code.

    It is 0 if the engines agree, else 1. rotors: ratio and inertia [kg m^2] where files state none.
    Raises InputError.
    """
    robot = load_as_robot(name, *rotors)
    page = None if out is None else out / PAGE
    require_files((json_file, COST), (page, COST_PAGE))
    along = None
    if motion is not None:
        count, slides = len(robot.coordinates), robot.slides
        along = fit_motion(read_record(motion, count, slides=slides, is_motion=True))
    with show_progress(f"computing costs of {make_printable(name)}") as progress:
        costs = compute_costs(robot, seed, QUICK if quick else FULL, progress, along)
    requests = (json_file, lambda: cost_json(costs)), (page, lambda: cost_page(costs))
    print_and_write(describe_result(costs), *requests)
    return 0 if costs.agrees else 1
