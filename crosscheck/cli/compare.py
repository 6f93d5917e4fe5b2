"""`crosscheck compare`: a recorded motion and the rigid levels of an arm."""

from __future__ import annotations

from pathlib import Path

from crosscheck.cli.answer import answer
from crosscheck.kinds import MEASURED, MEASURED_PAGE
from crosscheck.measured.compare import RecordComparison, compare
from crosscheck.measured.output import comparison_json, comparison_page, lines
from crosscheck.measured.record import read_record
from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_chosen
from crosscheck.output import require_files, require_writable
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
    chosen = load_chosen(arm, scenarios, settings)
    tolerances = dict(_tolerance(text) for text in stated)
    page = None if out is None else out / PAGE
    if out is not None:
        require_writable(out)
    require_files((json_file, MEASURED), (page, MEASURED_PAGE))
    own = read_record(record, len(chosen.arm.joints), topic, joints)
    scenario = chosen.scenarios[0] if chosen.scenarios else None
    with progress_bar() as on_progress:
        found = compare(own, chosen.arm, scenario, tolerances, on_progress)
    made = (json_file, lambda: comparison_json(found)), (page, lambda: comparison_page(found))
    answer(lines(found), *made)
    return 0 if isinstance(found, RecordComparison) and found.explained else 1


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
