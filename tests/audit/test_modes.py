"""The clock, the second engine and the modes: what decides them, and the tools behind them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.experiments.motion import (
    build_models,
    build_pd_variant,
    simulate_motion,
    vibration,
)
from crosscheck.audit.experiments.paper_conditions import (
    INTEGRAL,
    PRINTED,
    REPAIRED_RATE,
    Condition,
)
from crosscheck.audit.experiments.variant import Variant, simulate
from crosscheck.audit.findings import clock, linear, presence
from crosscheck.audit.findings.engines import (
    APART_M,
    EngineEvidence,
    ModelComparison,
    PartedStartsQuestion,
)
from crosscheck.audit.findings.stability import ONSET_WITHIN, Onset
from crosscheck.audit.judging.rule import State
from crosscheck.audit.measures.third_fluctuation import ThirdFluctuation
from crosscheck.audit.measures.thresholds import SEVERE
from tests.audit.planted_runs import ContinuedModel, third
from tests.loops import require_items

SHORT = Variant(zeta=0.02, phase="omega_t", ring_rate="corrected", duration_s=0.02)
CELL = Condition(PRINTED, 0.005)
ABOVE, BELOW = 1.01, 0.99


@pytest.mark.parametrize(
    ("omega_t", "angle", "expected"),
    [
        (State.YES, State.NO, presence.Presence.PRINTED),
        (State.BISTABLE, State.NO, presence.Presence.PRINTED),
        (State.NO, State.BISTABLE, presence.Presence.INTEGRATED),
        (State.YES, State.YES, presence.Presence.BOTH),
        (State.NO, State.NO, presence.Presence.NEITHER),
        (State.YES, State.UNDEFINED, presence.Presence.PRINTED),
    ],
)
def test_one_setting_in_which_it_happens_decides(omega_t, angle, expected):
    states = {"omega_t": [State.NO, omega_t], "angle": [angle, State.NO]}
    assert presence.find_presence(states) == expected


def test_a_law_that_says_nothing_leaves_it_open():
    said = {"omega_t": [State.YES], "angle": [State.UNDEFINED]}
    assert presence.find_presence(said) == presence.Presence.UNKNOWN


@pytest.mark.parametrize("knows", [(True, True), (True, False), (False, True), (False, False)])
def test_both_printed_laws_must_know_the_time_and_the_integral_must_not(knows):
    nothing = clock.SignalEnvelope((), (), ())

    def tested(law, same):
        return clock.LawClockTest(law, [clock.DelayResult(1.0, (), same, nothing)])

    laws = [
        tested(law, not knew) for law, knew in zip((PRINTED, REPAIRED_RATE), knows, strict=True)
    ]
    for blind in (True, False):
        found = clock.ClockTestResult([*laws, tested(INTEGRAL, blind)])
        assert found.supports is (all(knows) and blind)


@pytest.mark.parametrize(("law", "same"), [(INTEGRAL, True), (PRINTED, False)])
def test_only_the_printed_law_knows_the_time(law, same):
    found = clock.ClockTest(law, 0.01, (1, 2)).answer()
    assert [one.same for one in found] == [True, same, same, same]


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


def test_a_start_is_the_same_whichever_stand_beside_it():
    variant = build_pd_variant(CELL, 0.01)
    alone, three = (simulate_motion(build_models(variant, seeds)).q for seeds in ((2,), (1, 2, 3)))
    assert np.array_equal(alone[:, :, 0], three[:, :, 1])


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


@pytest.mark.parametrize("law", ["omega_t", "angle"])
def test_jacobian_is_that_of_the_equations(law):
    """By differences of the fourth order, whose steps keep within contact.

    1e-6 rad and rad/s, for phi = 99 theta needs 1e-4 rad to change by 1 %; 1e-9 m is far less than
    the 1e-5 m by which a mesh is pressed in.
    """
    case = replace(SHORT, phase=law, duration_s=1.0).case()
    plant = linear.build_plant(PhysicalModel(*case))
    base = linear.compute_base_motion(case, plant, 100)
    steps = np.full(2 * base.q.shape[1], 1e-6)
    steps[plant.gears.x_index] = 1e-9
    for k in require_items(np.linspace(1, base.time.size - 1, 6).astype(int)):
        state = np.concatenate([base.q[k], base.v[k]])

        def acceleration(state, t=float(base.time[k])):
            return plant.states.evaluate(t, *np.split(state, 2)).acceleration

        columns = [
            (8 * (acceleration(state + h) - acceleration(state - h))
             - acceleration(state + 2 * h) + acceleration(state - 2 * h)) / (12 * h.sum())
            for h in np.diag(steps)
        ]  # fmt: skip
        found = linear.jacobian(plant, float(base.time[k]), base.q[k], base.v[k])[state.size // 2 :]
        size = np.abs(columns).max(axis=1)
        assert (np.abs(found - np.transpose(columns)) <= 1e-7 * np.where(size > 0, size, 1.0)).all()


def test_the_base_motion_needs_no_vibration_to_carry_the_arm():
    """Started on it, the full equations stay on it: forces balance row by row."""
    case = replace(SHORT, phase="angle", duration_s=0.6).case()
    plant = linear.build_plant(PhysicalModel(*case))
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
    plant = linear.build_plant(PhysicalModel(*case))
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


def test_vibration_leaves_the_motion_of_the_arm_out():
    time = np.arange(50000) * 2e-5
    fast = vibration(time, 100 * np.sin(2 * np.pi * 20 * time) + np.sin(2 * np.pi * 1700 * time))
    assert np.abs(fast[2000:-2000]).max() == pytest.approx(1.0, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("cell", [Condition(PRINTED, 0.005), Condition(REPAIRED_RATE, 0.02)])
def test_exudyn_follows_the_analytic_model_into_the_vibration(cell):
    """Up to where rounding has grown: the first 0.1 s of the same start, planets free."""
    one = replace(build_pd_variant(cell, 0.1), seed=1)
    runs = [simulate(replace(one, model=model)) for model in ("analytic:physical", "exudyn:tree")]
    gap = np.abs(runs[0]["theta_ddot"].values - runs[1]["theta_ddot"].values)
    assert gap.max() < 1e-2 * np.abs(runs[0]["theta_ddot"].values).max()
