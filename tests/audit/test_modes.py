"""The clock, the second engine and the modes: what decides them, and the tools behind them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.experiments.paper_conditions import (
    DECISIVE,
    INTEGRAL,
    PRINTED,
    REPAIRED_RATE,
    Condition,
)
from crosscheck.audit.experiments.variant import Variant, simulate
from crosscheck.audit.findings import clock, linear, presence
from crosscheck.audit.findings.clock import simulate_motion
from crosscheck.audit.findings.engines import (
    APART_M,
    EngineEvidence,
    ModelComparison,
    PartedStartsQuestion,
)
from crosscheck.audit.findings.stability import ONSET_WITHIN, Onset, find_vibration_envelope
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


def test_a_run_goes_on_where_another_stopped():
    half = replace(SHORT, duration_s=0.01).case()
    before, whole = (
        simulate_motion([PhysicalModel(*half)]),
        simulate_motion([PhysicalModel(*SHORT.case())]),
    )
    last = before.q[-1, :, 0].copy(), before.v[-1, :, 0].copy()
    assert before.elapsed[-1] == pytest.approx(0.01)
    resumed = simulate_motion([ContinuedModel(half, *last)], 0.01)
    assert np.abs(resumed.q[-1] - whole.q[-1]).max() < 1e-12


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
    asked = PartedStartsQuestion(CELL.variant(), (1, 2))
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
def test_jacobian_foretells_what_any_small_change_does(law):
    """All coordinates and rates changed at once, by up to ten times the steps of its columns."""
    model = PhysicalModel(*replace(SHORT, phase=law, duration_s=1.0).case())
    base = linear.compute_base_motion(model, 100)
    size = np.full(2 * base.q.shape[1], 10 * linear.STEP_RAD)
    size[model.gears.x_index] = 10 * linear.STEP_M
    change = size * np.random.default_rng(1).uniform(-1, 1, size.size)
    for k in require_items(np.linspace(1, base.time.size - 1, 6).astype(int)):
        t, q, v = float(base.time[k]), base.q[k], base.v[k]
        there, back = (
            model.acceleration(t, q + d[: q.size], v + d[q.size :]) for d in (change, -change)
        )
        foretold = linear.jacobian(model, t, q, v)[q.size :] @ (2 * change)
        # The sine of a phase that changes by 1e-3 is straight to 1e-6 of its size.
        assert np.abs(there - back - foretold).max() < 1e-5 * np.abs(foretold).max()


def test_the_base_motion_needs_no_vibration_to_carry_the_arm():
    """Started on it, the full equations stay on it: forces balance row by row."""
    case = replace(SHORT, phase="angle", duration_s=0.6).case()
    model = PhysicalModel(*case)
    base = linear.compute_base_motion(model, 10)
    k = int(np.searchsorted(base.time, 0.5))
    brief = replace(SHORT, phase="angle", duration_s=0.01, record_every=1000).case()
    run = simulate_motion(
        [ContinuedModel(brief, base.q[k], base.v[k], model.term_equations)], float(base.time[k])
    )
    drift = run.q[-1, :, 0] - base.q[k + 10]
    assert np.abs(drift[model.gears.x_index]).max() < 2e-7  # against 1e-5 m of compression
    assert np.abs(drift[model.gears.theta]).max() < 1e-5


def test_modes_at_rest_are_those_of_the_model():
    case = replace(SHORT, zeta=1e-6, phase="angle").case()
    model = PhysicalModel(*case)
    base = linear.compute_base_motion(model, 10)
    still = linear.BaseMotion(*(part[:1] for part in base))
    expected = model.mesh_modes()[-4:]
    assert np.sort(linear.compute_mesh_modes(model, still).frequency[0]) == pytest.approx(
        expected, rel=2e-3
    )


def test_amplitude_follows_the_integral_above_the_floor():
    time = np.linspace(0.0, 1.0, 1001)
    growth = np.where(time < 0.5, -100.0, 40.0)[:, None]
    level = linear.predicted_amplitude(time, growth, np.array([1.0]), np.array([1e-6]))
    assert level[300] == pytest.approx(1e-6)
    assert level[-1] == pytest.approx(1e-6 * np.exp(40 * 0.5), rel=0.1)


def test_the_envelope_leaves_the_motion_of_the_arm_out():
    time = np.arange(50000) * 2e-5
    values = 100 * np.sin(2 * np.pi * 20 * time) + np.sin(2 * np.pi * 1700 * time)
    envelope = find_vibration_envelope(time, values)[2000:-2000]
    assert (envelope.min(), envelope.max()) == pytest.approx((1.0, 1.0), rel=0.01)
    assert np.isnan(find_vibration_envelope(time[:10], values[:10])).all()


@pytest.mark.slow
@pytest.mark.parametrize("cell", DECISIVE)
def test_exudyn_follows_the_analytic_model_into_the_vibration(cell):
    """Up to where rounding has grown: the first 0.1 s of the same start, planets free."""
    one = replace(cell.variant(), duration_s=0.1, seed=1)
    runs = [simulate(replace(one, model=model)) for model in ("analytic:physical", "exudyn:tree")]
    gap = np.abs(runs[0]["theta_ddot"].values - runs[1]["theta_ddot"].values)
    assert gap.max() < 1e-2 * np.abs(runs[0]["theta_ddot"].values).max()
