"""Rigid levels that are equal on an arm are one, decided by its file and true of both engines."""

from itertools import pairwise

import numpy as np
import pytest

from crosscheck.checks.answers import sample_states
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import rigid_layout
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.registry import (
    RIGID_LEVELS,
    build,
    find_distinct_levels,
    find_level_models,
    group_equal_levels,
    is_rigid_arm,
)
from tests import mixed_arms
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
