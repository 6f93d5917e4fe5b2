"""Single planets in every geared model: virtual work, energies, the teeth's symmetry and flanks."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from crosscheck.checks.energy import springs_at
from crosscheck.checks.first_principles.mesh_energy import spring_energy as energy_in_spring
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.experiment.scenario import Switches, switches
from crosscheck.models.exudyn.bodies.bodies import ExudynBodies, GearPair
from crosscheck.models.exudyn.bodies.contact import CARRIER, PREVIOUS, contact_state, mesh_forces
from crosscheck.models.interface import Model
from crosscheck.models.loading import load_arm
from crosscheck.models.pinocchio.arm import PinocchioGears
from crosscheck.registry import MODELS, build, model_names
from tests import planet_laws
from tests.engines.bodies_checks import contact_wrenches
from tests.loops import require_items
from tests.mixed_arms import NONE, PLANET_M, SUN_J, arm_of, direct, geared, random_states, scenario
from tests.planet_meshes import (
    ROD,
    alike_arms,
    contacts,
    expected_force,
    mesh,
    rounding,
    slope,
    spring_energy,
    stage,
    stiffness_at,
    unlike_arms,
)

EPS = float(np.finfo(float).eps)
GEARED = tuple(model_names("geared"))
RUNNING = tuple(name for name in GEARED if "simulate" in MODELS[name].promises)
ENGINES = tuple(name for name in GEARED if not name.startswith("analytic"))  # built in no time
CONSERVATIVE = {"mesh_work": "conservative"}
LAWS = ({}, {"damping": "contact"}, CONSERVATIVE, {"ring_rate": "eq13"})
seeds = st.integers(0, 2**32 - 1)
every_model = pytest.mark.parametrize("name", GEARED)
every_run = pytest.mark.parametrize("name", RUNNING)
every_model_with_modes = pytest.mark.parametrize(
    "name", [name for name in GEARED if "mesh_modes" in MODELS[name].promises]
)
every_engine = pytest.mark.parametrize("name", ENGINES)


def free(name: str, arm: Arm, start: dict[str, object] | None = None, **laws: str) -> Model:
    """The model, its planets free, for three steps from a start."""
    run = scenario(duration_s=3e-6, record_every=1, start=start or {})
    return build(name, arm, run, switches(**{"planets": "free", **laws}))


@every_model
@pytest.mark.parametrize("laws", LAWS)
def test_every_planets_teeth_push_by_their_own_numbers(name, laws):
    model = free(name, planet_laws.unlike_arm(), **laws)
    # Deflections of 1e-5 m out of places near 1 m; phases of 300 rad.
    assert planet_laws.force_off(model, 8) < 1e-11
    assert planet_laws.motion_off(model, 5) < 1e-11


@pytest.mark.parametrize("rate", ["corrected", "eq13"])
def test_springs_of_the_energy_balance_follow_every_law_of_stiffness(rate):
    """Stiffness, x - e and energy of each mesh, sun before ring, at both rates of the ring."""
    model = free("analytic:physical", planet_laws.unlike_arm(), ring_rate=rate)
    [(q, _)] = random_states(model.layout, 1)
    springs = springs_at(model.arm, model.switches, model.layout, q[None])
    meshes = contacts(model.arm, model.switches, model.layout)
    for spring, contact in require_items([*zip(springs, meshes, strict=True)]):
        phase = contact.phase_at(q[contact.angle])
        gap = contact.row @ q - contact.error(phase)
        right = stiffness_at(contact.mesh.stiffness, phase), gap, contact.energy(q).real
        values = *spring.stiffness, *spring.gap, *energy_in_spring(spring)
        assert values == pytest.approx(right, rel=1e-10)


@every_model
@pytest.mark.parametrize("odd", range(4))
def test_one_planet_unlike_its_neighbours_alone_differs(name, odd):
    assert planet_laws.force_off(free(name, planet_laws.odd_one_out(odd))) < 1e-12


def every_law() -> st.SearchStrategy[Switches]:
    """Of free planets, with phases by the angle or by time."""
    angle, time = ({"planets": "free", "phase": phase} for phase in ("angle", "omega_t"))
    laws = [angle | CONSERVATIVE, angle | {"ring_rate": "eq13"}, angle, time]
    damping = st.sampled_from(["always", "contact"])
    return st.builds(lambda law, d: switches(**law, damping=d), st.sampled_from(laws), damping)


@every_engine
@settings(max_examples=10)
@given(arm=unlike_arms(), chosen=every_law(), seed=seeds)
def test_every_planets_mesh_does_its_own_virtual_work(name, arm, chosen, seed):
    """Unlike laws, clearances, errors, phases and dampers, in every switch's sense."""
    model = build(name, arm, scenario(), chosen)
    [(q, v)] = random_states(model.layout, 1, seed)
    found = model.generalized_force(0.7, q, v)
    expected = expected_force(arm, chosen, model.layout, 0.7, q, v)
    off = rounding(contacts(arm, chosen, model.layout))
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=off)


