"""How far each level is from the most detailed one: motors' torques, and the tip in free motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from crosscheck.checks.robots.case import RobotLevel, SampledRobot, ask, group_by_level
from crosscheck.checks.robots.engines import RUNS, inverse_dynamics
from crosscheck.findings import ComparisonKey, Finding, Subject, make_measurement
from crosscheck.models.robot.integration import integrate
from crosscheck.models.robot.interface import RobotModel
from crosscheck.planning.comparison import Comparison, make_comparison

RIGID_GEARS = "coupled"


def free_tips(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Places of the tip (runs, 3) [m] after a free motion of the first states, teeth centred."""
    q, v, _, torques = case.states.first(RUNS)
    q, v = (np.where(np.arange(q.shape[1]) < case.free, each, 0.0) for each in (q, v))
    ends, _ = integrate(model, q, v, lambda time: 0 * torques, case.motion_s, case.motion_steps)
    return ask(model, "tip", (len(q), 3), ends)


def plan(models: Sequence[SampledRobot]) -> Iterator[Comparison]:
    """Measurements of the first engine's levels beside its last, and beside rigid gears."""
    chain = [some[0] for some in group_by_level(models).values()]
    finest = chain[-1]
    for sampled in chain[:-1]:
        yield _plan_tip(sampled, finest)
    if len(chain) > 1:
        (exact,) = (each for each in chain if each.case.level == RIGID_GEARS)
        for sampled in chain[: chain.index(exact)]:
            for column in range(exact.case.free):
                yield _plan_torque(sampled, exact, column)


def _plan_tip(sampled: SampledRobot, finest: SampledRobot) -> Comparison:
    case = sampled.case
    key = ComparisonKey("deviation", "free-motion", "tip", sampled.model, finest.model)
    metric = (
        f"largest distance of the tip after {case.motion_s:.2g} s of free motion, {RUNS} starts"
    )

    def judge(about: Subject, left: np.ndarray, right: np.ndarray) -> Finding:
        measured, reach = float(np.linalg.norm(left - right, axis=1).max()), case.sizes.tip.max()
        relative = measured / reach if reach else None
        return make_measurement(about, measured=measured, relative=relative)

    tasks = sampled.ask(free_tips), finest.ask(free_tips)
    return make_comparison(Subject(key, "m", metric), tasks, judge)


def _plan_torque(sampled: SampledRobot, exact: SampledRobot, column: int) -> Comparison:
    robot = sampled.case.robot
    joint = robot.joints[robot.coordinates[column]]
    unit = "N m" if joint.kind == "revolute" else "N"
    models = sampled.model, exact.model
    key = ComparisonKey("deviation", "random-states", "torque", *models, joint=column + 1)
    about = Subject(key, unit, sampled.over(f"largest difference of the torque of {joint.name}"))

    def judge(about: Subject, left: np.ndarray, right: np.ndarray) -> Finding:
        measured = float(np.abs(left - right)[:, column].max())
        largest = float(np.abs(right[:, column]).max())
        relative = measured / largest if largest else None
        return make_measurement(about, measured=measured, relative=relative)

    return make_comparison(about, [each.ask(inverse_dynamics) for each in (sampled, exact)], judge)
