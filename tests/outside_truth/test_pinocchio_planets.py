"""Single planets in the gear tree: virtual work, energies, the symmetry and flanks of the teeth."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.layout import Layout, free_layout, lumped_layout
from crosscheck.models.experiment.switches import Switches, switches
from crosscheck.models.pinocchio.gears import PinocchioGears
from tests.planet_meshes import (
    ROD,
    alike_arms,
    arm_of,
    contacts,
    expected_force,
    mesh,
    rounding,
    slope,
    spring_energy,
    stage,
    state,
    undriven,
    unlike_arms,
)

EPS = np.finfo(float).eps
seeds = st.integers(0, 2**32 - 1)


def gears(arm: Arm, **chosen: str) -> PinocchioGears:
    return PinocchioGears(arm, undriven(), switches(planets="free", **chosen))


def every_law() -> st.SearchStrategy[Switches]:
    """Of free planets, with phases by the angle or by time."""
    angle, time = ({"planets": "free", "phase": phase} for phase in ("angle", "omega_t"))
    laws = [angle | {"mesh_work": "conservative"}, angle | {"ring_rate": "eq13"}, angle, time]
    damping = st.sampled_from(["always", "contact"])
    return st.builds(lambda law, d: switches(**law, damping=d), st.sampled_from(laws), damping)


@settings(max_examples=20, deadline=None)
@given(unlike_arms(), every_law(), seeds)
def test_every_planets_mesh_does_its_own_virtual_work(arm, chosen, seed):
    """Unlike laws, clearances, errors, phases and dampers, in every switch's sense."""
    model = PinocchioGears(arm, undriven(), chosen)
    q, v = state(model.layout, seed)
    found = model.generalized_force(0.7, q, v)
    expected = expected_force(arm, chosen, model.layout, 0.7, q, v)
    np.testing.assert_allclose(
        found, expected, rtol=1e-12, atol=rounding(contacts(arm, chosen, model.layout))
    )


@settings(max_examples=20, deadline=None)
@given(unlike_arms() | alike_arms(), st.booleans(), seeds)
def test_conservative_forces_are_the_slope_of_the_springs_energy(arm, corrected, seed):
    """At rest, in every coordinate at once; V takes complex coordinates, so its slope is exact."""
    model = gears(arm, mesh_work="conservative", ring_rate="corrected" if corrected else "eq13")
    springs = contacts(arm, model.switches, model.layout)
    q, v = state(model.layout, seed)
    found = model.generalized_force(0.0, q, 0 * v)
    expected = -slope(lambda at: spring_energy(springs, at), q)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=rounding(springs))


@settings(max_examples=10, deadline=None)
@given(unlike_arms(), seeds)
def test_work_on_the_phase_is_a_torque_between_link_and_previous_body(arm, seed):
    """Nothing else changes: neither what the teeth tell each body, nor other coordinates."""
    paper, conservative = (gears(arm, mesh_work=law) for law in ("paper", "conservative"))
    q, v = state(paper.layout, seed)
    wrenches = (model.contact_wrenches(0.0, q, v) for model in (paper, conservative))
    np.testing.assert_array_equal(*wrenches)
    forces = [model.generalized_force(0.0, q, v) for model in (paper, conservative)]
    off = rounding(contacts(arm, paper.switches, paper.layout))
    meshes_alone = ~paper.layout.angular
    np.testing.assert_allclose(forces[1][meshes_alone], forces[0][meshes_alone], rtol=0, atol=off)


def to_free(lumped: Layout, free: Layout) -> np.ndarray:
    """Free coordinates of planets that move as one: x_s = x_sp + x_pr, every x_pr the same."""
    rows = {
        "x_s": lambda joint: (
            lumped.displacement("x_sp", joint, 0) + lumped.displacement("x_pr", joint, 0)
        ),
        "x_pr": lambda joint: lumped.displacement("x_pr", joint, 0),
        "theta": lambda joint: np.eye(len(lumped))[lumped.at("theta", joint)],
    }
    return np.array([rows[c.meaning](c.joint - 1) for c in free.coordinates])


@settings(max_examples=10, deadline=None)
@given(alike_arms(), st.sampled_from(["paper", "conservative"]), seeds)
def test_lumped_planets_are_free_ones_that_move_alike(arm, work, seed):
    free = gears(arm, mesh_work=work)
    lumped = PinocchioGears(arm, undriven(), switches(mesh_work=work))
    along = to_free(lumped_layout(arm), free_layout(arm))
    q, v = state(lumped.layout, seed)
    # Sums of some hundred products in another order.
    mass = lumped.mass_matrix(q)
    close = {"rtol": 0, "atol": 100 * EPS * np.abs(mass).max()}
    np.testing.assert_allclose(along.T @ free.mass_matrix(along @ q) @ along, mass, **close)
    close["atol"] *= 1 + v @ v
    bias = lumped.bias(q, v)
    np.testing.assert_allclose(along.T @ free.bias(along @ q, along @ v), bias, **close)
    force = lumped.generalized_force(0.0, q, v)
    off = rounding(contacts(arm, free.switches, free.layout))
    of_all = along.T @ free.generalized_force(0.0, along @ q, along @ v)
    np.testing.assert_allclose(of_all, force, rtol=1e-12, atol=off)


