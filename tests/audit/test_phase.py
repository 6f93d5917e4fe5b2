"""Hypothesis H1: what decides it, on both sides of every threshold, and the tools behind it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.claims.rule import State
from crosscheck.audit.experiments.paper_conditions import (
    INTEGRAL,
    PRINTED,
    REPAIRED_RATE,
    Condition,
    Law,
)
from crosscheck.audit.experiments.scale import QUICK
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Variant, simulate
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.third_fluctuation import NONE, ThirdFluctuation
from crosscheck.audit.measures.thresholds import EVIDENT, SEVERE
from crosscheck.audit.page.context import AuditContext
from crosscheck.audit.phase import clock, dampers, linear, maps, objections, resonance
from crosscheck.audit.phase.chapter import judge_h1
from crosscheck.audit.phase.engines import (
    APART_M,
    WITHIN,
    EngineEvidence,
    ModelComparison,
    PartedStartsQuestion,
)
from crosscheck.audit.phase.handover import (
    DEAD,
    ERROR_FREE,
    INTEGRATED,
    DecayAfterSwitch,
    HandoverResult,
    SwitchOutcome,
)
from crosscheck.audit.phase.page.sections import build_maps_section
from crosscheck.audit.phase.runs import (
    ChangeQuestion,
    ContinuedModel,
    build_models,
    build_pd_variant,
    build_plant,
    neglected_weights,
    simulate_motion,
    vibration,
)
from crosscheck.audit.phase.stability import ONSET_WITHIN, Onset
from tests.audit.planted_runs import third
from tests.loops import require_items

SHORT = Variant(zeta=0.02, phase="omega_t", ring_rate="corrected", duration_s=0.02)
CELL = Condition(PRINTED, 0.005)
ABOVE, BELOW = 1.01, 0.99


@pytest.mark.parametrize(
    ("omega_t", "angle", "expected"),
    [
        (State.YES, State.NO, maps.Presence.PRINTED),
        (State.BISTABLE, State.NO, maps.Presence.PRINTED),
        (State.NO, State.BISTABLE, maps.Presence.INTEGRATED),
        (State.YES, State.YES, maps.Presence.BOTH),
        (State.NO, State.NO, maps.Presence.NEITHER),
        (State.YES, State.UNDEFINED, maps.Presence.PRINTED),
    ],
)
def test_one_setting_in_which_it_happens_decides(omega_t, angle, expected):
    states = {"omega_t": [State.NO, omega_t], "angle": [angle, State.NO]}
    assert maps.find_presence(states) == expected


def test_a_law_that_says_nothing_leaves_it_open():
    said = {"omega_t": [State.YES], "angle": [State.UNDEFINED]}
    assert maps.find_presence(said) == maps.Presence.UNKNOWN


def test_a_setting_asks_the_same_starts_without_tooth_error():
    plain, other = maps.MapSetting(CELL), maps.MapSetting(CELL, backlash_um=500.0)
    assert [str(source) for source in plain.sources] == ["pd", "no error"]
    assert [source.size_um for source in other.sources] == [500.0, 500.0]
    assert len(set(maps.FOUR)) == 4
    conservative = maps.MapSetting(Condition(Law("angle", "corrected", "conservative"), 0.02))
    assert maps.integral_of(conservative) == maps.MapSetting(Condition(INTEGRAL, 0.02))


@pytest.mark.parametrize(("severe", "told"), [(0, False), (4, True), (8, False)])
def test_a_severe_fluctuation_is_of_a_branch_only_where_the_start_decides(severe, told, tmp_path):
    """By the records of lumped planets too, where all starts may be severe."""

    def mapped(cell: Condition, loud: int) -> maps.MapPoint:
        found = third(*[300.0] * loud, *[5.0] * (8 - loud))
        return maps.MapPoint(maps.MapSetting(cell), third=found, without=third(*[0.0] * 8))

    lumped = [mapped(replace(CELL, planets="lumped"), severe)]
    said = build_maps_section(
        maps.Maps([mapped(CELL, 0)], lumped, []), AuditContext(Study(tmp_path), QUICK)
    ).html
    assert ("belongs to a branch" in said) == told
    assert ("severe in nine starts of ten or more at ζ 0.005" in said) == (severe == 8)


def test_verdict_of_h1():
    every = {"clock": True, "engine": True}
    assert judge_h1(maps.Presence.PRINTED, every) == "holds"
    assert judge_h1(maps.Presence.UNKNOWN, every) == "undefined"
    undefined = judge_h1(maps.Presence.PRINTED, {**every, "engine": None})
    assert undefined == "holds in the simulations, but undefined in: engine"
    assert "clock" in judge_h1(maps.Presence.PRINTED, {**every, "clock": False})
    for elsewhere in (maps.Presence.BOTH, maps.Presence.NEITHER, maps.Presence.INTEGRATED):
        assert judge_h1(elsewhere, every) == "does not hold"


def _clocks(*changes: float) -> clock.ClockTestResult:
    """Of the paper's laws and the integral."""
    nothing = clock.SignalEnvelope((), (), ())

    def delayed(change: float) -> clock.DelayResult:
        return clock.DelayResult(1.0, change, 1.0, (), False, nothing, nothing)

    laws = (PRINTED, REPAIRED_RATE, INTEGRAL)
    return clock.ClockTestResult(
        [clock.LawClockTest(law, [delayed(c)]) for law, c in zip(laws, changes, strict=True)]
    )


