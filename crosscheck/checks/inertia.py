"""A model's M: symmetric, positive definite, and what its bias follows from."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from crosscheck.checks import states
from crosscheck.checks.answers import Setting, ask, bias, mass_matrix
from crosscheck.checks.first_principles import slopes
from crosscheck.checks.robot_states import TOLERANCE
from crosscheck.checks.sampled import (
    DIFFERENCE,
    ModelQuestion,
    RobotLevel,
    SampledModel,
    Subjects,
)
from crosscheck.checks.scales import check_share, share_of
from crosscheck.checks.states import LOOSEST, is_usable, scale_mass_matrix
from crosscheck.findings import Finding, Subject, make_failed_check
from crosscheck.planning.comparison import Comparison

SYMMETRY = 1e-12
AGAINST = "Christoffel symbols of its own mass matrix"


def christoffel_force(model: Any, setting: Setting | RobotLevel) -> np.ndarray:
    """The bias (first states, n) that follows from M's slopes, with no formula of a model."""

    def matrices(q: np.ndarray) -> np.ndarray:
        return ask(model, "mass_matrix", (*q.shape, q.shape[1]), q)

    of_mass = slopes.compute_slopes(matrices, setting.first.q, setting.slope_rule)
    return slopes.christoffel_force(of_mass, setting.first.v)


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Comparisons of each model's M with itself, and of its bias with M."""
    for arm in subjects.arms:
        if arm.owes_laws:
            yield from _plan_laws(arm, _check_arm_bias, mass_matrix)
    for robot in subjects.robots:
        yield from _plan_laws(robot, _check_robot_bias)


def _plan_laws(
    sampled: SampledModel, check_bias: Callable[..., Finding], *sizes: ModelQuestion
) -> Iterator[Comparison]:
    """Comparisons of a model; check_bias is also given the answers that it takes sizes from."""
    metric = f"{sampled.over('largest relative asymmetry')}; positive definite"
    yield sampled.plan_law("inertia", [mass_matrix], check_inertia, metric)
    questions: list[ModelQuestion] = [bias, christoffel_force, *sizes]
    metric = sampled.over(DIFFERENCE)
    yield sampled.plan_law("bias-from-inertia", questions, check_bias, metric, AGAINST)


def check_inertia(about: Subject, mass: np.ndarray, setting: object) -> Finding:
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
