"""The page's beginning: its answers follow its numbers."""

import re
from html import unescape
from itertools import product
from types import SimpleNamespace as Of
from typing import Any

import numpy as np
import pytest

from crosscheck.analytic.model import PhysicalModel
from crosscheck.analytic.paper.model import PrintedModel
from crosscheck.audit.claims.catalogue import BY_ID
from crosscheck.audit.errata.printed_equations import PrintedEquationsQuestion
from crosscheck.audit.experiments import paper_conditions
from crosscheck.audit.findings.chapter import (
    MODELS,
    ThirdFluctuationFinding,
    draw_third_fluctuations,
    find_laws,
)
from crosscheck.audit.judging.judgement import ClaimJudgement
from crosscheck.audit.judging.rule import Answer, Place, State
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.measures.undefined import UNDEFINED
from crosscheck.audit.page.chapter import LAW_MEANINGS, LAW_NAMES, render_template
from crosscheck.models.loading import load_case
from tests.audit.planted_runs import third


def thirds(severe: dict[paper_conditions.Law, int]) -> ThirdFluctuationFinding:
    """Ten starts of every law; so many are severe with free planets, none with planets alike."""
    answers = {}
    for law, planets in product(paper_conditions.LAWS, MODELS):
        count = severe.get(law, 0) if planets == "free" else 0
        cell = paper_conditions.Condition(law, 0.005, planets=planets)
        answers[cell] = third(*[2 * SEVERE] * count, *[1.0] * (10 - count))
    return ThirdFluctuationFinding(0.005, answers)


@pytest.mark.parametrize(
    ("severe", "needs"),
    [
        ({}, False),  # nowhere: nothing to explain
        ({paper_conditions.PRINTED: 10}, True),
        ({paper_conditions.REPAIRED_RATE: 5}, True),
        ({paper_conditions.PRINTED: 1}, False),  # one of ten may be none
        ({paper_conditions.PRINTED: 10, paper_conditions.INTEGRAL: 1}, True),
        ({paper_conditions.PRINTED: 10, paper_conditions.INTEGRAL: 4}, False),
        ({paper_conditions.INTEGRAL: 10}, False),
    ],
)
def test_the_third_fluctuation_needs_the_clock_only_if_it_is_nowhere_without(severe, needs):
    found = thirds(severe)
    assert found.needs_clock is needs
    share = found.share(paper_conditions.PRINTED, "free")
    assert share is not None
    assert share.yes == severe.get(paper_conditions.PRINTED, 0)


@pytest.mark.parametrize(
    ("omega_t", "angle", "expected"),
    [
        (State.YES, State.NO, "only with omega_t"),
        (State.BISTABLE, State.NO, "only with omega_t"),
        (State.NO, State.BISTABLE, "only with angle"),
        (State.YES, State.YES, "with both"),
        (State.NO, State.NO, "with neither"),
        (State.YES, State.UNDEFINED, "only with omega_t"),
    ],
)
def test_one_setting_in_which_it_happens_decides(omega_t, angle, expected):
    assert find_laws(_judged([State.NO, omega_t], [angle, State.NO])) == expected


def test_a_law_that_says_nothing_leaves_it_open():
    assert find_laws(_judged([State.YES], [State.UNDEFINED])) == UNDEFINED


SUPPORTING = {State.YES: 10, State.BISTABLE: 5, State.NO: 0}  # of ten starts


def _judged(omega_t: list[State], angle: list[State]) -> ClaimJudgement:
    """Claim 5-04 with these answers by law, at a damping ratio each."""
    claim = BY_ID["5-04"]
    answers = []
    for law, states in ((paper_conditions.PRINTED, omega_t), (paper_conditions.INTEGRAL, angle)):
        for place, wanted in enumerate(states):
            where = Place(tuple(paper_conditions.Condition(law, 0.01 + place).conditions.items()))
            yes = SUPPORTING.get(wanted, 0)
            values = () if wanted == State.UNDEFINED else (0.0,) * (10 - yes) + (1e3,) * yes
            answers.append(Answer(where, values, 10, claim.limits))
            assert answers[-1].state == wanted
    return ClaimJudgement(claim, tuple(answers))


def test_every_start_is_drawn():
    one, more = (thirds({paper_conditions.PRINTED: count}) for count in (0, 10))
    assert draw_third_fluctuations(one) != draw_third_fluctuations(more)
    assert draw_third_fluctuations(one) == draw_third_fluctuations(one)


