"""A model's weights: the slopes of their energy, and what moves against them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from crosscheck.checks.engines import gravity, momentum
from crosscheck.checks.robot_sizes import TOLERANCE
from crosscheck.checks.sampled import (
    RobotLevel,
    Subjects,
    ask,
    compute_slopes,
)
from crosscheck.checks.scales import EPS, check_share, share_of
from crosscheck.findings import Finding, Subject
from crosscheck.models.robot.interface import RobotModel
from crosscheck.planning.comparison import Comparison

ROUNDED = 100 * EPS  # rounding error of an energy, which sums masses at their heights


def energy_slopes(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Slopes of the energy at rest (first states, n)."""

    def energies(q: np.ndarray) -> np.ndarray:
        return ask(model, "energy", (len(q),), q, 0 * q)

    return compute_slopes(energies, case.first.q, case.steps).T


def plan(subjects: Subjects) -> Iterator[Comparison | str]:
    """Comparisons of each model's weights with its own energy and momentum."""
    for sampled in subjects.robots:
        if sampled.case.robot.gravity.any():
            questions = gravity, energy_slopes
            yield sampled.plan_case_law("gravity-from-energy", questions, _check_slopes)
            questions = gravity, momentum
            yield sampled.plan_case_law("linear-momentum", questions, _check_momentum)
    if subjects.robots and not subjects.robots[0].case.robot.gravity.any():
        yield "without gravity: no weights to hold against energy and linear momentum"


def _check_slopes(
    about: Subject, given: np.ndarray, slopes: np.ndarray, case: RobotLevel
) -> Finding:
    sizes, count = case.sizes, len(slopes)
    height = (sizes.energy - sizes.motion**2 / 2)[:count, None]
    least = ROUNDED * height / case.steps / TOLERANCE
    size = np.maximum(sizes.gravity[:count], least)
    basis = f"{TOLERANCE:g} of the torque's natural size, or what rounding leaves in the slopes"
    return check_share(about, share_of(given[:count] - slopes, size), TOLERANCE, basis)


def _check_momentum(
    about: Subject, given: np.ndarray, moving: np.ndarray, case: RobotLevel
) -> Finding:
    """Weights take the power -g . P from the motion, P the linear momentum."""
    pull, sizes = case.robot.gravity, case.sizes
    power = (given * case.states.v).sum(axis=1) + moving[:, :3] @ pull
    size = sizes.momentum[:, 0] * np.linalg.norm(pull)
    size = size + (np.abs(given) * np.abs(case.states.v)).sum(axis=1)
    basis = f"{TOLERANCE:g} of the powers that are summed"
    return check_share(about, share_of(power, size), TOLERANCE, basis)