def test_a_clock_is_seen_above_rounding():
    seen, unseen = ABOVE * clock.CLOCK_N, BELOW * clock.CLOCK_N
    assert _clocks(seen, seen, unseen).supports
    for changes in ((seen, unseen, unseen), (unseen, seen, unseen), (seen, seen, seen)):
        assert not _clocks(*changes).supports


@pytest.mark.parametrize(("law", "same"), [(INTEGRAL, True), (PRINTED, False)])
def test_only_the_printed_law_knows_the_time(law, same):
    found = clock.ClockTest(law, 0.02, 0.01, (1, 2)).answer()
    assert [one.same for one in found] == [True, same, same, same]
    largest = [one.largest_change_N for one in found[1:]]
    assert all(change == 0 for change in largest) if same else min(largest) > 1.0


def test_the_free_clock_at_zero_is_the_model_itself():
    run = simulate(SHORT)
    own = simulate_motion([PhysicalModel(*SHORT.case())])
    assert np.array_equal(own.a[:, own.theta, 0], run["theta_ddot"].values)


def test_a_run_goes_on_where_another_stopped():
    half = replace(SHORT, duration_s=0.01).case()
    before, whole = (
        simulate_motion([PhysicalModel(*half)]),
        simulate_motion([PhysicalModel(*SHORT.case())]),
    )
    last = before.q[-1, :, 0].copy(), before.v[-1, :, 0].copy()
    resumed = simulate_motion([ContinuedModel(half, *last)], float(before.time[-1]))
    assert resumed.time[0] == pytest.approx(0.01)
    assert np.abs(resumed.q[-1] - whole.q[-1]).max() < 1e-12


def test_changed_dampers_and_drives_are_other_questions():
    variant = build_pd_variant(CELL, 0.002)
    plain, stronger = (
        ChangeQuestion(variant, (1,)),
        ChangeQuestion(variant, (1,), damping=(2.0, 0.2)),
    )
    fed = ChangeQuestion(variant, (1,), recorded=True)
    assert len({plain.inputs, stronger.inputs, fed.inputs}) == 3
    own, other = plain.models((1,))[0].gears.d, stronger.models((1,))[0].gears.d
    assert np.unique(np.round(other / own, 12)).tolist() == [0.2, 2.0]
    assert fed.models((1,))[0].scenario.drive.kind == "table"


def test_a_start_is_the_same_whichever_stand_beside_it():
    variant = build_pd_variant(CELL, 0.01)
    alone, three = (simulate_motion(build_models(variant, seeds)).q for seeds in ((2,), (1, 2, 3)))
    assert np.array_equal(alone[:, :, 0], three[:, :, 1])


def test_branches_are_compared_only_where_both_models_have_starts():
    small, severe = [20.0] * 8, [400.0] * 4
    one, other = third(*small, *severe), third(*small, 400.0)
    found = {(a.severe, a.number): a.met for a in ModelComparison(CELL, one, other).branches}
    assert {met for (branch, _), met in found.items() if branch} == {None}
    assert {met for (branch, _), met in found.items() if not branch} == {True}


