"""The page's beginning: three findings, what they mean, and what the words mean."""

from __future__ import annotations

from collections import Counter

from audit.experiments.cells import LAWS
from audit.front.findings import ladder_finding, third_finding
from audit.front.views import clock_svg, ladder_svg, third_svg
from audit.measures.thresholds import SEVERE
from audit.measures.undefined import known
from audit.page.chapter import Chapter, rendered
from audit.page.material import Material
from audit.page.text import html, text
from audit.page.words import LAW_MEANINGS, LAW_NAMES
from audit.phase.clock import clocks

ID, TITLE = "findings", "What came out"
LITTLE = 0.1  # of a deviation: less is not what it is "caused by"


def chapter(material: Material) -> Chapter:
    """The findings."""
    clock = clocks(material.study, material.scale)
    third, ladder = third_finding(material), ladder_finding(material)
    kinds = Counter(str(one.verdict.kind) for one in material.judged.values())
    page = text(
        "front/findings",
        clocks=clock,
        third=third,
        ladder=ladder,
        needs_clock=third.needs_clock,
        little=known(*ladder.left_to_meshes) and max(ladder.left_to_meshes) < LITTLE,
        clock_svg=html(clock_svg(clock)),
        third_svg=html(third_svg(third)),
        ladder_svg=html(ladder_svg(ladder)),
        names=LAW_NAMES,
        meanings=LAW_MEANINGS,
        laws=LAWS,
        severe=SEVERE,
        kinds=kinds,
        count=kinds.total(),
    )
    outcome = text("front/outcome", supports=clock.supports)
    return Chapter(ID, TITLE, page, rendered([*third.strips, *ladder.steps]), outcome, third.said())
