"""The page's second chapter: the words that the others use, with pictures."""

from __future__ import annotations

from crosscheck.audit.experiments.cells import LABELLED
from crosscheck.audit.experiments.starts import ALIKE, FIRST
from crosscheck.audit.front.terms import teeth_passed
from crosscheck.audit.front.views import stage_svg, teeth_passed_svg
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.text import html, text
from crosscheck.audit.page.words import LAW_MEANINGS, LAW_NAMES
from crosscheck.models.loading import load_arm

ID, TITLE = "terms", "The arm, and the words of this page"


def chapter(material: Material) -> AuditChapter:
    """Stage, terms and phase laws."""
    passed = teeth_passed(material)
    most = {
        "most_by_angle": float(passed.angle.max()),
        "most_by_clock": float(passed.clock.max()),
    }
    page = text(
        "front/terms",
        backwards=bool(((passed.clock_rate < 0) & (passed.rate > 0)).any()),
        stage_svg=html(stage_svg(paper_stage(load_arm(LABELLED)).joint)),
        passed_svg=html(teeth_passed_svg(passed)),
        names=LAW_NAMES,
        meanings=LAW_MEANINGS,
        first=FIRST,
        alike=ALIKE,
        **most,
    )
    records = [{"id": "terms/teeth-passed", **most}]
    return AuditChapter(ID, TITLE, page, records, text("front/terms-outcome"))
