"""A run as the paper's measures read it: the joints, and the shoulder's first meshes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import Any

import numpy as np
import xarray as xr

from crosscheck.analytic.ensemble import Group, RunChunk, group_models
from crosscheck.analytic.model import AnalyticModel
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import Diverged
from crosscheck.models.experiment.drive import torques_along
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.loading import Case
from crosscheck.models.trajectory import recorded_times

JOINT_SIGNALS = ("theta", "theta_dot", "theta_ddot", "torque")
FORCES = ("F_sp", "F_pr")
MESH_SIGNALS = ("x_sp", "x_pr", *FORCES)
_NO_MESHES = [np.empty(0)] * (len(MESH_SIGNALS) + 1)


@dataclass(frozen=True)
class RunSignals:
    """The signals of one run, in SI units.

    time (times,); theta, theta_dot, theta_ddot, torque (times, joints); x_sp, x_pr, F_sp, F_pr
    (times,): of the shoulder's first planet, F_outer (times, 2 (joints - 1)): F_sp, F_pr of the
    outer joints' first planets, all empty without gears; planet_spread_m: the largest difference
    between planets of a stage in a mesh displacement.
    """

    case: Case
    time: np.ndarray
    theta: np.ndarray
    theta_dot: np.ndarray
    theta_ddot: np.ndarray
    torque: np.ndarray
    x_sp: np.ndarray
    x_pr: np.ndarray
    F_sp: np.ndarray
    F_pr: np.ndarray
    F_outer: np.ndarray
    planet_spread_m: float = field(default=0.0, kw_only=True)

    def at(self, time: np.ndarray) -> RunSignals:
        """The course with its joints at other times, by straight lines; for smooth motion."""

        def interpolate(values: np.ndarray) -> np.ndarray:
            return np.array([np.interp(time, self.time, column) for column in values.T]).T

        joints: dict[str, Any] = {name: interpolate(getattr(self, name)) for name in JOINT_SIGNALS}
        return replace(self, time=time, **joints)


def extract_signals(run: xr.Dataset) -> RunSignals:
    """The course of a trajectory, as any model gives it."""
    arm, scenario, switches = (json.loads(run.attrs[name]) for name in Case._fields)
    case = Case(
        Arm.model_validate(arm),
        Scenario.model_validate(scenario),
        Switches.model_validate(switches),
    )
    joints = [run[name].values for name in JOINT_SIGNALS]
    if "x_sp" not in run:
        return RunSignals(case, run["time"].values, *joints, *_NO_MESHES)
    meshes = [run[name].values[:, 0, 0] for name in MESH_SIGNALS]
    outer = np.concatenate([run[name].values[:, 1:, 0] for name in FORCES], axis=1)
    planet_spread = float(_planet_spread(run["x_pr"].values))
    signals = [*joints, *meshes, outer]
    return RunSignals(case, run["time"].values, *signals, planet_spread_m=planet_spread)


def simulate_signals(models: Sequence[AnalyticModel]) -> list[RunSignals | Diverged]:
    """Courses of many models, run side by side; memory holds of each only what a Course holds."""
    results: dict[int, RunSignals | Diverged] = {}
    for group in group_models(models):
        results |= zip(group.members, _simulate_group(group), strict=True)
    return [results[place] for place in range(len(models))]


def _simulate_group(group: Group[AnalyticModel]) -> list[RunSignals | Diverged]:
    """Courses of models that are stepped side by side, in the group's order."""
    time = recorded_times(group.models[0].scenario)
    geared = bool(group.models[0].layout.mesh_joints)
    planet_spread = np.zeros(len(group.models))
    signals: list[np.ndarray] = []  # each (..., members, times)
    first = 0
    for chunk in group.chunks():
        parts = _signals(chunk, geared)
        signals = signals or [np.empty((*part.shape[1:], time.size)) for part in parts]
        for whole, part in zip(signals, parts, strict=True):
            # Turned over in the processor's cache, then written: half the time of one assignment.
            whole[..., first : first + len(part)] = np.ascontiguousarray(np.moveaxis(part, 0, -1))
        first += len(chunk.time)
        if geared:
            planet_spread = np.fmax(planet_spread, _planet_spread(chunk.x_pr))
    results = list[RunSignals | Diverged]()
    for place, (model, at) in enumerate(zip(group.models, group.diverged_s, strict=True)):
        if not np.isnan(at):
            results.append(Diverged(model.name, float(at)))
            continue
        theta, theta_dot, theta_ddot, *meshes = (signal[..., place, :].T for signal in signals)
        joints = [theta, theta_dot, theta_ddot, torques_along(model.drive, time, theta, theta_dot)]
        case, size = Case(model.arm, model.scenario, model.switches), float(planet_spread[place])
        results.append(
            RunSignals(case, time, *joints, *(meshes or _NO_MESHES), planet_spread_m=size)
        )
    return results


def _signals(chunk: RunChunk, geared: bool) -> list[np.ndarray]:
    """Signals of a chunk, those of the joints without torques.

    The joints' (records, joints, members), the shoulder's first meshes' (records, members), and
    the outer joints' mesh forces (records, pairs, members).
    """
    joints = [chunk.theta, chunk.theta_dot, chunk.theta_ddot]
    if not geared:
        return joints
    outer = np.concatenate([force[:, 1:, 0] for force in (chunk.F_sp, chunk.F_pr)], axis=1)
    return [*joints, *(getattr(chunk, name)[:, 0, 0] for name in MESH_SIGNALS), outer]


def _planet_spread(x: np.ndarray) -> np.ndarray:
    """Largest difference between planets of a stage, x (times, joints, planets, ...) -> (...)."""
    planets = np.moveaxis(x, 2, 0)  # pair by pair: a reduction along so short an axis takes longer
    spread = reduce(np.maximum, planets) - reduce(np.minimum, planets)
    largest_spread: np.ndarray = reduce(np.maximum, np.moveaxis(spread, 1, 0)).max(axis=0)
    return largest_spread
