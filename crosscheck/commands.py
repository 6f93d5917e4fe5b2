"""What the commands do, once the command line is parsed."""

from __future__ import annotations

import json
from pathlib import Path

from rich.console import Console
from rich.markup import escape

from crosscheck.output import require_file, write_files
from crosscheck.plan import is_the_papers
from crosscheck.progress import progress_bar, shown_progress
from crosscheck.provenance import provenance
from crosscheck.registry import entry_of
from crosscheck.report.html import report_page
from crosscheck.report.terminal import print_agreement
from crosscheck.run import cross_check
from crosscheck.studies.study import Study, cache_folder
from crosscheck.tasks import Failure, Request
from crosscheck.workers import perform_all
from models.errors import Unfinished
from models.loading import load_arm, load_case
from models.trajectory import netcdf

STDERR = Console(stderr=True)


def run_command(arm: str, out: Path, quick: bool, jobs: int, seed: int) -> int:
    """Cross-check an arm, write the report, print the table; returns the exit code."""
    from crosscheck.paper.report import chapters as paper_chapters  # a second of imports

    chosen = load_arm(arm)
    files = out / "index.html", out / "agreement.json"
    for file in files:
        require_file(file)
    with shown_progress() as told:
        result = cross_check(chosen, quick=quick, jobs=jobs, seed=seed, told=told)
    with progress_bar() as bar:
        in_brief = not quick and is_the_papers(chosen)
        brief = paper_chapters(Study(cache_folder(), jobs, bar), quick=True) if in_brief else []
        page = report_page(result, brief)
    write_files(dict(zip(files, (page, result.agreement.to_json()), strict=True)))
    print_agreement(result.agreement)
    print(f"wrote {files[0]} and {files[1]}")
    return result.agreement.exit_code


def simulate_command(
    arm: str,
    model: str,
    scenario: str,
    switches: dict[str, str],
    settings: list[str],
    out: Path,
    force: bool,
) -> None:
    """Simulate one model into a NetCDF file."""
    case = load_case(arm, scenario, switches, settings)
    entry_of(model)
    require_file(out, "--out")
    request = Request(model, case, force)
    about = escape(f"{model}, {case.scenario.name}, {case.scenario.duration_s:g} s")
    with STDERR.status(about):
        trajectory = perform_all([request], 1, lambda key: None)[request]
    if isinstance(trajectory, Failure):
        raise Unfinished(f"{model}: {trajectory}")
    if isinstance(trajectory, Exception):
        raise trajectory
    record = provenance(case.arm, 0, False)
    trajectory.attrs |= {"provenance": json.dumps(record), "command": record["command"]}
    write_files({out: netcdf(trajectory)})
    final = ", ".join(f"{angle:.9g}" for angle in trajectory["theta"].values[-1])
    print(f"wrote {out}: {trajectory.sizes['time']} times, theta at the end {final} rad")