@pytest.mark.parametrize("number", list(WITHIN))
def test_medians_of_a_branch_have_limits_on_both_sides(number):
    for by, expected in ((BELOW, True), (ABOVE, False)):
        factor = 1 + by * WITHIN[number]
        of = {name: factor if name == number else 1.0 for name in WITHIN}
        one = third(*[200.0] * 4)
        other = third(
            *[200.0 * of["size"]] * 4,
            onset_s=0.9 * of["onset"],
            frequency_Hz=1300.0 * of["frequency"],
        )
        (met,) = [
            a.met
            for a in ModelComparison(CELL, one, other).branches
            if a.severe and a.number == number
        ]
        assert met is expected


def _engines(same: ThirdFluctuation, angle: float) -> EngineEvidence:
    rising = third(*np.linspace(150.0, 200.0, 16))
    quiet = ModelComparison(CELL, third(0.1), third(angle))
    return EngineEvidence([ModelComparison(CELL, rising, same)], [quiet])


def test_second_engine_supports_if_it_has_the_vibration_and_is_quiet_under_angle():
    """By itself: how alike both models are is told beside it."""
    alike = third(*np.linspace(151.0, 201.0, 16))
    assert _engines(alike, BELOW * SEVERE).supports is True
    assert _engines(third(*np.linspace(300.0, 400.0, 16)), 1.0).supports is True
    assert _engines(alike, ABOVE * SEVERE).supports is False
    assert _engines(third(*[20.0] * 16), 1.0).supports is False
    assert _engines(third(math.nan), 1.0).supports is None
    assert _engines(alike, math.nan).supports is None


def test_models_are_the_same_only_where_that_is_shown():
    """Not where a few starts leave it open, in which no test finds a difference either."""
    sizes = np.linspace(150.0, 152.0, 16)
    assert _engines(third(*sizes), 1.0).same is None  # of scattered sizes: 150 to 200
    tight = ModelComparison(CELL, third(*sizes), third(*(1.01 * sizes)))
    assert tight.same is True
    assert ModelComparison(CELL, third(*sizes), third(*(1.2 * sizes))).same is False
    half = third(*[20.0] * 8, *sizes[:8])
    assert ModelComparison(CELL, third(*sizes), half).same is False
    few = ModelComparison(CELL, third(*sizes[:3]), third(*sizes[:3]))
    assert few.same is None
    evidence = EngineEvidence([tight, few], [])
    assert evidence.adjusted_p[0].by_share == 1.0


def test_both_models_start_with_planets_apart():
    variant = replace(build_pd_variant(CELL, 0.01), planets="free")
    asked = PartedStartsQuestion(variant, (1, 2))
    for model in require_items(asked.models((1, 2))):
        (q, _), at = model.start(), model.layout.at
        planets = [q[at("x_pr", 0, planet)] for planet in range(3)]
        assert 0.1 * APART_M < np.ptp(planets) < 2 * APART_M


def test_onset_predicted():
    assert Onset(None, None).as_predicted
    assert not Onset(None, 1.0).as_predicted
    assert not Onset(1.0, None).as_predicted
    assert Onset(1 + BELOW * ONSET_WITHIN, 1.0).as_predicted
    assert not Onset(1 + ABOVE * ONSET_WITHIN, 1.0).as_predicted


def test_a_vibration_dies_below_a_tenth():
    assert DecayAfterSwitch(100.0, 50.0, BELOW * DEAD * 100.0).dies
    assert not DecayAfterSwitch(100.0, 50.0, ABOVE * DEAD * 100.0).dies


def test_the_handover_counts_where_it_dies_without_tooth_error():
    every, some = Share(4, 4), Share(3, 4)

    def fates(with_error: Share | None, without: Share | None) -> HandoverResult:
        pairs = ((INTEGRATED, with_error), (ERROR_FREE, without))
        found = [SwitchOutcome(CELL, heir, 4, NONE, NONE, NONE, dying) for heir, dying in pairs]
        return HandoverResult(found, None)  # type: ignore[arg-type]  # nothing is drawn

    assert fates(every, every).supports is True
    assert fates(some, every).supports is False
    assert fates(some, some).supports is None
    assert fates(None, None).supports is None


