"""Whatever arm the schema lets through, every model can be built and gives finite numbers."""

import random
from itertools import product

import numpy as np
import pytest

from crosscheck.checks.scales import meshes
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.interface import STATE_ABILITIES, Model
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.registry import MODELS, build, model_names, select_covering
from tests.draws import any_arm, examples, fresh_seed
from tests.loops import require_items

WITHOUT = ("sun_mass_kg", "planet_mass_kg", "carrier_mass_kg", "ring_mass_kg")


def state_of(model: Model, generator: random.Random) -> tuple[float, np.ndarray, np.ndarray]:
    """A state: any pose, meshes as far from rest as their play or 1e-5 of the largest gear."""
    geared = [joint for joint in model.arm.joints if isinstance(joint, Planetary)]
    arc = max((joint.module_m * joint.ring_teeth / 2 for joint in geared), default=0.0)
    plays = [mesh.backlash_m for joint in geared for mesh in meshes(joint)]
    reach = 1e-5 * arc + 3 * max(plays, default=0.0)
    sizes = np.where(model.layout.angular, 3.0, reach)
    q = np.array([generator.uniform(-size, size) for size in sizes])
    v = np.array([generator.uniform(-1, 1) for _ in sizes])
    return generator.uniform(0, 1), q, v


def values(model: Model, t: float, q: np.ndarray, v: np.ndarray) -> list[np.ndarray]:
    """M, bias, force and acceleration."""
    return [
        model.mass_matrix(q),
        model.bias(q, v),
        model.generalized_force(t, q, v),
        model.acceleration(t, q, v),
    ]


def is_singular(mass: np.ndarray) -> bool:
    """Whether a mass matrix is so to rounding: a link of 0.3 mm before one of 1e13 kg m^2."""
    scale = 1 / np.sqrt(np.diag(mass))
    return bool(np.linalg.eigvalsh(mass * scale[:, None] * scale).min() <= 1e-14)


def all_finite(arm: Arm, generator: random.Random) -> bool:
    """Whether every model of the arm gives finite numbers in a state, and a stable step."""
    for name in MODELS:
        if name not in select_covering([name], arm, usual_switches(arm)):
            continue
        model = build(name, arm, load_scenario("constant-torque"))
        state = state_of(model, generator)
        if is_singular(model.mass_matrix(state[1])):
            continue
        found = values(model, *state)
        if not all(np.isfinite(value).all() for value in found) or model.largest_stable_step() <= 0:
            return False
    return True


@pytest.mark.slow
@pytest.mark.campaign
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("joints", [1, 2])
def test_any_arm_in_range_has_finite_numbers_in_every_model(joints, capfd):
    """And no engine says a word about it."""
    seed = fresh_seed()
    generator = random.Random(seed)
    capfd.readouterr()
    for _ in range(examples(4, 60) // joints):
        arm = any_arm(generator, joints)
        assert all_finite(arm, generator), (seed, arm)
    assert capfd.readouterr() == ("", ""), seed


@pytest.mark.parametrize("massless", [("planet_mass_kg",), ("sun_mass_kg",), WITHOUT])
def test_gears_without_mass_still_have_inertia(massless):
    """Kinetic energy J w^2 / 2 needs no mass; the planet's centre then carries nothing along."""
    probe = load_arm("probe")
    joints = tuple(j.model_copy(update=dict.fromkeys(massless, 0.0)) for j in probe.joints)
    arm = probe.model_copy(update={"joints": joints})
    models = [build(name, arm, load_scenario("pd")) for name in model_names("geared")]
    state = state_of(models[0], random.Random(fresh_seed()))
    expected, *others = ([*values(model, *state)] for model in models)
    pairs = product(others, zip(STATE_ABILITIES, expected, strict=True))
    for other, (ability, one) in require_items(pairs):
        measured = other[STATE_ABILITIES.index(ability)]
        assert measured == pytest.approx(one, rel=1e-10, abs=1e-10 * abs(one).max()), ability


def test_point_mass_at_the_joint_leaves_no_bias():
    """A link whose centre is on its joint, nothing on its end: every term of the bias cancels."""
    probe = load_arm("probe")
    inner, outer = probe.links
    links = inner, outer.model_copy(update={"com_m": 0.0})
    arm = probe.model_copy(update={"links": links, "payload_mass_kg": 0.0})
    model = build("analytic:links", arm, load_scenario("pd"))
    assert not model.bias(np.array([0.3, 0.7]), np.array([1.0, -2.0])).any()
