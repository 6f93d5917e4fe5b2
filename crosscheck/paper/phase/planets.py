"""Do the planets of a stage move alike? The paper says so by counting three of them as one."""

from __future__ import annotations

import json

import numpy as np
import xarray as xr

from crosscheck.paper.fluctuation import third_fluctuation
from crosscheck.studies.study import Numbers
from models.arm import Arm
from models.scenario import Scenario
from models.switches import Switches


def planet_spread(run: xr.Dataset) -> float:
    """Largest difference [m] between the planets of a stage in a mesh displacement."""
    spreads = [np.ptp(run[name].values, axis=2).max() for name in ("x_sp", "x_pr")]
    return float(max(spreads))


def fluctuation_and_spread(run: xr.Dataset) -> Numbers:
    """The third fluctuation, and how far the planets were apart."""
    return {**third_fluctuation(run), "planet_spread_m": planet_spread(run)}


def in_step(run: xr.Dataset) -> Numbers:
    """The same of Exudyn in the experiment of ``run``, its planets held alike.

    At every record the tree is set back to the mean of its planets, as the paper's equations have
    it; in between they part by rounding alone, so the projection adds no other force.
    """
    from models.exudyn_engine import Engine
    from models.exudyn_tree import ExudynTree

    class InStep(ExudynTree):
        def _advanced(self, engine: Engine, t: float) -> tuple[np.ndarray, np.ndarray]:
            q, v = super()._advanced(engine, t)
            return self.from_paper @ (self.to_paper @ q), self.from_paper @ (self.to_paper @ v)

    arm = Arm.model_validate(json.loads(run.attrs["arm"]))
    scenario = Scenario.model_validate(json.loads(run.attrs["scenario"]))
    switches = Switches.model_validate(json.loads(run.attrs["switches"]))
    return fluctuation_and_spread(InStep(arm, scenario, switches).simulate())
