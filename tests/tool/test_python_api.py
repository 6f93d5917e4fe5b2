"""The Python API: the same as the command line, for notebooks."""

import numpy as np
import pytest

import crosscheck
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import CannotDo, Diverged, InputError
from crosscheck.models.experiment.scenario import Scenario


def test_arm_and_scenario_are_loaded_by_name_and_file(tmp_path):
    assert isinstance(crosscheck.load_arm("paper-swapped"), Arm)
    assert isinstance(crosscheck.load_scenario("pd"), Scenario)
    with pytest.raises(crosscheck.InputError, match="no such file, nor built-in name"):
        crosscheck.load_arm(str(tmp_path / "none.toml"))


def test_model_gives_states_and_a_trajectory(labelled):
    scenario = crosscheck.load_scenario("constant-torque").model_copy(update={"duration_s": 0.001})
    model = crosscheck.build("analytic:physical", labelled, scenario)
    assert model.mass_matrix(np.zeros(6)).shape == (6, 6)
    run = crosscheck.simulate(model)
    assert run.sizes["time"] == 11
    assert run["theta"].attrs["units"] == "rad"


def test_switches_are_taken(labelled):
    scenario = crosscheck.load_scenario("pd")
    chosen = crosscheck.switches(phase="omega_t")
    assert chosen.ring_rate == "eq13"
    assert crosscheck.build("exudyn:tree", labelled, scenario, chosen).switches == chosen


def test_model_of_states_alone_says_that_it_cannot_simulate(labelled):
    model = crosscheck.build("pinocchio:gears", labelled, crosscheck.load_scenario("pd"))
    with pytest.raises(InputError, match="cannot simulate"):
        crosscheck.simulate(model)
    with pytest.raises(CannotDo, match="pinocchio:gears has no simulate"):
        model.simulate()


def test_step_beyond_stability_needs_force(labelled):
    scenario = crosscheck.load_scenario("constant-torque").model_copy(update={"step_s": 5e-4})
    model = crosscheck.build("analytic:physical", labelled, scenario)
    with pytest.raises(InputError, match="largest stable step of analytic:physical is"):
        crosscheck.simulate(model)
    with pytest.raises(Diverged, match="analytic:physical: diverged at t = "):
        crosscheck.simulate(model, force=True)
