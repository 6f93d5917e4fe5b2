"""A run as the paper's measures read it: the joints, and the shoulder's first meshes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import xarray as xr

from analytic.ensemble import Chunk, Group, groups
from analytic.model import AnalyticModel
from crosscheck.paper.reading import arm_of, scenario_of, switches_of
from models.errors import Diverged
from models.loading import Case

JOINT_SIGNALS = ("theta", "theta_dot", "theta_ddot", "torque")
FORCES = ("F_sp", "F_pr")
MESH_SIGNALS = ("x_sp", "x_pr", *FORCES)
_NO_MESHES = [np.empty(0)] * (len(MESH_SIGNALS) + 1)


@dataclass(frozen=True)
class Course:
    """Of one run, in SI units.

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
        """Its joints at other times, by straight lines between records; for smooth motion."""

        def taken(values: np.ndarray) -> np.ndarray:
            return np.array([np.interp(time, self.time, column) for column in values.T]).T

        return replace(
            self,
            time=time,
            theta=taken(self.theta),
            theta_dot=taken(self.theta_dot),
            theta_ddot=taken(self.theta_ddot),
            torque=taken(self.torque),
        )


def course_of(run: xr.Dataset) -> Course:
    """Of a trajectory, as any model gives it."""
    case = Case(arm_of(run), scenario_of(run), switches_of(run))
    joints = [run[name].values for name in JOINT_SIGNALS]
    if "x_sp" not in run:
        return Course(case, run["time"].values, *joints, *_NO_MESHES)
    meshes = [run[name].values[:, 0, 0] for name in MESH_SIGNALS]
    outer = np.concatenate([run[name].values[:, 1:, 0] for name in FORCES], axis=1)
    apart = float(_apart(run["x_pr"].values))
    signals = [*joints, *meshes, outer]
    return Course(case, run["time"].values, *signals, planets_apart_m=apart)


def courses(models: Sequence[AnalyticModel]) -> list[Course | Diverged]:
    """The runs of many models, side by side; of each only what a Course holds is ever in memory."""
    found: dict[int, Course | Diverged] = {}
    for group in groups(models):
        found |= zip(group.members, _of_group(group), strict=True)
    return [found[place] for place in range(len(models))]


def _of_group(group: Group) -> list[Course | Diverged]:
    geared = bool(group.models[0].layout.meshing)
    apart = np.zeros(len(group.models))
    time, parts = [], []
    for chunk in group.chunks():
        time.append(chunk.time)
        parts.append(_signals(chunk, geared))
        if geared:
            apart = np.fmax(apart, _apart(chunk.x_pr))
    times = np.concatenate(time)
    signals = [np.concatenate(signal) for signal in zip(*parts, strict=True)]
    found = [_of_member(m, place, group, times, signals) for place, m in enumerate(group.models)]
    return [
        replace(one, planets_apart_m=float(most)) if isinstance(one, Course) else one
        for one, most in zip(found, apart, strict=True)
    ]


def _signals(chunk: Chunk, geared: bool) -> list[np.ndarray]:
    """Of the joints (records, joints, members), of the shoulder's first meshes (records, members).

    Last those of the outer pairs (records, pairs, members). Copies: a chunk's own records do not
    outlive it.
    """
    joints = [np.array(getattr(chunk, name)) for name in JOINT_SIGNALS]
    if not geared:
        return joints
    outer = np.concatenate([getattr(chunk, name)[:, 1:, 0] for name in FORCES], axis=1)
    return [*joints, *(np.array(getattr(chunk, name)[:, 0, 0]) for name in MESH_SIGNALS), outer]


def _of_member(
    model: AnalyticModel, place: int, group: Group, time: np.ndarray, signals: Sequence[np.ndarray]
) -> Course | Diverged:
    if not np.isnan(group.diverged_s[place]):
        return Diverged(model.name, float(group.diverged_s[place]))
    own = [np.ascontiguousarray(signal[..., place]) for signal in signals]
    meshes = own[len(JOINT_SIGNALS) :] or _NO_MESHES
    case = Case(model.arm, model.scenario, model.switches)
    return Course(case, time, *own[: len(JOINT_SIGNALS)], *meshes)


def _apart(x: np.ndarray) -> np.ndarray:
    """Largest difference between planets of a stage, x (times, joints, planets, ...) -> (...)."""
    found: np.ndarray = (x.max(axis=2) - x.min(axis=2)).max(axis=(0, 1))
    return found
