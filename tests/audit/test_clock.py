"""The clock and the second engine: what decides them, and the tools behind them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.experiments.paper_conditions import (
    DECISIVE,
    INTEGRAL,
    LAWS,
    PRINTED,
    Condition,
)
from crosscheck.audit.experiments.variant import Variant, simulate
from crosscheck.audit.findings import clock
from crosscheck.audit.findings.clock import simulate_motion
from crosscheck.audit.findings.engines import (
    APART_M,
    ModelComparison,
    PartedStartsQuestion,
    is_third_fluctuation_in_engine,
)
from crosscheck.audit.judging.rule import Answer
from crosscheck.audit.measures.thresholds import SEVERE
from tests.audit.planted_runs import ContinuedModel, third
from tests.loops import require_items

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
    resumed = simulate_motion([ContinuedModel(half, *last)], 0.01)
    assert np.abs(resumed.q[-1] - whole.q[-1]).max() < 1e-12


def _is_in_engine(with_clock: Answer, angle: float) -> bool | None:
    rising = third(*np.linspace(150.0, 200.0, 16))
    quiet = ModelComparison(Condition(INTEGRAL, 0.005), third(0.1), third(angle))
    return is_third_fluctuation_in_engine([ModelComparison(CELL, rising, with_clock), quiet])


def test_second_engine_supports_if_it_has_the_vibration_and_is_quiet_under_angle():
    """By itself: how alike both models are is told beside it."""
    alike = third(*np.linspace(151.0, 201.0, 16))
    assert _is_in_engine(alike, BELOW * SEVERE) is True
    assert _is_in_engine(third(*np.linspace(300.0, 400.0, 16)), 1.0) is True
    assert _is_in_engine(alike, ABOVE * SEVERE) is False
    assert _is_in_engine(third(*[20.0] * 16), 1.0) is False
    assert _is_in_engine(third(math.nan), 1.0) is None
    assert _is_in_engine(alike, math.nan) is None


def test_both_models_start_with_planets_apart():
    asked = PartedStartsQuestion(CELL.variant(), (1, 2))
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
