"""Single planets of the Exudyn tree: each one's meshes by hand, symmetry, potential and energy."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from scipy.linalg import eigh

from crosscheck.models.arm.arm import Planetary
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.experiment.switches import switches
from crosscheck.models.exudyn.tree.laws import mesh_law
from crosscheck.models.exudyn.tree.tree import ExudynTree
from crosscheck.models.loading import load_case
from tests.mixed_arms import (
    LAWS,
    Data,
    arm_of,
    direct,
    geared,
    mean_stiffness,
    random_states,
    scenario,
    stiffness,
)
from tests.outside_truth.tree_planets import (
    PLANETS,
    RING,
    SIZE,
    SUN,
    directly_damped,
    energy,
    mesh_forces,
    undamped,
    unlike,
)

EPSILON = np.finfo(float).eps
OFFSETS = [4e-5, -3e-5, 1e-5]


def tree(*joints: Data, run: Scenario | None = None, **chosen: str) -> ExudynTree:
    """An arm without weight, its planets free."""
    arm = arm_of(*joints, gravity=(0.0, 0.0))
    return ExudynTree(arm, run or scenario(), switches(**{"planets": "free", **chosen}))


@pytest.mark.parametrize("joint", [unlike, directly_damped])
@pytest.mark.parametrize("damping", ["always", "contact"])
def test_every_planets_meshes_have_laws_of_their_own(joint, damping):
    model = tree(joint(), damping=damping)
    assert model.coordinates == ("x_s1", "x_pr1_1", "x_pr1_2", "x_pr1_3", "theta_1")
    for q, v in random_states(model.layout, 10):
        expected = mesh_forces(q, v, in_contact_only=damping == "contact")
        # Deflections of 1e-5 m out of places near 1 m, times 4e8 N/m; phases of 300 rad.
        found = model.generalized_force(0.0, q, v)
        np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-6)


def test_unlike_planets_accelerate_as_mass_and_force_say():
    model = tree(unlike(), direct(), directly_damped(), mesh_work="conservative")
    for q, v in random_states(model.layout, 5):
        acceleration = model.acceleration(0.0, q, v)
        force = model.generalized_force(0.0, q, v) - model.bias(q, v)
        # Two ways through matrices whose entries are 1e3 apart.
        found = model.mass_matrix(q) @ acceleration
        np.testing.assert_allclose(found, force, rtol=0, atol=1e-10 * abs(force).max())


@pytest.mark.parametrize("odd", range(4))
def test_one_planet_unlike_its_neighbours_alone_differs(odd):
    """Planets that vary alike may be worked out at once; no other may."""
    laws = [LAWS["table" if n == odd else "square"] for n in range(4)]
    joint = geared("square", "square", planet_count=4)
    for side in ("sun_mesh", "ring_mesh"):
        joint[side] = {**joint[side], "stiffness": laws, "backlash_m": 0.0, "tooth_error_m": 0.0}
    model = tree(joint)
    x, theta = 2e-5, 0.7
    q = np.array([2 * x, x, x, x, x, theta])
    force = model.generalized_force(0.0, q, 0 * q)
    for n in range(4):
        law = "table" if n == odd else "square"
        at_sun, at_ring = (stiffness(law, 90 * theta + phase) for phase in (0.9, -0.4))
        # As above.
        assert force[1 + n] == pytest.approx((at_sun - at_ring) * x, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("mesh_work", ["paper", "conservative"])
@pytest.mark.parametrize("arm", ["probe", "three-unlike"])
def test_lumped_planets_are_free_ones_in_step(arm, mesh_work):
    case = load_case(arm, "back-and-forth")
    lumped, free = (
        ExudynTree(case.arm, case.scenario, switches(planets=planets, mesh_work=mesh_work))
        for planets in ("lumped", "free")
    )
    T = in_step(lumped, free)
    for q, v in random_states(lumped.layout, 5):
        pairs = (
            (lumped.mass_matrix(q), T.T @ free.mass_matrix(T @ q) @ T),
            (lumped.bias(q, v), T.T @ free.bias(T @ q, T @ v)),
            (lumped.generalized_force(0.1, q, v), T.T @ free.generalized_force(0.1, T @ q, T @ v)),
            (T @ lumped.acceleration(0.1, q, v), free.acceleration(0.1, T @ q, T @ v)),
        )
        for together, one_by_one in pairs:
            # Deflections of 1e-4 m out of places near 1 m, in forces and accelerations.
            off = 1e-10 * abs(together).max()
            np.testing.assert_allclose(one_by_one, together, rtol=0, atol=off)


def in_step(lumped: ExudynTree, free: ExudynTree) -> np.ndarray:
    """T of q_free = T q_lumped: x_s = x_sp + x_pr, every x_pr the same."""
    T = np.zeros((len(free.layout), len(lumped.layout)))
    for row, c in enumerate(free.layout.coordinates):
        meanings = {"x_s": ("x_sp", "x_pr"), "x_pr": ("x_pr",), "theta": ("theta",)}[c.meaning]
        T[row, [lumped.layout.at(meaning, c.joint - 1) for meaning in meanings]] = 1
    return T


# Sun and planet teeth, planets; cycles by which sun and ring meshes are ahead.
GEAR_SETS = [
    (28, 29, [0, 2 / 3, 1 / 3], [0, 2 / 3, 1 / 3]),
    (28, 32, [0, 2 / 3, 1 / 3], [1 / 2, 1 / 6, 5 / 6]),
    (31, 29, [0, 1 / 4, 1 / 2, 3 / 4], [0, 1 / 4, 1 / 2, 3 / 4]),
    (30, 30, [0, 1 / 2, 0, 1 / 2], [1 / 2, 0, 1 / 2, 0]),
    (27, 36, [0, 0, 0], [1 / 2, 1 / 2, 1 / 2]),
]


@pytest.mark.parametrize(("sun", "planet", "at_sun", "at_ring"), GEAR_SETS)
def test_phases_from_the_teeth(sun, planet, at_sun, at_ring):
    """Parker and Lin (2004): delays of z_s n / N and -z_r n / N, half a pitch for even planets."""
    joint = teeth_of(sun, planet, len(at_sun), "from-teeth")
    for side, cycles in (("sun", at_sun), ("ring", at_ring)):
        np.testing.assert_allclose(offsets(joint, side), 2 * np.pi * np.array(cycles), rtol=1e-15)


@pytest.mark.parametrize(("sun", "planet", "at_sun", "at_ring"), GEAR_SETS)
def test_the_ring_mesh_from_teeth_follows_a_given_sun_mesh(sun, planet, at_sun, at_ring):
    for given in (-2.9, [float(2 * np.pi * cycles - 2.9) for cycles in at_sun]):
        joint = teeth_of(sun, planet, len(at_sun), given)
        np.testing.assert_array_equal(offsets(joint, "sun"), given * np.ones(len(at_sun)))
        expected = np.exp(1j * (2 * np.pi * np.array(at_ring) - 2.9))  # cut a circle anywhere
        found = np.exp(1j * np.array(offsets(joint, "ring")))
        np.testing.assert_allclose(found, expected, rtol=0, atol=20 * EPSILON)


def offsets(joint: Planetary, side: Literal["sun", "ring"]) -> list[float]:
    chosen = switches(planets="free")
    return [mesh_law(joint, chosen, side, n).phase_offset for n in range(joint.planet_count)]


def teeth_of(sun: int, planet: int, planets: int, phase: object) -> Planetary:
    meshes = geared()
    for side, given in (("sun_mesh", phase), ("ring_mesh", "from-teeth")):
        meshes[side] = {**meshes[side], "phase_rad": given}
    teeth = {"sun_teeth": sun, "planet_teeth": planet, "ring_teeth": sun + 2 * planet}
    (found,) = arm_of({**meshes, **teeth, "planet_count": planets}).joints
    assert isinstance(found, Planetary)
    return found


@pytest.mark.parametrize("even", [True, False])
def test_turned_by_a_planets_spacing_each_meshes_as_the_next_one_did(even):
    """The ring stands still, and where a planet goes the next one was."""
    joint = geared("table", "square", sun_teeth=28, planet_teeth=32 if even else 29)
    joint = {**joint, "ring_teeth": 92 if even else 86, "planet_count": 3}
    for side in ("sun_mesh", "ring_mesh"):
        joint[side] = {**joint[side], "phase_rad": "from-teeth"}
    model = tree(joint, mesh_work="conservative")
    turned, onward = np.zeros(SIZE), [0, 2, 3, 1, 4]
    turned[4] = 2 * np.pi / 3
    for q, v in random_states(model.layout, 5):
        here = model.generalized_force(0.0, q, v)
        there = model.generalized_force(0.0, q[onward] + turned, v[onward])
        # As above; 92 teeth per turn magnify the rounding of two angles.
        np.testing.assert_allclose(there, here[onward], rtol=1e-10, atol=1e-5)


def test_conservative_force_is_minus_the_gradient_of_the_springs_energy():
    """In every coordinate of two stages, a direct joint between: each phase turns its own link."""
    model = tree(undamped(), direct(), undamped(), mesh_work="conservative")
    layout = model.layout
    places = [
        place
        for joint in (0, 2)
        for place in (
            layout.at("x_s", joint),
            *(layout.at("x_pr", joint, planet) for planet in PLANETS),
            layout.at("theta", joint),
        )
    ]
    for q, v in random_states(model.layout, 6):
        force = model.generalized_force(0.0, q, 0 * v)
        gradient = [slope(q[places], place) for place in range(2 * SIZE)]
        # Of differences below; and deflections as above.
        np.testing.assert_allclose(force[places], -np.array(gradient), rtol=1e-8, atol=1e-5)
        assert force[layout.at("theta", 1)] == 0


def slope(q: np.ndarray, place: int) -> float:
    """Of the springs' energy, by a stencil of fourth order."""
    step = np.zeros(q.size)
    step[place] = 1e-5 if place % SIZE == 4 else 1e-8
    near, far = (energy(q + m * step) - energy(q - m * step) for m in (1, 2))
    return (8 * near - far) / (12 * step[place])


