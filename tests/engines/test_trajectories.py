"""The engines against each other, run by run; by every drive and switch in tests/faults."""

import numpy as np
import pytest
import xarray as xr

from crosscheck.checks.trajectories import Pair, largest_difference
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.loading import Case
from crosscheck.planning.plan import perturb_start_by_one_ulp
from crosscheck.registry import build
from tests.arms import PAPER
from tests.judged import same_step
from tests.loops import require_items
from tests.mixed_arms import scenario

PAIR = ("analytic:physical", "exudyn:tree")
OFFSETS = {"sun_planet_offset_m": 2.2e-6, "planet_ring_offset_m": 2.2e-6}
PD = {
    "kind": "pd",
    "target_rad": [0.5, -0.3],
    "proportional_N_m_per_rad": [1000.0, 800.0],
    "derivative_N_m_s_per_rad": [400.0, 300.0],
}


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
    moved = scenario(duration_s=0.01, step_s=1e-5, drive=PD, start=start)
    case = Case(PAPER, moved, switches())
    left, right = (build(name, *case).simulate() for name in PAIR)
    nudged = build(PAIR[0], *perturb_start_by_one_ulp(case)).simulate()
    findings = list(same_step("test", case, left, right, Pair(left, nudged)))
    assert {f.verdict for f in findings} == {"agree"}, findings


def run(name: str, duration_s: float, step_s: float, every: int, **start: float) -> xr.Dataset:
    """Of the paper's arm under constant torque, from the first contact on."""
    grid = {"duration_s": duration_s, "step_s": step_s, "record_every": every}
    return build(name, PAPER, scenario(100.0, **grid, start=start)).simulate()


@pytest.mark.parametrize("name", PAIR)
def test_runge_kutta_has_order_four_while_the_teeth_stay_in_contact(name):
    results = []
    for every in (2, 4, 8, 32):
        found = run(name, 0.002, 2e-5 / every, every, **OFFSETS)
        assert found.F_sp.values.min() > 0 < found.F_pr.values.min()
        results.append(np.stack([found.x_sp, found.x_pr]))
    errors = [abs(result - results[-1]).max() for result in results[:-1]]
    # The fastest mode turns by 0.28 rad in the largest step, whose square is the next term's share.
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 4, atol=0.1)


@pytest.mark.slow
def test_a_millisecond_of_separate_bodies_agrees_to_richardsons_estimate():
    coarse, fine = (run("exudyn:bodies", 1e-3, 1e-5 / every, every) for every in (10, 20))
    tree = run("exudyn:tree", 1e-3, 1e-6, 10)
    for quantity in require_items(("theta", "theta_dot", "x_sp", "x_pr", "F_sp", "F_pr")):
        # Order 2 leaves a third of the last change; the tree's RK44 leaves 1e-3 of that. 1.25 is
        # the safety factor of the grid convergence index where the order is known.
        estimate = 1.25 * largest_difference(fine, coarse, quantity) / 3
        assert 0 < largest_difference(fine, tree, quantity) < estimate
        # With the second order taken out the fourth is left, (h omega)^2 = 2e-4 of it per order.
        best = fine[quantity] + (fine[quantity] - coarse[quantity]) / 3
        assert float(abs(best - tree[quantity]).max()) < 1e-2 * estimate
