"""Records, starts and large forces of Exudyn's two tiers, on arms that mix kinds of joints."""

import numpy as np
import pytest

from crosscheck.models.exudyn.bodies.bodies import ExudynBodies
from crosscheck.models.exudyn.tree.stiffness import WAVES, StiffnessCurve
from crosscheck.models.exudyn.tree.tree import ExudynTree
from tests.mixed_arms import MIXED, NONE, R_S, arm_of, geared, scenario
from tests.planet_meshes import stiffness_at

both_tiers = pytest.mark.parametrize("tier", [ExudynTree, ExudynBodies], ids=lambda t: t.name)


@both_tiers
def test_records_of_an_arm_with_direct_joints(tier):
    run = tier(MIXED["geared-direct"], scenario()).simulate()
    assert dict(run.sizes) == {"time": 11, "joint": 2, "planet": 4}
    for name in ("x_sp", "x_pr", "x_sp_dot", "x_pr_dot", "F_sp", "F_pr"):
        assert run[name].sel(joint=1).notnull().all()
        assert run[name].sel(joint=2).isnull().all()
    run = tier(MIXED["direct-direct"], scenario()).simulate()
    assert dict(run.sizes) == {"time": 11, "joint": 2}
    assert {"theta", "theta_dot", "theta_ddot", "torque", "kinetic_energy"} == set(run.data_vars)


def test_the_largest_stiffness_of_waves_is_that_of_all_together():
    """Waves of one to seven a cycle: the highest needs the finest samples."""
    cosines, sines = 1e6 * np.array([[3, 0, 1, 0, 2, 0, 5], [1, 0, 0, 4, 0, 0, 3]])
    phase, orders = np.linspace(0, 2 * np.pi, 20_001), np.arange(1, 8)
    waves = np.cos(np.outer(phase, orders)) @ cosines + np.sin(np.outer(phase, orders)) @ sines
    curve = StiffnessCurve(WAVES, 1e8, columns=(cosines, sines))
    assert curve.largest_stiffness == pytest.approx(1e8 + waves.max(), abs=5e-4 * np.ptp(waves))


@both_tiers
def test_large_contact_forces_in_balance_raise_no_alarm(tier):
    joint, torque = geared(), 2e5
    heavy = {"length_m": 0.9, "com_m": 0.4, "mass_kg": 1e6, "inertia_kg_m2": 1e9}
    model = tier(arm_of(joint, links=[heavy], gravity=NONE), scenario(torque))
    law = model.arm.joints[0].sun_mesh.planet_mesh(0).stiffness
    force = torque / 4 / R_S / 4  # of a planet's mesh: the sun is at rest, the ratio is 4
    at_sun, at_ring = 90 * 0.7 + 0.9, 90 * 0.7 - 0.4
    x_sp = force / stiffness_at(law, at_sun) + 4e-5 + 2e-5 * np.sin(at_sun)
    x_pr = force / stiffness_at(law, at_ring) + 3e-5 + 1e-5 * np.sin(at_ring)
    acceleration = model.acceleration(0.0, np.array([x_sp, x_pr, 0.7]), np.zeros(3))
    assert acceleration[2] == pytest.approx(torque / 1e9, rel=1e-2)
    assert force > 3e5


def test_coordinates_by_the_angles_of_planets_that_move_alike():
    poses = ExudynBodies(arm_of(geared()), scenario()).poses
    turning = poses.turns @ np.array([0.1, 0.2, 0.3])
    np.testing.assert_allclose(poses.coordinates(turning), [0.1, 0.2, 0.3], rtol=1e-12)
