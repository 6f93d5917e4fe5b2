"""The page's beginning: its six findings follow their numbers, and the tools behind them."""

import math
import re
from dataclasses import replace
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
from crosscheck.audit.experiments.ensembles import EnsembleNumbersQuestion
from crosscheck.audit.experiments.experiments import BACK
from crosscheck.audit.experiments.paper_conditions import (
    AS_MODELLED,
    DECISIVE,
    INTEGRAL,
    LAWS,
    PRINTED,
    READINGS,
    Condition,
)
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.figures.figure_data import ZETA
from crosscheck.audit.findings import accumulation, clock, linear_limits
from crosscheck.audit.findings.baselines import LABELS, BaselineFinding, compare_baselines
from crosscheck.audit.findings.chapter import (
    MODELS,
    ThirdFluctuationFinding,
    draw_third_fluctuations,
    evaluate_third_fluctuation,
    find_laws,
)
from crosscheck.audit.findings.clock import simulate_motion
from crosscheck.audit.findings.engines import (
    APART_M,
    ModelComparison,
    is_third_fluctuation_in_engine,
)
from crosscheck.audit.findings.linear_limits import SUN, Point
from crosscheck.audit.judging.judgement import ClaimJudgement
from crosscheck.audit.judging.quantities import ConditionResults, Sample
from crosscheck.audit.judging.rule import Answer, Place, State
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.measures.undefined import UNDEFINED
from crosscheck.audit.page.chapter import LAW_NAMES, render_template
from crosscheck.models.loading import load_case
from crosscheck.registry import RIGID_LEVELS
from tests.audit.runs import simulate
from tests.audit.test_rule import third
from tests.loops import require_items


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
    assert share.yes == severe.get(paper_conditions.PRINTED, 0)


def test_the_third_fluctuation_is_asked_of_every_law_by_every_model():
    asked = list[paper_conditions.Condition]()

    def draw(questions, _):
        asked.extend(condition for condition, _ in questions)
        return dict.fromkeys(questions, Sample({"third": np.ones(10)}, np.zeros(10, bool)))

    found = evaluate_third_fluctuation(Of(samples=draw))
    models = {(each.planets, each.equations) for each in asked}
    assert models == {("lumped", "printed"), ("free", "corrected")}
    every = [*product(("lumped", "free"), paper_conditions.LAWS)]
    assert [(each.planets, each.law) for each in asked] == every
    assert list(found.answers) == asked


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
    assert 0.98 * worst < found.mass_matrix <= worst * (1 + 1e-6)  # the grid is this fine
    assert found.acceleration > found.mass_matrix
    assert all(run.duration_s == 0.002 and run.F_sp_N > 0 for run in found.runs.values())


