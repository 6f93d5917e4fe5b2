"""Exudyn's bodies with planets of their own, against mechanics that owes nothing to them."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.experiment.switches import switches
from crosscheck.models.exudyn.bodies.bodies import ExudynBodies, Toothed
from crosscheck.models.exudyn.bodies.contact import CARRIER, PREVIOUS, look, mesh_forces, readings
from tests.mixed_arms import PLANET_M, SUN_J, Data, arm_of, direct, geared, scenario
from tests.mixed_arms import random_states as states_of
from tests.outside_truth.bodies_planets import (
    ANGLES,
    energy_slopes,
    first_touch,
    recorded_forces,
    spots,
    spring_energy,
    states_in,
    tooth_forces,
    unlike_arm,
)

EPSILON = np.finfo(float).eps
BASE_PER_TOOTH = 0.0025 / 2 * np.cos(np.radians(20))
SUNS = [SUN_J / (teeth * BASE_PER_TOOTH) ** 2 for teeth in (28, 31)]  # equivalent masses [kg]
CONSERVATIVE = {"mesh_work": "conservative"}


def free(arm: Arm, run: Scenario | None = None, **laws: str) -> ExudynBodies:
    return ExudynBodies(arm, run or scenario(), switches(planets="free", **laws))


def every_mesh(model: ExudynBodies) -> list[Toothed]:
    """In the order of ``spots``."""
    return [
        toothed for sides in model.meshes for pair in zip(*sides, strict=True) for toothed in pair
    ]


def seen(values: np.ndarray, toothed: Toothed) -> np.ndarray:
    """Poses or rates of a mesh's bodies, the ground's zero."""
    by_body = np.append(values, np.zeros(3)).reshape(-1, 3)
    return by_body[list(toothed.bodies)].ravel()


@pytest.mark.parametrize("damping", ["always", "contact"])
def test_every_planets_teeth_push_by_their_own_numbers(damping: str):
    model = free(unlike_arm(), damping=damping)
    for q, v in states_of(model.layout, 8):
        # Deflections of 1e-4 m out of places near 1 m, times 1e8 N/m; phases of 300 rad.
        np.testing.assert_allclose(
            model.generalized_force(0.0, q, v), tooth_forces(q, v, damping), rtol=1e-10, atol=1e-5
        )


def test_poses_and_rates_of_free_planets_show_every_displacement():
    model = free(unlike_arm())
    for q, v in states_of(model.layout, 5):
        pose, velocity = model.poses.pose(q), model.poses.velocity(q, v)
        for spot, toothed in zip(spots(q, v), every_mesh(model), strict=True):
            contact = look(toothed.mesh, 0.0, seen(pose, toothed), seen(velocity, toothed))
            # Gears turned by some 10 rad, places of 1 m: a few roundings.
            assert contact.x == pytest.approx(spot.x, rel=0, abs=2e-15)
            assert contact.x_dot == pytest.approx(spot.x_dot, rel=0, abs=2e-14)


def test_sun_and_planets_have_the_inertia_that_they_have_alone():
    model = free(unlike_arm())
    for q, _ in states_of(model.layout, 3):
        mass = model.mass_matrix(q)
        slides = ~model.layout.angular
        expected = np.diag([SUNS[0], *[PLANET_M] * 3, SUNS[1], *[PLANET_M] * 4])
        # All else moves with the angles alone: roundings of what cancels.
        np.testing.assert_allclose(mass[np.ix_(slides, slides)], expected, rtol=1e-12, atol=1e-12)


def test_phases_are_those_counted_by_hand():
    zero = np.zeros(ANGLES[-1] + 1)
    counted = [spot.phase for spot in spots(zero, zero)]
    offsets = [toothed.mesh.offset for toothed in every_mesh(free(unlike_arm()))]
    # 93 teeth, rounded; and whole teeth do not count.
    np.testing.assert_allclose(np.exp(1j * np.subtract(offsets, counted)), 1, rtol=0, atol=1e-13)


def out_of_phase() -> Data:
    joint = geared(sun_teeth=28, planet_teeth=32, ring_teeth=92, planet_count=3)
    for side in ("sun_mesh", "ring_mesh"):
        joint[side] = {**joint[side], "phase_rad": "from-teeth"}
    return joint


def test_a_planet_meshes_as_the_first_will_once_the_carrier_has_brought_it_there():
    model = free(arm_of(out_of_phase(), gravity=(0.0, 0.0)))
    q = np.array([2e-4, 9e-5, 9e-5, 9e-5, 0.3])
    now = spring_forces(model, q)
    for planet in (1, 2):
        then = spring_forces(model, q + np.array([0, 0, 0, 0, 2 * np.pi * planet / 3]))
        # Phases of 500 rad in forces of 1e4 N.
        np.testing.assert_allclose(now[planet], then[0], rtol=1e-10)
        assert abs(now[planet] - now[0]).min() > 10


def spring_forces(model: ExudynBodies, q: np.ndarray) -> np.ndarray:
    """Of a single joint's sun and ring meshes [N], (planets, 2)."""
    pose, still = model.poses.pose(q), model.poses.velocity(q, 0 * q)
    forces = [
        readings(of.mesh, np.zeros(1), seen(pose, of)[None], seen(still, of)[None])[1, 0]
        for of in every_mesh(model)
    ]
    return np.reshape(forces, (-1, 2))