@settings(max_examples=10, deadline=None)
@given(unlike_arms(), seeds)
def test_the_map_of_free_coordinates_has_an_inverse(arm, seed):
    model = gears(arm)
    q, _ = state(model.layout, seed)
    # Displacements are differences of arcs of up to 5 rad on radii of up to 0.4 m.
    found = model.from_tree(model.to_tree(q))
    np.testing.assert_allclose(found, q, rtol=0, atol=50 * EPS)


@settings(max_examples=10, deadline=None)
@given(unlike_arms(), seeds)
def test_forward_dynamics_of_unlike_planets_solve_the_equation_of_motion(arm, seed):
    model = gears(arm, mesh_work="conservative")
    q, v = state(model.layout, seed)
    mass, force = model.mass_matrix(q), model.generalized_force(0.2, q, v)
    left = mass @ model.acceleration(0.2, q, v) + model.bias(q, v)
    # Rounding of forces, as the condition of M may magnify it, scaled to equal diagonals.
    scale = np.sqrt(np.diag(mass))
    condition = np.linalg.cond(mass / np.outer(scale, scale))
    off = 100 * EPS * condition * np.abs(force / scale).max()
    np.testing.assert_allclose(left / scale, force / scale, rtol=0, atol=off)


@settings(max_examples=10, deadline=None)
@given(unlike_arms(), seeds)
def test_contact_forces_of_unlike_planets_obey_newtons_third_law(arm, seed):
    model = gears(arm)
    q, v = state(model.layout, seed)
    wrenches, (x, y) = model.contact_wrenches(0.2, q, v), model.body_positions(q).T
    moments = x * wrenches[:, 1] - y * wrenches[:, 0] + wrenches[:, 2]
    # Sums of some fifty forces, on arms of up to 5 m.
    size = 50 * EPS * (1 + np.abs(wrenches).max())
    np.testing.assert_allclose(wrenches[:, :2].sum(axis=0), 0, atol=size)
    assert moments.sum() == pytest.approx(0, abs=5 * size)


@pytest.mark.parametrize("theta", [0.0, 0.37, -2.2])
@pytest.mark.parametrize("planet", [1, 2])
def test_a_planet_meshes_like_the_first_once_the_carrier_brought_it_there(planet, theta):
    """Turned back by its place, planet n sits where the first one did, in the same ring teeth.

    The sun then has turned by a whole number of its teeth, (z_s + z_r) n / N, by assembly.
    """
    model, turn = gears(arm_of(stage(), links=[ROD])), 2 * pi * planet / 3
    x_s, x_pr = 3e-5, np.array([9e-5, -7e-5, 6e-5])
    here = np.array([x_s, *x_pr, theta])
    moved = np.array([x_s, *np.roll(x_pr, planet), theta - turn])
    one, other = (model.generalized_force(0.0, q, np.zeros(5)) for q in (here, moved))
    close = {"rtol": 1e-12, "atol": rounding(contacts(model.arm, model.switches, model.layout))}
    np.testing.assert_allclose(other[1:4], np.roll(one[1:4], planet), **close)
    np.testing.assert_allclose(other[[0, 4]], one[[0, 4]], **close)
    unlike = model.generalized_force(0.0, np.array([x_s, *np.roll(x_pr, planet), theta]), 0 * here)
    assert np.abs(unlike[1:4] / np.roll(one[1:4], planet) - 1).max() > 1e-3


def pitches_between_flanks(teeth: int) -> float:
    """From the sun's pitch point to the ring's, in pitches of a planet, modulo 1.

    The sun pushes a flank that faces one way round; a tooth is half a pitch thick, and the flank
    that the ring pushes faces the other way.
    """
    facing = np.array([pi + 2 * pi * k / teeth for k in range(teeth)])  # one is at the sun, at pi
    opposite = facing - pi / teeth
    return float(np.min((0.0 - opposite) * teeth / (2 * pi) % 1))


