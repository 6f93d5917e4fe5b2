"""All findings as a page lists them: by pair of models, the tightest check first."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from crosscheck.findings import Finding, Verdict
from crosscheck.report.formatting import (
    describe_outcome,
    format_count,
    format_number,
    format_percent,
    format_rounded,
    format_unit,
)
from crosscheck.report.matrix import WORST_FIRST

VERDICTS: tuple[Verdict, ...] = (*WORST_FIRST, "measured")
MOST_TIGHTEST = 10
MOST_PERCENT = 10.0  # parts of a tolerance; beyond it a multiple is read more easily


@dataclass(frozen=True)
class FindingRow:
    """A finding for reading: its numbers, with their unit, and the reason."""

    finding: Finding
    measured: str
    tolerance: str
    share: str
    reason: str


@dataclass(frozen=True)
class FindingGroup:
    """The findings between two models, or of one model alone, the tightest first.

    is_open: whether a check of them does not agree.
    """

    title: str
    summary: str
    rows: tuple[FindingRow, ...]
    is_open: bool


@dataclass(frozen=True)
class FindingList:
    """Findings for a page: how many have each verdict, the tightest checks, all by group."""

    total: int
    verdicts: dict[Verdict, int]
    tightest: tuple[FindingRow, ...]
    groups: tuple[FindingGroup, ...]


def list_findings(findings: Sequence[Finding]) -> FindingList:
    """The findings for a page."""
    tightest, groups = tuple(list_tightest(findings)), tuple(group_findings(findings))
    return FindingList(len(findings), count_verdicts(findings), tightest, groups)


def tolerance_share(finding: Finding) -> float:
    """The measured difference over what is allowed.

    A check without a number has failed or is gone: infinite. What has no tolerance is negative.
    """
    if finding.measured is None or finding.tolerance is None:
        return math.inf if finding.kind == "check" else -1.0
    if not finding.tolerance:
        return math.inf if finding.measured else 0.0
    return finding.measured / finding.tolerance


def format_share(share: float) -> str:
    """A part of a tolerance for reading: in per cent, or how many times it far beyond it."""
    if share <= MOST_PERCENT:
        return format_percent(share)
    times = f"{format_rounded(share)} times" if share < 1e6 else "over a million times"
    return times if math.isfinite(share) else "no number"


def sort_findings(findings: Iterable[Finding]) -> list[Finding]:
    """Sort findings: failures first, then the tightest checks, measurements last."""
    return sorted(findings, key=lambda each: (VERDICTS.index(each.verdict), -tolerance_share(each)))


def group_findings(findings: Sequence[Finding]) -> list[FindingGroup]:
    """A group for each pair of models and each model alone, in the order of their first finding."""
    groups: dict[str, list[Finding]] = {}
    for finding in sort_findings(findings):
        key = finding.about.key
        title = " and ".join(sorted((key.left, key.right))) if key.right else f"{key.left} alone"
        groups.setdefault(title, []).append(finding)
    return [_make_group(title, some) for title, some in groups.items()]


def list_tightest(findings: Sequence[Finding]) -> list[FindingRow]:
    """The tightest check of each kind, for the kinds that use most of their tolerance."""
    tightest: dict[str, Finding] = {}
    for finding in sort_findings(finding for finding in findings if finding.tolerance is not None):
        tightest.setdefault(finding.about.key.family, finding)
    return [make_row(finding) for finding in list(tightest.values())[:MOST_TIGHTEST]]


def count_verdicts(findings: Sequence[Finding]) -> dict[Verdict, int]:
    """Number of findings by verdict, the worst first; verdicts without findings are left out."""
    counts = Counter(finding.verdict for finding in findings)
    return {verdict: counts[verdict] for verdict in VERDICTS if counts[verdict]}


def make_row(finding: Finding) -> FindingRow:
    """The row of a finding."""
    unit, share = format_unit(finding.unit), tolerance_share(finding)
    return FindingRow(
        finding=finding,
        measured=f"{format_number(finding.measured)} {unit}".strip(),
        tolerance=format_number(finding.tolerance),
        share=format_share(share) if 0 <= share < math.inf else "",
        reason="; ".join(filter(None, (finding.basis, finding.note))),
    )


def _make_group(title: str, findings: Sequence[Finding]) -> FindingGroup:
    counts = ", ".join(f"{count} {verdict}" for verdict, count in count_verdicts(findings).items())
    shares = [tolerance_share(f) for f in findings if f.tolerance is not None]
    tightest = f"; at most {format_share(max(shares))} of a tolerance" if shares else ""
    return FindingGroup(
        title=title,
        summary=f"{counts}{tightest}",
        rows=tuple(make_row(finding) for finding in findings),
        is_open=any(f.kind == "check" and f.verdict != "agree" for f in findings),
    )


def describe_by_reason(findings: Sequence[Finding]) -> Iterator[tuple[Finding, str]]:
    """The first finding of each reason, its outcome, and how many others failed for it."""
    by_reason: dict[str, list[Finding]] = {}
    for finding in findings:
        reason, bracket, _ = finding.note.rpartition(" (")  # in brackets: at which state
        shared = (reason if bracket else finding.note) if finding.verdict == "failed" else ""
        by_reason.setdefault(shared or finding.id, []).append(finding)
    for finding, *more in by_reason.values():
        others = f"; and so in {format_count(len(more), 'more check')}" if more else ""
        yield finding, f"{describe_outcome(finding)}{others}"
