"""The project's own ways to integrate: `simulate` and `precise` of the model."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import xarray as xr

from benchmarks.suite.solver import Solver
from crosscheck.analytic.ensemble import GROUP_SIZE, group_models
from crosscheck.analytic.model import PhysicalModel
from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.interface import Model


def change_step(model: PhysicalModel, grid: np.ndarray, step_s: float) -> Scenario:
    """The model's scenario at another step, recorded on the same grid (records,) [s]."""
    update = {"step_s": step_s, "record_every": round(float(grid[1] - grid[0]) / step_s)}
    return model.scenario.model_copy(update=update)


def make_step_solver(
    model: PhysicalModel,
    grid: np.ndarray,
    made: Callable[[Arm, Scenario, Switches], Model] = PhysicalModel,
    name: str = "simulate(), RK4",
) -> Solver:
    """What a class of models simulates at a step [s], with all that it records."""

    def run(step_s: float) -> np.ndarray:
        scenario = change_step(model, grid, step_s)
        return coordinates(model, made(model.arm, scenario, model.switches).simulate())

    return Solver(name, "step", run)


def make_ensemble_solver(model: PhysicalModel, grid: np.ndarray) -> Solver:
    """The fixed step of as many equal trajectories as a group has, on one core; states are kept."""

    def run(step_s: float) -> np.ndarray:
        scenario = change_step(model, grid, step_s)
        members = [PhysicalModel(model.arm, scenario, model.switches) for _ in range(GROUP_SIZE)]
        (group,) = group_models(members)
        states = np.concatenate([chunk.records.q for chunk in group.chunks()])
        return np.ascontiguousarray(states[:, :, 0])

    return Solver(f"RK4, {GROUP_SIZE} side by side", "step", run, GROUP_SIZE)


def make_precise_solver(model: PhysicalModel, grid: np.ndarray) -> Solver:
    """Steps that end at contact changes, at a relative tolerance, with all that is recorded."""

    def run(tolerance: float) -> np.ndarray:
        run_model = PhysicalModel(model.arm, model.scenario, model.switches)
        return coordinates(run_model, run_model.precise(tolerance))

    return Solver("precise()", "rtol", run)


def coordinates(model: PhysicalModel, run: xr.Dataset) -> np.ndarray:
    """q (records, n) in the lumped layout, from a trajectory; of planets the first."""
    data = {name: run[name].to_numpy() for name in ("theta", "x_sp", "x_pr")}
    columns = []
    for coordinate in model.layout.coordinates:
        of_joint = data[coordinate.meaning][:, coordinate.joint - 1]
        columns.append(of_joint if coordinate.is_angle else of_joint[:, 0])
    return np.stack(columns, axis=1)
