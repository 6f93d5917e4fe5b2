"""A run as the paper's measures read it: the joints, and the shoulder's first meshes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import Any

import numpy as np
import xarray as xr

from crosscheck.analytic.ensemble import Chunk, Group, groups
from crosscheck.analytic.model import AnalyticModel
from crosscheck.audit.measures.reading import case_of
from crosscheck.models.errors import Diverged
from crosscheck.models.loading import Case
from crosscheck.models.trajectory import recorded_times

JOINT_SIGNALS = ("theta", "theta_dot", "theta_ddot", "torque")
FORCES = ("F_sp", "F_pr")
MESH_SIGNALS = ("x_sp", "x_pr", *FORCES)
_NO_MESHES = [np.empty(0)] * (len(MESH_SIGNALS) + 1)


@dataclass(frozen=True)
class Course:
    """The signals of one run, in SI units.

    time (times,); theta, theta_dot, theta_ddot, torque (times, joints); x_sp, x_pr, F_sp, F_pr
    (times,): of the shoulder's first planet, F_outer (times, 2 (joints - 1)): F_sp, F_pr of the
    outer joints' first planets, all empty without gears; planets_apart_m: the largest difference
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
    planets_apart_m: float = field(default=0.0, kw_only=True)

    def at(self, time: np.ndarray) -> Course:
        """The course with its joints at other times, by straight lines; for smooth motion."""

        def taken(values: np.ndarray) -> np.ndarray:
            return np.array([np.interp(time, self.time, column) for column in values.T]).T

        joints: dict[str, Any] = {name: taken(getattr(self, name)) for name in JOINT_SIGNALS}
        return replace(self, time=time, **joints)


def course_of(run: xr.Dataset) -> Course:
    """The course of a trajectory, as any model gives it."""
    case = case_of(run)
    joints = [run[name].values for name in JOINT_SIGNALS]
    if "x_sp" not in run:
        return Course(case, run["time"].values, *joints, *_NO_MESHES)
    meshes = [run[name].values[:, 0, 0] for name in MESH_SIGNALS]
    outer = np.concatenate([run[name].values[:, 1:, 0] for name in FORCES], axis=1)
    apart = float(_apart(run["x_pr"].values))
    signals = [*joints, *meshes, outer]
    return Course(case, run["time"].values, *signals, planets_apart_m=apart)


def courses(models: Sequence[AnalyticModel]) -> list[Course | Diverged]:
    """Courses of many models, run side by side; memory holds of each only what a Course holds."""
    found: dict[int, Course | Diverged] = {}
    for group in groups(models):
        found |= zip(group.members, _of_group(group), strict=True)
    return [found[place] for place in range(len(models))]


def _of_group(group: Group) -> list[Course | Diverged]:
    """Courses of models that are stepped side by side, in the group's order."""
    time = recorded_times(group.models[0].scenario)
    geared = bool(group.models[0].layout.meshing)
    apart = np.zeros(len(group.models))
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
            apart = np.fmax(apart, _apart(chunk.x_pr))
    found = list[Course | Diverged]()
    for place, (model, at) in enumerate(zip(group.models, group.diverged_s, strict=True)):
        if not np.isnan(at):
            found.append(Diverged(model.name, float(at)))
            continue
        theta, theta_dot, theta_ddot, *meshes = (signal[..., place, :].T for signal in signals)
        joints = [theta, theta_dot, theta_ddot, model.torques(time, theta, theta_dot)]
        case, size = Case(model.arm, model.scenario, model.switches), float(apart[place])
        found.append(Course(case, time, *joints, *(meshes or _NO_MESHES), planets_apart_m=size))
    return found


def _signals(chunk: Chunk, geared: bool) -> list[np.ndarray]:
    """Signals of a chunk, those of the joints without torques.

    The joints' (records, joints, members), the shoulder's first meshes' (records, members), and
    the outer joints' mesh forces (records, pairs, members).
    """
    joints = [chunk.theta, chunk.theta_dot, chunk.theta_ddot]
    if not geared:
        return joints
    layout, forces = chunk.models[0].layout, (chunk.F_sp, chunk.F_pr)
    outer = np.concatenate([force[:, 1:, 0] for force in forces], axis=1)
    x_pr, *first = (each[:, 0, 0] for each in (chunk.x_pr, *forces))
    # With free planets no other sun mesh's displacement is worked out.
    sun = chunk.records.q[:, layout.at("x_s", 0)] if layout.free else None
    x_sp = chunk.x_sp[:, 0, 0] if sun is None else sun - x_pr
    return [*joints, x_sp, x_pr, *first, outer]


def _apart(x: np.ndarray) -> np.ndarray:
    """Largest difference between planets of a stage, x (times, joints, planets, ...) -> (...)."""
    planets = np.moveaxis(x, 2, 0)  # pair by pair: a reduction along so short an axis takes longer
    apart = reduce(np.maximum, planets) - reduce(np.minimum, planets)
    found: np.ndarray = reduce(np.maximum, np.moveaxis(apart, 1, 0)).max(axis=0)
    return found
