"""The engines against each other, run by run; by every drive and switch in tests/faults."""

import numpy as np
import pytest
import xarray as xr

from crosscheck.checks.trajectories import Pair
from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario, Switches, switches
from crosscheck.models.loading import Case
from crosscheck.planning.plan import perturb_start_by_one_ulp
from crosscheck.registry import build
from tests.arms import PAPER, arm_of
from tests.judged import same_step
from tests.mixed_arms import scenario

PAIR = ("analytic:physical", "exudyn:tree")
OFFSETS = {"sun_planet_offset_m": 2.2e-6, "planet_ring_offset_m": 2.2e-6}
CONSTANT = {"kind": "constant", "torque_N_m": 100.0}
PD = {
    "kind": "pd",
    "target_rad": [0.5, -0.3],
    "proportional_N_m_per_rad": [1000.0, 800.0],
    "derivative_N_m_s_per_rad": [400.0, 300.0],
}


def experiment(drive: dict, duration_s: float = 0.01, step_s: float = 1e-5, **more) -> Scenario:
    """A short scenario with this drive, the start at first contact unless stated."""
    return scenario(duration_s=duration_s, step_s=step_s, drive=drive, **more)


def runs(case: Case) -> list[xr.Dataset]:
    return [build(name, *case).simulate() for name in PAIR]


def disagreements(arm: Arm, moved: Scenario, chosen: Switches | None = None) -> list[str]:
    """Checks that are not green at the tolerances of a common step."""
    case = Case(arm, moved, chosen or switches())
    left, right = runs(case)
    findings = list(same_step("test", case, left, right, Pair(left, nudged_run(case))))
    return [f"{f.id}: {f.measured} > {f.tolerance}" for f in findings if f.verdict != "agree"]


def nudged_run(case: Case) -> xr.Dataset:
    """The first model's, started one rounding away."""
    return build(PAIR[0], *perturb_start_by_one_ulp(case)).simulate()


@pytest.mark.parametrize("phase", ["angle", "omega_t"])
def test_constant_torque_agrees_through_every_impact(reading, phase):
    chosen = switches(phase=phase)
    assert disagreements(reading, experiment(CONSTANT, 0.05), chosen) == []


@pytest.mark.parametrize(
    "arm",
    [arm_of(1), arm_of(3), arm_of(2, direct=[0]), arm_of(3, direct=[2]), arm_of(2, direct=[0, 1])],
    ids=["one", "three", "direct-geared", "geared-geared-direct", "direct"],
)
def test_arms_of_other_sizes_and_kinds_agree(arm):
    drive = CONSTANT | {"torque_N_m": [40.0] * len(arm.joints)}
    assert disagreements(arm, experiment(drive)) == []


@pytest.mark.parametrize("seed", range(3))
def test_starts_perturbed_at_random_agree(seed):
    draw = np.random.default_rng(seed)
    start = {
        "mesh": ("contact", "centre")[seed % 2],
        "theta_rad": draw.uniform(-3, 3, 2).tolist(),
        "theta_dot_rad_per_s": draw.uniform(-2, 2, 2).tolist(),
        "sun_planet_offset_m": draw.uniform(-6e-5, 6e-5, 2).tolist(),
        "planet_ring_offset_m": draw.uniform(-6e-5, 6e-5, 2).tolist(),
    }
    assert disagreements(PAPER, experiment(PD, start=start)) == []


@pytest.mark.parametrize("name", PAIR)
def test_runge_kutta_has_order_four_while_the_teeth_stay_in_contact(name):
    finest = 32
    results = []
    for every in (2, 4, 8, finest):
        scenario = experiment(CONSTANT, 0.002, 2e-5 / every, start=OFFSETS, record_every=every)
        run = build(name, PAPER, scenario).simulate()
        assert run.F_sp.values.min() > 0 < run.F_pr.values.min()
        results.append(np.stack([run.x_sp, run.x_pr]))
    errors = [abs(result - results[-1]).max() for result in results[:-1]]
    # The fastest mode turns by 0.28 rad in the largest step, whose square is the next term's share.
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 4, atol=0.1)