@every_engine
@settings(max_examples=8)
@given(arm=unlike_arms() | alike_arms(), corrected=st.booleans(), seed=seeds)
def test_conservative_forces_are_the_slope_of_the_springs_energy(name, arm, corrected, seed):
    """At rest, in every coordinate at once; V takes complex coordinates, so its slope is exact."""
    laws = CONSERVATIVE | {"ring_rate": "corrected" if corrected else "eq13", "planets": "free"}
    model = build(name, arm, scenario(), switches(**laws))
    springs = contacts(arm, model.switches, model.layout)
    [(q, v)] = random_states(model.layout, 1, seed)
    found = model.generalized_force(0.0, q, 0 * v)
    expected = -slope(lambda at: spring_energy(springs, at), q)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=rounding(springs))


@every_engine
@settings(max_examples=5)
@given(arm=unlike_arms(), seed=seeds)
def test_forward_dynamics_of_unlike_planets_solve_the_equation_of_motion(name, arm, seed):
    model = build(name, arm, scenario(), switches(planets="free", **CONSERVATIVE))
    [(q, v)] = random_states(model.layout, 1, seed)
    mass, force = model.mass_matrix(q), model.generalized_force(0.2, q, v)
    left = mass @ model.acceleration(0.2, q, v) + model.bias(q, v)
    # Rounding of forces, as the condition of M may magnify it, scaled to equal diagonals.
    scale = np.sqrt(np.diag(mass))
    condition = np.linalg.cond(mass / np.outer(scale, scale))
    off = 100 * EPS * condition * np.abs(force / scale).max()
    np.testing.assert_allclose(left / scale, force / scale, rtol=0, atol=off)


@every_model
def test_sun_and_planets_have_the_inertia_that_they_have_alone(name):
    model = free(name, planet_laws.unlike_arm())
    per_tooth = 0.0025 / 2 * np.cos(np.radians(20))
    suns = [SUN_J / (teeth * per_tooth) ** 2 for teeth in (28, 31)]
    expected = np.diag([suns[0], *[PLANET_M] * 3, suns[1], *[PLANET_M] * 4])
    slides = ~model.layout.angular
    for q, _ in require_items(random_states(model.layout, 3)):
        # All else moves with the angles alone: roundings of what cancels.
        mass = model.mass_matrix(q)[np.ix_(slides, slides)]
        np.testing.assert_allclose(mass, expected, rtol=1e-12, atol=1e-12)


@every_model
@pytest.mark.parametrize("laws", [{}, CONSERVATIVE, {"phase": "omega_t", "dead_zone": "tanh"}])
@pytest.mark.parametrize("arm", ["alike", "probe", "three-unlike"])
def test_lumped_planets_are_free_ones_in_step(name, arm, laws):
    own = planet_laws.alike_planets() if arm == "alike" else load_arm(arm)
    # Sums of four planets in another order, of deflections as above.
    assert planet_laws.in_step_off(free(name, own, **laws)) < 1e-11


