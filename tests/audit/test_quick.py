"""A few settings from eight starts, every run as long as it should be: the page's own answers."""

import json
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from crosscheck.audit.claims.catalogue import CLAIMS
from crosscheck.audit.claims.rule import State
from crosscheck.audit.claims.study_plan import QUICK as PLAN
from crosscheck.audit.claims.study_plan import run_experiments
from crosscheck.audit.errata.engine_comparison import PrintedEquationsQuestion
from crosscheck.audit.errata.errata_texts import add_errata_texts
from crosscheck.audit.errata.erratum import SimulatedErratum
from crosscheck.audit.errata.finder import ErrataQuestion
from crosscheck.audit.errata.sheet import QUICK_S, ArmErratum
from crosscheck.audit.experiments.paper_conditions import (
    INTEGRAL,
    LABELLED,
    PRINTED,
    READINGS,
    REPAIRED_RATE,
)
from crosscheck.audit.experiments.scale import QUICK
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.figures import chapter as figures
from crosscheck.audit.figures.figure_data import FigureData
from crosscheck.audit.front.chapter import compare_baselines, evaluate_third_fluctuation
from crosscheck.audit.hypotheses.accumulation import judge_drive, run_shaking
from crosscheck.audit.hypotheses.evidence.shaking import DRIVES
from crosscheck.audit.hypotheses.evidence.spin import SpinCost
from crosscheck.audit.hypotheses.h2_ablation import claims as ladder_claims
from crosscheck.audit.hypotheses.h2_ablation import run_ablations
from crosscheck.audit.hypotheses.planet_spin import DURATIONS_S as SPUN_S
from crosscheck.audit.page import report
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.context import AuditContext
from crosscheck.audit.phase.maps import build_maps
from crosscheck.audit.phase.stability import CELLS
from crosscheck.audit.statics.statics import Statics
from tests.audit import stated
from tests.audit.contradictions import (
    contradictions,
    held_and_denied,
    taught_otherwise,
    two_values,
)
from tests.audit.markup import page_problems, strict_json

pytestmark = pytest.mark.slow
NUMBERS = (4, 17)
CHAPTERS = (
    *("front.chapter", "front.terms", "phase.chapter", "hypotheses.h2_ablation"),
    *("hypotheses.planet_spin", "hypotheses.controller", "figures.chapter", "claims.chapter"),
    "errata.sheet",
)


@pytest.fixture(scope="module")
def material(kept: Path) -> AuditContext:
    """Of all chapters: what one has asked, the others read."""
    return AuditContext(Study(kept), QUICK)


@pytest.fixture(scope="module")
def chapters(material: AuditContext) -> dict[str, AuditChapter]:
    """By id; of the figures one without runs and one of a sweep."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "QUICK_NUMBERS", NUMBERS)
        made = [report._build_chapter(material, name) for name in CHAPTERS]
    return {chapter.id: chapter for chapter in made}


def _said(material: AuditContext) -> Iterator[stated.Said]:
    """What the chapters' own records say of quantities of the claims."""
    yield from stated.of_claims(material.judged_claims.values())
    yield from stated.of_third(
        "findings", ((x.condition, x.third) for x in evaluate_third_fluctuation(material).strips)
    )
    yield from _third_of_phase(material)
    yield from stated.of_ladder(run_ablations(material).residuals, ladder_claims())
    shelf = FigureData(material)
    for number in NUMBERS:
        yield from stated.of_figure(number, figures._figure_claims(shelf, number))


def _third_of_phase(material: AuditContext) -> list[stated.Said]:
    found = [one for one in build_maps(material).settings if one.setting.is_paper]
    return stated.of_third("phase", ((one.setting.cell, one.third) for one in found))


