"""Torques along a motion: those of every rigid model are M a + bias less the forces."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from crosscheck.models.experiment.scenario import ConstantDrive
from crosscheck.models.interface import Model
from crosscheck.planning.sizing import make_sized_scenario
from crosscheck.registry import RIGID_LEVELS, build, find_level_models
from tests.any_arms import any_arms

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