def test_conservative_forces_are_the_slopes_of_the_springs_energy():
    model, on_angles = free(unlike_arm(), **CONSERVATIVE), 0.0
    for q, _ in states_of(model.layout, 8):
        force = model.generalized_force(0.0, q, 0 * q)
        # Fourth order leaves 1e-9 N m; rounding 1e-16 of a joule over 1e-9 m, 1e-5 N at most.
        np.testing.assert_allclose(force, -energy_slopes(q), rtol=0, atol=1e-5)
        on_angles = max(on_angles, abs(force[list(ANGLES)]).max())
    assert on_angles > 10


def test_action_and_reaction_of_conservative_teeth_cancel_wherever_the_bodies_are():
    draw = np.random.default_rng(5)
    paper = every_mesh(free(unlike_arm()))
    for toothed, plain in zip(every_mesh(free(unlike_arm(), **CONSERVATIVE)), paper, strict=True):
        size = 3 * len(toothed.bodies)
        pose, velocity = draw.normal(size=size), draw.normal(size=size)
        forces, without = (
            mesh_forces(mesh, 0.2, pose, velocity).reshape(-1, 3)
            for mesh in (toothed.mesh, plain.mesh)
        )
        places = pose.reshape(-1, 3)
        turning = places[:, 0] * forces[:, 1] - places[:, 1] * forces[:, 0] + forces[:, 2]
        # Opposite forces at one point and opposite torques, with arms of a few metres.
        largest = abs(forces).max()
        np.testing.assert_allclose(forces[:, :2].sum(axis=0), 0, atol=4 * EPSILON * largest)
        assert turning.sum() == pytest.approx(0, abs=50 * EPSILON * largest)
        pair = (forces - without)[[CARRIER, PREVIOUS], 2]
        assert abs(pair).min() > 1e-6 * largest
        np.testing.assert_array_equal(forces[:, :2], without[:, :2])


@pytest.mark.parametrize("laws", [{}, CONSERVATIVE, {"phase": "omega_t", "dead_zone": "tanh"}])
def test_equal_planets_are_the_lumped_ones_where_they_move_alike(laws: dict[str, str]):
    arm = arm_of(geared("table", "fourier"), direct(), geared("square", "sine"))
    lumped = ExudynBodies(arm, scenario(40.0), switches(**laws))
    single = free(arm, scenario(40.0), **laws)
    spread = spread_of(lumped, single)
    for q, v in states_of(lumped.layout, 4):
        wide, wide_v = spread @ q, spread @ v
        mass = spread.T @ single.mass_matrix(wide) @ spread
        bias = spread.T @ single.bias(wide, wide_v)
        force = spread.T @ single.generalized_force(0.3, wide, wide_v)
        a = spread @ lumped.acceleration(0.3, q, v)
        one_by_one = single.acceleration(0.3, wide, wide_v)
        # Sums of four planets in another order, of forces up to 1e5 N.
        np.testing.assert_allclose(lumped.mass_matrix(q), mass, rtol=1e-12, atol=1e-11)
        np.testing.assert_allclose(lumped.bias(q, v), bias, rtol=1e-11, atol=1e-10)
        together = lumped.generalized_force(0.3, q, v)
        np.testing.assert_allclose(together, force, rtol=1e-11, atol=1e-6)
        np.testing.assert_allclose(one_by_one, a, rtol=0, atol=1e-10 * abs(a).max())


