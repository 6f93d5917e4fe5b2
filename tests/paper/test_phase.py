"""Hypothesis H1: what decides it, on both sides of every threshold, and the tools behind it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analytic.model import PhysicalModel
from crosscheck.paper.phase import engines as phase_engines
from crosscheck.paper.phase import maps as phase_maps
from crosscheck.paper.phase import stability as phase_stability
from crosscheck.paper.phase.chapter import chapter
from crosscheck.paper.phase.experiments import (
    Experiment,
    Response,
    third_amplitude,
    vibration,
)
from crosscheck.paper.phase.fluctuations import Fluctuation
from crosscheck.paper.phase.linear import (
    Modes,
    base_motion,
    jacobian_error,
    mesh_modes,
    predicted_amplitude,
    unstable_intervals,
)
from crosscheck.paper.phase.planets import planet_spread
from crosscheck.paper.phase.plant import integrate, neglected_weights, plant_of
from crosscheck.paper.phase.resonance import tongues
from crosscheck.paper.phase.verdict import (
    CLOCK_N,
    DEAD,
    FAR,
    NEAR,
    ONSET_PREDICTED,
    PRESENT_RAD_PER_S2,
    Presence,
    dies,
    error_part,
    h1_verdict,
    is_far,
    is_near,
    knows_the_clock,
    onset_is_predicted,
    second_engine_supports,
    where_present,
)
from crosscheck.paper.scale import QUICK
from crosscheck.studies.study import Study, Variant, simulate

SHORT = Variant(zeta=0.02, phase="omega_t", ring_rate="corrected", duration_s=0.02)
ABOVE, BELOW = 1.01, 0.99


@pytest.mark.parametrize(
    ("omega_t", "angle", "expected"),
    [
        (ABOVE, BELOW, Presence.PRINTED),
        (BELOW, ABOVE, Presence.INTEGRATED),
        (ABOVE, ABOVE, Presence.BOTH),
        (BELOW, BELOW, Presence.NEITHER),
    ],
)
def test_one_cell_above_the_threshold_decides(
    omega_t: float, angle: float, expected: Presence
) -> None:
    parts = {
        "omega_t": [0.0, omega_t * PRESENT_RAD_PER_S2],
        "angle": [angle * PRESENT_RAD_PER_S2, 0.0],
    }
    assert where_present(parts) == expected


def test_the_error_part_is_what_the_error_adds() -> None:
    assert error_part(300.0, 20.0) == 280.0
    assert error_part(19.0, 20.0) == 0.0
    assert error_part(np.inf, 20.0) == np.inf
    assert np.isnan(error_part(20.0, np.inf))
    assert np.isnan(error_part(np.nan, 20.0))


def test_a_clock_is_seen_above_rounding() -> None:
    assert knows_the_clock(ABOVE * CLOCK_N)
    assert not knows_the_clock(BELOW * CLOCK_N)


def test_a_vibration_dies_below_a_tenth() -> None:
    assert dies(100.0, BELOW * DEAD * 100.0)
    assert not dies(100.0, ABOVE * DEAD * 100.0)


def test_far_from_a_resonance() -> None:
    assert is_far(ABOVE * FAR, 1.0)
    assert not is_far(BELOW * FAR, 1.0)


def test_near_the_threshold() -> None:
    for edge, inside, outside in ((1 / NEAR, ABOVE, BELOW), (NEAR, BELOW, ABOVE)):
        assert is_near(inside * edge * PRESENT_RAD_PER_S2)
        assert not is_near(outside * edge * PRESENT_RAD_PER_S2)


def test_second_engine_supports_if_it_shows_the_same_and_is_quiet_under_angle() -> None:
    below, above = BELOW * PRESENT_RAD_PER_S2, ABOVE * PRESENT_RAD_PER_S2
    assert second_engine_supports([True, True], [False, True], [below, below])
    assert not second_engine_supports([True, True], [False, False], [below, below])
    assert not second_engine_supports([True, False], [True, True], [below, below])
    assert not second_engine_supports([True, True], [True, True], [below, above])
    assert second_engine_supports([True, True], [True, True], [below, None]) is None


def test_a_number_of_another_name_is_no_fluctuation() -> None:
    with pytest.raises(TypeError):
        Fluctuation.of({"amplitude": 1.0})


def test_planets_out_of_step_are_seen() -> None:
    run = simulate(replace(SHORT, duration_s=0.001))
    assert planet_spread(run) == 0.0
    run["x_pr"][-1, 1, 2] += 1e-6
    assert planet_spread(run) == pytest.approx(1e-6)


def test_onset_predicted() -> None:
    assert onset_is_predicted(None, None)
    assert not onset_is_predicted(None, 1.0)
    assert not onset_is_predicted(1.0, None)
    assert onset_is_predicted(1 + BELOW * ONSET_PREDICTED, 1.0)
    assert not onset_is_predicted(1 + ABOVE * ONSET_PREDICTED, 1.0)


def test_verdict_of_h1() -> None:
    every = {"clock": True, "engine": True}
    assert h1_verdict(Presence.PRINTED, every) == "holds"
    assert h1_verdict(Presence.UNKNOWN, every) == "undefined"
    undefined = h1_verdict(Presence.PRINTED, {**every, "engine": None})
    assert undefined == "holds in the simulations, but undefined in: engine"
    assert "clock" in h1_verdict(Presence.PRINTED, {**every, "clock": False})
    for elsewhere in (Presence.BOTH, Presence.NEITHER, Presence.INTEGRATED):
        assert h1_verdict(elsewhere, every) == "does not hold"


def test_the_free_clock_at_zero_is_the_model_itself() -> None:
    run, own = simulate(SHORT), Experiment(SHORT).perform()
    assert np.abs(own.theta_ddot - run["theta_ddot"].values).max() < 1e-6


@pytest.mark.parametrize(("law", "same"), [("angle", True), ("omega_t", False)])
def test_only_the_printed_law_knows_the_time(law: str, same: bool) -> None:
    variant = replace(SHORT, phase=law)
    early, late = (Experiment(variant, clock).perform() for clock in (0.0, 5.0))
    assert np.array_equal(early.theta_ddot, late.theta_ddot) is same


def test_an_experiment_goes_on_where_another_stopped() -> None:
    half = Experiment(replace(SHORT, duration_s=0.01))
    whole, resumed = Experiment(SHORT).perform(), Experiment(half.variant, after=half).perform()
    assert resumed.time[0] == pytest.approx(0.01)
    assert np.abs(resumed.q - whole.q).max() < 1e-12


def test_eq_11_in_full_is_the_suns_and_the_planets_own_turning() -> None:
    model = PhysicalModel(*SHORT.case())
    weights = neglected_weights(model)
    sun, planet = 27 / 36.82406e-3, 36 / 49.09875e-3
    assert weights[0] == pytest.approx([sun, sun, 0, 0, 0, 0], rel=1e-6)
    assert weights[3] == pytest.approx([0, 0, 0, 0, planet, 0], rel=1e-6)


@pytest.mark.parametrize("law", ["omega_t", "angle"])
@pytest.mark.parametrize("full_rate", [False, True])
def test_jacobian_is_that_of_the_equations(law: str, full_rate: bool) -> None:
    case = replace(SHORT, phase=law, duration_s=1.0).case()
    plant = plant_of(PhysicalModel(*case), full_rate)
    assert jacobian_error(plant, base_motion(case, plant, 100), 6) < 1e-7


def test_the_base_motion_needs_no_vibration_to_carry_the_arm() -> None:
    """Started on it, the full equations stay on it: forces balance row by row."""
    case = replace(SHORT, phase="angle", duration_s=0.6).case()
    plant = plant_of(PhysicalModel(*case))
    base = base_motion(case, plant, 10)
    k = int(np.searchsorted(base.time, 0.5))
    qs, _ = integrate(plant, float(base.time[k]), base.q[k], base.v[k], 1e-5, 1000, 1000)
    drift = qs[-1] - base.q[k + 10]
    assert np.abs(drift[plant.gears.where]).max() < 2e-7  # against 1e-5 m of compression
    assert np.abs(drift[plant.gears.theta]).max() < 1e-5


def test_modes_at_rest_are_those_of_the_model() -> None:
    case = replace(SHORT, zeta=1e-6, phase="angle").case()
    plant = plant_of(PhysicalModel(*case))
    base = base_motion(case, plant, 10)
    still = base._replace(time=base.time[:1], q=base.q[:1], v=base.v[:1], force=base.force[:1])
    expected = PhysicalModel(*case).mesh_modes()[-4:]
    assert np.sort(mesh_modes(plant, still).frequency[0]) == pytest.approx(expected, rel=2e-3)


def test_amplitude_follows_the_integral_above_the_floor() -> None:
    time = np.linspace(0.0, 1.0, 1001)
    growth = np.where(time < 0.5, -100.0, 40.0)[:, None]
    level = predicted_amplitude(time, growth, np.array([1.0]), np.array([1e-6]))
    assert level[300] == pytest.approx(1e-6)
    assert level[-1] == pytest.approx(1e-6 * np.exp(40 * 0.5), rel=0.1)


def test_intervals_are_told_from_their_e_folds_on() -> None:
    time = np.linspace(0.0, 1.0, 1001)
    growth = np.where((time > 0.3) & (time < 0.5), 100.0, -1.0)[:, None]
    modes = Modes(growth, np.full_like(growth, 1700.0))
    (found,) = unstable_intervals(time, modes, 19.0)
    assert found.folds == pytest.approx(20.0, rel=0.02)
    assert found.frequency == pytest.approx(1700.0)
    assert not unstable_intervals(time, modes, 21.0)


def test_vibration_leaves_the_motion_of_the_arm_out() -> None:
    time = np.arange(50000) * 2e-5
    fast = vibration(time, 100 * np.sin(2 * np.pi * 20 * time) + np.sin(2 * np.pi * 1700 * time))
    assert np.abs(fast[2000:-2000]).max() == pytest.approx(1.0, rel=0.01)


def test_a_diverged_run_has_no_finite_amplitude() -> None:
    nothing = np.full((10, 2), np.nan)
    assert third_amplitude(Response(np.arange(10.0), nothing, nothing[0], nothing[0])) == np.inf
    assert phase_maps.amplitude(Fluctuation(diverged_s=0.1)) == np.inf


def test_a_tongue_opens_at_twice_a_modes_frequency_and_damping_closes_it() -> None:
    speeds = np.array([150.0, 2 * 2 * np.pi * 1709.9 / 99])
    away, inside = tongues(0.005, speeds)
    assert away < 0 < inside
    assert tongues(0.1, speeds).max() < 0


@pytest.mark.slow
def test_quick_chapter(tmp_path: Path) -> None:
    made = chapter(Study(tmp_path), QUICK)
    assert made.records[0]["verdict"] == "holds"
    assert made.html.count("<svg") == 2
    assert {r["id"] for r in made.records} >= {
        f"stability/{law}/{ring}/{zeta:g}"
        for zeta, ring in phase_stability.SETTINGS
        for law in phase_stability.LAWS
    }


@pytest.mark.slow
@pytest.mark.parametrize(("zeta", "ring"), phase_engines.SETTINGS)
def test_exudyn_follows_the_analytic_model_into_the_vibration(zeta: float, ring: str) -> None:
    """Up to where rounding has grown: the first 0.1 s of the same start."""
    one = Variant(phase="omega_t", ring_rate=ring, zeta=zeta, duration_s=0.1, seed=1)
    runs = [simulate(replace(one, model=model)) for model in ("analytic:physical", "exudyn:tree")]
    gap = np.abs(runs[0]["theta_ddot"].values - runs[1]["theta_ddot"].values)
    assert gap.max() < 1e-2 * np.abs(runs[0]["theta_ddot"].values).max()