@pytest.mark.parametrize("planet_teeth", [20, 23])
@pytest.mark.parametrize("sun_phase", ["from-teeth", 0.4])
def test_the_ring_meshes_half_a_pitch_after_the_sun_on_planets_of_even_teeth(
    planet_teeth, sun_phase
):
    """The first planet's stiffnesses, without error or clearance."""
    plain = {"backlash_m": 0.0, "tooth_error_m": 0.0}
    teeth = {"planet_teeth": planet_teeth, "ring_teeth": 28 + 2 * planet_teeth, "planet_count": 2}
    meshes = {"sun_mesh": mesh(phase_rad=sun_phase, **plain), "ring_mesh": mesh(**plain)}
    model = gears(arm_of(stage(**teeth, **meshes), links=[ROD]))
    x = np.array([0.0, 1e-4, 0.0, 0.21])  # the first planet alone, towards sun and ring alike
    found = model.generalized_force(0.0, x, np.zeros(4))[1] / -1e-4
    phase = (28 + 2 * planet_teeth) * 0.21 + (0.4 if sun_phase == 0.4 else 0.0)
    half = 2 * pi * pitches_between_flanks(planet_teeth)
    assert found == pytest.approx(fourier(phase) + fourier(phase + half), rel=1e-11)


def fourier(phase: float) -> float:
    cosines = 1e7 * np.cos(phase) - 3e6 * np.cos(2 * phase)
    sines = 5e6 * np.sin(phase) + 4e6 * np.sin(2 * phase) + 1e6 * np.sin(3 * phase)
    return float(9e7 + cosines + sines)


@settings(max_examples=10, deadline=None)
@given(alike_arms(), seeds)
def test_phases_from_the_teeth_are_those_that_one_may_list(arm, seed):
    """To whole turns: the arm checks a list against the teeth by itself."""
    taught = arm.model_copy(update={"joints": tuple(map(from_teeth, arm.joints))})
    listed = arm.model_copy(update={"joints": tuple(map(as_listed, arm.joints))})
    one, other = (gears(arm) for arm in (taught, listed))
    q, v = state(one.layout, seed)
    forces = (model.generalized_force(0.0, q, v) for model in (one, other))
    off = rounding(contacts(taught, one.switches, one.layout))
    np.testing.assert_allclose(*forces, rtol=1e-12, atol=off)


def from_teeth(joint: Planetary) -> Planetary:
    ring = joint.ring_mesh.model_copy(update={"phase_rad": "from-teeth"})
    sun = joint.sun_mesh.model_copy(update={"phase_rad": "from-teeth"})
    return joint.model_copy(update={"sun_mesh": sun, "ring_mesh": ring})


def as_listed(joint: Planetary) -> Planetary:
    """Delays of z_s n / N pitches in either mesh, half a pitch later where the ring is."""
    delays = [joint.sun_teeth * n / joint.planet_count for n in range(joint.planet_count)]
    half = 0.0 if joint.planet_teeth % 2 else 0.5
    sun, ring = (tuple(2 * pi * (at - d) for d in delays) for at in (0.0, half))
    meshes = {
        "sun_mesh": {**dict(joint.sun_mesh), "phase_rad": sun},
        "ring_mesh": {**dict(joint.ring_mesh), "phase_rad": ring},
    }
    return Planetary.model_validate({**dict(joint), **meshes})


def energy_over(model: PinocchioGears, duration: float) -> np.ndarray:
    """Kinetic and spring energy [J] along an undamped motion from teeth pressed together."""
    springs, n = contacts(model.arm, model.switches, model.layout), len(model.layout)
    pressed = np.where(model.layout.angular, 0.3, 4e-5)
    pressed[model.layout.of("x_s")] = 1e-4
    start = [*pressed, *np.where(model.layout.angular, 20.0, 0.0)]

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate((y[n:], model.acceleration(t, y[:n], y[n:])))

    times = np.linspace(0, duration, 10)
    run = solve_ivp(rate, times[[0, -1]], start, "DOP853", times, rtol=1e-11, atol=1e-13)
    return np.array(
        [
            spring_energy(springs, q).real + v @ model.mass_matrix(q) @ v / 2
            for q, v in zip(run.y[:n].T, run.y[n:].T, strict=True)
        ]
    )


def test_conservative_meshes_keep_the_energy_and_the_papers_do_not():
    """A stage out of phase, unlike planets, for a fifth of a mesh period."""
    arm = arm_of(stage(sun_mesh=mesh(static_error_m=[0.0, 4e-6, -3e-6])), links=[ROD])
    kept, lost = (energy_over(gears(arm, mesh_work=law), 1e-3) for law in ("conservative", "paper"))
    # 0.2 J in springs, next to 1.1 kJ of motion, whose integration keeps eleven digits.
    assert np.ptp(kept) < 1e-8
    assert np.ptp(lost) > 1e-3
