"""A sentence of the page follows its record: when the record turns, it changes or goes.

Each row renders a template from records that say one thing, and again with one of them turned.
"""

from dataclasses import replace
from types import SimpleNamespace as Of
from typing import Any

import pytest

from crosscheck.audit.errata.engine_comparison import EngineComparison, RunDifferences
from crosscheck.audit.errata.sheet import SheetCounts
from crosscheck.audit.experiments.paper_conditions import (
    INTEGRAL,
    LAWS,
    PRINTED,
    REPAIRED_RATE,
    Law,
)
from crosscheck.audit.front.chapter import MODELS
from crosscheck.audit.hypotheses.evidence import flutter, shaking
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.page.labels import LAW_MEANINGS, LAW_NAMES
from crosscheck.audit.page.text import render_template
from crosscheck.audit.phase import clock, stability
from crosscheck.audit.phase.clock import ClockTestResult, DelayResult, LawClockTest, SignalEnvelope
from crosscheck.audit.phase.objections import GrowthRates
from crosscheck.audit.planets import parting

Given = dict[str, Any]
BAND = SignalEnvelope((), (), ())
NOTHING = Share(0, 32)


def clocks(*changes_N: float) -> ClockTestResult:
    """Each law's largest change by a delay."""
    return ClockTestResult([_law(law, change) for law, change in zip(LAWS, changes_N, strict=True)])


def _law(law: Law, change_N: float) -> LawClockTest:
    delays = [DelayResult(c, change_N, 1103.0, (), False, BAND, BAND) for c in (0.0, 1.0, 5.0)]
    return LawClockTest(law, delays)


def by_law(found: ClockTestResult) -> dict[Law, LawClockTest]:
    """As the first chapter asks for them."""
    return {one.law: one for one in found.laws}


def printed(mass: float | None) -> EngineComparison:
    """Beside an engine."""
    runs = {
        "constant-torque": RunDifferences(0.5, 1.1e-3, 0.4),
        "pd": RunDifferences(3.0, 1e-5, 50.0),
    }
    return EngineComparison(mass, None if mass is None else 50 * mass, 200, runs)


def thirds(needs_clock: bool) -> Of:
    """Severe starts by law and planets."""
    own, gears = Share(32, 32), NOTHING if needs_clock else Share(32, 32)
    return Of(
        zeta=0.005,
        needs_clock=needs_clock,
        as_modelled=own,
        as_gears=gears,
        share=lambda law, planets: gears if law == INTEGRAL else own,
    )


def left(theta_1: float = 0.0014) -> Of:
    """What a baseline leaves."""
    sizes = {"theta_1": theta_1, "theta_2": 0.0116, "tip": 0.008}
    found = {name: Of(total=size) for name, size in sizes.items()}
    return Of(arm="paper-labelled", level="carriers", deviations=found)


