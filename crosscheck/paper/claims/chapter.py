"""The claims table: every statement of the paper that asserts a number or a direction, judged."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from crosscheck.paper.claims import ablations, control, section2, section3, section4, section5
from crosscheck.paper.claims.cells import cells
from crosscheck.paper.claims.rule import (
    DEFAULT_ZETA,
    Answer,
    Cell,
    Claim,
    answers,
    verdict,
)
from crosscheck.paper.claims.table import table_html
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import extreme
from crosscheck.report.chapter import Chapter
from crosscheck.studies.study import Study

ID, TITLE = "claims", "The paper's statements, one by one"
CLAIMS: tuple[Claim, ...] = (
    *section2.CLAIMS,
    *section3.CLAIMS,
    *control.CLAIMS,
    *ablations.CLAIMS,
    *section4.CLAIMS,
    *section5.CLAIMS,
)


def chapter(study: Study, scale: Scale) -> Chapter:
    """The claims, their values in all cells and their verdicts."""
    simulated = cells(study, scale)
    judged = [(claim, answers(claim, simulated)) for claim in CLAIMS]
    records = [_record(name, *pair) for name, pair in zip(_names(), judged, strict=True)]
    zetas = sorted({cell.zeta for cell in simulated})
    return Chapter(
        ID,
        TITLE,
        table_html(records, zetas, _left(simulated)),
        records,
        _outcome(records),
    )


def _outcome(records: Sequence[dict[str, Any]]) -> str:
    counts = Counter(record["verdict"].split(" on ")[0] for record in records)
    found = "; ".join(f"{verdict}: {count}" for verdict, count in counts.most_common())
    return f"of {len(records)} statements: {found}."


def _left(simulated: Sequence[Cell]) -> tuple[float, float]:
    """Largest third fluctuation under `angle`, and the largest loss of it without tooth error.

    Of the runs that have one; nan if none has.
    """
    angle = [cell.numbers for cell in simulated if cell.phase == "angle"]
    numbers = [n for n in angle if n.simulated("pd")]
    ablated = [n for n in numbers if n.simulated("no_error")]
    return (
        extreme((n["pd.third"] for n in numbers), max),
        extreme((n["pd.third"] - n["no_error.third"] for n in ablated), max),
    )


def _names() -> Iterator[str]:
    """Section and running number within it."""
    counts: Counter[str] = Counter()
    for claim in CLAIMS:
        counts[claim.section] += 1
        yield f"{claim.section}-{counts[claim.section]:02d}"


def _record(name: str, claim: Claim, given: Sequence[Answer]) -> dict[str, Any]:
    """JSON-able: the claim, its values by group of cells, its verdict."""
    judged = verdict(given, claim.free)
    return {
        "id": name,
        "section": claim.section,
        "figure": claim.figure,
        "statement": claim.statement,
        "quantity": claim.quantity,
        "unit": claim.unit,
        "threshold": str(claim.decide),
        "free_parameter": claim.free or None,
        "values": _groups(claim, given),
        "verdict": judged.verdict,
        "depends_on": list(judged.depends_on),
        "undefined": judged.undefined,
    }


def _groups(claim: Claim, given: Sequence[Answer]) -> dict[str, dict[str, Any]]:
    """By law and reading: default, range over damping and free parameter, cells' answers."""
    groups: dict[str, list[Answer]] = {}
    for answer in given:
        groups.setdefault(f"{answer.phase}, {answer.reading}", []).append(answer)
    first = next(iter(claim.formulas))
    return {name: _summary(group, first) for name, group in groups.items()}


def _summary(group: Sequence[Answer], first_choice: str) -> dict[str, Any]:
    finite = [answer.value for answer in group if math.isfinite(answer.value)]
    default = [a.value for a in group if a.zeta == DEFAULT_ZETA and a.choice == first_choice]
    return {
        "default": default[0] if default and math.isfinite(default[0]) else None,
        "min": min(finite, default=None),
        "max": max(finite, default=None),
        "zetas": sorted({answer.zeta for answer in group}),
        "yes": sum(answer.yes is True for answer in group),
        "undefined": sum(answer.yes is None for answer in group),
        "cells": len(group),
    }