@every_engine
@settings(max_examples=6)
@given(arm=alike_arms(), work=st.sampled_from(["paper", "conservative"]), seed=seeds)
def test_lumped_planets_of_any_arm_are_free_ones_in_step(name, arm, work, seed):
    one_by_one = free(name, arm, mesh_work=work)
    lumped = free(name, arm, mesh_work=work, planets="lumped")
    T = planet_laws.in_step(lumped, one_by_one)
    [(q, v)] = random_states(lumped.layout, 1, seed)
    # Sums of some hundred products in another order.
    mass = lumped.mass_matrix(q)
    close = {"rtol": 0, "atol": 100 * EPS * np.abs(mass).max()}
    np.testing.assert_allclose(T.T @ one_by_one.mass_matrix(T @ q) @ T, mass, **close)
    close["atol"] *= 1 + v @ v
    np.testing.assert_allclose(T.T @ one_by_one.bias(T @ q, T @ v), lumped.bias(q, v), **close)
    force = lumped.generalized_force(0.0, q, v)
    off = rounding(contacts(arm, one_by_one.switches, one_by_one.layout))
    of_all = T.T @ one_by_one.generalized_force(0.0, T @ q, T @ v)
    np.testing.assert_allclose(of_all, force, rtol=1e-12, atol=off)


# Sun and planet teeth, planets; cycles by which sun and ring meshes are ahead, counted by hand.
GEAR_SETS = [
    (28, 29, [0, 2 / 3, 1 / 3], [0, 2 / 3, 1 / 3]),
    (28, 32, [0, 2 / 3, 1 / 3], [1 / 2, 1 / 6, 5 / 6]),
    (31, 29, [0, 1 / 4, 1 / 2, 3 / 4], [0, 1 / 4, 1 / 2, 3 / 4]),
    (30, 30, [0, 1 / 2, 0, 1 / 2], [1 / 2, 0, 1 / 2, 0]),
    (27, 36, [0, 0, 0], [1 / 2, 1 / 2, 1 / 2]),
]


@every_model
@pytest.mark.parametrize(("sun", "planet", "at_sun", "at_ring"), GEAR_SETS)
@pytest.mark.parametrize("given_sun", ["from-teeth", "number", "list"])
def test_phases_from_the_teeth(name, sun, planet, at_sun, at_ring, given_sun):
    """Parker and Lin (2004): delays of z_s n / N and -z_r n / N, half a pitch for even planets.

    The ring's meshes follow a sun mesh whose phase is given, as a number for its first planet.
    """
    cycles = 0.0 if given_sun == "from-teeth" else -2.9 / (2 * pi)
    listed = [2 * pi * (cycles + at) for at in at_sun]
    phase = {"from-teeth": "from-teeth", "number": -2.9, "list": listed}[given_sun]
    sun_mesh = {**geared()["sun_mesh"], "phase_rad": phase}
    ring_mesh = {**geared()["ring_mesh"], "phase_rad": "from-teeth"}
    teeth = {"sun_teeth": sun, "planet_teeth": planet, "ring_teeth": sun + 2 * planet}
    joint = geared(**teeth, planet_count=len(at_sun), sun_mesh=sun_mesh, ring_mesh=ring_mesh)
    model = free(name, arm_of(joint, gravity=NONE))
    found = contacts(model.arm, model.switches, model.layout)
    of_sun = [-2.9] * len(at_sun) if given_sun == "number" else listed
    of_ring = [2 * pi * (cycles + at) for at in at_ring]
    for side, expected in ((0, of_sun), (1, of_ring)):
        turns = [contact.phase for contact in found[side::2]]
        off = np.exp(1j * np.subtract(turns, expected)) - 1  # cut a circle anywhere
        assert abs(off).max() < 20 * EPS
    assert planet_laws.force_off(model) < 2e-12


@every_engine
@settings(max_examples=6)
@given(arm=alike_arms(), seed=seeds)
def test_phases_from_the_teeth_are_those_that_one_may_list(name, arm, seed):
    """To whole turns: the arm checks a list against the teeth by itself."""
    taught = arm.model_copy(update={"joints": tuple(map(from_teeth, arm.joints))})
    listed = arm.model_copy(update={"joints": tuple(map(as_listed, arm.joints))})
    one, other = (free(name, own) for own in (taught, listed))
    [(q, v)] = random_states(one.layout, 1, seed)
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


