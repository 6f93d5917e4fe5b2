"""The engines against each other, state by state."""

from collections.abc import Sequence
from itertools import product

import numpy as np
import pytest

from crosscheck.checks import states
from crosscheck.checks.answers import acceleration, generalized_force, mass_matrix
from crosscheck.findings import ComparisonKey, Subject
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.scenario import Switches, switches
from crosscheck.models.files import builtin_arms
from crosscheck.models.interface import STATE_ABILITIES
from crosscheck.models.loading import Case, load_arm, load_scenario
from crosscheck.planning.arms import sample_model
from crosscheck.planning.plan import remove_backlash
from crosscheck.registry import RIGID_LEVELS, build, model_names, reference_model
from tests.arms import PAPER, arm_of
from tests.judged import compare_states
from tests.loops import require_items

COUNT, SEED = 6, 3  # every planted fault of a model is seen at five (tests/faults)
LAWS = {
    "phase": ("angle", "omega_t"),
    "ring_rate": ("eq13", "corrected"),
    "dead_zone": ("exact", "tanh"),
    "damping": ("always", "contact"),
}
ALL_SWITCHES = [
    switches(**dict(zip(LAWS, chosen, strict=True))) for chosen in product(*LAWS.values())
]
FOUR_PLANETS = {"sun_teeth": 30, "planet_teeth": 30, "ring_teeth": 90, "planet_count": 4}


def direct_damping(sun: float, ring: float) -> dict[str, object]:
    """A joint's meshes damped directly [N s/m]."""
    given = [
        mesh.model_copy(update={"damping_ratio": None, "damping_N_s_per_m": value})
        for mesh, value in ((PAPER.joints[0].sun_mesh, sun), (PAPER.joints[0].ring_mesh, ring))
    ]
    return {"sun_mesh": given[0], "ring_mesh": given[1]}


def ring_mesh(**update: float) -> dict[str, object]:
    """A joint with another ring mesh."""
    return {"ring_mesh": PAPER.joints[0].ring_mesh.model_copy(update=update)}


def paper_arm_with(*updates: dict[str, object]) -> Arm:
    """The paper's arm, each joint with changes of its own."""
    joints = [j.model_copy(update=u) for j, u in zip(PAPER.joints, updates, strict=True)]
    return Arm.model_validate(PAPER.model_copy(update={"joints": tuple(joints)}).model_dump())


ARMS = {
    "one joint": arm_of(1),
    "two joints": arm_of(2, 1.3),
    "three joints": arm_of(3),
    "four joints": arm_of(4, 0.7),
    "seven joints": arm_of(7, 0.6),
    "one direct joint": arm_of(1, direct=[0]),
    "direct joints alone": arm_of(3, direct=[0, 1, 2]),
    "direct joints first and last": arm_of(4, direct=[0, 3]),
    "direct joint between": load_arm("direct-between"),
    "unlike meshes": load_arm("three-unlike"),
    "direct damping": paper_arm_with(direct_damping(1300.0, 700.0), direct_damping(0.0, 700.0)),
    "phase of the ring mesh": paper_arm_with(
        ring_mesh(phase_rad=3.141592653589793), ring_mesh(phase_rad=-0.4)
    ),
    "inertia of the ring": paper_arm_with(
        {"ring_inertia_kg_m2": 0.3}, {"ring_inertia_kg_m2": 0.18231}
    ),
    "unequal numbers of planets": paper_arm_with({}, FOUR_PLANETS),
    "everything unequal": load_arm("probe"),
    "no backlash": remove_backlash(PAPER),
}


def disagreements(arm: Arm, names: Sequence[str], chosen: Switches) -> list[str]:
    """The checks that are not green, at the tolerance that they earn."""
    models = [build(name, arm, load_scenario("pd"), chosen) for name in names]
    findings = list(compare_states("test", models, STATE_ABILITIES, COUNT, SEED))
    pairs = len(names) * (len(names) - 1) // 2
    assert len(findings) == pairs * len(STATE_ABILITIES)
    return [f"{f.id}: {f.measured} > {f.tolerance}" for f in findings if f.verdict != "agree"]


