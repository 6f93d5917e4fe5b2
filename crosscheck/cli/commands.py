"""`crosscheck run`, `validate` and `baseline`: an arm is cross-checked, and held to a record."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from dataclasses import replace
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
from crosscheck.baseline.reduction import baseline_of, uncompared, unrecorded
from crosscheck.baseline.regression import compare
from crosscheck.cli.answer import write_asked
from crosscheck.kinds import AGREEMENT, JUNIT, PAGE, RECORD
from crosscheck.models.loading import load_chosen
from crosscheck.output import require_files, write_files
from crosscheck.planning.plan import Wanted
from crosscheck.report.answers import agreement_json
from crosscheck.report.junit import junit_xml
from crosscheck.report.terminal import print_agreement, print_answers, print_changed
from crosscheck.report.words import counted, printable
from crosscheck.run import CrossCheck, Shown, cross_check
from crosscheck.runner.progress import QUIET_S, shown_progress

STDERR = Console(stderr=True)
Made = Callable[[Wanted, int], CrossCheck]  # (what is wanted, processes)


def wanted(
    arm: str, scenarios: list[str] | None, settings: list[str] | None, quick: bool, seed: int
) -> Wanted:
    """What a command line asks to be cross-checked. Raises InputError."""
    chosen = load_chosen(arm, scenarios or [], settings or [])
    own = chosen.scenarios, chosen.switches
    return Wanted(chosen.arm, quick, seed, *own, told=chosen.told)


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
    """Cross-check an arm, with its progress and what a user should know before it."""
    about = f"cross-checking {printable(chosen.arm.name)}"
    with shown_progress(about, QUIET_S if chosen.quick else 0.0) as told:
        return cross_check(chosen, jobs=jobs, told=told, warned=_say, shown=shown)


def _say(line: str) -> None:
    STDERR.print(printable(line), markup=False, highlight=False)


def validate_command(chosen: Wanted, jobs: int, json_file: Path | None, junit: Path | None) -> int:
    """Cross-check an arm and print the table; returns the exit code. Raises InputError."""
    require_files((json_file, AGREEMENT), (junit, JUNIT))
    agreement = checked_aloud(chosen, jobs).agreement
    write_asked(
        (json_file, lambda: agreement_json(agreement, chosen.arm)),
        (junit, lambda: junit_xml(agreement, f"crosscheck {chosen.arm.name}")),
    )
    print_answers(agreement, chosen.arm)
    return agreement.exit_code


def recorded(
    arm: str, scenarios: list[str], settings: list[str], quick: bool, model: str
) -> tuple[Wanted, Made]:
    """What a baseline is to be of, and the function that makes it; runs code. Raises InputError."""
    if not model:
        return wanted(arm, scenarios, settings, quick, 0), checked_aloud
    from crosscheck.cli.trial import asked_of, tried_aloud  # sympy, which nothing else needs
    from crosscheck.trial.trial import wanted_of

    asked = asked_of(model, arm, scenarios, settings, quick=quick, seed=0)
    return wanted_of(asked), partial(tried_aloud, asked)


def accept_command(
    chosen: Wanted,
    folder: Path,
    jobs: int,
    junit: Path | None,
    with_differences: bool,
    made: Made = checked_aloud,
) -> int:
    """Cross-check an arm and record the result; returns the exit code.

    made: the function that makes the result, where equations are tried instead. Checks that differ
    are recorded only ``with_differences``, as known ones. Raises InputError, before anything is
    run, where another arm's record would be replaced, and for uncommitted changes of a checkout
    that the record would lie in.
    """
    path = baseline_path(folder, chosen)
    require_files((path, RECORD), (junit, JUNIT))
    require_replaceable(path, chosen.arm)
    require_committed(path)
    result = made(chosen, jobs)
    agreement = result.agreement
    write_asked((junit, lambda: junit_xml(agreement, f"crosscheck {chosen.arm.name}")))
    print_agreement(agreement)
    if not _may_be_recorded(result, with_differences):
        return agreement.exit_code or 1
    baseline = baseline_of(result)
    write_baseline(path, baseline)
    for line in uncompared(baseline):
        print(printable(line))
    said = [counted(len(baseline.checks), "verdict"), counted(len(baseline.runs), "run")]
    said += [counted(len(baseline.known), "known difference")] if baseline.known else []
    print(f"wrote {printable(str(path))}: {', '.join(said)}")
    return 0


def _may_be_recorded(result: CrossCheck, with_differences: bool) -> bool:
    """Whether all was judged, and nothing is wrong or wanted as it is; prints why not."""
    wrong, lost = result.agreement.disagreeing, list(unrecorded(result))
    for line in lost:
        print(printable(line))
    if unfinished := sum(finding.verdict == "unfinished" for finding in wrong):
        print(f"{counted(unfinished, 'unfinished check')}: nothing recorded")
        return False
    if result.agreement.checks and (with_differences or not (wrong or lost)):
        return True
    told = [counted(len(wrong), "differing check")] + [counted(len(lost), "lost run")] * bool(lost)
    print(f"{', '.join(told)}: nothing recorded (--with-differences records known differences)")
    return False


def check_command(
    chosen: Wanted,
    folder: Path,
    jobs: int,
    junit: Path | None,
    renew: str,
    made: Made = checked_aloud,
) -> int:
    """Repeat a recorded cross-check and print what moved; returns the exit code.

    renew: the command that records anew; made: as accept_command has it.

    Raises InputError, before anything is run, for a record that cannot be held against this.
    """
    path = baseline_path(folder, chosen)
    require_files((junit, JUNIT), apart_from=path)
    baseline = read_baseline(path, chosen, renew)
    again = replace(chosen, seed=baseline.provenance.seed)
    agreement = compare(baseline, made(again, jobs))
    write_asked((junit, lambda: junit_xml(agreement, f"baseline {chosen.arm.name}")))
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
    """The command line that records anew."""
    parts = ["crosscheck", "baseline", "accept", arm]
    parts += ["--model", model] if model else []
    parts += ["--dir", str(folder)] if folder != Path("baselines") else []
    parts += [part for name in scenarios for part in ("--scenario", name)]
    parts += [part for setting in settings for part in ("--set", setting)]
    return shlex.join(parts + (["--quick"] if quick else []))
