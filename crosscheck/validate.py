"""`crosscheck validate` and `crosscheck baseline`: all checks, without the report page."""

from __future__ import annotations

import shlex
from pathlib import Path

from crosscheck.baseline import baseline_path, read_baseline, write_baseline
from crosscheck.output import require_file, write_text
from crosscheck.progress import shown_progress
from crosscheck.reduction import baseline_of, uncompared
from crosscheck.regression import compare
from crosscheck.report.junit import junit_xml
from crosscheck.report.moved import print_moved
from crosscheck.report.terminal import print_agreement
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


def accept_command(arm: str, folder: Path, quick: bool, jobs: int, junit: Path | None) -> None:
    """Cross-check an arm and record the result, red or not. Raises InputError."""
    chosen = load_arm(arm)
    path = baseline_path(folder, chosen, quick)
    _require_files(path, junit)
    result = _checked(chosen, quick, jobs, seed=0)
    baseline = baseline_of(result)
    write_baseline(path, baseline)
    if junit is not None:
        write_text(junit, junit_xml(result.agreement, f"crosscheck {chosen.name}"))
    print_agreement(result.agreement)
    for line in uncompared(baseline):
        print(line)
    print(f"wrote {path}: {len(baseline.checks)} verdicts, {len(baseline.runs)} runs")


def check_command(arm: str, folder: Path, quick: bool, jobs: int, junit: Path | None) -> int:
    """Repeat a recorded cross-check and print what moved; returns the exit code.

    Raises InputError, before anything is run, for a record that cannot be held against this.
    """
    chosen = load_arm(arm)
    _require_files(junit)
    path = baseline_path(folder, chosen, quick)
    baseline = read_baseline(path, chosen, _renewal(arm, folder, quick))
    agreement = compare(baseline, _checked(chosen, quick, jobs, baseline.seed))
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


def _require_files(*paths: Path | None) -> None:
    """Raise InputError unless each can be written: before the work, not after it."""
    targets = []
    for path in filter(None, paths):
        if require_file(path) in targets:
            raise InputError(str(path), "", None, "is given twice; each needs a file")
        targets.append(require_file(path))
