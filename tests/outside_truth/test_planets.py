"""Single planets in every geared model: virtual work, energies, the teeth's symmetry and flanks."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.checks.energy import springs_at
from crosscheck.checks.first_principles.mesh_energy import spring_energy as energy_in_spring
from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Switches, switches
from crosscheck.models.interface import Model
from crosscheck.models.loading import load_arm
from crosscheck.models.pinocchio.arm import PinocchioGears
from crosscheck.registry import MODELS, build, model_names
from tests import planet_laws
from tests.engines.bodies_checks import contact_wrenches
from tests.loops import require_items
from tests.mixed_arms import NONE, PLANET_M, SUN_J, arm_of, direct, random_states, scenario
from tests.planet_meshes import contacts, expected_force, rounding, stiffness_at, unlike_arms

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
    arm = planet_laws.standing_errors()
    start: dict[str, object] = {"planet_offset_m": [[0.0] * each for each in arm.planet_counts]}
    model = free(name, arm, start, planets="lumped")  # offsets of nothing
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