LADDER = Of(
    holds=True,
    fitting=("carriers",),
    most_meshes=(2e-5, 1e-5),
    rest={"inertia": (1.1, 1.2)},
    slips=(-0.2, -0.1),
)
BASELINES = Of(nearest=left(), gives_all=False, verdict=LADDER, return_s=1.61, returns_as_read=True)
OWN, NOT_OWN = Of(own="yes"), Of(own="no")
FOUND = clocks(1300.0, 1300.0, 0.0)
BLIND = clocks(0.0, 0.0, 0.0)
FRONT: Given = {
    "printed": printed(0.0127),
    "spin": Of(theta_rad=0.0012),
    "spin_matters": False,
    "clocks": FOUND,
    "by_law": by_law(FOUND),
    "third": thirds(True),
    "baselines": BASELINES,
    "level": "links, payload, joint masses",
    "accumulation": {"sqrt_time": OWN, "time": NOT_OWN},
    "largest_rad": {"sqrt_time": 0.15, "time": 2.3e-5},
    "unstable_below": (0.0017, 0.0059),
    "cured": True,
    "PRINTED": PRINTED,
    "INTEGRAL": INTEGRAL,
    "clock_svg": "",
    "window_s": (0.45, 0.79),
    "run_zeta": 0.02,
    "third_svg": "",
    "baselines_svg": "",
    "names": LAW_NAMES,
    "meanings": LAW_MEANINGS,
    "laws": LAWS,
    "models": MODELS,
    "verdicts": {"over all settings": {"holds": 2}},
}
OUTCOME = {name: FRONT[name] for name in ("printed", "clocks")}
TERMS: Given = {
    "stage_svg": "",
    "passed_svg": "",
    "names": LAW_NAMES,
    "meanings": LAW_MEANINGS,
    "backwards": True,
    "first": 8,
    "alike": 1e-3,
    "most_by_angle": 9.0,
    "most_by_clock": 12.0,
}
VIBRATIONS = [[(None, 1.0, None)] * 3] * 2
CLOCK: Given = {
    "clock": clock,
    "found": FOUND,
    "starts": 8,
    "table": "",
    "drawing": "",
    "printed": by_law(FOUND)[PRINTED],
    "repaired": by_law(FOUND)[REPAIRED_RATE],
    "integral": by_law(FOUND)[INTEGRAL],
    "integral_same": True,
    "vibrations": VIBRATIONS,
}
VERDICT = Of(verdict="holds", evidence={"resonance": True})
INTRODUCTION: Given = {
    "verdict": VERDICT,
    "maps": Of(visible="only with omega_t", severe="only with omega_t"),
    "settings": 216,
    "starts": 32,
    "printed": Share(5, 32),
    "repaired": Share(32, 32),
    "integral": NOTHING,
    "alike": Share(32, 32),
}
STABILITY: Given = {
    "gain": 100.0,
    "starts": 8,
    "stability": stability,
    "band": 200.0,
    "error": 1e-6,
    "table": "",
    "intervals": "",
    "drawing": "",
    "found": Of(
        supports=True, largest_growth=lambda phase: {"omega_t": 120.0, "angle": -2.0}[phase]
    ),
}
TURNED_GROWTH = Of(supports=False, largest_growth=lambda phase: 77.0)
REPAIR: Given = {
    "table": "",
    "calm": (2e-4, 0.017),
    "calm_zeta": 0.015,
    "factor": 6000.0,
    "severe_settings": 0,
    "visible_settings": 0,
    "settings": 24,
    "stands": True,
}
RATES = GrowthRates(120.0, 119.0, 1.2e4, -3.0, 110.0)
OBJECTIONS: Given = {
    "starts": 32,
    "table": "",
    "rates": "",
    "spacing": "27 / 3 = 9 and 99 / 3 = 33",
    "in_phase": True,
    "growth": [RATES],
    "in_full_over_own": (100.0, 300.0),
    "counts": {"visible": {"angle": 0, "omega_t": 76}, "settings": {"angle": 108, "omega_t": 108}},
    **dict.fromkeys(
        ("d_unknown", "d_unknown_angle", "flutter", "flutter_angle", "planets", "planets_angle"),
        "0 of 32 starts",
    ),
    **dict.fromkeys(("eq11", "eq11_visible", "eq11_angle"), "2 of 2 starts"),
    "full_equation": "weaker",
}
FORETOLD = Of(starts=8, right=8, largest_error=0.005, strayed=3)
PARTING: Given = {
    "planets": parting,
    "starts": 8,
    "apart_um": 1.0,
    "breaking": "",
    "early": [0.003, 0.005],
    "drawing": "",
    "table": "",
    "grown": Of(free=FORETOLD, lumped=FORETOLD),
    "pressed": 1e-12,
    "by_contact": True,
}
REACH = {"always": 0.004, "contact": 0.008, "contact_lumped": 0.01, "contact_steady": 0.008}
FLUTTER = Of(
    verdict="holds",
    parts={"gone without feedback": True},
    lowest_threshold_zeta=0.0017,
    highest_threshold_zeta=0.0059,
    vibrates_up_to_zeta=REACH,
)
PLAYED = Of(setting=Of(played_back=True), share=NOTHING)
CONTROLLER: Given = {
    "verdict": FLUTTER,
    "check": Of(zeta=0.003, measured_per_s=9.0, predicted_per_s=9.1, frequency_Hz=1700.0),
    "found": Of(cells=[PLAYED]),
    "flutter": flutter,
    "resolved": 1e-3,
    "starts": 32,
    "single": 0.005,
    "continued": {"link": Share(30, 32), "torque": NOTHING, "sun": NOTHING},
    "cured": True,
    **dict.fromkeys(("drawing", "poses", "others", "cells", "handed"), ""),
}
H2: Given = {
    "verdict": LADDER,
    "levels": ["carriers"],
    "limits": {"theta_1": "0.015 to 0.025", "theta_2": "0.005 to 0.015", "tip": "25 to 35"},
    "all_three": [],
    "links_factor": 24.0,
    "coupled_rad": 1e-4,
    "fitting": [left()],
    "names": {"carriers": "links and joint masses"},
    "causes": ["joint masses"],
    "groups": {"inertia": "inertia"},
    "rungs": 9,
    "scenarios": [],
    **dict.fromkeys(("picture", "left", "shares"), ""),
}
REFUTED = Of(**{**vars(LADDER), "holds": False})
SHAKEN = Of(span=lambda name: (0.02, 0.03), rigid_growth_per_s=7.8, largest_sensitivity=3000.0)
H3_OWN = Of(own="yes", linear="yes", ordered="no")
H3: Given = {
    "printed": SHAKEN,
    "even": SHAKEN,
    "largest": lambda found: 0.1,
    "verdicts": {"sqrt_time": H3_OWN, "time": Of(own="no", linear="yes", ordered="yes")},
    "shaking": shaking,
    "starts": 32,
    **dict.fromkeys(("picture", "summary", "sizes"), ""),
}
H5: Given = {
    "arm_kg": 87.0,
    "drift": 1e-12,
    "ratios": (5.0, 10000.0),
    "lightest_turn_rad": 0.4,
    "lightest_joint_rad": 0.2,
    "enough": False,
    "needed": {"PD": "97 to 438"},
    "limit_m": 0.03,
    **dict.fromkeys(("picture", "needs", "flights"), ""),
}
COUNTS = SheetCounts({"equation": 10, "statement": 23, "notation": 39}, 19, 21, 21)
FEWER = SheetCounts({"equation": 9, "statement": 23, "notation": 39}, 18, 21, 21)
BLINDED = {"clocks": BLIND, "by_law": by_law(BLIND)}
GIVEN = {
    "front/findings": FRONT,
    "front/outcome": OUTCOME,
    "front/terms": TERMS,
    "phase/clock": CLOCK,
    "phase/introduction": INTRODUCTION,
    "phase/stability": STABILITY,
    "phase/repair": REPAIR,
    "phase/objections": OBJECTIONS,
    "planets/parting": PARTING,
    "hypotheses/controller": CONTROLLER,
    "hypotheses/ladder": H2,
    "hypotheses/accumulation": H3,
    "hypotheses/floating_base": H5,
    "errata/introduction": {"counts": COUNTS},
}
# A template, what is changed of what it is given, a sentence before and one after.
ROWS: list[tuple[str, Given, str, str]] = [
    ("front/findings", {"printed": printed(1e-15)}, "do not agree", "<b>Yes.</b> Over"),
    ("front/findings", {"spin": Of(theta_rad=0.5)}, "makes 0.0012 rad", "makes 0.5 rad"),
    ("front/findings", {"spin_matters": True}, "not considerable at the tip", "rad, considerable"),
    (
        "front/findings",
        {"baselines": Of(**{**vars(BASELINES), "returns_as_read": False})},
        "which is that time",
        "which is not that time",
    ),
    ("front/findings", BLINDED, "depends on when a motion happens: Eqs", "cannot be told"),
    ("front/findings", BLINDED, "How to repair", "is not shown by these runs"),
    ("front/findings", {"third": thirds(False)}, "it needs the", "Undecided"),
    (
        "front/findings",
        {"baselines": Of(**{**vars(BASELINES), "nearest": left(0.0199)})},
        "0.0014 rad of θ₁",
        "0.02 rad of θ₁",
    ),
    (
        "front/findings",
        {"baselines": Of(**{**vars(BASELINES), "gives_all": True})},
        "No baseline gives the",
        "One gives all",
    ),
    (
        "front/findings",
        {"accumulation": {"sqrt_time": OWN, "time": OWN}},
        "With the printed drive alone",
        "yes with sin(20πt)",
    ),
    ("front/findings", {"unstable_below": (0.1, 0.2)}, "0.0017", "0.1000"),
    (
        "front/findings",
        {"verdicts": {"as the gears are": {"holds": 1, "depends": 1}}},
        "over all settings: 2 holds",
        "as the gears are: 1 holds, 1 depends",
    ),
    ("front/findings", {"cured": False}, "removes the", "does not remove it"),
    ("front/outcome", {"printed": printed(0.0)}, "do not agree", "printed agree"),
    ("front/outcome", {"clocks": BLIND}, "a gear does not", "cannot be told"),
    ("front/terms", {"backwards": False}, "then backwards", "counts up to 12.</p>"),
    ("phase/clock", {"found": BLIND}, "is the formula", "may.</p>"),
    (
        "phase/clock",
        {"repaired": by_law(BLIND)[REPAIRED_RATE]},
        "and does with the corrected",
        "and does not with the corrected",
    ),
    (
        "phase/introduction",
        {"verdict": Of(verdict="does not hold", evidence={"resonance": False})},
        "resonance for it",
        "resonance against it",
    ),
    ("phase/introduction", {"alike": NOTHING}, "is 32 of 32", "is 0 of 32"),
    ("phase/stability", {"found": TURNED_GROWTH}, "start: yes", "start: no"),
    ("phase/stability", {"found": TURNED_GROWTH}, "is 120 1/s", "is 77 1/s"),
    ("phase/repair", {"stands": False}, "repair stands", "not free of"),
    ("phase/repair", {"calm": (0.1, 0.05)}, "0.017 rad/s²", "0.05 rad/s²"),
    ("phase/objections", {"in_phase": False}, "Not in this", "not all whole"),
    (
        "phase/objections",
        {"growth": [replace(RATES, without_feedback_per_s=3.0)]},
        "119 without feedback",
        "3 without feedback",
    ),
    ("phase/objections", {"in_full_over_own": (2.0, 3.0)}, "100 to 300", "2 to 3 times"),
    ("phase/objections", {"full_equation": "severe"}, "no longer severe", "it stays severe"),
    ("phase/objections", {"full_equation": "gone"}, "no longer severe", "holds: it goes away"),
    ("phase/objections", {"full_equation": None}, "no longer severe", "is not settled"),
    ("planets/parting", {"early": []}, "at ζ = 0.003, 0.005", "In no setting"),
    ("planets/parting", {"by_contact": False}, "alone does not", "could break"),
    ("hypotheses/controller", {"cured": False}, "sun nowhere", "sun it is too"),
    ("hypotheses/controller", {"single": 0.01}, "up to 0.005", "up to 0.01"),
    (
        "hypotheses/controller",
        {"found": Of(cells=[Of(setting=PLAYED.setting, share=Share(7, 32))])},
        "feedback 0 starts",
        "feedback 7 starts",
    ),
    (
        "hypotheses/controller",
        {"verdict": Of(**{**vars(FLUTTER), "highest_threshold_zeta": 0.02})},
        "above the linear limit",
        "0.0200",
    ),
    ("hypotheses/ladder", {"verdict": REFUTED}, "So H2 holds", "H2 does not hold"),
    ("hypotheses/ladder", {"verdict": REFUTED}, "say nothing of", "does not hold"),
    ("hypotheses/ladder", {"links_factor": 0.5}, "not the paper's", "leave 0.5 times"),
    ("hypotheses/ladder", {"fitting": [left(0.02)]}, "0.0014 rad", "0.02 rad of"),
    (
        "hypotheses/accumulation",
        {"verdicts": {**H3["verdicts"], "sqrt_time": Of(own="no", linear="no", ordered="yes")}},
        "no measure of backlash",
        "is not proportional to b",
    ),
    ("hypotheses/floating_base", {"enough": True}, "how many times", "is enough"),
    ("hypotheses/floating_base", {"needed": {"PD": "5 or fewer"}}, "97 to 438", "5 or fewer"),
    ("errata/introduction", {"counts": FEWER}, "10 errors", "9 errors"),
    ("errata/introduction", {"counts": FEWER}, "19 of all", "18 of all"),
]


@pytest.mark.parametrize(
    ("template", "changed", "before", "after"), ROWS, ids=[f"{row[0]}: {row[3]}" for row in ROWS]
)
def test_a_sentence_turns_with_its_record(template, changed, before, after):
    said, turned = (
        " ".join(render_template(template, **given).split())
        for given in (GIVEN[template], {**GIVEN[template], **changed})
    )
    assert before in said
    assert before not in turned
    assert after not in said
    assert after in turned