def test_the_printed_equations_are_off_by_what_the_derivation_says():
    """M beside Pinocchio over 200 random states; here beside the derivation over the elbow's turn.

    No state can be further off than the worst pose, and of 200 one comes within 2 % of it.
    """
    found = PrintedEquationsQuestion(paper_conditions.LABELLED, 0.002).answer()
    case = load_case(paper_conditions.LABELLED, "pd", None, [])
    models, worst = (PrintedModel(*case), PhysicalModel(*case)), 0.0
    for elbow in np.linspace(0, 2 * np.pi, 721):
        q = np.array([0, 0, 0, 0, 0, elbow])
        printed, right = (model.mass_matrix(q) for model in models)
        size = np.sqrt(np.outer(np.diag(printed), np.diag(printed)))
        worst = max(worst, float((np.abs(printed - right) / size).max()))
    assert found.mass_matrix is not None
    assert 0.98 * worst < found.mass_matrix <= worst * (1 + 1e-6)  # the grid is this fine
    assert found.acceleration is not None
    assert found.acceleration > found.mass_matrix
    assert all(run.duration_s == 0.002 and run.F_sp_N > 0 for run in found.runs.values())


GIVEN: dict[str, Any] = {
    "printed": Of(
        agrees=False,
        states=200,
        mass_matrix=0.013,
        acceleration=0.67,
        runs=dict.fromkeys(
            ("constant-torque", "pd"), Of(theta_rad=1e-3, F_sp_N=0.4, duration_s=0.5)
        ),
    ),
    "spin_rad": 1e-3,
    "clocks": Of(supports=True, blind={}),
    "force_change_N": 1000.0,
    "third": Of(
        needs_clock=True, zeta=0.005, as_modelled="32 of 32", as_gears="0 of 32",
        share=lambda law, planets: None,
    ),
    "presence": {"visible": "only with omega_t", "severe": "only with omega_t"},
    "in_engine": True,
    "compared": [],
    "baselines": Of(is_inertia=None, gives_all=False),
    "own": {"sqrt_time": "yes", "time": "no"},
    "added_rad": {"sqrt_time": 0.15, "time": 2e-5},
    "growth_per_s": 8.0,
    "unstable_below": (0.0017, 0.0059),
    "cured": True,
    "verdicts": {},
    "names": LAW_NAMES,
    "meanings": LAW_MEANINGS,
    "laws": paper_conditions.LAWS,
    "models": MODELS,
    **dict.fromkeys(("clock_svg", "third_svg", "baselines_svg", "level"), ""),
    "left": [],
    "zeta": 0.02,
    "window_s": (0.45, 0.79),
    "run_zeta": 0.02,
}  # fmt: skip
TURNED = [
    ({"printed": Of(**vars(GIVEN["printed"]) | {"agrees": True})}, 0, "No", "Yes"),
    ({"printed": Of(**vars(GIVEN["printed"]) | {"agrees": None})}, 0, "No", "Undefined"),
    ({"clocks": Of(supports=False, blind={})}, 1, "Yes", "Undecided"),
    ({"third": Of(**vars(GIVEN["third"]) | {"needs_clock": False})}, 2, "No", "Undecided"),
    (
        {"baselines": Of(is_inertia=None, gives_all=True)},
        *(3, "No baseline gives the paper's numbers", "One gives all three numbers"),
    ),
    ({"own": {"sqrt_time": "no", "time": "no"}}, 4, "With the printed drive alone", "Undecided"),
    ({"own": {"sqrt_time": "yes", "time": "yes"}}, 4, "With the printed drive alone", "Undecided"),
]


@pytest.mark.parametrize(("turned", "place", "before", "after"), TURNED)
def test_an_answer_turns_with_its_record_and_no_other_does(turned, place, before, after):
    first, second = (
        re.findall(r'<p class="answer"><b>(.*?)\.?</b>', unescape(page))
        for page in (render_template("findings/chapter", **x) for x in (GIVEN, GIVEN | turned))
    )
    assert len(first) == len(second) == 6
    assert (first[place], second[place]) == (before, after)
    assert [x for at, x in enumerate(first) if at != place] == [
        x for at, x in enumerate(second) if at != place
    ]
