"""The claims table: every statement of the paper that asserts a number or a direction, judged."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from crosscheck.paper.claims import ablations, control, section2, section3, section4, section5
from crosscheck.paper.claims.cells import cells
from crosscheck.paper.claims.judged import Judged, judged
from crosscheck.paper.claims.quantities import NO_ERROR, PD
from crosscheck.paper.claims.rule import Cell, Claim, answers
from crosscheck.paper.claims.table import Left, table_html
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import extreme
from crosscheck.report.chapter import Chapter, rendered
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
    found = [
        judged(name, claim, answers(claim, simulated))
        for name, claim in zip(_names(), CLAIMS, strict=True)
    ]
    zetas = sorted({cell.zeta for cell in simulated})
    html = table_html(found, zetas, _left(simulated))
    return Chapter(ID, TITLE, html, rendered(found), _outcome(found))


def _outcome(found: Sequence[Judged]) -> str:
    counts = Counter(one.verdict.verdict for one in found)
    verdicts = "; ".join(f"{verdict}: {count}" for verdict, count in counts.most_common())
    return f"of {len(found)} statements: {verdicts}."


def _left(simulated: Sequence[Cell]) -> Left:
    """Of the runs under `angle` that have a third fluctuation; nan if none has."""
    numbers = [c.numbers for c in simulated if c.phase == "angle" and c.numbers.simulated(PD)]
    ablated = [n for n in numbers if n.simulated(NO_ERROR)]
    return Left(
        extreme((n[PD("third")] for n in numbers), max),
        extreme((n[PD("third")] - n[NO_ERROR("third")] for n in ablated), max),
    )


def _names() -> Iterator[str]:
    """Section and running number within it."""
    counts: Counter[str] = Counter()
    for claim in CLAIMS:
        counts[claim.section] += 1
        yield f"{claim.section}-{counts[claim.section]:02d}"