def spread_of(lumped: ExudynBodies, single: ExudynBodies) -> np.ndarray:
    """x_s = x_sp + x_pr, and every planet's x_pr the common one."""
    spread, own = np.zeros((len(single.layout), len(lumped.layout))), lumped.layout
    for row, c in enumerate(single.layout.coordinates):
        meanings = ("x_sp", "x_pr") if c.meaning == "x_s" else (c.meaning,)
        spread[row, [own.at(meaning, c.joint - 1) for meaning in meanings]] = 1.0
    return spread


def test_accelerations_of_free_planets_solve_their_equations():
    model = free(unlike_arm(), scenario([130.0, -70.0]), **CONSERVATIVE)
    for q, v in states_of(model.layout, 4):
        a, force = model.acceleration(0.1, q, v), model.generalized_force(0.1, q, v)
        left = model.mass_matrix(q) @ a + model.bias(q, v)
        # Gears of 0.5 kg accelerate with 1e4 m/s^2, and heavy links beside them hardly.
        np.testing.assert_allclose(left, force, rtol=1e-9, atol=1e-6)


def test_a_start_in_contact_touches_every_ring_mesh_and_one_of_the_suns():
    own = [[1e-6, -2e-6, 3e-6], [0.0, 5e-6, 0.0, -4e-6]]
    offsets = {"sun_planet_offset_m": [2e-6, 5e-6], "planet_ring_offset_m": [-3e-6, 4e-6]}
    bare, moved = (
        free(unlike_arm(), scenario(start=start)).start()[0]
        for start in ({}, {**offsets, "planet_offset_m": own})
    )
    by_hand = first_touch()
    added = np.array([2e-6 - 3e-6, -2e-6, -5e-6, 0.0, 5e-6 + 4e-6, 4e-6, 9e-6, 4e-6, 0.0, 0.0, 0.0])
    # Roundings of 1e-4 m.
    np.testing.assert_allclose(bare, by_hand, rtol=0, atol=1e-19)
    np.testing.assert_allclose(moved, by_hand + added, rtol=0, atol=1e-19)


def test_a_start_at_the_centre_has_the_offsets_alone():
    own = [[1e-6, -2e-6, 3e-6], [0.0, 5e-6, 0.0, -4e-6]]
    start = {"mesh": "centre", "sun_planet_offset_m": 2e-6, "planet_offset_m": own}
    q, _ = free(unlike_arm(), scenario(start=start)).start()
    np.testing.assert_array_equal(q, [2e-6, *own[0], 2e-6, *own[1], 0.0, 0.0])


def test_lumped_planets_start_where_their_standing_errors_touch():
    meshes = {
        side: {**geared()[side], "static_error_m": 3e-6} for side in ("sun_mesh", "ring_mesh")
    }
    q, _ = ExudynBodies(arm_of(geared(**meshes)), scenario()).start()
    np.testing.assert_array_equal(q, [4e-5 + 3e-6, 3e-5 + 3e-6, 0.0])


def undamped(arm: Arm) -> Arm:
    none = {"damping_ratio": 0.0, "damping_N_s_per_m": None}
    joints = [
        joint.model_copy(
            update={
                side: getattr(joint, side).model_copy(update=none)
                for side in ("sun_mesh", "ring_mesh")
            }
        )
        for joint in arm.joints
    ]
    return arm.model_copy(update={"joints": tuple(joints)})


@pytest.mark.parametrize(("laws", "least", "most"), [({}, 1e-4, 1e-3), (CONSERVATIVE, 0, 1e-6)])
def test_a_run_records_every_planet_and_keeps_its_energy_if_the_teeth_do_so(laws, least, most):
    start = {"planet_ring_offset_m": 1e-5, "theta_dot_rad_per_s": [1.4, -2.7]}
    grid = {"duration_s": 2e-4, "record_every": 20, "start": start}
    run = free(undamped(unlike_arm()), scenario(**grid), **laws).simulate()
    assert dict(run.sizes) == {"time": 11, "joint": 2, "planet": 4}
    advance = (run.x_sp + run.x_pr).values
    # One sun, seen by every planet: roundings of gears turned by some rad.
    assert np.nanmax(np.ptp(advance[:, 0, :3], axis=1)) < 1e-15
    recorded = np.stack([run.F_sp.values, run.F_pr.values], axis=1)
    states = states_in(run)
    # Deflections out of places near 1 m, times 1e8 N/m.
    found = [recorded_forces(q) for q in states]
    np.testing.assert_allclose(recorded, found, rtol=1e-10, atol=1e-6)
    energies = run.kinetic_energy.values + [spring_energy(q) for q in states]
    # Of 18 J. The rule's second order leaves 4e-7 J while teeth meet and part.
    assert least <= np.ptp(energies) < most
