"""Whether the engines agree on the torques of a recorded motion: Findings, as of every check.

Each model is asked at some rows, an arm's at each rigid level, a robot's at those that differ.
Without agreement nothing is judged.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

import numpy as np

from crosscheck.checks.answers import require_numbers
from crosscheck.checks.first_principles.christoffel import christoffel_force
from crosscheck.checks.first_principles.composite import arm_pose, build_parts, inertia, weight
from crosscheck.checks.robots.case import check_share, share_of
from crosscheck.findings import ComparisonKey, Finding, Subject
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.interface import Model
from crosscheck.models.pinocchio.regressor import LinkRegressor
from crosscheck.models.robot.robot import RIGID, Robot
from crosscheck.planning.comparison import (
    Comparison,
    Results,
    collect_tasks,
    judge_comparisons,
    make_comparison,
)
from crosscheck.planning.sizing import make_rest_scenario
from crosscheck.registry import (
    build,
    build_robot_model,
    find_covering_models,
    find_distinct_levels,
    find_level_engines,
    find_level_models,
)
from crosscheck.runner.outcomes import return_failures
from crosscheck.runner.workers import perform_all

ENGINE_ROWS = 1000
QUANTITY = "inverse_dynamics"
# Of the sum of the sizes of a torque's terms, times the arm's reach over its shortest link: engines
# sum the same terms in another order, and a short link's are small beside those that pass it. 300
# random arms were 1.5e-15 apart at most, 40 with a first link of a thousand lengths 1.5e-13.
ROUNDINGS = 1000 * float(np.finfo(float).eps)
ROBOT_TOLERANCE = 1e-10  # of the same sizes, of which rounding explains 1e-15
# First principles take differences of mass matrices in place of their slopes.
WITNESS_TOLERANCE = 1e-10
REFERENCE = "analytic"
REGRESSOR = "regressor:links"  # of Pinocchio, by which links are estimated
Motion = tuple[np.ndarray, np.ndarray, np.ndarray]  # positions, rates, accelerations (rows, n)
Witness = Callable[[dict[str, np.ndarray], list[np.ndarray]], str]


class TorqueModel(Protocol):
    """What tells the torques (rows, n) of a motion."""

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray: ...


NamedModel = tuple[str, Callable[[], TorqueModel]]  # and what builds it
Measure = Callable[[TorqueModel, Motion], np.ndarray]  # sums (rows, n) of the sizes of terms


@dataclass(frozen=True, eq=False)
class MotionTorques:
    """A task: the torques (rows, n) of a model along a motion."""

    model: str
    build: Callable[[], TorqueModel]
    motion: Motion

    @property
    def key(self) -> str:
        """The model: a comparison is of one motion."""
        return self.model

    @property
    def cost(self) -> float:
        """Estimated cost [s]."""
        return 0.05 + 5e-5 * self.motion[0].size

    @return_failures
    def perform(self) -> np.ndarray:
        """The torques, or a Failure where there are none."""
        answer = self.build().inverse_dynamics(*self.motion)
        return require_numbers(answer, "torques", self.motion[0].shape)


@dataclass(frozen=True, eq=False)
class ReferenceTorques(MotionTorques):
    """A task: the torques of a model, and the sizes of their terms."""

    measure: Measure

    @return_failures
    def perform(self) -> np.ndarray:
        """Torques, then the sums of the sizes of their terms (2, rows, n), or a Failure."""
        model, shape = self.build(), self.motion[0].shape
        torques = require_numbers(model.inverse_dynamics(*self.motion), "torques", shape)
        return np.stack([torques, self.measure(model, self.motion)])


class _RegressorModel:
    """The torques of a URDF's links by the regressor."""

    def __init__(self, robot: Robot) -> None:
        self._regressor = LinkRegressor(robot)

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        return self._regressor.compute(q, v, a) @ self._regressor.values


