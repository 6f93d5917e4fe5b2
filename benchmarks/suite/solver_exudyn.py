"""Exudyn's tree with its connectors, by three of its integrators."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from benchmarks.suite.solver import Solver
from benchmarks.suite.solver_project import make_step_solver
from crosscheck.analytic.model import PhysicalModel
from crosscheck.models.exudyn.engine import Engine, exudyn
from crosscheck.models.exudyn.tree.tree import ExudynTree

SMALLEST_S = 1e-12  # step of DOPRI5: at its default it may halve one for ever


class DormandPrince(ExudynTree):
    """The tree by DOPRI5, fixed step."""

    @cached_property
    def _driven_engine(self) -> Engine:
        engine = self._engine(self.model.gears)
        time = engine.settings.timeIntegration
        time.solverType = exudyn.DynamicSolverType.DOPRI5
        time.automaticStepSize, time.minimumStepSize = False, SMALLEST_S
        return engine


class GeneralizedAlpha(ExudynTree):
    """The tree by generalized-alpha, fixed step, Newton's method in every step."""

    @cached_property
    def _driven_engine(self) -> Engine:
        engine = self._engine(self.model.gears)
        engine.solver = exudyn.MainSolverImplicitSecondOrder()
        engine.solver.InitializeSolver(engine.system, engine.settings)
        return engine


# RK44 is the tree's own.
INTEGRATORS = {"RK44": ExudynTree, "DOPRI5": DormandPrince, "generalized-alpha": GeneralizedAlpha}


def make_tree_solver(model: PhysicalModel, grid: np.ndarray, method: str) -> Solver:
    """The tree by one of the engine's integrators, at a step [s]."""
    return make_step_solver(model, grid, INTEGRATORS[method], f"Exudyn {method}")