@pytest.mark.parametrize("mesh_work", ["paper", "conservative"])
@pytest.mark.parametrize(("play", "drift"), [(0.0, 1e-9), (1.0, 1e-6)])
def test_energy_of_an_undamped_arm_stays_with_conservative_meshes_alone(play, drift, mesh_work):
    """Where teeth part and meet RK4 has the second order left, with play."""
    start = {"planet_offset_m": [OFFSETS], "sun_planet_offset_m": 3e-5, "theta_dot_rad_per_s": 2.0}
    run = scenario(duration_s=2e-3, step_s=5e-7, record_every=50, start=start)
    motion = tree(undamped(play), run=run, mesh_work=mesh_work).simulate()
    x_pr, x_s = motion.x_pr.values[:, 0], (motion.x_sp + motion.x_pr).values[:, 0, :1]
    states = np.concatenate([x_s, x_pr, motion.theta.values], axis=1)
    springs = np.array([energy(state, play) for state in states])
    assert np.ptp(springs) > 0.2  # [J] beside 10 J of motion
    total = motion.kinetic_energy.values + springs
    changed = np.ptp(total) / total[0]
    assert changed < drift if mesh_work == "conservative" else changed > 1e-4


def test_each_planet_starts_at_its_own_contact_with_the_ring_and_one_with_the_sun():
    run = scenario(start={"theta_rad": 0.4})
    first = tree(unlike(), run=run).simulate().isel(time=0, joint=0)
    at_ring = np.array([teeth.b + teeth.static for teeth in RING])
    at_sun = np.array([teeth.b + teeth.static for teeth in SUN])
    # Sums of rotations near 1 rad on radii of 0.1 m.
    np.testing.assert_allclose(first.x_pr, at_ring, rtol=0, atol=1e-16)
    assert (first.x_sp < at_sun + 1e-16).all()
    assert abs(first.x_sp - at_sun).min() < 1e-16


