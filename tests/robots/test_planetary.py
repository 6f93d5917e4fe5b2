"""Planetary stages of robots; test_arms_as_robots holds them against planar arms."""

from collections.abc import Callable

import numpy as np
import pytest

from crosscheck.analytic.ensemble import group_models
from crosscheck.analytic.robot.runs import RobotMember
from crosscheck.analytic.robot.springs import replace_stages_by_rotors, tooth_springs
from crosscheck.checks.robot_states import sample_states
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import ConstantDrive, Start
from crosscheck.models.loading import make_rest_scenario, require_fit
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import RIGID, Robot
from crosscheck.provenance import ROOT
from crosscheck.registry import build_robot_model
from crosscheck.robot_experiment import RobotExperiment
from tests.faults.robots import parted
from tests.robots import chains
from tests.robots.traced import random_state

PAPER = str(ROOT / "examples" / "robots" / "planetary-arm.toml")
SUN, PLANET, RATIO, TURNS = 3e-4, 1e-4, 4.0, -2.0  # of tests.robots.chains.planetary


def pendulum(**changes: object) -> Robot:
    """A bob on an axis along y, which a stage turns against the ground."""
    return chains.robot(chains.BOB, {"swing": chains.planetary(**changes)})


def test_errors_of_teeth_are_bounded_by_both_of_their_parts():
    ring = chains.contact(static_error_m=-4e-6)
    springs = tooth_springs(pendulum(ring_mesh=ring))
    assert [each.error for each in springs] == pytest.approx([3e-6 + 1e-6, 3e-6 + 4e-6])


@pytest.mark.parametrize("engine", chains.ENGINES)
def test_spins_are_coupled_to_what_carries_the_ring(engine):
    """J (c q1' + k q2')^2 / 2 of each gear, c = 0.8 between the axes: sun k = 4, planets k = -2."""
    text = chains.urdf(
        chains.link("ground"),
        chains.link("ring", chains.Solid()),
        chains.link("disc", chains.Solid()),
        chains.joint("yaw", "ground", "ring"),
        chains.joint("roll", "ring", "disc", axis=(0.6, 0, 0.8)),
    )
    own, q = chains.robot(text, {"roll": chains.planetary()}), np.array([[0.4, -0.7]])
    exact, plain = (
        build_robot_model(engine, own, "coupled"),
        build_robot_model(engine, own, "links"),
    )
    rows = np.array([[0.8, RATIO], [0.8, TURNS]])
    expected = rows.T @ np.diag([SUN, 3 * PLANET]) @ rows
    found = exact.mass_matrix(q)[0] - plain.mass_matrix(q)[0]
    assert found == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize("engine", chains.ENGINES)
def test_planets_alike_that_start_alike_move_as_one(engine):
    """x_s = x_sp + x_pr and x_pr of each, under weight, friction and a torque."""
    lumped, free = (
        build_robot_model(engine, pendulum(planets=each, friction_N_m_s_per_rad=3.0), "geared")
        for each in ("lumped", "free")
    )
    q, v = np.array([[0.4, 3e-5, -6e-5]]), np.array([[0.7, 0.02, -0.01]])
    by = np.array([[1.0, 0, 0], [0, 1, 1], [0, 0, 1], [0, 0, 1], [0, 0, 1]])
    torque = np.array([[2.0]])
    expected = lumped.forward_dynamics(q, v, torque) @ by.T
    found = free.forward_dynamics(q @ by.T, v @ by.T, torque)
    # Accelerations of teeth are 1e5 times the joint's, and differences of such.
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())
    assert free.stage_forces(q @ by.T) == pytest.approx(lumped.stage_forces(q), rel=1e-11)


@pytest.mark.parametrize("engine", chains.ENGINES)
def test_forces_of_planets_are_what_holds_their_coordinates(engine):
    """Of unlike ones: sun meshes together hold x_s, each planet is between ring and sun."""
    own = parted()
    model, columns = build_robot_model(engine, own, "geared"), own.stage_columns[0]
    q, _, _ = random_state(own, "geared", 3, 4)
    held = model.inverse_dynamics(q, 0 * q, 0 * q) - model.gravity(q)
    sun, ring = model.stage_forces(q)[:, :6].reshape(4, 3, 2).transpose(2, 0, 1)
    expected = np.column_stack([sun.sum(axis=1), ring - sun])
    assert held[:, columns] == pytest.approx(expected, rel=1e-10, abs=1e-9 * np.abs(sun).max())


def test_runs_of_unlike_planets_have_displacements_and_forces_of_each():
    """Of each engine alone, and of the kernel's lanes; the start touches where it is asked to."""
    own, joints = parted(), 3
    start = {"planet_offset_m": [[1e-6, 0.0, -1e-6], [], []]}
    scenario = make_rest_scenario().model_copy(
        update={
            "duration_s": 2e-5,
            "step_s": 1e-6,
            "record_every": 5,
            "start": Start.model_validate(start),
            "drive": ConstantDrive(kind="constant", torque_N_m=[1.0] * joints),
        }
    )
    require_fit(scenario, own)
    runs = [
        RobotExperiment(build_robot_model(each, own, "geared"), scenario).simulate()
        for each in chains.ENGINES
    ]
    gap = runs[0].x_pr.values[0, 0, :3] - np.array([2e-5, 1.1e-5, 2.8e-5])
    assert gap == pytest.approx([1e-6, 0.0, -1e-6], abs=1e-18)
    (group,) = group_models([RobotMember(own, "geared", scenario)])
    chunks = list(group.chunks())
    for name in ("x_sp", "x_pr", "x_sp_dot", "x_pr_dot", "F_sp", "F_pr"):
        lanes = np.concatenate([getattr(chunk, name)[..., 0].copy() for chunk in chunks])
        values = [*(run[name].values for run in runs), lanes]
        size = np.nanmax(np.abs(values[0]))
        assert size > 0
        for other in values[1:]:
            np.testing.assert_allclose(other, values[0], rtol=0, atol=1e-9 * size)


def test_offsets_of_planets_fit_the_robot():
    start = Start.model_validate({"planet_offset_m": [[1e-6, 0.0], [], []]})
    scenario = make_rest_scenario().model_copy(update={"start": start})
    for own, needed in ((parted(), "needs 3 values"), (load_robot(PAPER), "planets = free")):
        for named, where in (("", scenario.name), ("own.toml", "own.toml")):
            with pytest.raises(InputError, match=needed) as refused:
                require_fit(scenario, own, named)
            assert refused.value.where == where


@pytest.mark.parametrize("level", RIGID)
@pytest.mark.parametrize("engine", chains.ENGINES)
def test_a_locked_stage_is_a_pair_of_rotors(engine, level):
    own = load_robot(PAPER)
    pair = replace_stages_by_rotors(own)
    assert [rotor.ratio for rotor in pair.rotors[:2]] == pytest.approx([14 / 3, -1.75])
    (q, v, *_), one, other = (
        sample_states(own, 3, 0),
        build_robot_model(engine, own, level),
        build_robot_model(engine, pair, level),
    )
    answers: list[Callable[[RobotModel], np.ndarray]] = [
        lambda model: model.mass_matrix(q),
        lambda model: model.bias(q, v),
        lambda model: model.momentum(q, v),
    ]
    for answer in answers:
        assert answer(one) == pytest.approx(answer(other), rel=1e-12, abs=1e-12)
