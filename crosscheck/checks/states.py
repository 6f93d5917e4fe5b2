"""Answers of two models to one question at the same states, beside their natural sizes."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.answers import Setting
from crosscheck.checks.sampled import RobotLevel
from crosscheck.checks.scales import check_share, share_of
from crosscheck.findings import Finding, Subject, make_measurement


def compare_answers(
    about: Subject, left: np.ndarray, right: np.ndarray, setting: Setting | RobotLevel
) -> Finding:
    """Check two answers (states, ...): every component at every state, by its natural size."""
    size = setting.sizes.natural_size(about.key.quantity, left)
    measured = share_of(left - right, size)
    return check_share(about, measured, *setting.sizes.limit(about.key.quantity))


def measure_answers(
    about: Subject, left: np.ndarray, right: np.ndarray, setting: Setting | RobotLevel
) -> Finding:
    """Measure how far models are apart that nobody expects to agree.

    An entry of M is measured by its natural size, a component of a vector (states, n) by its root
    mean square in the left answer: how wrong it is for those who use it, which rounding does not
    limit.
    """
    quantity = about.key.quantity
    size = setting.sizes.natural_size(quantity, left)
    if left.ndim == 2:
        rounding = setting.sizes.limit(quantity).value * size
        size = np.maximum(np.sqrt((left**2).mean(axis=0)), rounding)
    measured = share_of(left - right, size)
    return make_measurement(about, measured=measured, relative=measured)


def is_usable(mass: np.ndarray) -> bool:
    """Whether a mass matrix (n, n) can be scaled: its diagonal is positive."""
    return bool((np.diag(mass) > 0).all())


def scale_mass_matrix(inertia: np.ndarray) -> np.ndarray:
    """Mass matrices (..., n, n) with ones on their diagonals."""
    scale = 1 / np.sqrt(np.abs(np.einsum("...ii->...i", inertia)))
    return inertia * (scale[..., :, None] * scale[..., None, :])
