"""What the commands do, once the command line is parsed."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from crosscheck.kinds import AGREEMENT, PAGE
from crosscheck.models.loading import load_chosen
from crosscheck.output import require_files, write_files
from crosscheck.planning.plan import Wanted
from crosscheck.report.answers import agreement_json
from crosscheck.report.terminal import print_answers
from crosscheck.report.words import printable
from crosscheck.run import CrossCheck, Shown, cross_check
from crosscheck.runner.progress import QUIET_S, shown_progress

STDERR = Console(stderr=True)


def wanted(
    arm: str, scenarios: list[str] | None, settings: list[str] | None, quick: bool, seed: int
) -> Wanted:
    """What a command line asks to be cross-checked. Raises InputError."""
    chosen = load_chosen(arm, scenarios or [], settings or [])
    laws, told = chosen.switches, chosen.told
    return Wanted(chosen.arm, quick, seed, chosen.scenarios, laws, told=told)


def run_command(chosen: Wanted, out: Path, jobs: int) -> int:
    """Cross-check an arm, write the report, print the table; returns the exit code."""
    from crosscheck.report.plots.charts import Charts

    files = out / "index.html", out / "agreement.json"
    require_files(*zip(files, (PAGE, AGREEMENT), strict=True))
    charts = Charts()
    result = checked_aloud(chosen, jobs, charts.show)
    from crosscheck.report.html import report_page  # Matplotlib, which no simulation waits for

    page = report_page(result, charts.made())
    data = agreement_json(result.agreement, result.arm)
    write_files(dict(zip(files, (page, data), strict=True)))
    print_answers(result.agreement, result.arm)
    print(f"wrote {files[0]} and {files[1]}")
    return result.agreement.exit_code


def checked_aloud(
    chosen: Wanted, jobs: int, shown: Shown = lambda key, outcome: None
) -> CrossCheck:
    """The cross-check, with its progress and what a user should know before it."""
    about = f"cross-checking {printable(chosen.arm.name)}"
    with shown_progress(about, QUIET_S if chosen.quick else 0.0) as told:
        return cross_check(chosen, jobs=jobs, told=told, warned=_say, shown=shown)


def _say(line: str) -> None:
    STDERR.print(printable(line), markup=False, highlight=False)
