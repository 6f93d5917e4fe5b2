"""The verdict matrix: which models agree, and to how many digits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from crosscheck.findings import Finding, Verdict
from crosscheck.registry import reference_model
from crosscheck.report.formatting import format_count

WORST_FIRST: tuple[Verdict, ...] = ("failed", "differ", "unfinished", "unresolved", "agree")
FAMILIES = {
    "states": "at states",
    "same-step": "over runs",
    "refined": "with another integrator",
    "form-states": "at states",
    "form": "over runs",
}
# Families of the paper's equations, which are measured beside the engines.
FORMS = ("form-states", "form")


@dataclass(frozen=True)
class MatrixCell:
    """Summary of all checks between two models, or of a model against something else.

    verdict: of a form of the paper, which is only measured, whether it is within what the reference
    model is allowed at the same states; ``measured`` where that is not known; digits: per family,
    those that its worst relative difference leaves in common.
    """

    left: str
    right: str
    between_models: bool
    verdict: Verdict
    checks: int
    digits: dict[str, float]


def collect_cells(findings: Sequence[Finding]) -> list[MatrixCell]:
    """One MatrixCell per pair that is compared, pairs of models first, else by appearance.

    Of measurements those of the paper's equations count.
    """
    pairs: dict[tuple[str, str, bool], list[Finding]] = {}
    for finding in findings:
        counts = finding.kind == "check" or finding.about.key.family in FORMS
        if counts and finding.left != finding.right:
            between = bool(finding.about.key.right)
            ends = (finding.left, finding.right)
            left, right = sorted(ends) if between else ends
            pairs.setdefault((left, right, between), []).append(finding)
    matrix_cells = [_make_cell(pair, checks, findings) for pair, checks in pairs.items()]
    return sorted(matrix_cells, key=lambda cell: not cell.between_models)


def fold_cells(cells: Sequence[MatrixCell]) -> list[MatrixCell]:
    """The cells, with one for all models that are compared with one other thing and agree."""
    alone = [cell for cell in cells if cell.between_models or cell.verdict != "agree"]
    rest: dict[str, list[MatrixCell]] = {}
    for cell in cells:
        if cell not in alone:
            rest.setdefault(cell.right, []).append(cell)
    for some in rest.values():
        left = some[0].left if len(some) == 1 else format_count(len(some), "model")
        alone.append(replace(some[0], left=left, checks=sum(cell.checks for cell in some)))
    return alone


def _make_cell(
    pair: tuple[str, str, bool], findings: list[Finding], everything: Sequence[Finding]
) -> MatrixCell:
    judged = [check.verdict for check in findings if check.kind == "check"]
    beyond = [is_beyond(f, everything) for f in findings if f.kind == "measurement"]
    decided = [far for far in beyond if far is not None]
    measured: Verdict = "measured" if not decided else "differ" if any(decided) else "agree"
    verdict: Verdict = min(judged, key=WORST_FIRST.index, default=measured)
    worst: dict[str, float] = {}
    for check in findings:
        family = FAMILIES.get(check.about.key.family)
        if family is not None and check.relative is not None:
            worst[family] = max(worst.get(family, 0.0), check.relative)
    common = {name: common_digits(value) for name, value in worst.items()}
    return MatrixCell(*pair, verdict, len(judged), common)


def is_beyond(finding: Finding, everything: Sequence[Finding]) -> bool | None:
    """Whether a difference at states exceeds what the reference model may differ by.

    None if no such check states a limit.
    """
    key = finding.about.key
    if key.family not in ("states", FORMS[0]):
        return None
    checks = (f for f in everything if f.kind == "check" and f.quantity == finding.quantity)
    here = (f for f in checks if (f.about.key.family, f.about.key.case) == ("states", key.case))
    limits = (f.tolerance for f in here if reference_model() in (f.left, f.right))
    allowed = [limit for limit in limits if limit is not None]
    if not allowed:
        return None
    return finding.measured is None or finding.measured > max(allowed)


def group_models(cells: Sequence[MatrixCell]) -> list[list[str]]:
    """Models that checks connect, directly or through others, in order of appearance."""
    together: list[list[str]] = []
    for cell in cells:
        touched = [group for group in together if cell.left in group or cell.right in group]
        rest = [group for group in together if group not in touched]
        names = [name for group in touched for name in group]
        together = [*rest, list(dict.fromkeys([*names, cell.left, cell.right]))]
    return together


def common_digits(relative: float) -> float:
    """Decimal digits that a relative difference leaves in common, at most a double's 16."""
    return 16.0 if relative <= 1e-16 else max(0.0, -math.log10(relative))
