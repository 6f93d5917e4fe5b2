"""`crosscheck compare`: a recorded motion and the rigid levels of an arm."""

from __future__ import annotations

from pathlib import Path

from crosscheck.cli.output import print_and_write
from crosscheck.file_types import MEASURED, MEASURED_PAGE
from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_selection
from crosscheck.output import require_files, require_writable
from crosscheck.recordings.compare import RecordComparison, compare
from crosscheck.recordings.output import comparison_json, comparison_page, describe_comparison
from crosscheck.recordings.record import read_record
from crosscheck.runner.progress import progress_bar

PAGE = "compare.html"


def compare_command(
    record: Path,
    arm: str,
    scenarios: list[str],
    settings: list[str],
    stated: list[str],
    topic: str,
    joints: list[str],
    json_file: Path | None,
    out: Path | None,
) -> int:
    """Compare a recorded motion with an arm's rigid levels; returns the exit code.

    It is 0 if the engines agree and the likeliest level leaves noise alone, else 1. Raises
    InputError.
    """
    chosen = load_selection(arm, scenarios, settings)
    tolerances = dict(_tolerance(text) for text in stated)
    page = None if out is None else out / PAGE
    if out is not None:
        require_writable(out)
    require_files((json_file, MEASURED), (page, MEASURED_PAGE))
    recording = read_record(record, len(chosen.arm.joints), topic, joints)
    scenario = chosen.scenarios[0] if chosen.scenarios else None
    with progress_bar() as progress:
        comparison = compare(recording, chosen.arm, scenario, tolerances, progress)
    requests = (
        (json_file, lambda: comparison_json(comparison)),
        (page, lambda: comparison_page(comparison)),
    )
    print_and_write(describe_comparison(comparison), *requests)
    return 0 if isinstance(comparison, RecordComparison) and comparison.explained else 1


def _tolerance(text: str) -> tuple[str, float]:
    """Path and relative standard uncertainty of a text PATH=SHARE. Raises InputError."""
    path, _, number = text.partition("=")
    try:
        share = float(number)
    except ValueError:
        share = -1.0
    if not 0 < share < 1:
        allowed = "must be PATH=SHARE with a share between 0 and 1, such as 0.01 for 1 %"
        raise InputError("--tolerance", path, number or None, allowed)
    return path, share
