"""`crosscheck validate` and `crosscheck baseline`: all checks, without the report page."""

from __future__ import annotations

import os
import shlex
from pathlib import Path

from crosscheck.baseline import Baseline
from crosscheck.baseline_file import (
    baseline_path,
    read_baseline,
    require_replaceable,
    write_baseline,
)
from crosscheck.output import require_file, write_text
from crosscheck.progress import shown_progress
from crosscheck.reduction import baseline_of, uncompared, unrecorded
from crosscheck.regression import compare
from crosscheck.report.junit import junit_xml
from crosscheck.report.moved import print_moved
from crosscheck.report.terminal import print_agreement
from crosscheck.report.words import counted, printable
from crosscheck.run import CrossCheck, cross_check
from models.arm import Arm
from models.errors import InputError
from models.loading import load_arm


def validate_command(
    arm: str, quick: bool, jobs: int, seed: int, json_file: Path | None, junit: Path | None
) -> int:
    """Cross-check an arm and print the table; returns the exit code. Raises InputError."""
    chosen = load_arm(arm)
    _require_files(json_file, junit)
    agreement = _checked(chosen, quick, jobs, seed).agreement
    if json_file is not None:
        write_text(json_file, agreement.to_json())
    if junit is not None:
        write_text(junit, junit_xml(agreement, f"crosscheck {chosen.name}"))
    print_agreement(agreement)
    return agreement.exit_code


def accept_command(
    arm: str, folder: Path, quick: bool, jobs: int, junit: Path | None, with_red: bool
) -> int:
    """Cross-check an arm and record the result; returns the exit code.

    Red checks are recorded only ``with_red``, as known differences. Raises InputError, before
    anything is run, where another arm's record would be replaced.
    """
    chosen = load_arm(arm)
    path = baseline_path(folder, chosen, quick)
    _require_files(path, junit)
    require_replaceable(path, chosen)
    result = _checked(chosen, quick, jobs, seed=0)
    agreement = result.agreement
    if junit is not None:
        write_text(junit, junit_xml(agreement, f"crosscheck {chosen.name}"))
    print_agreement(agreement)
    if not _may_be_recorded(result, with_red):
        return 1
    _record(path, baseline_of(result))
    return 0


def _may_be_recorded(result: CrossCheck, with_red: bool) -> bool:
    """Whether nothing is wrong, or it is wanted as it is; says why not."""
    red, lost = result.agreement.red, list(unrecorded(result))
    for line in lost:
        print(printable(line))
    if result.agreement.checks and (with_red or not (red or lost)):
        return True
    wrong = [counted(len(red), "red check")] + ([counted(len(lost), "lost run")] if lost else [])
    print(f"{', '.join(wrong)}: nothing recorded (--with-red records known differences)")
    return False


def _record(path: Path, baseline: Baseline) -> None:
    write_baseline(path, baseline)
    for line in uncompared(baseline):
        print(printable(line))
    verdicts, runs = counted(len(baseline.checks), "verdict"), counted(len(baseline.runs), "run")
    known = counted(len(baseline.known), "known difference")
    print(
        f"wrote {printable(str(path))}: {verdicts}, {runs}{f', {known}' if baseline.known else ''}"
    )


def check_command(arm: str, folder: Path, quick: bool, jobs: int, junit: Path | None) -> int:
    """Repeat a recorded cross-check and print what moved; returns the exit code.

    Raises InputError, before anything is run, for a record that cannot be held against this.
    """
    chosen = load_arm(arm)
    path = baseline_path(folder, chosen, quick)
    _require_files(junit, apart_from=path)
    baseline = read_baseline(path, chosen, quick, _renewal(arm, folder, quick))
    agreement = compare(baseline, _checked(chosen, quick, jobs, baseline.provenance.seed))
    if junit is not None:
        write_text(junit, junit_xml(agreement, f"baseline {chosen.name}"))
    print_moved(agreement)
    return agreement.exit_code


def _renewal(arm: str, folder: Path, quick: bool) -> str:
    """The command that records anew."""
    parts = ["crosscheck", "baseline", "accept", arm]
    parts += ["--dir", str(folder)] if folder != Path("baselines") else []
    return shlex.join(parts + (["--quick"] if quick else []))


def _checked(arm: Arm, quick: bool, jobs: int, seed: int) -> CrossCheck:
    with shown_progress() as told:
        return cross_check(arm, quick=quick, jobs=jobs, seed=seed, told=told)


def _require_files(*paths: Path | None, apart_from: Path | None = None) -> None:
    """Raise InputError unless each can be written and is a file of its own: before the work."""
    taken = set() if apart_from is None else {os.path.realpath(apart_from)}
    for path in filter(None, paths):
        target = require_file(path)
        if os.path.realpath(target) in taken:
            raise InputError(str(path), "", None, "is in use for two things; name another file")
        taken.add(os.path.realpath(target))
