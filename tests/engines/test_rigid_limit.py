"""The rigid arm beside a geared model is what that model's own equations tend to."""

import numpy as np
import pytest

from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.registry import build
from tests.loops import require_items

LIMITS = {"analytic:physical": "analytic:coupled", "analytic:printed": "analytic:printed-rigid"}


@pytest.mark.parametrize("geared", LIMITS)
@pytest.mark.parametrize("reading", ["paper-labelled", "paper-swapped"])
def test_held_meshes_leave_the_rigid_arm(geared: str, reading: str):
    """With x' = x'' = 0 the rows of theta are an equation of theta'' alone, whatever holds x."""
    arm, scenario = load_arm(reading), load_scenario("constant-torque")
    meshing, rigid = (build(name, arm, scenario) for name in (geared, LIMITS[geared]))
    theta = meshing.layout.theta
    states = np.random.default_rng(3).normal(0, 2, (5, 2, 2))
    for angles, rates in require_items(states):
        q, v = np.zeros((2, len(meshing.layout)))
        q[theta], v[theta] = angles, rates
        mass = meshing.mass_matrix(q)[np.ix_(theta, theta)]
        push = (meshing.generalized_force(0.0, q, v) - meshing.bias(q, v))[theta]
        assert rigid.mass_matrix(angles) == pytest.approx(mass, rel=1e-13)
        found = rigid.acceleration(0.0, angles, rates)
        assert found == pytest.approx(np.linalg.solve(mass, push), rel=1e-11)
