"""Differences as parts of a size, by which they are judged."""

from __future__ import annotations

import numpy as np

from crosscheck.findings import Finding, Subject, make_check


def share_of(difference: np.ndarray, size: np.ndarray) -> float:
    """The largest part of its size that a difference is, 1e300 at most.

    0 for none; no number where a value is none, or two runs diverged; that one did is huge.
    """
    difference = np.abs(difference)
    with np.errstate(invalid="ignore"):
        parts = np.where(difference == 0, 0.0, difference / np.maximum(size, 1e-300))
    return float(np.minimum(parts, 1e300).max(initial=0.0))


def check_share(about: Subject, measured: float, tolerance: float, basis: str) -> Finding:
    """The Finding of a difference that is a part of a size."""
    return make_check(about, measured=measured, tolerance=tolerance, basis=basis, relative=measured)
