"""Rigid levels: equal ones are one, torques along a motion are M a + bias less forces; limits."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from crosscheck.checks.answers import sample_states
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import rigid_layout
from crosscheck.models.experiment.scenario import ConstantDrive
from crosscheck.models.interface import Model
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.planning.sizing import make_sized_scenario
from crosscheck.registry import (
    RIGID_LEVELS,
    build,
    find_distinct_levels,
    find_level_models,
    group_equal_levels,
    is_rigid_arm,
)
from tests import mixed_arms
from tests.any_arms import any_arms
from tests.arms import arm_of
from tests.loops import require_items

LINKS, CARRIERS, ARMATURE, COUPLED = RIGID_LEVELS


LINK = {"length_m": 0.5, "com_m": 0.2, "mass_kg": 1.3, "inertia_kg_m2": 0.03}


def direct(*motors: tuple[float, float]) -> Arm:
    """An arm without gears: mass [kg] and rotor's inertia [kg m^2] of each joint's motor."""
    joints = [
        mixed_arms.direct(motor_mass_kg=mass, rotor_inertia_kg_m2=inertia)
        for mass, inertia in motors
    ]
    return mixed_arms.arm_of(
        *joints, links=[LINK] * len(joints), payload_kg=0.4, gravity=(0.0, -9.81)
    )


CASES = [
    (direct((0, 0), (0, 0)), [RIGID_LEVELS]),
    (direct((2, 0), (0, 0)), [RIGID_LEVELS]),  # at the first joint's axis, which does not move
    (direct((0, 0), (2, 0)), [(LINKS,), (CARRIERS, ARMATURE, COUPLED)]),
    (direct((0, 0.1), (0, 0)), [(LINKS,), (CARRIERS, ARMATURE, COUPLED)]),
    (direct((1, 0.1), (1, 0.1)), [(LINKS,), (CARRIERS, ARMATURE, COUPLED)]),
    (arm_of(1), [(LINKS,), (CARRIERS,), (ARMATURE, COUPLED)]),
    (load_arm("direct-between"), [(each,) for each in RIGID_LEVELS]),
]


@pytest.mark.parametrize(("arm", "groups"), CASES)
def test_levels_of_a_group_are_equal_and_those_of_others_are_not(arm, groups):
    assert group_equal_levels(arm) == groups
    assert find_distinct_levels(arm) == tuple(group[0] for group in groups)
    assert is_rigid_arm(arm) == (len(groups) == 1)
    states = sample_states(rigid_layout(arm), arm, 4, 0)
    scenario = load_scenario("constant-torque" if len(arm.joints) == 2 else "pd")
    for engine in require_items((0, 1)):
        answers = {}
        for level in RIGID_LEVELS:
            model = build(find_level_models(level)[engine], arm, scenario)
            masses = np.array([model.mass_matrix(q) for q in states.q])
            forces = [model.generalized_force(*state) for state in zip(*states, strict=True)]
            answers[level] = masses, np.array(forces)
        firsts = [group[0] for group in groups]
        for group in groups:
            first, *others = (answers[level] for level in group)
            for mass, force in others:
                assert np.abs(mass - first[0]).max() <= 1e-12 * np.abs(first[0]).max()
                assert np.abs(force - first[1]).max() <= 1e-12 * np.abs(first[1]).max()
        for lower, upper in pairwise(firsts):
            off = np.abs(answers[lower][0] - answers[upper][0]).max()
            assert off > 1e-6 * np.abs(answers[lower][0]).max()


STATES = 20
# Of the largest torque: sums of a few hundred products in seven joints.
ROUNDED = 1e-12


@pytest.mark.parametrize("level", RIGID_LEVELS)
@settings(max_examples=5, suppress_health_check=[*HealthCheck])
@given(arm=st.integers(1, 7).flatmap(any_arms), seed=st.integers(0, 2**32 - 1))
def test_every_model_asks_for_the_same_torques(level, arm, seed):
    draw = np.random.default_rng(seed)
    motion = draw.normal(size=(3, STATES, len(arm.joints)))
    pushed = make_sized_scenario(
        "pushed", ConstantDrive(kind="constant", torque_N_m=100.0), 1.0, 1.0
    )
    models = [build(name, arm, pushed) for name in find_level_models(level)]
    assert len(models) > 1
    by_definition = Model.inverse_dynamics(models[0], *motion)
    for model in models:
        apart = np.abs(model.inverse_dynamics(*motion) - by_definition).max()
        assert apart <= ROUNDED * np.abs(by_definition).max(), model.name


LIMITS = {"analytic:physical": "analytic:coupled", "analytic:printed": "analytic:printed-rigid"}


@pytest.mark.parametrize("geared", LIMITS)
@pytest.mark.parametrize("reading", ["paper-labelled", "paper-swapped"])
def test_held_meshes_leave_the_rigid_arm(geared: str, reading: str):
    """With x' = x'' = 0 the rows of theta are an equation of theta'' alone, whatever holds x."""
    arm, scenario = load_arm(reading), load_scenario("constant-torque")
    meshing, rigid = (build(name, arm, scenario) for name in (geared, LIMITS[geared]))
    theta = meshing.layout.theta
    states = np.random.default_rng(3).normal(0, 2, (5, 2, 2))
    for angles, rates in require_items(states):
        q, v = np.zeros((2, len(meshing.layout)))
        q[theta], v[theta] = angles, rates
        mass = meshing.mass_matrix(q)[np.ix_(theta, theta)]
        push = (meshing.generalized_force(0.0, q, v) - meshing.bias(q, v))[theta]
        assert rigid.mass_matrix(angles) == pytest.approx(mass, rel=1e-13)
        found = rigid.acceleration(0.0, angles, rates)
        assert found == pytest.approx(np.linalg.solve(mass, push), rel=1e-11)
