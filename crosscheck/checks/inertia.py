"""A model's M: symmetric, positive definite, and what its bias follows from."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from crosscheck.checks import states
from crosscheck.checks.answers import CHRISTOFFEL
from crosscheck.checks.engines import bias, mass_matrix
from crosscheck.checks.robot_states import TOLERANCE
from crosscheck.checks.sampled import (
    DIFFERENCE,
    RobotLevel,
    SampledModel,
    Subjects,
    ask,
    compute_slopes,
)
from crosscheck.checks.scales import check_share, share_of
from crosscheck.checks.states import LOOSEST, Setting, is_usable, scale_mass_matrix
from crosscheck.findings import Finding, Subject, make_failed_check
from crosscheck.models.robot.interface import RobotModel
from crosscheck.planning.comparison import Comparison

SYMMETRY = 1e-12
AGAINST = "Christoffel symbols of its own mass matrix"


def christoffel_torques(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """The bias (first states, n) that follows from M's slopes, with no formula of a model."""

    def matrices(q: np.ndarray) -> np.ndarray:
        return ask(model, "mass_matrix", (*q.shape, q.shape[1]), q)

    q, v, *_ = case.first
    slopes = compute_slopes(matrices, q, case.steps)  # (n, states, n, n)
    moving = np.einsum("ksij,sk,sj->si", slopes, v, v)
    return moving - np.einsum("isjk,sj,sk->si", slopes, v, v) / 2


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Comparisons of each model's M with itself, and of its bias with M."""
    for arm in subjects.arms:
        if arm.owes_laws:
            yield _plan_inertia(arm, "mass_matrix")
            judge = partial(_check_arm_bias, setting=arm.setting)
            yield _plan_bias(arm, ("bias", CHRISTOFFEL, "mass_matrix"), judge)
    for robot in subjects.robots:
        yield _plan_inertia(robot, mass_matrix)
        judge = partial(_check_robot_bias, case=robot.case)
        yield _plan_bias(robot, (bias, christoffel_torques), judge)


def _plan_inertia(sampled: SampledModel, question: Any) -> Comparison:
    metric = f"{sampled.over('largest relative asymmetry')}; positive definite"
    return sampled.plan_law("inertia", [question], check_inertia, metric)


def _plan_bias(
    sampled: SampledModel, questions: Sequence[Any], judge: Callable[..., Finding]
) -> Comparison:
    metric = sampled.over(DIFFERENCE)
    return sampled.plan_law("bias-from-inertia", questions, judge, metric, AGAINST)


def check_inertia(about: Subject, mass: np.ndarray) -> Finding:
    """Check that M (count, n, n) is symmetric and positive definite at every state."""
    for state, matrix in enumerate(mass, 1):
        if not (is_usable(matrix) and np.linalg.eigvalsh(scale_mass_matrix(matrix)).min() > 0):
            return make_failed_check(
                about, f"not positive definite at state {state} of {len(mass)}"
            )
    size = np.sqrt(np.einsum("kii,kjj->kij", mass, mass))
    measured = float((np.abs(mass - mass.swapaxes(1, 2)) / size).max())
    basis = "rounding of sums over bodies; positive definite at every state"
    return check_share(about, measured, SYMMETRY, basis)


def _check_arm_bias(
    about: Subject, bias: np.ndarray, christoffel: np.ndarray, mass: np.ndarray, setting: Setting
) -> Finding:
    """Check the bias against Christoffel's symbols of the model's own M, both (count, n)."""
    if not is_usable(mass[0]):
        return make_failed_check(about, "the mass matrix has a diagonal that is not positive")
    size = states.component_sizes(bias, states.natural_sizes("bias", bias, mass[0], setting))
    least = states.bias_rounding(mass[0], setting) / LOOSEST
    measured = float((np.abs(bias - christoffel) / np.maximum(size, least)).max())
    basis = f"{LOOSEST:g}, as for state checks: differences of M that are exact but for rounding"
    if (least > size).any():
        basis += f"; or, where more, {states.CANCELLING['bias']}"
    return check_share(about, measured, LOOSEST, basis)


def _check_robot_bias(
    about: Subject, given: np.ndarray, expected: np.ndarray, case: RobotLevel
) -> Finding:
    count, v = len(expected), np.abs(case.first.v)
    # What is summed: every term of Christoffel's, whose M are not larger than their roots.
    size = np.einsum("sij,sj->si", case.sizes.mass_matrix[:count], v)
    size = size * (v @ np.maximum(case.turns, 1.0))[:, None]
    basis = f"{TOLERANCE:g} of what is summed: differences of M of order 8 leave 3e-12"
    return check_share(about, share_of(given[:count] - expected, size), TOLERANCE, basis)