def _numbers(material: AuditContext) -> Iterator[stated.StatedNumber]:
    """What the chapters and the sheet state, too."""
    study, scale = material.study, material.scale
    ladder = run_ablations(material)
    yield from stated.left_by_baselines("ladder", ladder.residuals)
    yield from stated.left_by_baselines("findings", compare_baselines(ladder, material).residuals)
    spins = [
        SpinCost(arm, name, scale.limit_duration(s))
        for arm in READINGS
        for name, s in SPUN_S.items()
    ]
    for one in study.answer_questions(spins, "planet spin"):
        yield stated.StatedNumber("H4", "eq18-planets-2, size", one.arm, one.missing_kg_m2)
    errata = add_errata_texts(_simulated_errata(material))
    yield from stated.of_sheet(ArmErratum(LABELLED, one) for one in errata)
    (statics,) = study.answer_questions([Statics(LABELLED)], "statics")
    for name, quoted in QUOTED_TOO.items():
        yield stated.StatedNumber("claims", quoted, LABELLED, statics[name])


def test_the_page_contradicts_itself_nowhere(material):
    said = list(_said(material))
    told = Counter((one.quantity, *one.place._replace(choice="")) for one in said)
    assert max(told.values()) > 1  # else there was nothing to compare
    assert contradictions(said) == []
    kinds = {name: judged.verdict.kind for name, judged in material.judged_claims.items()}
    errata = add_errata_texts(_simulated_errata(material))
    assert held_and_denied((row.erratum for row in errata), kinds) == []
    assert taught_otherwise(_findings(material), kinds) == []


def _findings(material: AuditContext) -> list[stated.Taught]:
    (printed,) = material.study.answer_questions(
        [PrintedEquationsQuestion(LABELLED, material.scale.longest_s)], "printed equations"
    )
    shaken = run_shaking(material)
    drives = {drive: judge_drive([one for one in shaken if one.drive == drive]) for drive in DRIVES}
    baselines = compare_baselines(run_ablations(material), material)
    return stated.of_findings(printed, baselines, drives)


def _simulated_errata(material: AuditContext) -> list[SimulatedErratum]:
    (found,) = material.study.answer_questions(
        [ErrataQuestion(LABELLED, material.scale.limit_duration(QUICK_S))], "errata sheet"
    )
    return found


# What claims measure and the errata sheet quotes: names of the one and of the other.
QUOTED_TOO = {
    "bent_0_mm": "thirty-millimetres, straight",
    "bent_90_mm": "thirty-millimetres, bent",
}


def test_no_number_of_page_and_sheet_has_two_values(material):
    numbers = list(_numbers(material))
    told = Counter((one.quantity, one.setting) for one in numbers)
    assert sum(count > 1 for count in told.values()) > len(QUOTED_TOO)
    assert two_values(numbers) == []


def test_the_page_is_well_formed(material, chapters):
    made: Sequence[AuditChapter] = list(chapters.values())
    assert page_problems(report.render_page(made, material.study)) == []
    strict_json(report.format_records(made, material.study))


def test_claims(material, chapters):
    made = chapters["claims"]
    assert [record["id"] for record in made.records] == [claim.id for claim in CLAIMS]
    json.dumps(made.records, allow_nan=False)
    verdicts = {record["id"]: record["verdict"] for record in made.records}
    assert verdicts["2.2-10"] == "does not hold"  # Eq. 13, from the teeth alone
    assert verdicts["3.1-09"] == "holds"  # x_sp converges to 52 um
    assert 'href="#figure-14"' in made.html
    again = run_experiments(material.study, QUICK, PLAN.claim_conditions(), "claims")
    assert again[0][0] == material.settings[0][0]


def test_phase(material, chapters):
    made = chapters["phase"]
    assert made.records[0]["verdict"] == "holds"
    assert made.html.count("<svg") == 2
    assert {r["id"] for r in made.records} >= {f"stability/{cell.id}" for cell in CELLS}
    assert {
        (one.place.law, one.state) for one in _third_of_phase(material) if one.place.zeta == 0.02
    } == {(PRINTED, State.NO), (REPAIRED_RATE, State.YES), (INTEGRAL, State.NO)}


def test_figures(chapters):
    made = chapters["figures"]
    json.dumps(made.records, allow_nan=False)
    numbers = [str(number) for number in NUMBERS]
    assert [record["id"] for record in made.records] == [f"figure-{n}" for n in numbers]
    assert re.findall(r'<h3 id="figure-(\d+)"', made.html) == numbers