def test_lumped_planets_start_at_contact_with_the_error_that_stands_still():
    joint = geared()
    for side, static in (("sun_mesh", -6e-6), ("ring_mesh", 7e-6)):
        joint[side] = {**joint[side], "static_error_m": static}
    first = tree(joint, planets="lumped").simulate().isel(time=0, joint=0)
    # As above.
    np.testing.assert_allclose(first.x_sp, 4e-5 - 6e-6, rtol=0, atol=1e-16)
    np.testing.assert_allclose(first.x_pr, 3e-5 + 7e-6, rtol=0, atol=1e-16)


@pytest.mark.parametrize("mesh", ["contact", "centre"])
def test_a_planets_offset_at_the_start_moves_it_alone(mesh):
    common = {"sun_planet_offset_m": 2e-5, "planet_ring_offset_m": -5e-6, "mesh": mesh}
    plain, moved, apart = (
        tree(unlike(), run=scenario(start=start)).simulate().isel(time=0, joint=0)
        for start in ({"mesh": mesh}, common, {**common, "planet_offset_m": [OFFSETS]})
    )
    for run, x_sp, x_pr in ((moved, 2e-5, -5e-6), (apart, 2e-5, -5e-6)):
        own = np.array(OFFSETS) if run is apart else np.zeros(3)
        np.testing.assert_allclose(run.x_sp - plain.x_sp, x_sp - own, rtol=0, atol=1e-16)
        np.testing.assert_allclose(run.x_pr - plain.x_pr, x_pr + own, rtol=0, atol=1e-16)
    if mesh == "centre":
        assert not plain.x_sp.any()
        assert not plain.x_pr.any()