GIVEN: dict[str, Any] = {
    "apart_m": "1e-09",
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


SHORT = Variant(zeta=0.02, phase="omega_t", ring_rate="corrected", duration_s=0.02)
CELL = Condition(PRINTED, 0.005)
ABOVE, BELOW = 1.01, 0.99


@pytest.mark.parametrize("knows", [(True, True), (True, False), (False, True), (False, False)])
def test_both_printed_laws_must_know_the_time_and_the_integral_must_not(knows):
    for blind in (True, False):
        same = dict(zip(LAWS, (*(not knew for knew in knows), blind), strict=True))
        found = clock.ClockTestResult(
            {law: [clock.DelayResult(1.0, (), each, ([], [], []))] for law, each in same.items()}
        )
        assert found.supports is (all(knows) and blind)


def test_another_clock_changes_a_force_by_twice_the_error_at_the_mean_stiffness():
    assert clock.largest_force_change() == pytest.approx(2 * 5e-6 * 1e8)


@pytest.mark.parametrize("law", [INTEGRAL, PRINTED])
def test_only_the_printed_law_knows_the_time(law):
    variant = replace(Condition(law, 0.02).variant(), duration_s=0.01)
    same = law == INTEGRAL
    found = clock.ClockTest(variant, (1, 2)).answer()
    assert [one.same for one in found] == [True, same, same, same]


def test_the_free_clock_at_zero_is_the_model_itself():
    run = simulate(SHORT)
    own = simulate_motion([PhysicalModel(*SHORT.case())])
    theta = PhysicalModel(*SHORT.case()).layout.theta
    assert np.array_equal(own.a[:, theta, 0], run["theta_ddot"].values)


def test_a_run_goes_on_where_another_stopped(monkeypatch):
    half = replace(SHORT, duration_s=0.01).case()
    before, whole = (
        simulate_motion([PhysicalModel(*half)]),
        simulate_motion([PhysicalModel(*SHORT.case())]),
    )
    last, continued = (before.q[-1, :, 0].copy(), before.v[-1, :, 0].copy()), PhysicalModel(*half)
    monkeypatch.setattr(continued, "start", lambda: last)
    resumed = simulate_motion([continued], 0.01)
    assert np.abs(resumed.q[-1] - whole.q[-1]).max() < 1e-12


def _is_in_engine(with_clock: Answer, angle: float) -> bool | None:
    rising = third(*np.linspace(150.0, 200.0, 16))
    quiet = ModelComparison(Condition(INTEGRAL, 0.005), third(0.1), third(angle))
    return is_third_fluctuation_in_engine([ModelComparison(CELL, rising, with_clock), quiet])


def test_second_engine_supports_if_it_has_the_vibration_and_is_quiet_under_angle():
    """By itself: how close both models are stands beside it."""
    alike = third(*np.linspace(151.0, 201.0, 16))
    assert _is_in_engine(alike, BELOW * SEVERE) is True
    assert _is_in_engine(third(*np.linspace(300.0, 400.0, 16)), 1.0) is True
    assert _is_in_engine(alike, ABOVE * SEVERE) is False
    assert _is_in_engine(third(*[20.0] * 16), 1.0) is False
    assert _is_in_engine(third(math.nan), 1.0) is None
    assert _is_in_engine(alike, math.nan) is None


def test_both_models_start_with_planets_apart():
    asked = EnsembleNumbersQuestion(CELL.variant(), (1, 2), apart_m=APART_M)
    for model in require_items(asked.models((1, 2))):
        (q, _), at = model.start(), model.layout.at
        planets = [q[at("x_pr", 0, planet)] for planet in range(3)]
        assert 0.1 * APART_M < np.ptp(planets) < 2 * APART_M


@pytest.mark.parametrize("law", [PRINTED, INTEGRAL])
def test_the_tooth_error_feeds_the_speed_back_by_the_time(law):
    """F = k (x - b - E sin(phi)), phi = 99 theta' t, so dF/dtheta' = -k E 99 t cos(phi)."""
    constant = ("arm.joints.*.*_mesh.stiffness.amplitude_N_per_m=0.0",)
    variant = replace(Condition(law, 0.02).variant("constant-torque"), meshes=constant)
    model = PhysicalModel(*replace(variant, planets="lumped").case())
    q, v, time, step = np.zeros(6), np.zeros(6), 0.7, 1e-6
    sun, speed = model.layout.at("x_sp", 0), model.layout.theta[0]
    q[sun], v[speed] = 1e-4, 0.3
    on_mesh = []
    for sign in (1, -1):
        v[speed] = 0.3 + sign * step
        on_mesh.append(model.generalized_force(time, q, v)[sun])
    slope = -(on_mesh[0] - on_mesh[1]) / (2 * step) / 3  # of one planet's force on the teeth
    phase = 99 * 0.3 * time
    expected = -1e8 * 5e-6 * 99 * time * np.cos(phase) if law == PRINTED else 0.0
    assert slope == pytest.approx(expected, rel=1e-6, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("cell", DECISIVE)
def test_exudyn_follows_the_analytic_model_into_the_vibration(cell):
    """Up to where rounding has grown: the first 0.1 s of the same start, planets free."""
    one = replace(cell.variant(), duration_s=0.1, seed=1)
    runs = [simulate(replace(one, model=model)) for model in ("analytic:physical", "exudyn:tree")]
    gap = np.abs(runs[0]["theta_ddot"].values - runs[1]["theta_ddot"].values)
    assert gap.max() < 1e-2 * np.abs(runs[0]["theta_ddot"].values).max()


PLACE = Condition(INTEGRAL, 0.02)


def _results(rate: float, own_rate: float = 6.0, exact: float = 1e-6) -> ConditionResults:
    """Two starts; errors of exp(rate t), middles of the windows at 0.2 and 1.9 s."""
    grown, own = (np.exp(np.array([each, each]) * 1.7) for each in (rate, own_rate))
    return ConditionResults(
        {
            BACK(b): Sample(
                {
                    "error_early": np.full(2, exact + added),
                    "error_2_s": exact + added * grown,
                    "own_early": np.full(2, 1e-6),
                    "own_2_s": 1e-6 * own,
                },
                np.zeros(2, bool),
            )
            for b, added in ((0.0, 0.0), (50.0, 2e-6))
        }
    )


@pytest.mark.parametrize(
    ("rate", "own", "state"),
    [(7.4, 6.0, State.YES), (7.6, 6.0, State.NO), (4.6, 6.0, State.YES), (4.4, 6.0, State.NO),
     (1.7, -0.1, State.NO), (1.7, np.nan, State.UNDEFINED)],
)  # fmt: skip
def test_the_growth_is_the_rigid_arms_own_on_both_sides_of_a_quarter(rate, own, state):
    found = accumulation.measure_accumulation(PLACE, _results(rate, own), BACK)
    assert found.growth_per_s == pytest.approx([rate, rate])
    assert found.added_rad == pytest.approx(2e-6 * np.exp(1.7 * rate))
    assert found.state == state
    assert accumulation.judge_drive([found]) == state


def test_settings_that_differ_decide_nothing():
    one, other = (
        accumulation.measure_accumulation(PLACE, _results(rate), BACK) for rate in (6.0, 9.0)
    )
    assert accumulation.judge_drive([one, other]) is None


def test_the_settings_are_those_of_the_gears_that_were_driven():
    settings = [
        (PLACE, _results(6.0)),
        (Condition(PRINTED, 0.02), _results(9.0)),
        (Condition(INTEGRAL, 0.03), ConditionResults()),
    ]
    assert [x.condition for x in accumulation.find_accumulations(settings)["sqrt_time"]] == [PLACE]


FIT = (0.02, 0.01, 30.0)  # the paper's, in the order of LABELS
LINKS = (0.1, 0.4, 250.0)


def _compare(**left: tuple[float, float, float]) -> BaselineFinding:
    """What these levels leave, in both readings; all others leave the links' amount."""
    judged = {}
    for place, (name, claim) in enumerate((name, BY_ID[name]) for name in LABELS):
        answers = [
            Answer(Place(_conditions(arm, zeta), level), (value,), 1, claim.limits)
            for arm in READINGS
            for level in RIGID_LEVELS
            for zeta, value in ((ZETA, left.get(level, LINKS)[place]), (0.1, FIT[place]))
        ]
        judged[name] = ClaimJudgement(claim, tuple(answers))
    return compare_baselines(judged)


def _conditions(arm, zeta):
    where = Condition(AS_MODELLED.law, zeta, arm, AS_MODELLED.planets, AS_MODELLED.equations)
    return tuple(where.conditions.items())


def test_one_arm_must_leave_all_three_numbers():
    assert _compare(carriers=FIT).gives_all
    for place in range(3):
        off = tuple(2 * x if at == place else x for at, x in enumerate(FIT))
        assert not _compare(carriers=off).gives_all


@pytest.mark.parametrize(
    ("theta_2", "level"), [(0.0149, "carriers"), (0.0151, None), (0.0051, "carriers")]
)
def test_the_nearest_is_the_first_that_leaves_the_papers_theta_2(theta_2, level):
    nearest = _compare(carriers=(0.001, theta_2, 8.0)).nearest
    assert (nearest and nearest.level) == level
    assert nearest is None or nearest.size("3.1-02") == theta_2


@pytest.mark.parametrize(("share", "is_inertia"), [(1e-4, True), (0.099, True), (0.11, False)])
def test_it_is_inertia_if_next_to_nothing_is_the_meshes(share, is_inertia):
    tip_alone = (2e-6, 1e-6, share * 30.0)
    found = _compare(carriers=FIT, coupled=tip_alone)
    assert found.most_meshes == pytest.approx(max(share, 1e-4))
    assert found.is_inertia is is_inertia


def test_nothing_is_decided_where_no_level_fits():
    found = _compare()
    assert (found.fitting, found.nearest, found.is_inertia) == ((), None, None)
    assert not found.gives_all


def test_growth_changes_sign_at_the_threshold():
    edge = linear_limits.find_threshold(Point())
    below, above = (linear_limits.compute_growth(Point(), part * edge) for part in (0.99, 1.01))
    assert below > 0 > above


def test_the_sun_feels_torque_and_angle_through_one_lever():
    """theta_s / n by the paper's geometry: drive_map is its gradient."""
    model = PhysicalModel(*Variant().case())
    r_s, r_p = 0.0135 * 3 * np.cos(np.radians(24.6)), 0.018 * 3 * np.cos(np.radians(24.6))
    n = 99 / 27 + 1
    gradient = np.array([1, 1, 2 * (r_s + r_p)]) / r_s / n
    np.testing.assert_allclose(model.terms.drive_map[:3, 0], gradient, rtol=1e-12)


@pytest.mark.parametrize("elbow", [0.0, 1.0, 3.0])
def test_feedback_at_the_sun_only_stores_and_dissipates(elbow):
    assert linear_limits.find_threshold(Point(elbow_rad=elbow, sensed=SUN)) == 0
    assert linear_limits.find_threshold(Point(elbow_rad=elbow)) > 0


def test_a_vibration_grows_as_the_eigenvalues_say():
    """The PD run without backlash, tooth error and stiffness variation, whose peaks are counted."""
    names = ("backlash_m", "tooth_error_m", "stiffness.amplitude_N_per_m")
    settings = tuple(f"arm.joints.*.*_mesh.{name}=0.0" for name in names)
    run = simulate(Variant(zeta=0.003, duration_s=0.45, settings=settings))
    time, x, width = run["time"].values, run["x_sp"].values[:, 0, 0], 250  # 5 ms
    vibration = np.abs(x - np.convolve(x, np.ones(width) / width, mode="same"))
    part = slice(5000, 20000)  # 0.1 to 0.4 s
    peaks = vibration[part].reshape(-1, width).max(axis=1)
    measured = np.polyfit(time[part].reshape(-1, width).mean(axis=1), np.log(peaks), 1)[0]
    pose = float(run["theta"].values[part, 1].mean())
    # The frozen eigenvalues at the mean pose stand for those along it.
    foretold = linear_limits.compute_growth(Point(elbow_rad=pose), 0.003)
    assert measured == pytest.approx(foretold, rel=0.1)


@pytest.mark.parametrize(("sun", "cured"), [(0.0, True), (0.001, False)])
def test_cured_at_the_sun(sun, cured):
    survey = {Point(): 0.005, Point(sensed=SUN): sun}
    assert linear_limits.is_cured_at_sun(survey) is cured
