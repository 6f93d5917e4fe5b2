"""Observed order of convergence of each fixed-step integrator."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.checks.trajectories import largest_difference
from crosscheck.findings import About, Finding, checked, measured_only

if TYPE_CHECKING:
    import xarray as xr


# Three grids in their asymptotic range give the order to a few per cent of one.
ORDER_TOLERANCE = 0.2


def observed_order(runs: Sequence[xr.Dataset], quantity: str) -> float:
    """p from runs at h, h/2, h/4: differences shrink by 2^p (Richardson)."""
    coarse, middle, fine = runs
    first = largest_difference(coarse, middle, quantity)
    second = largest_difference(middle, fine, quantity)
    return math.log2(first / second) if first > 0 and second > 0 else math.nan


def formal_order(about: About, runs: Sequence[xr.Dataset], formal: int, quantity: str) -> Finding:
    """In smooth motion the formal order must show."""
    observed = observed_order(runs, quantity)
    return checked(
        about,
        measured=abs(observed - formal),
        tolerance=ORDER_TOLERANCE,
        basis="three grids in the asymptotic range",
        note=f"observed order {observed:.3f} from steps h, h/2, h/4",
    )


def order_through_impacts(about: About, runs: Sequence[xr.Dataset], quantity: str) -> Finding:
    """Through impacts the order is measured."""
    note = "the dead zone's kink leaves less than the formal order"
    return measured_only(about, measured=observed_order(runs, quantity), note=note)


def stable_step(about: About, limit: np.ndarray, step_s: float) -> Finding:
    """The largest step that a plan takes with a model against the model's own limit [s], ()."""
    limit_s = float(limit)
    known = math.isfinite(limit_s)
    said = f"at most {limit_s:.3g} s are stable" if known else "and steps of any length are stable"
    basis = f"steps of {step_s:.3g} s, {said}"
    return checked(about, measured=step_s / limit_s, tolerance=1.0, basis=basis)
