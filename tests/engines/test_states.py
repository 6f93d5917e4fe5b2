"""The engines against each other, state by state."""

from collections.abc import Sequence
from itertools import product

import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Switches, switches
from crosscheck.models.interface import STATE_ABILITIES
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.planning.plan import remove_backlash
from crosscheck.registry import RIGID_LEVELS, build, model_names
from tests.arms import PAPER, arm_of
from tests.judged import compare_states

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
def test_geared_models_agree_under_all_switches_on_unequal_joints(chosen):
    assert disagreements(load_arm("probe"), model_names("geared"), chosen) == []


@pytest.mark.parametrize("name", ARMS)
def test_geared_models_agree_on_any_arm(name):
    assert disagreements(ARMS[name], model_names("geared"), switches()) == []


def test_geared_models_agree_whichever_comes_first():
    assert disagreements(load_arm("probe"), model_names("geared")[::-1], switches()) == []


@pytest.mark.parametrize("level", RIGID_LEVELS)
@pytest.mark.parametrize(
    "name",
    [
        *("one joint", "three joints", "seven joints", "direct joints first and last"),
        *("unlike meshes", "everything unequal"),
    ],
)
def test_rigid_levels_agree_on_any_arm(name, level):
    names = (f"analytic:{level}", f"pinocchio:{level}")
    assert disagreements(ARMS[name], names, switches()) == []
