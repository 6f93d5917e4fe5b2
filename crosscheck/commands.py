"""What the commands do, once the command line is parsed."""

from __future__ import annotations

import json
from pathlib import Path

from rich.console import Console

from crosscheck.api import require_stable_step
from crosscheck.api import simulate as simulate_model
from crosscheck.output import require_writable, write_text
from crosscheck.plan import is_the_papers
from crosscheck.progress import progress_bar, shown_progress
from crosscheck.provenance import provenance
from crosscheck.registry import build
from crosscheck.report.html import report_page
from crosscheck.report.terminal import print_agreement
from crosscheck.run import cross_check
from crosscheck.studies.study import Study, cache_folder
from models.errors import InputError
from models.loading import load_arm, load_case
from models.trajectory import write_netcdf

STDERR = Console(stderr=True)


def run_command(arm: str, out: Path, quick: bool, jobs: int, seed: int) -> int:
    """Cross-check an arm, write the report, print the table; returns the exit code."""
    from crosscheck.paper.report import chapters as paper_chapters  # a second of imports

    chosen = load_arm(arm)
    require_writable(out)
    with shown_progress() as told:
        result = cross_check(chosen, quick=quick, jobs=jobs, seed=seed, told=told)
    with progress_bar() as bar:
        in_brief = not quick and is_the_papers(chosen)
        brief = paper_chapters(Study(cache_folder(), jobs, bar), quick=True) if in_brief else []
        page = report_page(result, brief)
    write_text(out / "agreement.json", result.agreement.to_json())
    write_text(out / "index.html", page)
    print_agreement(result.agreement)
    print(f"wrote {out / 'index.html'} and {out / 'agreement.json'}")
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
    if out.is_dir():
        raise InputError("--out", "", str(out), "is a folder; a file name is expected")
    built = build(model, *case)
    if not force:
        require_stable_step(built)
    require_writable(out.parent)
    with STDERR.status(f"{model}, {case.scenario.name}, {case.scenario.duration_s:g} s"):
        trajectory = simulate_model(built, force=True)
    record = provenance(case.arm, 0, False)
    trajectory.attrs |= {"provenance": json.dumps(record), "command": record["command"]}
    write_netcdf(trajectory, out)
    final = ", ".join(f"{angle:.9g}" for angle in trajectory["theta"].values[-1])
    print(f"wrote {out}: {trajectory.sizes['time']} times, theta at the end {final} rad")