def test_records_are_every_planets_own():
    start = {"planet_offset_m": [[], OFFSETS], "theta_rad": 0.4}
    both = tree(direct(), unlike(), run=scenario(duration_s=1e-3, start=start)).simulate()
    assert np.isnan(both.x_sp[:, 0]).all()
    motion = both.isel(joint=1)
    for side, x, force in ((SUN, motion.x_sp, motion.F_sp), (RING, motion.x_pr, motion.F_pr)):
        for n in PLANETS:
            own = zip(x.values[:, n], motion.theta.values, strict=True)
            expected = [side[n].spring(at, theta) for at, theta in own]
            np.testing.assert_allclose(force[:, n], expected, rtol=1e-9, atol=1e-6)
    differences = (motion.x_sp.values[2:] - motion.x_sp.values[:-2]) / 2e-5
    # Mesh modes of 3e4 rad/s, records 1e-5 s apart.
    assert abs(differences - motion.x_sp_dot.values[1:-1]).max() < 0.1 * abs(differences).max()


def test_modes_and_largest_step_follow_every_planets_own_stiffness():
    model = tree(undamped())
    mass = model.mass_matrix(np.zeros(SIZE))
    means = spring_matrix([[mean_stiffness(t.law) for t in side] for side in (SUN, RING)])
    modes = np.sqrt(eigh(means, mass, eigvals_only=True)[1:]) / (2 * np.pi)
    # The engine linearises by differences at 1e-7.
    np.testing.assert_allclose(model.mesh_modes(), modes, rtol=1e-6)
    phases = np.linspace(0, 2 * np.pi, 4001)
    most = [[max(stiffness(t.law, p) for p in phases) for t in side] for side in (SUN, RING)]
    fastest = np.sqrt(eigh(spring_matrix(most), mass, eigvals_only=True)[-1])
    # RK4's |R| is 1 at i sqrt(8); fine samples, and steps tried in 1e-4.
    assert model.largest_stable_step() == pytest.approx(np.sqrt(8) / fastest, rel=1e-3)


def spring_matrix(stiffnesses: list[list[float]]) -> np.ndarray:
    """K [N/m], shape (SIZE, SIZE), of springs of every sun and ring mesh in contact."""
    K = np.zeros((SIZE, SIZE))
    for n in PLANETS:
        for side, row in enumerate((np.eye(SIZE)[0] - np.eye(SIZE)[1 + n], np.eye(SIZE)[1 + n])):
            K += stiffnesses[side][n] * np.outer(row, row)
    return K
