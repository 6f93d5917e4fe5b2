"""Do the planets of a stage move alike? The paper says so by counting three of them as one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from crosscheck.paper.fluctuation import third_fluctuation
from crosscheck.paper.phase.experiments import ENGINE
from crosscheck.paper.phase.fluctuations import Fluctuation, one_start
from crosscheck.paper.rigid import beside_coupled
from crosscheck.registry import entry_of
from crosscheck.studies.study import Comparison, Numbers, Variant


def planet_spread(run: xr.Dataset) -> float:
    """Largest difference [m] between the planets of a stage in a mesh displacement."""
    spreads = [np.ptp(run[name].values, axis=2).max() for name in ("x_sp", "x_pr")]
    return float(max(spreads))


def fluctuation_and_spread(run: xr.Dataset, others: tuple[xr.Dataset, ...]) -> Numbers:
    """The third fluctuation, and how far the planets were apart."""
    return {**third_fluctuation(run, others), "planet_spread_m": planet_spread(run)}


FLUCTUATION_AND_SPREAD = Comparison(fluctuation_and_spread, beside_coupled)


@dataclass(frozen=True)
class InStep:
    """The same of Exudyn in the experiment of a variant, its planets held alike."""

    variant: Variant

    @property
    def inputs(self) -> str:
        return "\n".join(record.model_dump_json() for record in self.variant.case())

    @property
    def cost(self) -> float:
        return self.variant.case().scenario.steps * entry_of(ENGINE).call_s

    def answer(self) -> Fluctuation:
        return one_start(self.variant, self._numbers)

    def _numbers(self, others: tuple[xr.Dataset, ...]) -> Numbers:
        return fluctuation_and_spread(self._run(), others)

    def _run(self) -> xr.Dataset:
        """At every record the tree is set back to the mean of its planets.

        As the paper's equations have it; in between they part by rounding alone, so the projection
        adds no other force.
        """
        from models.exudyn_engine import Engine
        from models.exudyn_tree import ExudynTree

        class Tree(ExudynTree):
            def _advanced(self, engine: Engine, t: float) -> tuple[np.ndarray, np.ndarray]:
                q, v = super()._advanced(engine, t)
                return self.from_paper @ (self.to_paper @ q), self.from_paper @ (self.to_paper @ v)

        return Tree(*self.variant.case()).simulate()
