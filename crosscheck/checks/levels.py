"""How far each level is from the most detailed one: runs, motors' torques, and the tip."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.checks.answers import ask, inverse_dynamics
from crosscheck.checks.engines import RUNS
from crosscheck.checks.sampled import (
    ExperimentPlan,
    RobotLevel,
    SampledRobot,
    Subjects,
    find_usual,
    group_models,
)
from crosscheck.checks.scales import geared_joints
from crosscheck.checks.trajectories import compute_difference, make_subject, measure_deviation
from crosscheck.findings import ComparisonKey, Finding, Subject, make_measurement
from crosscheck.models.arm.arm import Arm
from crosscheck.models.robot.integration import integrate
from crosscheck.models.robot.interface import RobotModel
from crosscheck.planning.comparison import Comparison, make_comparison

if TYPE_CHECKING:
    import xarray as xr

RIGID_GEARS = "coupled"


def free_tips(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Places of the tip (runs, 3) [m] after a free motion of the first states, teeth centred."""
    q, v, _, torques = case.states.first(RUNS)
    q, v = (np.where(np.arange(q.shape[1]) < case.free, each, 0.0) for each in (q, v))
    ends, _ = integrate(model, q, v, lambda time: 0 * torques, case.motion_s, case.motion_steps)
    return ask(model, "tip", (len(q), 3), ends)


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Measurements of each rigid level beside an arm's gears, or of a robot's beside its others."""
    for experiment in find_usual(subjects):
        for level, (engine, *_) in experiment.models.levels.items():
            is_arm_itself = not geared_joints(experiment.case.arm)
            if not (is_arm_itself and level in experiment.models.exact):
                yield from _plan_rigid_level(experiment, engine)
    if subjects.robots:
        yield from _plan_robot_levels([some[0] for some in group_models(subjects.robots)])


def _plan_rigid_level(experiment: ExperimentPlan, engine: str) -> Iterator[Comparison]:
    """Measurements of a rigid level beside the geared arm: joints, and tip."""
    first, arm = experiment.models.same[0], experiment.case.arm
    runs = experiment.run(engine), experiment.run(first)
    about = make_subject("deviation", experiment, "tip", engine, first)
    yield make_comparison(about, runs, partial(measure_tip_deviation, arm=arm))
    for joint in range(1, len(arm.joints) + 1):
        for quantity in ("theta", "theta_dot"):
            about = make_subject("deviation", experiment, quantity, engine, first, joint)
            yield make_comparison(about, runs, measure_deviation)


def _plan_robot_levels(chain: Sequence[SampledRobot]) -> Iterator[Comparison]:
    """Measurements of the first engine's levels beside its last, and beside rigid gears."""
    finest = chain[-1]
    for sampled in chain[:-1]:
        yield _plan_tip(sampled, finest)
    if len(chain) > 1:
        (exact,) = (each for each in chain if each.setting.level == RIGID_GEARS)
        for sampled in chain[: chain.index(exact)]:
            for column in range(exact.setting.free):
                yield _plan_torque(sampled, exact, column)


def _plan_tip(sampled: SampledRobot, finest: SampledRobot) -> Comparison:
    case = sampled.setting
    key = ComparisonKey("deviation", "free-motion", "tip", sampled.model, finest.model)
    after = f"after {case.motion_s:.2g} s of free motion, {RUNS} starts"
    metric = f"largest distance of the tip {after}"

    def judge(about: Subject, left: np.ndarray, right: np.ndarray) -> Finding:
        distances = np.linalg.norm(left - right, axis=1)
        return _measure_largest(about, distances, case.sizes.tip)

    tasks = sampled.ask(free_tips), finest.ask(free_tips)
    return make_comparison(Subject(key, "m", metric), tasks, judge)


def _plan_torque(sampled: SampledRobot, exact: SampledRobot, column: int) -> Comparison:
    robot = sampled.setting.robot
    joint = robot.joints[robot.coordinates[column]]
    unit = "N m" if joint.kind == "revolute" else "N"
    models = sampled.model, exact.model
    key = ComparisonKey("deviation", "random-states", "torque", *models, joint=column + 1)
    about = Subject(key, unit, sampled.over(f"largest difference of the torque of {joint.name}"))

    def judge(about: Subject, left: np.ndarray, right: np.ndarray) -> Finding:
        return _measure_largest(about, (left - right)[:, column], right[:, column])

    return make_comparison(about, [each.ask(inverse_dynamics) for each in (sampled, exact)], judge)


def _measure_largest(about: Subject, differences: np.ndarray, sizes: np.ndarray) -> Finding:
    """Measure the largest of some differences, also as a part of the largest of some sizes."""
    measured, largest = float(np.abs(differences).max()), float(np.abs(sizes).max())
    relative = measured / largest if largest else None
    return make_measurement(about, measured=measured, relative=relative)


def measure_tip_deviation(about: Subject, left: xr.Dataset, right: xr.Dataset, arm: Arm) -> Finding:
    """Measure the largest distance between the tips of two runs, and its share of the reach."""
    left_run, right_run = (run.assign(tip=tip_position(run, arm)) for run in (left, right))
    distances = np.linalg.norm(compute_difference(left_run, right_run, "tip"), axis=1)
    measured = float(np.fmax.reduce(distances))
    relative = measured / sum(link.length_m for link in arm.links)
    return make_measurement(about, measured=measured, relative=relative)


def tip_position(run: xr.Dataset, arm: Arm) -> xr.DataArray:
    """Position of the tip in the base frame, (time, axis) [m], from relative joint angles."""
    import xarray as xr

    absolute = run["theta"].cumsum("joint")
    lengths = xr.DataArray([link.length_m for link in arm.links], dims="joint")
    axes = [(lengths * turn(absolute)).sum("joint") for turn in (np.cos, np.sin)]
    return xr.concat(axes, "axis").transpose("time", "axis")