@every_model
@pytest.mark.parametrize("laws", [{}, CONSERVATIVE])
@pytest.mark.parametrize("planet_teeth", [20, 23])
@pytest.mark.parametrize("theta", [0.37, -2.2])
@pytest.mark.parametrize("planet", [1, 2])
def test_a_planet_meshes_like_the_first_once_the_carrier_brought_it_there(
    name, planet, theta, planet_teeth, laws
):
    """Turned back by its place, planet n sits where the first one did, in the same ring teeth.

    The sun then has turned by a whole number of its teeth, (z_s + z_r) n / N, by assembly.
    """
    teeth = {"planet_teeth": planet_teeth, "ring_teeth": 28 + 2 * planet_teeth}
    sun_teeth = 28 if planet_teeth == 20 else 31  # neither passes by three planets
    teeth = {"sun_teeth": sun_teeth, **teeth, "ring_teeth": sun_teeth + 2 * planet_teeth}
    model, turn = (
        free(name, arm_of(stage(**teeth), links=[ROD], gravity=NONE), **laws),
        2 * pi * planet / 3,
    )
    x_s, x_pr = 3e-5, np.array([9e-5, -7e-5, 6e-5])
    here = np.array([x_s, *x_pr, theta])
    moved = np.array([x_s, *np.roll(x_pr, planet), theta - turn])
    one, other = (model.generalized_force(0.0, q, np.zeros(5)) for q in (here, moved))
    close = {"rtol": 2e-12, "atol": rounding(contacts(model.arm, model.switches, model.layout))}
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


@every_model
@pytest.mark.parametrize("planet_teeth", [20, 23])
@pytest.mark.parametrize("sun_phase", ["from-teeth", 0.4])
def test_the_ring_meshes_half_a_pitch_after_the_sun_on_planets_of_even_teeth(
    name, planet_teeth, sun_phase
):
    """The first planet's stiffnesses, without error or clearance."""
    plain = {"backlash_m": 0.0, "tooth_error_m": 0.0}
    teeth = {"planet_teeth": planet_teeth, "ring_teeth": 28 + 2 * planet_teeth, "planet_count": 2}
    meshes = {"sun_mesh": mesh(phase_rad=sun_phase, **plain), "ring_mesh": mesh(**plain)}
    model = free(name, arm_of(stage(**teeth, **meshes), links=[ROD], gravity=NONE))
    x = np.array([0.0, 1e-4, 0.0, 0.21])  # the first planet alone, towards sun and ring alike
    found = model.generalized_force(0.0, x, np.zeros(4))[1] / -1e-4
    phase = (28 + 2 * planet_teeth) * 0.21 + (0.4 if sun_phase == 0.4 else 0.0)
    half = 2 * pi * pitches_between_flanks(planet_teeth)
    assert found == pytest.approx(fourier(phase) + fourier(phase + half), rel=1e-11)


def fourier(phase: float) -> float:
    cosines = 1e7 * np.cos(phase) - 3e6 * np.cos(2 * phase)
    sines = 5e6 * np.sin(phase) + 4e6 * np.sin(2 * phase) + 1e6 * np.sin(3 * phase)
    return float(9e7 + cosines + sines)


@every_run
@pytest.mark.parametrize(
    "given_start",
    [{}, planet_laws.OFFSETS, {"mesh": "centre"}, {"mesh": "centre", **planet_laws.OFFSETS}],
)
def test_planets_start_at_contact_or_in_the_middle_and_where_offsets_move_them(name, given_start):
    # Sums of rotations near 1 rad on radii of 0.1 m.
    assert planet_laws.start_off(free(name, planet_laws.unlike_arm(), given_start)) < 1e-16


@every_run
def test_lumped_planets_start_where_their_standing_errors_touch(name):
    model = free(name, planet_laws.standing_errors(), planets="lumped")
    assert planet_laws.start_off(model) < 1e-16
    first = model.simulate().isel(time=0, joint=0)
    np.testing.assert_allclose(first.x_sp, 4e-5 - 6e-6, rtol=0, atol=1e-16)
    np.testing.assert_allclose(first.x_pr, 3e-5 + 7e-6, rtol=0, atol=1e-16)