def test_far_from_a_resonance():
    growth = np.where(resonance.SPEEDS > 200.0, 5.0, -5.0)
    rates = {0.01: resonance.FloquetRates(tuple(growth), -1.0)}

    def found(speed: float) -> resonance.Resonance:
        modes = resonance.StageModes((speed * 99 / (2 * np.pi),), 99.0)
        return resonance.Resonance(modes, resonance.Speeds(1.0, 6.0, 19.0), {}, rates)

    assert found(ABOVE * resonance.FAR).supports
    assert not found(BELOW * resonance.FAR).supports
    assert found(resonance.FAR).lowest_open == resonance.SPEEDS[resonance.SPEEDS > 200.0][0]


def _dampers(sizes: dict[str, float], rest: float) -> dampers.DamperResult:
    ablated = [
        dampers.DamperAblation(one, 0.01, third(*[sizes[one.name]] * 10))
        for one in dampers.ABLATIONS
    ]
    return dampers.DamperResult(ablated[:1], ablated, (rest, rest, rest), [])


def test_a_hard_excited_flutter_needs_all_of_its_causes():
    gone, there = BELOW * dampers.STILL, ABOVE * EVIDENT
    own = {one.name: gone for one in (dampers.ALWAYS, dampers.PLAYED_BACK, dampers.TIGHT)}
    own |= {one.name: there for one in (dampers.AS_IT_STANDS, dampers.STEADY)}
    assert _dampers(own, gone).excited_hard is True
    assert _dampers(own, ABOVE * dampers.STILL).excited_hard is False
    for one in (dampers.ALWAYS, dampers.PLAYED_BACK, dampers.TIGHT):
        assert _dampers({**own, one.name: ABOVE * dampers.STILL}, gone).excited_hard is False
    for one in (dampers.AS_IT_STANDS, dampers.STEADY):
        assert _dampers({**own, one.name: BELOW * EVIDENT}, gone).excited_hard is False
    assert _dampers({**own, dampers.TIGHT.name: math.nan}, gone).excited_hard is None
    assert _dampers(own, gone).largest_zeta == 0.01


def test_running_away_is_faster_than_any_controlled_motion():
    run = simulate(replace(SHORT, model="analytic:coupled", duration_s=1.0, zeta=None))
    assert 5 * np.abs(run["theta_dot"].values).max() < dampers.FAST_RAD_PER_S


def test_eq_11_in_full_is_the_suns_and_the_planets_own_turning():
    model = PhysicalModel(*SHORT.case())
    weights = neglected_weights(model)
    sun, planet = 27 / 36.82406e-3, 36 / 49.09875e-3
    assert weights[0] == pytest.approx([sun, sun, 0, 0, 0, 0], rel=1e-6)
    assert weights[3] == pytest.approx([0, 0, 0, 0, planet, 0], rel=1e-6)


@pytest.mark.parametrize("law", ["omega_t", "angle"])
@pytest.mark.parametrize("full_rate", [False, True])
def test_jacobian_is_that_of_the_equations(law, full_rate):
    case = replace(SHORT, phase=law, duration_s=1.0).case()
    plant = build_plant(PhysicalModel(*case), full_rate)
    assert linear.jacobian_error(plant, linear.compute_base_motion(case, plant, 100), 6) < 1e-7


def test_the_base_motion_needs_no_vibration_to_carry_the_arm():
    """Started on it, the full equations stay on it: forces balance row by row."""
    case = replace(SHORT, phase="angle", duration_s=0.6).case()
    plant = build_plant(PhysicalModel(*case))
    base = linear.compute_base_motion(case, plant, 10)
    k = int(np.searchsorted(base.time, 0.5))
    brief = replace(SHORT, phase="angle", duration_s=0.01, record_every=1000).case()
    run = simulate_motion(
        [ContinuedModel(brief, base.q[k], base.v[k], plant.equations)], float(base.time[k])
    )
    drift = run.q[-1, :, 0] - base.q[k + 10]
    assert np.abs(drift[plant.gears.x_index]).max() < 2e-7  # against 1e-5 m of compression
    assert np.abs(drift[plant.gears.theta]).max() < 1e-5


