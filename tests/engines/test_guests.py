"""What guests may take: tooth contacts, motors and numbers of bodies, against the engines here."""

import numpy as np
import pytest

from crosscheck.checks.answers import sample_states
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.scenario import Switches
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.models.pinocchio.tree import base_radii, equivalent_masses
from crosscheck.models.plugin import Motors, gear_numbers, link_mass, tooth_contacts
from crosscheck.planning.arms import switch_combinations
from crosscheck.registry import build
from tests import planet_laws
from tests.loops import require_items

ARMS = ("probe", "three-unlike", "planets-apart")
COUNT, ROUNDING = 20, 1e-11  # of the largest force


def of_contacts(arm: Arm, laws: Switches, layout, t: float, q, v) -> np.ndarray:
    """All contacts' generalized force, (n,)."""
    force = np.zeros(len(layout))
    for contact in tooth_contacts(arm, laws):
        motion = contact.motion(t, q, v, layout)
        force -= contact.displacement(layout) * contact.force(motion)
        force[layout.at("theta", contact.joint)] += contact.torque(motion)
    return force


def of_model(name: str, arm: Arm, laws: Switches):
    """A model without drive, friction and weight, whose force is the meshes' alone."""
    still = load_scenario("constant-torque").drive.model_copy(update={"torque_N_m": 0.0})
    scenario = load_scenario("constant-torque").model_copy(update={"drive": still})
    joints = tuple(j.model_copy(update={"friction_N_m_s_per_rad": 0.0}) for j in arm.joints)
    bare = arm.model_copy(update={"joints": joints, "gravity_m_per_s2": (0.0, 0.0)})
    return build(name, bare, scenario, laws)


def apart(name: str, arm: Arm, laws: Switches) -> float:
    """Largest difference of the contacts' force from a model's, over each coordinate's size."""
    model = of_model(name, arm, laws)
    states = zip(*sample_states(model.layout, arm, COUNT, 0), strict=True)
    pairs = [
        (of_contacts(arm, laws, model.layout, *state), model.generalized_force(*state))
        for state in states
    ]
    ours, theirs = (np.array(side) for side in zip(*pairs, strict=True))
    size = np.abs(theirs).max(axis=0)
    largest = max(gear_numbers(j).ring_radius for j in arm.joints if isinstance(j, Planetary))
    size[model.layout.theta] = size.max() * largest  # of torques that cancel, if nothing is left
    return float((np.abs(ours - theirs).max(axis=0) / size).max())


@pytest.mark.parametrize(
    "laws", switch_combinations(), ids=lambda laws: "-".join(dict(laws).values())
)
def test_contacts_under_every_law(laws):
    """As one engine has them: the others agree with that (test_any_arm)."""
    assert apart("exudyn:tree", load_arm("probe"), laws) < ROUNDING


@pytest.mark.parametrize("arm_name", [*ARMS, *planet_laws.ARMS])
@pytest.mark.parametrize("work", ["paper", "conservative"])
def test_contacts_of_any_mesh(arm_name, work):
    arm = planet_laws.ARMS[arm_name]() if arm_name in planet_laws.ARMS else load_arm(arm_name)
    laws = usual_switches(arm, planets="free", mesh_work=work)
    assert apart("exudyn:tree", arm, laws) < ROUNDING


@pytest.mark.parametrize("arm_name", [*ARMS, "direct-between"])
def test_numbers_of_bodies(arm_name):
    arm = load_arm(arm_name)
    for link in require_items(arm.links):
        assert link_mass(link)[0] == pytest.approx(link.mass, rel=1e-15)
    for joint in require_items(j for j in arm.joints if isinstance(j, Planetary)):
        numbers = gear_numbers(joint)
        assert numbers[:3] == pytest.approx(base_radii(joint), rel=1e-15)
        sun, planet = equivalent_masses(joint)
        assert numbers.sun_inertia == pytest.approx(sun * numbers.sun_radius**2, rel=1e-15)
        assert numbers.planet_inertia == pytest.approx(planet * numbers.planet_radius**2, rel=1e-15)


@pytest.mark.parametrize("name", ["pd", "back-and-forth"])
def test_motors_follow_the_law_of_an_experiment(name):
    """A rigid arm is moved by the torques on its joints, at random times and states."""
    arm, scenario = load_arm("direct-between"), load_scenario(name)
    still = tuple(j.model_copy(update={"friction_N_m_s_per_rad": 0.0}) for j in arm.joints)
    bare = arm.model_copy(update={"joints": still, "gravity_m_per_s2": (0.0, 0.0)})
    model, motors = build("analytic:coupled", bare, scenario), Motors(bare, scenario)
    ratios = [
        (j.sun_teeth + j.ring_teeth) / j.sun_teeth if isinstance(j, Planetary) else 1.0
        for j in arm.joints
    ]
    drawn = np.random.default_rng(2).uniform(0, 0.5, (5, 1 + 2 * len(ratios)))
    for t, *state in require_items(drawn.tolist()):
        q, v = np.reshape(state, (2, -1))
        torques = model.generalized_force(t, q, v)
        np.testing.assert_allclose(motors.torques(t, q, v) * ratios, torques, rtol=1e-13)


def test_motors_turn_the_sun_by_the_output_torque_over_the_ratio():
    arm, scenario = load_arm("direct-between"), load_scenario("constant-torque")
    drive = scenario.drive.model_copy(update={"torque_N_m": 7.0})
    motors = Motors(arm, scenario.model_copy(update={"drive": drive}))
    still = np.zeros(len(arm.joints))
    ratios = [
        (j.sun_teeth + j.ring_teeth) / j.sun_teeth if isinstance(j, Planetary) else 1.0
        for j in arm.joints
    ]
    np.testing.assert_allclose(motors.torques(0.0, still, still) * ratios, 7.0, rtol=1e-15)
