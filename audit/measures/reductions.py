"""What is kept of a run where not all of it is needed."""

from __future__ import annotations

import xarray as xr


def first_planets(run: xr.Dataset) -> xr.Dataset:
    """The run with one planet per joint: the paper's model moves all of a joint alike."""
    return run.isel(planet=[0]) if "planet" in run.dims else run


def angles(run: xr.Dataset) -> xr.Dataset:
    """The joints' angles alone."""
    return run[["theta"]]
