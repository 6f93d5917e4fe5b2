"""A model's M: symmetric, positive definite, and what its bias follows from."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from crosscheck.checks.invariants import check_inertia
from crosscheck.checks.robots.case import (
    RobotLevel,
    SampledRobot,
    ask,
    check_share,
    compute_slopes,
    plan_law,
    share_of,
)
from crosscheck.checks.robots.engines import bias, mass_matrix
from crosscheck.checks.robots.sizes import TOLERANCE
from crosscheck.findings import Finding, Subject
from crosscheck.models.robot.interface import RobotModel
from crosscheck.planning.comparison import Comparison


def christoffel_torques(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """The bias (first states, n) that follows from M's slopes, with no formula of a model."""

    def matrices(q: np.ndarray) -> np.ndarray:
        return ask(model, "mass_matrix", (*q.shape, q.shape[1]), q)

    q, v, *_ = case.first
    slopes = compute_slopes(matrices, q, case.steps)  # (n, states, n, n)
    moving = np.einsum("ksij,sk,sj->si", slopes, v, v)
    return moving - np.einsum("isjk,sj,sk->si", slopes, v, v) / 2


def plan(models: Sequence[SampledRobot]) -> Iterator[Comparison]:
    """Comparisons of each model's M with itself, and of its bias with M."""
    against = "Christoffel symbols of its own mass matrix"
    for sampled in models:
        yield plan_law(sampled, "inertia", [mass_matrix], _check_inertia)
        questions = bias, christoffel_torques
        yield plan_law(sampled, "bias-from-inertia", questions, _check_bias, against)


def _check_inertia(about: Subject, mass: np.ndarray, case: RobotLevel) -> Finding:
    return check_inertia(about, mass)


def _check_bias(
    about: Subject, given: np.ndarray, expected: np.ndarray, case: RobotLevel
) -> Finding:
    count, v = len(expected), np.abs(case.first.v)
    # What is summed: every term of Christoffel's, whose M are not larger than their roots.
    size = np.einsum("sij,sj->si", case.sizes.mass_matrix[:count], v)
    size = size * (v @ np.maximum(case.turns, 1.0))[:, None]
    basis = f"{TOLERANCE:g} of what is summed: differences of M of order 8 leave 3e-12"
    return check_share(about, share_of(given[:count] - expected, size), TOLERANCE, basis)
