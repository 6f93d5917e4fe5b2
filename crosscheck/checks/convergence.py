"""Observed order of convergence of each fixed-step integrator."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import xarray as xr

from crosscheck.checks.trajectories import largest_difference
from crosscheck.findings import Finding, checked, measured_only

# Three grids in their asymptotic range give the order to a few per cent of one.
ORDER_TOLERANCE = 0.2


def observed_order(runs: Sequence[xr.Dataset], quantity: str) -> float:
    """p from runs at h, h/2, h/4: differences shrink by 2^p (Richardson)."""
    coarse, middle, fine = runs
    first = largest_difference(coarse, middle, quantity)
    second = largest_difference(middle, fine, quantity)
    return math.log2(first / second) if first > 0 and second > 0 else math.nan


def order(case: str, runs: Sequence[xr.Dataset], formal: int, smooth: bool) -> Iterator[Finding]:
    """In smooth motion the formal order must show; through impacts it is measured."""
    name = runs[0].attrs["model"]
    observed = observed_order(runs, "x_sp")
    fields: dict[str, Any] = {
        "id": f"order/{case}/{name}",
        "quantity": "order of convergence",
        "unit": "1",
        "left": name,
        "right": f"formal order {formal}",
    }
    if not smooth:
        yield measured_only(
            measured=observed,
            basis="",
            metric="observed order in x_sp from steps h, h/2, h/4",
            note="the dead zone's kink leaves less than the formal order",
            **fields,
        )
        return
    yield checked(
        measured=abs(observed - formal),
        tolerance=ORDER_TOLERANCE,
        basis="three grids in the asymptotic range",
        metric="distance of the observed order in x_sp from the formal one",
        note=f"observed order {observed:.3f} from steps h, h/2, h/4",
        **fields,
    )
