"""Exudyn's tree with its connectors, by three of its integrators."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar

import numpy as np

from benchmarks.suite.solver import Solver
from benchmarks.suite.solver_project import coordinates
from crosscheck.analytic.model import PhysicalModel
from crosscheck.models.exudyn.engine import Engine, exudyn
from crosscheck.models.exudyn.tree.tree import ExudynTree

SMALLEST_S = 1e-12  # step of DOPRI5: at its default it may halve one for ever


class ExudynIntegrator(ExudynTree):
    """By an integrator of the engine."""

    method: ClassVar[str]


class RungeKutta(ExudynIntegrator):
    """RK44, fixed step: the model as it is."""

    method = "RK44"


class DormandPrince(ExudynIntegrator):
    """DOPRI5, fixed step."""

    method = "DOPRI5"

    @cached_property
    def _driven_engine(self) -> Engine:
        engine = self._engine(self.gears)
        time = engine.settings.timeIntegration
        time.solverType = exudyn.DynamicSolverType.DOPRI5
        time.automaticStepSize, time.minimumStepSize = False, SMALLEST_S
        return engine


class GeneralizedAlpha(ExudynIntegrator):
    """Generalized-alpha, fixed step, Newton's method in every step."""

    method = "generalized-alpha"

    @cached_property
    def _driven_engine(self) -> Engine:
        engine = self._engine(self.gears)
        engine.solver = exudyn.MainSolverImplicitSecondOrder()
        engine.solver.InitializeSolver(engine.system, engine.settings)
        return engine


def make_tree_solver(
    model: PhysicalModel, grid: np.ndarray, made: type[ExudynIntegrator]
) -> Solver:
    """By one of the classes above, at a step [s]."""
    grid_s = float(grid[1] - grid[0])

    def run(step_s: float) -> np.ndarray:
        update = {"step_s": step_s, "record_every": round(grid_s / step_s)}
        scenario = model.scenario.model_copy(update=update)
        return coordinates(model, made(model.arm, scenario, model.switches).simulate())

    return Solver(f"Exudyn {made.method}", "step", run)