def build_rigid_model(level: str, arm: Arm, engine: str = REFERENCE) -> Model:
    """The model in an experiment without a drive: its inverse dynamics ask for motors' torques."""
    return build(f"{engine}:{level}", arm, make_rest_scenario())


def compare_arm_engines(motion: Motion, arm: Arm) -> list[Finding]:
    """Every engine's torques against the analytic ones, at each rigid level.

    Of two that differ, the note of the Finding says which stands alone.
    """
    lengths = [link.length_m for link in arm.links]
    tolerance = ROUNDINGS * sum(lengths) / min(lengths)
    able, still = set(find_covering_models("rigid", arm, usual_switches(arm))), make_rest_scenario()
    plans: list[Comparison] = []
    for level in find_distinct_levels(arm):
        models = [
            (name, partial(build, name, arm, still))
            for name in find_level_models(level)
            if name in able
        ]
        witness = partial(describe_outsider, arm, level)
        case = f"{arm.name}/{level}"
        plans += _plan_level(case, motion, models, _measure_terms, tolerance, witness)
    return _judge_all(plans)


def compare_robot_engines(robot: Robot, motion: Motion) -> list[Finding]:
    """Torques of every engine against the reference's, at each rigid level that differs.

    The regressor's torques of the URDF's links are among them.
    """
    return _judge_all(list(plan_robot_engines(robot, motion)))


def plan_robot_engines(robot: Robot, motion: Motion) -> Iterator[Comparison]:
    """The comparisons of ``compare_robot_engines``."""
    has_rotors = robot.rotors or robot.stages or robot.armature.any()
    for level in RIGID if has_rotors else RIGID[:1]:
        models: list[NamedModel] = [
            (f"{engine}:{level}", partial(build_robot_model, engine, robot, level))
            for engine in find_level_engines(level)
        ]
        if level == "links":
            models.append((REGRESSOR, partial(_RegressorModel, robot)))
        case, measure = f"{robot.name}/{level}", partial(_measure_link_terms, robot)
        yield from _plan_level(case, motion, models, measure, ROBOT_TOLERANCE)


def _plan_level(
    case: str,
    motion: Motion,
    models: Sequence[NamedModel],
    measure: Measure,
    tolerance: float,
    witness: Witness | None = None,
) -> Iterator[Comparison]:
    """Comparisons of the first model with the others; witness: what it says of two that differ."""
    rows = np.unique(np.linspace(0, len(motion[0]) - 1, ENGINE_ROWS).astype(int))
    q, v, a = (part[rows] for part in motion)
    reference = ReferenceTorques(*models[0], (q, v, a), measure)
    for each in models[1:]:
        task = MotionTorques(*each, (q, v, a))
        key = ComparisonKey("recording", case, QUANTITY, reference.model, task.model)
        about = Subject(key, "1", f"largest difference, over its terms' size, in {len(rows)} rows")

        def judge(about: Subject, expected: np.ndarray, torques: np.ndarray) -> Finding:
            apart, size = np.abs(torques - expected[0]), np.abs(expected).max(axis=(0, 1))
            size = np.where(size > 0, size, 1.0)
            basis = f"{tolerance:.2g} of the sum of the sizes of a torque's terms"
            finding = check_share(about, share_of(apart, size), tolerance, basis)
            if witness is None or finding.verdict == "agree":
                return finding
            row = int(np.argmax((apart / size).max(axis=1)))
            given = {about.key.left: expected[0][row], about.key.right: torques[row]}
            return replace(finding, note=witness(given, [part[row] for part in (q, v, a)]))

        yield make_comparison(about, (reference, task), judge)


def _judge_all(comparisons: Sequence[Comparison]) -> list[Finding]:
    outcomes = perform_all(collect_tasks(comparisons), os.cpu_count() or 1, lambda key: None)
    return list(judge_comparisons(comparisons, Results(outcomes)))


