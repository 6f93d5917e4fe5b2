"""The verdict matrix: which models agree, and to how many digits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from crosscheck.findings import Finding, Verdict

WORST_FIRST: tuple[Verdict, ...] = ("failed", "differ", "unresolved", "agree")


FAMILIES = {"states": "at states", "same-step": "over runs", "refined": "by other integrators"}


@dataclass(frozen=True)
class Cell:
    """What all checks between two models come to.

    digits: per family of checks, the digits that its worst relative difference leaves in common.
    """

    left: str
    right: str
    verdict: Verdict
    checks: int
    digits: dict[str, float]

    @property
    def between_models(self) -> bool:
        """False for a model against a closed form or first principles."""
        return ":" in self.left and ":" in self.right


def cells(findings: Sequence[Finding]) -> list[Cell]:
    """One Cell per pair that any check compares, pairs of models first, else by appearance."""
    pairs: dict[tuple[str, str], list[Finding]] = {}
    for finding in findings:
        if finding.kind == "check" and finding.left != finding.right:
            left, right = sorted((finding.left, finding.right))
            pairs.setdefault((left, right), []).append(finding)
    found = [_cell(pair, checks) for pair, checks in pairs.items()]
    return sorted(found, key=lambda cell: not cell.between_models)


def _cell(pair: tuple[str, str], checks: list[Finding]) -> Cell:
    verdict = min((check.verdict for check in checks), key=WORST_FIRST.index)
    worst: dict[str, float] = {}
    for check in checks:
        family = FAMILIES.get(check.about.key.family)
        if family is not None and check.relative is not None:
            worst[family] = max(worst.get(family, 0.0), check.relative)
    return Cell(*pair, verdict, len(checks), {name: digits(value) for name, value in worst.items()})


def groups(found: Sequence[Cell]) -> list[list[str]]:
    """Models that checks connect, directly or through others, in order of appearance."""
    together: list[list[str]] = []
    for cell in found:
        touched = [group for group in together if cell.left in group or cell.right in group]
        rest = [group for group in together if group not in touched]
        names = [name for group in touched for name in group]
        together = [*rest, list(dict.fromkeys([*names, cell.left, cell.right]))]
    return together


def digits(relative: float) -> float:
    """Decimal digits that a relative difference leaves in common, at most a double's 16."""
    return 16.0 if relative <= 1e-16 else max(0.0, -math.log10(relative))