@every_run
def test_records_are_every_planets_own(name):
    joints = planet_laws.unlike_arm().model_dump()["joints"]
    arm = arm_of(*joints, direct(), gravity=NONE)
    start = {
        "planet_offset_m": [*planet_laws.OFFSETS["planet_offset_m"], []],
        "theta_dot_rad_per_s": 0.9,
    }
    run = scenario(duration_s=1e-4, record_every=2, start=start)
    model = build(name, arm, run, switches(planets="free"))
    # Deflections out of places near 1 m, times 1e8 N/m.
    assert planet_laws.records_off(model) < 1e-10
    motion = model.simulate()
    assert np.isnan(motion.x_sp[:, 2]).all()
    advance = (motion.x_sp + motion.x_pr).values[:, 0, :3]
    assert np.ptp(advance, axis=1).max() < 1e-15  # one sun, seen by every planet
    differences = (motion.x_sp.values[2:] - motion.x_sp.values[:-2]) / 4e-6
    # Mesh modes of 3e4 rad/s.
    off = np.nanmax(abs(differences - motion.x_sp_dot.values[1:-1]))
    assert off < 0.1 * np.nanmax(abs(differences))


def undamped(play: float = 1.0) -> Arm:
    """``unlike_arm`` without damping, its clearances times ``play``."""
    joints = planet_laws.unlike_arm().model_dump()["joints"]
    for joint in joints:
        for side in ("sun_mesh", "ring_mesh"):
            backlash = tuple(
                play * np.broadcast_to(joint[side]["backlash_m"], joint["planet_count"])
            )
            joint[side] |= {"damping_ratio": 0.0, "damping_N_s_per_m": None, "backlash_m": backlash}
    return arm_of(*joints, gravity=NONE)


@every_run
@pytest.mark.parametrize(("play", "drift"), [(0.0, 1e-9), (1.0, 1e-6)])
def test_energy_stays_with_conservative_meshes_alone(name, play, drift):
    """Where teeth part and meet RK4 has the second order left, with play."""
    start = {**planet_laws.OFFSETS, "theta_dot_rad_per_s": [1.4, -2.7]}
    run = scenario(duration_s=2e-4, step_s=5e-7, record_every=40, start=start)
    changes = []
    for laws in (CONSERVATIVE, {}):
        model = build(name, undamped(play), run, switches(planets="free", **laws))
        motion = model.simulate()
        total = motion.kinetic_energy.values + planet_laws.energies(model, motion)
        changes.append(float(np.ptp(total) / total[0]))
    assert changes[0] < drift < 1e-5 < changes[1]


def test_energy_stays_in_pinocchios_equations_too():
    """By an integrator that chooses its steps: a stage out of phase, for 1/20 of a period."""
    arm = arm_of(stage(sun_mesh=mesh(static_error_m=[0.0, 4e-6, -3e-6])), links=[ROD], gravity=NONE)
    kept, lost = (
        energy_over(free("pinocchio:gears", arm, mesh_work=law), 2.5e-4)
        for law in ("conservative", "paper")
    )
    # 0.2 J in springs, next to 1.1 kJ of motion, whose integration keeps eleven digits.
    assert np.ptp(kept) < 1e-8
    assert np.ptp(lost) > 1e-3


def energy_over(model: Model, duration: float) -> np.ndarray:
    """Kinetic and spring energy [J] along an undamped motion from teeth pressed together."""
    springs, n = contacts(model.arm, model.switches, model.layout), len(model.layout)
    pressed = np.where(model.layout.angular, 0.3, 4e-5)
    pressed[model.layout.indices("x_s")] = 1e-4
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


@every_model_with_modes
def test_modes_follow_every_planets_own_stiffness(name):
    # The engine linearises by differences at 1e-7.
    assert planet_laws.modes_off(free(name, undamped())) < 1e-6


