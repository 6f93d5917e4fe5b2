"""A model's M: symmetric, positive definite, and what its bias follows from."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from crosscheck.checks.answers import Setting, ask, bias, mass_matrix
from crosscheck.checks.first_principles import slopes
from crosscheck.checks.sampled import DIFFERENCE, ModelQuestion, RobotLevel, Subjects
from crosscheck.checks.scales import check_share, share_of
from crosscheck.checks.states import is_usable, scale_mass_matrix
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
    for sampled in (*(each for each in subjects.arms if each.owes_laws), *subjects.robots):
        metric = f"{sampled.over('largest relative asymmetry')}; positive definite"
        yield sampled.plan_law("inertia", [mass_matrix], check_inertia, metric)
        questions: list[ModelQuestion] = [bias, christoffel_force]
        metric = sampled.over(DIFFERENCE)
        yield sampled.plan_law("bias-from-inertia", questions, check_bias, metric, AGAINST)


def check_inertia(about: Subject, mass: np.ndarray, setting: object) -> Finding:
    """Check that M (count, n, n) is symmetric and positive definite at every state."""
    for state, matrix in enumerate(mass, 1):
        if not (is_usable(matrix) and np.linalg.eigvalsh(scale_mass_matrix(matrix)).min() > 0):
            note = f"not positive definite at state {state} of {len(mass)}"
            return make_failed_check(about, note)
    size = np.sqrt(np.einsum("kii,kjj->kij", mass, mass))
    measured = float((np.abs(mass - mass.swapaxes(1, 2)) / size).max())
    basis = "rounding of sums over bodies; positive definite at every state"
    return check_share(about, measured, SYMMETRY, basis)


def check_bias(
    about: Subject, bias: np.ndarray, christoffel: np.ndarray, setting: Setting | RobotLevel
) -> Finding:
    """Check the bias against Christoffel's symbols of the model's own M, at the first states.

    What is summed: every term of the symbols, whose M are not larger than their natural sizes.
    """
    count, v = len(christoffel), np.abs(setting.first.v)
    size = np.einsum("sij,sj->si", setting.sizes.mass_matrix[:count], v)
    size = size * (v @ np.maximum(setting.turns, 1.0))[:, None]
    tolerance, reason = setting.slope_rule.tolerance, setting.slope_rule.reason
    basis = f"{tolerance:g} of what is summed: {reason}"
    return check_share(about, share_of(bias[:count] - christoffel, size), tolerance, basis)
