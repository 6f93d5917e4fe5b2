"""A few settings from eight starts, every run as long as it should be: the page's own answers."""

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from crosscheck.audit.claims.study_plan import QUICK as PLAN
from crosscheck.audit.claims.study_plan import run_experiments
from crosscheck.audit.errata.engine_comparison import PrintedEquationsQuestion
from crosscheck.audit.experiments.experiments import PD
from crosscheck.audit.experiments.paper_conditions import (
    INTEGRAL,
    LABELLED,
    PRINTED,
    REPAIRED_RATE,
)
from crosscheck.audit.experiments.scale import QUICK
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.figures import chapter as figures
from crosscheck.audit.findings.accumulation import find_accumulations, judge_drive
from crosscheck.audit.findings.chapter import evaluate_third_fluctuation
from crosscheck.audit.judging.rule import State
from crosscheck.audit.measures.third_fluctuation import ThirdFluctuation
from crosscheck.audit.page import report
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.context import AuditContext
from tests.audit import stated
from tests.audit.contradictions import (
    contradictions,
    held_and_denied,
    taught_otherwise,
)
from tests.audit.markup import page_problems, strict_json

pytestmark = pytest.mark.slow
NUMBERS = (4, 17)


@pytest.fixture(scope="module")
def material(kept: Path) -> AuditContext:
    """Of all chapters: what one has asked, the others read."""
    return AuditContext(Study(kept), QUICK)


@pytest.fixture(scope="module")
def chapters(material: AuditContext) -> dict[str, AuditChapter]:
    """By id; of the figures one without runs and one of a sweep."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "QUICK_NUMBERS", NUMBERS)
        made = [report._build_chapter(material, name) for name in report.CHAPTERS]
    return {chapter.id: chapter for chapter in made}


def _said(material: AuditContext) -> Iterator[stated.Said]:
    """What the chapters' own records say of quantities of the claims."""
    yield from stated.of_claims(material.judged_claims.values())
    yield from stated.of_third(
        "findings", ((x.condition, x.third) for x in evaluate_third_fluctuation(material).strips)
    )


def test_the_page_contradicts_itself_nowhere(material):
    said = list(_said(material))
    told = Counter((one.quantity, *one.place._replace(choice="")) for one in said)
    assert max(told.values()) > 1  # else there was nothing to compare
    assert contradictions(said) == []
    kinds = {name: judged.verdict.kind for name, judged in material.judged_claims.items()}
    assert held_and_denied((row.erratum for row in material.errata[LABELLED]), kinds) == []
    assert taught_otherwise(_findings(material), kinds) == []


def _findings(material: AuditContext) -> list[stated.Taught]:
    (printed,) = material.study.answer_questions(
        [PrintedEquationsQuestion(LABELLED, material.scale.longest_s)], "printed equations"
    )
    found = find_accumulations(material.settings)
    drives = {drive: judge_drive(each) for drive, each in found.items()}
    assert drives == {"sqrt_time": State.YES, "time": State.NO}
    return stated.of_findings(printed, drives)


def test_the_page_is_well_formed(material, chapters):
    made: Sequence[AuditChapter] = list(chapters.values())
    assert page_problems(report.render_page(made, material.study)) == []
    strict_json(report.format_records(made, material.study))


def test_claims(material, chapters):
    made = chapters["claims"]
    verdicts = {record["id"]: record["verdict"] for record in made.records}
    assert verdicts["2.2-10"] == "does not hold"  # Eq. 13, from the teeth alone
    assert verdicts["3.1-09"] == "holds"  # x_sp converges to 52 um
    assert 'id="claim-3.1-09"' in made.html
    again = run_experiments(material.study, QUICK, PLAN.claim_conditions(), "claims")
    assert again[0][0] == material.settings[0][0]


def test_findings(material, chapters):
    made = chapters["findings"]
    verdicts = {r["id"]: r["verdict"] for r in made.records if r["id"].startswith("verdict/")}
    assert verdicts["verdict/clock"] == "yes"
    assert verdicts["verdict/presence-visible"] == "only with omega_t"
    assert verdicts["verdict/engine"] == "undefined"  # which is not run here
    assert made.html.count("<svg") == 3
    thirds = {
        cell.law: ThirdFluctuation.from_samples(results[PD]).state
        for cell, results in material.settings
        if cell.zeta == 0.02
    }
    assert thirds == {PRINTED: State.NO, REPAIRED_RATE: State.YES, INTEGRAL: State.NO}