@pytest.mark.parametrize("chosen", ALL_SWITCHES, ids=lambda chosen: "-".join(dict(chosen).values()))
def test_geared_models_agree_under_all_switches_and_both_readings(reading, chosen):
    assert disagreements(reading, model_names("geared"), chosen) == []


@pytest.mark.parametrize("chosen", ALL_SWITCHES, ids=lambda chosen: "-".join(dict(chosen).values()))
def test_geared_models_agree_under_all_switches_on_unequal_joints(chosen):
    assert disagreements(load_arm("probe"), model_names("geared"), chosen) == []


@pytest.mark.parametrize("name", ARMS)
def test_geared_models_agree_on_any_arm(name):
    assert disagreements(ARMS[name], model_names("geared"), switches()) == []


def test_geared_models_agree_whichever_comes_first():
    assert disagreements(load_arm("probe"), model_names("geared")[::-1], switches()) == []


@pytest.mark.parametrize("level", RIGID_LEVELS)
def test_rigid_levels_agree_on_both_readings(reading, level):
    assert disagreements(reading, (f"analytic:{level}", f"pinocchio:{level}"), switches()) == []


@pytest.mark.parametrize("level", RIGID_LEVELS)
@pytest.mark.parametrize(
    "name",
    ["one joint", "three joints", "seven joints", "direct joints first and last", "unlike meshes"],
)
def test_rigid_levels_agree_on_any_arm(name, level):
    names = (f"analytic:{level}", f"pinocchio:{level}")
    assert disagreements(ARMS[name], names, switches()) == []


@pytest.mark.parametrize("switch", ["phase", "ring_rate", "dead_zone", "damping"])
@pytest.mark.parametrize("model", model_names("geared"))
def test_every_switch_changes_the_forces_of_every_model(model, switch):
    """A switch that did nothing would agree everywhere."""
    default = switches(phase="angle", ring_rate="corrected")
    other = {"phase": "omega_t", "ring_rate": "eq13", "dead_zone": "tanh", "damping": "contact"}
    changed = default.model_copy(update={switch: other[switch]})
    arm, scenario = load_arm("probe"), load_scenario("pd")
    # A state with the shoulder's sun mesh in play and the rest in contact, all in motion.
    q = [1e-5, 9e-5, 0.3, 8e-5, -9e-5, -0.7]
    v = [0.03, -0.02, 0.9, 0.05, 0.04, -0.4]
    state = 0.7, np.array(q), np.array(v)
    one, two = (
        build(model, arm, scenario, s).generalized_force(*state) for s in (default, changed)
    )
    # Damping of one mesh alone is 40 N; rounding, 1e-9 N.
    assert abs(one - two).max() > 1


@pytest.mark.parametrize("name", builtin_arms())
def test_a_force_or_an_acceleration_beyond_its_tolerance_is_seen_in_every_component(name):
    """Roundings of terms that cancel are nothing beside the tolerance where links are alike."""
    arm, reference = load_arm(name), reference_model()
    case = Case(arm, load_scenario("pd"), usual_switches(arm))
    model = build(reference, *case)
    setting = sample_model("test", reference, case, COUNT, SEED).setting
    masses, forces, accelerations = (
        question(model, setting) for question in (mass_matrix, generalized_force, acceleration)
    )
    for quantity, values in (("generalized_force", forces), ("acceleration", accelerations)):
        about = Subject(ComparisonKey("states", "test", quantity, reference), "1", "largest")
        limit = states.compare_values(about, values, values, masses, setting).tolerance
        natural = states.natural_sizes(quantity, values, masses[0], setting)
        sizes = states.component_sizes(values, natural)
        # On the angles the teeth's moments cancel, and their roundings count.
        first = int(setting.layout.angular.sum()) if quantity == "generalized_force" else 0
        for component in require_items(range(first, sizes.size)):
            other = values.copy()
            other[0, component] += 1.05 * limit * sizes[component]
            assert states.compare_values(about, values, other, masses, setting).verdict == "differ"
