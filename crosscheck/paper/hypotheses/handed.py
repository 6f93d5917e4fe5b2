"""A vibration that has grown under the controller is handed over: does it live on the feedback?

From one and the same state the run goes on with the controller as it was, with the rigid arm's
torque played back, and with the controller looking at the sun. The plain kernel runs them with any
linear feedback T = P (target - y) - D y', y = sensor^T q.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from analytic import kernel
from analytic.fast.batch import Batch
from analytic.gears import Gears
from analytic.model import PhysicalModel
from analytic.terms import Terms
from crosscheck import signals
from crosscheck.paper.hypotheses.flutter import played_back
from crosscheck.paper.sampling.torque import fast
from crosscheck.studies.starts import perturbed
from crosscheck.studies.variant import Variant, spelled_out
from models.drive import CONSTANT, DriveData, drive_data

HANDED_S, AFTER_S = 0.9, 0.2  # when it is handed over, and how long it is watched
LAST_S, SMOOTHED_S = 0.05, 5e-3  # where it is measured; slower than the meshes' vibrations
STRIDE = 5


class Handed(NamedTuple):
    """Shoulder vibration [rad/s^2] of every start, AFTER_S later, by what drives the arm."""

    link: list[float]
    torque: list[float]
    sun: list[float]


@dataclass(frozen=True)
class Handover:
    """A Question: the variant's run under PD control, handed over at HANDED_S."""

    variant: Variant
    seeds: tuple[int, ...]

    @property
    def inputs(self) -> str:
        return spelled_out(self.variant.case(), repr(self.seeds))

    @property
    def cost(self) -> float:
        return 1.0 * len(self.seeds)

    def answer(self) -> Handed:
        case = self.variant.case()
        models = [PhysicalModel(*perturbed(case, seed)) for seed in self.seeds]
        table = drive_data(played_back(case, self.variant).scenario, len(case.arm.joints))
        later = table._replace(table_time=table.table_time - HANDED_S)
        found = [
            after(model, *state, later) for model, state in zip(models, grown(models), strict=True)
        ]
        return Handed(*map(list, zip(*found, strict=True)))


def grown(models: Sequence[PhysicalModel]) -> list[tuple[np.ndarray, np.ndarray]]:
    """The states q, v (n,) at HANDED_S."""
    steps = round(HANDED_S / models[0].scenario.step_s)
    *_, last = Batch(models).run(1, steps, 1)
    return [(last.q[-1, :, i].copy(), last.v[-1, :, i].copy()) for i in range(len(models))]


def after(
    model: PhysicalModel, q: np.ndarray, v: np.ndarray, table: DriveData
) -> tuple[float, float, float]:
    """The vibration left of a state: looking at the link, at nothing, at the sun."""
    gains, sun = model.drive.gains, model.terms.drive_map
    link = np.eye(len(model.layout))[:, model.layout.theta]
    still = DriveData(CONSTANT, np.zeros_like(gains), np.zeros(1), np.zeros((len(gains), 1)))
    ways = ((still, link, gains), (table, link, np.zeros_like(gains)), (still, sun, gains))
    loops = [Loop(model.terms, model.gears, *way) for way in ways]
    return tuple(_left(model, loop, q, v) for loop in loops)  # type: ignore[return-value]


def _left(model: PhysicalModel, loop: Loop, q: np.ndarray, v: np.ndarray) -> float:
    """Largest fast part [rad/s^2] of the shoulder's acceleration at the end; inf if it diverges."""
    step = model.scenario.step_s
    made = accelerations(loop, q, v, step, round(AFTER_S / step))
    time = STRIDE * step * np.arange(len(made))
    shoulder = made[:, model.layout.theta[0]]
    if not np.isfinite(shoulder).all():
        return np.inf
    return signals.amplitude(fast(time, shoulder, SMOOTHED_S)[time >= AFTER_S - LAST_S])


class Loop(NamedTuple):
    """An arm whose drive's torque is added to by gains (joints, 3) on sensor (n, joints)."""

    terms: Terms
    gears: Gears
    drive: DriveData
    sensor: np.ndarray
    gains: np.ndarray


@njit(cache=True)
def accelerations(
    loop: Loop, q0: np.ndarray, v0: np.ndarray, step: float, steps: int
) -> np.ndarray:
    """q'' at every STRIDE-th of the steps [s] from a state, (steps // STRIDE, n), by RK4."""
    q, v = q0.copy(), v0.copy()
    made = np.empty((steps // STRIDE, q.size))
    room, s = kernel.scratch(loop.terms), kernel.stages(q.size)
    for k in range(steps):
        for stage in range(4):
            part = 0.0 if stage == 0 else step if stage == 3 else step / 2
            before = max(stage - 1, 0)
            for i in range(q.size):
                s.q[i] = q[i] + part * s.v[before, i] if stage else q[i]
                s.v[stage, i] = v[i] + part * s.a[before, i] if stage else v[i]
            _acceleration(loop, k * step + part, s.q, s.v[stage], room, s.a[stage])
        if k % STRIDE == 0:
            made[k // STRIDE] = s.a[0]
        for i in range(q.size):
            q[i] += step / 6 * (s.v[0, i] + 2 * s.v[1, i] + 2 * s.v[2, i] + s.v[3, i])
            v[i] += step / 6 * (s.a[0, i] + 2 * s.a[1, i] + 2 * s.a[2, i] + s.a[3, i])
    return made


@njit(cache=True, inline="always")
def _acceleration(
    loop: Loop, t: float, q: np.ndarray, v: np.ndarray, room: kernel.Scratch, out: np.ndarray
) -> None:
    """``kernel.acceleration_by`` with the feedback's torque added."""
    terms, sensor, gains = loop.terms, loop.sensor, loop.gains
    kernel.mass_matrix_by(terms, q, room.cosines, room.matrix)
    kernel.bias_by(terms, q, v, room.sines, room.gyroscopic)
    kernel.generalized_force(terms, loop.gears, loop.drive, t, q, v, out)
    for j in range(gains.shape[0]):
        sensed, rate = 0.0, 0.0
        for i in range(q.size):
            sensed += sensor[i, j] * q[i]
            rate += sensor[i, j] * v[i]
        torque = gains[j, 1] * (gains[j, 0] - sensed) - gains[j, 2] * rate
        for i in range(q.size):
            out[i] += terms.drive_map[i, j] * torque
    for i in range(q.size):
        out[i] -= room.gyroscopic[i]
    kernel.solve(room.matrix, out, room.filled)
