"""Do the planets of a stage move alike? The paper says so by counting three of them as one."""

from __future__ import annotations

import numpy as np
import xarray as xr

from crosscheck.paper.fluctuation import third_fluctuation
from crosscheck.paper.rigid import beside_coupled
from crosscheck.studies.study import Comparison, Numbers


def planet_spread(run: xr.Dataset) -> float:
    """Largest difference [m] between the planets of a stage in a mesh displacement."""
    spreads = [np.ptp(run[name].values, axis=2).max() for name in ("x_sp", "x_pr")]
    return float(max(spreads))


def fluctuation_and_spread(run: xr.Dataset, others: tuple[xr.Dataset, ...]) -> Numbers:
    """The third fluctuation, and how far the planets were apart."""
    return {**third_fluctuation(run, others), "planet_spread_m": planet_spread(run)}


FLUCTUATION_AND_SPREAD = Comparison(fluctuation_and_spread, beside_coupled)
