"""The verdict matrix: which models agree, and to how many digits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from crosscheck.findings import Finding, Verdict

WORST_FIRST: tuple[Verdict, ...] = ("failed", "differ", "unresolved", "agree")


@dataclass(frozen=True)
class Cell:
    """What all checks between two models come to; digits of the worst relative difference."""

    left: str
    right: str
    verdict: Verdict
    checks: int
    digits: float | None


def cells(findings: Sequence[Finding]) -> list[Cell]:
    """One Cell per pair of models that any check compares, in order of appearance."""
    pairs: dict[tuple[str, str], list[Finding]] = {}
    for finding in findings:
        if finding.kind == "check" and finding.left != finding.right:
            left, right = sorted((finding.left, finding.right))
            pairs.setdefault((left, right), []).append(finding)
    return [_cell(pair, checks) for pair, checks in pairs.items()]


def _cell(pair: tuple[str, str], checks: list[Finding]) -> Cell:
    verdict = min((check.verdict for check in checks), key=WORST_FIRST.index)
    relative = [check.relative for check in checks if check.relative is not None]
    return Cell(*pair, verdict, len(checks), digits(max(relative)) if relative else None)


def digits(relative: float) -> float:
    """Decimal digits that a relative difference leaves in common, at most a double's 16."""
    return 16.0 if relative <= 1e-16 else max(0.0, -math.log10(relative))