def test_modes_at_rest_are_those_of_the_model():
    case = replace(SHORT, zeta=1e-6, phase="angle").case()
    plant = build_plant(PhysicalModel(*case))
    base = linear.compute_base_motion(case, plant, 10)
    still = base._replace(time=base.time[:1], q=base.q[:1], v=base.v[:1], force=base.force[:1])
    expected = PhysicalModel(*case).mesh_modes()[-4:]
    assert np.sort(linear.compute_mesh_modes(plant, still).frequency[0]) == pytest.approx(
        expected, rel=2e-3
    )


def test_amplitude_follows_the_integral_above_the_floor():
    time = np.linspace(0.0, 1.0, 1001)
    growth = np.where(time < 0.5, -100.0, 40.0)[:, None]
    level = linear.predicted_amplitude(time, growth, np.array([1.0]), np.array([1e-6]))
    assert level[300] == pytest.approx(1e-6)
    assert level[-1] == pytest.approx(1e-6 * np.exp(40 * 0.5), rel=0.1)


def test_intervals_are_told_from_their_e_folds_on():
    time = np.linspace(0.0, 1.0, 1001)
    growth = np.where((time > 0.3) & (time < 0.5), 100.0, -1.0)[:, None]
    modes = linear.Modes(growth, np.full_like(growth, 1700.0))
    (found,) = linear.find_unstable_intervals(time, modes, 19.0)
    assert found.folds == pytest.approx(20.0, rel=0.02)
    assert found.frequency == pytest.approx(1700.0)
    assert not linear.find_unstable_intervals(time, modes, 21.0)


def test_vibration_leaves_the_motion_of_the_arm_out():
    time = np.arange(50000) * 2e-5
    fast = vibration(time, 100 * np.sin(2 * np.pi * 20 * time) + np.sin(2 * np.pi * 1700 * time))
    assert np.abs(fast[2000:-2000]).max() == pytest.approx(1.0, rel=0.01)


def test_a_tongue_opens_at_twice_a_modes_frequency_and_damping_closes_it():
    speeds = np.array([150.0, 2 * 2 * np.pi * 1709.9 / 99])
    away, inside = resonance.compute_floquet_growth(0.005, speeds)
    assert away < 0 < inside
    assert resonance.compute_floquet_growth(0.1, speeds).max() < 0


@pytest.mark.parametrize(
    ("sizes", "without", "outcome"),
    [
        ([ABOVE * SEVERE] * 32, 1.0, "severe"),
        ([BELOW * SEVERE] * 32, 1.0, "weaker"),
        ([BELOW * EVIDENT] * 32, 1.0, "gone"),
        ([BELOW * EVIDENT] * 16 + [ABOVE * SEVERE] * 16, 1.0, "unsettled"),
        ([ABOVE * SEVERE] * 32, ABOVE * SEVERE, None),  # the tooth error has nothing to make
    ],
)
def test_what_eq_11_in_full_leaves_is_judged_on_both_sides_of_both_limits(sizes, without, outcome):
    one = objections.ObjectionResult(
        objections.FULL,
        objections.IN_FULL,
        CELL,
        third=third(*sizes),
        without=third(*[without] * 32),
    )
    rest = replace(one, cell=Condition(INTEGRAL, 0.005), third=third(*[1.0] * 32))
    assert objections.Objections([one, rest], {}).full_equation == outcome
    assert objections.Objections([rest], {}).full_equation is None


@pytest.mark.slow
@pytest.mark.parametrize("cell", [Condition(PRINTED, 0.005), Condition(REPAIRED_RATE, 0.02)])
def test_exudyn_follows_the_analytic_model_into_the_vibration(cell):
    """Up to where rounding has grown: the first 0.1 s of the same start, planets free."""
    one = replace(build_pd_variant(cell, 0.1), seed=1)
    runs = [simulate(replace(one, model=model)) for model in ("analytic:physical", "exudyn:tree")]
    gap = np.abs(runs[0]["theta_ddot"].values - runs[1]["theta_ddot"].values)
    assert gap.max() < 1e-2 * np.abs(runs[0]["theta_ddot"].values).max()
