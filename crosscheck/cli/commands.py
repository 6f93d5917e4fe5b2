"""`crosscheck run`, `validate` and `baseline`: a cross-check of an arm, and its record."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from rich.console import Console

from crosscheck.baseline.file import (
    baseline_path,
    read_baseline,
    require_committed,
    require_replaceable,
    write_baseline,
)
from crosscheck.baseline.reduction import find_uncompared, find_unrecorded_runs, make_baseline
from crosscheck.baseline.regression import compare
from crosscheck.cli.output import write_requested
from crosscheck.file_types import AGREEMENT, JUNIT, PAGE, RECORD
from crosscheck.models.errors import make_printable
from crosscheck.models.loading import load_selection
from crosscheck.models.mechanism import select_mechanism
from crosscheck.output import require_files
from crosscheck.planning.plan import CrossCheckRequest, request_cross_check
from crosscheck.report.answers import format_agreement_json
from crosscheck.report.formatting import format_count
from crosscheck.report.junit import format_junit
from crosscheck.report.terminal import (
    print_agreement,
    print_answers,
    print_changed,
    print_report_summary,
)
from crosscheck.run import CrossCheck, run_cross_check
from crosscheck.runner.progress import QUIET_S, show_progress

STDERR = Console(stderr=True)
CrossCheckRunner = Callable[[CrossCheckRequest, int], CrossCheck]  # (request, number of processes)


def make_request(
    arm: str, scenarios: list[str] | None, settings: list[str] | None, quick: bool, seed: int
) -> CrossCheckRequest:
    """The request of a command line for a cross-check of an arm or robot. Raises InputError."""
    chosen = select_mechanism(arm, scenarios or [], settings or [])
    return request_cross_check(chosen, quick, seed)


def run_command(chosen: CrossCheckRequest, out: Path, jobs: int) -> int:
    """Cross-check an arm, write the report, print its summary; returns the exit code."""
    require_files((out / "index.html", PAGE), (out / "agreement.json", AGREEMENT))
    result = run_with_progress(chosen, jobs)
    from crosscheck.report.html import write_report  # Matplotlib would delay the simulations

    page, data = write_report(result, out)
    print_report_summary(result.agreement, result.mechanism)
    print(f"wrote {page} and {data}")
    return result.agreement.exit_code


def run_with_progress(chosen: CrossCheckRequest, jobs: int) -> CrossCheck:
    """Cross-check an arm, showing progress and warnings."""
    about = f"cross-checking {make_printable(chosen.name)}"
    with show_progress(about, QUIET_S if chosen.quick else 0.0) as progress:
        return run_cross_check(chosen, jobs=jobs, progress=progress, on_warning=_print_warning)


def _print_warning(line: str) -> None:
    STDERR.print(make_printable(line), markup=False, highlight=False)


def validate_command(
    chosen: CrossCheckRequest, jobs: int, json_file: Path | None, junit: Path | None
) -> int:
    """Cross-check an arm and print the table; returns the exit code. Raises InputError."""
    require_files((json_file, AGREEMENT), (junit, JUNIT))
    agreement = run_with_progress(chosen, jobs).agreement
    write_requested(
        (json_file, lambda: format_agreement_json(agreement, chosen.mechanism)),
        (junit, lambda: format_junit(agreement, f"crosscheck {chosen.name}")),
    )
    print_answers(agreement, chosen.mechanism)
    return agreement.exit_code


def prepare_recording(
    arm: str, scenarios: list[str], settings: list[str], quick: bool, model: str
) -> tuple[CrossCheckRequest, CrossCheckRunner]:
    """Subject of a baseline, and the function that makes it; runs code. Raises InputError."""
    if not model:
        return make_request(arm, scenarios, settings, quick, 0), run_with_progress
    from crosscheck.cli import trial  # SymPy, which no other command needs
    from crosscheck.trial.trial import make_cross_check_request

    chosen = load_selection(arm, scenarios, settings)
    request = trial.make_trial_request(model, chosen, quick=quick, seed=0)
    return make_cross_check_request(request), partial(trial.run_trial_with_progress, request)


def accept_command(
    chosen: CrossCheckRequest,
    folder: Path,
    jobs: int,
    junit: Path | None,
    with_differences: bool,
    runner: CrossCheckRunner = run_with_progress,
) -> int:
    """Cross-check an arm and record the result; returns the exit code.

    runner: makes the result, for example a trial of equations. Checks that differ are recorded
    only ``with_differences``, as known ones. Raises InputError before anything runs if another
    arm's record would be replaced, or if the checkout that holds the record has uncommitted
    changes.
    """
    path = baseline_path(folder, chosen)
    require_files((path, RECORD), (junit, JUNIT))
    require_replaceable(path, chosen.name)
    require_committed(path)
    result = runner(chosen, jobs)
    agreement = result.agreement
    write_requested((junit, lambda: format_junit(agreement, f"crosscheck {chosen.name}")))
    print_agreement(agreement)
    if not _can_be_recorded(result, with_differences):
        return agreement.exit_code or 1
    baseline = make_baseline(result)
    write_baseline(path, baseline)
    for line in find_uncompared(baseline):
        print(make_printable(line))
    counts = [format_count(len(baseline.checks), "verdict")]
    counts += [format_count(len(baseline.runs), "run")]
    counts += [format_count(len(baseline.known), "known difference")] if baseline.known else []
    print(f"wrote {make_printable(str(path))}: {', '.join(counts)}")
    return 0


def _can_be_recorded(result: CrossCheck, with_differences: bool) -> bool:
    """Whether a result may be recorded; prints the reason if not."""
    wrong, lost = result.agreement.disagreeing, list(find_unrecorded_runs(result))
    for line in lost:
        print(make_printable(line))
    if unfinished := sum(finding.verdict == "unfinished" for finding in wrong):
        print(f"{format_count(unfinished, 'unfinished check')}: nothing recorded")
        return False
    if result.agreement.checks and (with_differences or not (wrong or lost)):
        return True
    counts = [format_count(len(wrong), "differing check")]
    counts += [format_count(len(lost), "lost run")] if lost else []
    print(f"{', '.join(counts)}: nothing recorded (--with-differences records known differences)")
    return False


def check_command(
    chosen: CrossCheckRequest,
    folder: Path,
    jobs: int,
    junit: Path | None,
    renew: str,
    runner: CrossCheckRunner = run_with_progress,
) -> int:
    """Repeat a recorded cross-check and print what changed; returns the exit code.

    renew: the command line that replaces the record; runner: as in accept_command.

    Raises InputError, before anything is run, for a record that cannot be compared with this.
    """
    path = baseline_path(folder, chosen)
    require_files((junit, JUNIT), reserved=path)
    baseline = read_baseline(path, chosen, renew)
    agreement = compare(baseline, runner(chosen, jobs))
    write_requested((junit, lambda: format_junit(agreement, f"baseline {chosen.name}")))
    print_changed(agreement)
    return agreement.exit_code


def renewal(
    arm: str,
    folder: Path,
    scenarios: Sequence[str],
    settings: Sequence[str],
    quick: bool,
    model: str = "",
) -> str:
    """The command line that replaces a record."""
    parts = ["crosscheck", "baseline", "accept", arm]
    parts += ["--model", model] if model else []
    parts += ["--dir", str(folder)] if folder != Path("baselines") else []
    parts += [part for name in scenarios for part in ("--scenario", name)]
    parts += [part for setting in settings for part in ("--set", setting)]
    return shlex.join(parts + (["--quick"] if quick else []))