@every_model_with_modes
def test_the_largest_stable_step_follows_the_stiffest_moment_of_every_planet(name):
    arm = undamped()
    model = free(name, arm.model_copy(update={"joints": arm.joints[:1], "links": arm.links[:1]}))
    phases = np.linspace(0, 2 * pi, 4001)
    K = planet_laws.spring_matrix(model, lambda law: max(stiffness_at(law, p) for p in phases).real)
    fastest = np.sqrt(
        np.linalg.eigvals(np.linalg.solve(model.mass_matrix(np.zeros(5)), K)).real.max()
    )
    # RK4's |R| is 1 at i sqrt(8); fine samples, and steps tried in 1e-4.
    assert model.largest_stable_step() == pytest.approx(np.sqrt(8) / fastest, rel=1e-3)


def gear_tree(arm: Arm, **laws: str) -> PinocchioGears:
    return PinocchioGears(arm, scenario(), switches(planets="free", **laws))


@settings(max_examples=10)
@given(unlike_arms(), seeds)
def test_pinocchios_contact_forces_obey_newtons_third_law(arm, seed):
    """And work on the phase changes none of them: it is a torque between two links."""
    model = gear_tree(arm)
    [(q, v)] = random_states(model.layout, 1, seed)
    wrenches = contact_wrenches(model, 0.2, q, v)
    # Sums of some fifty forces, on arms of up to 5 m.
    size = 5 * 50 * EPS * (1 + np.abs(wrenches).max())
    np.testing.assert_allclose(wrenches.sum(axis=0), 0, atol=size)
    working = gear_tree(arm, **CONSERVATIVE)
    np.testing.assert_array_equal(contact_wrenches(working, 0.2, q, v), wrenches)


def every_mesh(model: ExudynBodies) -> list[GearPair]:
    """In the order of ``contacts``."""
    return [
        toothed for sides in model.meshes for pair in zip(*sides, strict=True) for toothed in pair
    ]


def bodies(**laws: str) -> ExudynBodies:
    return ExudynBodies(planet_laws.unlike_arm(), scenario(), switches(planets="free", **laws))


def test_poses_and_rates_of_exudyns_bodies_show_every_displacement():
    model = bodies()
    meshes = contacts(model.arm, model.switches, model.layout)
    for q, v in require_items(random_states(model.layout, 5)):
        values = model.poses.pose(q), model.poses.velocity(q, v)
        for contact, toothed in require_items(zip(meshes, every_mesh(model), strict=True)):
            seen = (
                np.append(of_all, np.zeros(3)).reshape(-1, 3)[list(toothed.bodies)].ravel()
                for of_all in values
            )
            found = contact_state(toothed.mesh, 0.0, *seen)
            # Gears turned by some 10 rad, places of 1 m: a few roundings.
            assert found.x == pytest.approx(contact.row @ q, rel=0, abs=2e-15)
            assert found.x_dot == pytest.approx(contact.row @ v, rel=0, abs=2e-14)


def test_action_and_reaction_of_conservative_teeth_cancel_wherever_exudyns_bodies_are():
    draw = np.random.default_rng(5)
    for toothed, plain in require_items(
        zip(every_mesh(bodies(**CONSERVATIVE)), every_mesh(bodies()), strict=True)
    ):
        size = 3 * len(toothed.bodies)
        pose, velocity = draw.normal(size=size), draw.normal(size=size)
        forces, without = (
            mesh_forces(own.mesh, 0.2, pose, velocity).reshape(-1, 3) for own in (toothed, plain)
        )
        places = pose.reshape(-1, 3)
        turning = places[:, 0] * forces[:, 1] - places[:, 1] * forces[:, 0] + forces[:, 2]
        # Opposite forces at one point and opposite torques, with arms of a few metres.
        largest = abs(forces).max()
        np.testing.assert_allclose(forces[:, :2].sum(axis=0), 0, atol=4 * EPS * largest)
        assert turning.sum() == pytest.approx(0, abs=50 * EPS * largest)
        pair = (forces - without)[[CARRIER, PREVIOUS], 2]
        assert abs(pair).min() > 1e-6 * largest
        np.testing.assert_array_equal(forces[:, :2], without[:, :2])