def _measure_terms(model: TorqueModel, motion: Motion) -> np.ndarray:
    """Sum (rows, n) of a torque's terms in size: weights, rates and each acceleration."""
    q, v, a = motion
    still = np.zeros_like(v)
    weights = model.inverse_dynamics(q, still, still)
    sizes = np.abs(weights) + np.abs(model.inverse_dynamics(q, v, still) - weights)
    for joint in range(q.shape[1]):
        single = still.copy()
        single[:, joint] = a[:, joint]
        sizes += np.abs(model.inverse_dynamics(q, still, single) - weights)
    return sizes


def _measure_link_terms(robot: Robot, model: TorqueModel, motion: Motion) -> np.ndarray:
    """Sum (rows, n) of the sizes of what each number of a link makes of a torque.

    Of a link that is alike all around its joint's axis the torque is nothing but what rounding
    leaves of these.
    """
    regressor = LinkRegressor(robot)
    sizes: np.ndarray = np.abs(regressor.compute(*motion)) @ np.abs(regressor.values)
    return sizes


def describe_engine(finding: Finding) -> str:
    """Whether an engine agrees with the reference, and how far it is from it."""
    verdict = "agrees with" if finding.verdict == "agree" else "DIFFERS from"
    return f"{finding.right} {verdict} {finding.left}: {format_difference(finding)}"


def describe_disagreement(engines: Sequence[Finding], what: str) -> Iterator[str]:
    """Who disagrees on the torques of what, who stands alone, and that nothing more is said."""
    wrong = [engine for engine in engines if engine.verdict != "agree"]
    # One that gave no number before those that are apart.
    worst = max(wrong, key=lambda engine: engine.measured or np.inf)
    yield (
        f"The engines do not agree on the {what}'s torques: {worst.right} and {worst.left},"
        f" {format_difference(worst)}. Nothing is said about the recording."
    )
    yield from (engine.note for engine in wrong if engine.measured is not None and engine.note)


def format_difference(finding: Finding) -> str:
    """How far an engine is from the reference, or why there is no number."""
    if finding.measured is None or finding.tolerance is None:
        return finding.note
    return (
        f"{finding.measured:.1e} of the torques' terms apart, at most {finding.tolerance:.1e} is"
        " rounding"
    )


def describe_outsider(
    arm: Arm, level: str, torques: dict[str, np.ndarray], state: list[np.ndarray]
) -> str:
    """Which of two models stands alone, by first principles, at a state where they differ."""
    alone = _find_disagreeing_models(torques, arm, level, state)
    if len(alone) == 1:
        (right,) = torques.keys() - set(alone)
        return f"{alone[0]} stands alone: {right} agrees with first principles."
    verdict = "both differ from first principles" if alone else "neither stands alone"
    return f"{' and '.join(sorted(torques))}: {verdict}."


def _find_disagreeing_models(
    torques: dict[str, np.ndarray], arm: Arm, level: str, state: list[np.ndarray]
) -> tuple[str, ...]:
    """Names of the models whose torques (joints,) at a state differ from first principles."""
    angles, rates, accelerations = state
    content = arm.model_dump(mode="json")
    parts = build_parts(content, level)

    def mass_matrix(at: np.ndarray) -> np.ndarray:
        return inertia(parts, arm_pose(content, at), locked=False)

    friction = np.array([joint.friction_N_m_s_per_rad for joint in arm.joints])
    terms = (
        mass_matrix(angles) * accelerations,
        christoffel_force(mass_matrix, angles, rates, np.ones(len(angles), dtype=bool))[:, None],
        -weight(parts, arm_pose(content, angles), content)[:, None],
        (friction * rates)[:, None],
    )
    every = np.hstack(terms)
    expected, sizes = every.sum(axis=1), np.abs(every).sum(axis=1)
    return tuple(
        name
        for name, model_torques in torques.items()
        if not share_of(model_torques - expected, sizes) <= WITNESS_TOLERANCE
    )
