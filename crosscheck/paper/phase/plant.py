"""The analytic model with what its scenario fixes set free: the clock, the start, the phase's rate.

The mesh phase is written as one linear form per mesh: phi = offset + w . q (law `angle`), or
phi = offset + (w . v) t (law `omega_t`), so that Eq. 11 in full is only another w than Eq. 12.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from analytic import kernel
from analytic.gears import Gears
from analytic.mesh_frequency import ANGLE, OMEGA_T
from analytic.model import AnalyticModel
from analytic.terms import Terms
from crosscheck.paper.stage import paper_stage
from models.drive import DriveData


class Plant(NamedTuple):
    """A geared arm in an experiment.

    gears: with the phases kept in ``offset``, which is overwritten at every evaluation; weights
    (meshes, n): w, in radians per metre or radian; offset (meshes,) [rad]; timed: law `omega_t`.
    """

    terms: Terms
    gears: Gears
    drive: DriveData
    weights: np.ndarray
    offset: np.ndarray
    timed: bool


def plant_of(model: AnalyticModel, full_rate: bool = False) -> Plant:
    """The model's plant; ``full_rate`` keeps the terms of Eq. 11 that Eq. 12 neglects."""
    meshes = model.gears
    weights = np.zeros((meshes.where.size, len(model.coordinates)))
    weights[np.arange(meshes.where.size), meshes.theta] = meshes.rate
    if full_rate:
        weights += neglected_weights(model)
    still = meshes._replace(
        rate=np.zeros_like(meshes.rate), offset=meshes.offset.copy(), phase=ANGLE
    )
    timed = meshes.phase == OMEGA_T
    return Plant(model.terms, still, model.drive, weights, meshes.offset.copy(), timed)


def neglected_weights(model: AnalyticModel) -> np.ndarray:
    """Eq. 11 less Eq. 12 [rad/m], (meshes, n): z_s / r_s on x_sp and x_pr; z_p / r_p on x_pr."""
    weights = np.zeros((model.gears.where.size, len(model.coordinates)))
    layout = model.layout
    for number, joint in enumerate(layout.meshing):
        stage = paper_stage(model.arm, joint)
        x_sp, x_pr = layout.at("x_sp", joint), layout.at("x_pr", joint)
        weights[2 * number, [x_sp, x_pr]] = stage.joint.sun_teeth / stage.geometry.r_s
        weights[2 * number + 1, x_pr] = stage.joint.planet_teeth / stage.geometry.r_p
    return weights


@njit(cache=True, inline="always")
def set_phases(plant: Plant, t: float, q: np.ndarray, v: np.ndarray) -> None:
    """phi of every mesh at time t [s] into the gears' ``offset``."""
    for i in range(plant.offset.size):
        total = 0.0
        for k in range(q.size):
            total += plant.weights[i, k] * (v[k] * t if plant.timed else q[k])
        plant.gears.offset[i] = plant.offset[i] + total


@njit(cache=True)
def acceleration(plant: Plant, t: float, q: np.ndarray, v: np.ndarray, out: np.ndarray) -> None:
    """q'' into out (n,)."""
    set_phases(plant, t, q, v)
    kernel.acceleration(plant.terms, plant.gears, plant.drive, t, q, v, out)


@njit(cache=True)
def forces_along(plant: Plant, time: np.ndarray, qs: np.ndarray, vs: np.ndarray) -> np.ndarray:
    """Elastic force per planet [N], (times, meshes), at states qs, vs (times, n)."""
    out = np.empty((time.size, plant.offset.size))
    for k in range(time.size):
        set_phases(plant, time[k], qs[k], vs[k])
        kernel.elastic_forces(plant.gears, time[k], qs[k], vs[k], out[k])
    return out


@njit(cache=True)
def accelerations_along(
    plant: Plant, time: np.ndarray, qs: np.ndarray, vs: np.ndarray
) -> np.ndarray:
    """q'' at states qs, vs (times, n)."""
    out = np.empty_like(qs)
    for k in range(time.size):
        acceleration(plant, time[k], qs[k], vs[k], out[k])
    return out


@njit(cache=True)
def integrate(
    plant: Plant, clock: float, q0: np.ndarray, v0: np.ndarray, step: float, steps: int, stride: int
) -> tuple[np.ndarray, np.ndarray]:
    """RK4 from any state, the clock at ``clock`` [s] at the start; q, v (steps // stride + 1, n).

    Records after the state has ceased to be finite stay NaN.
    """
    n, records = q0.size, steps // stride + 1
    qs, vs = np.full((records, n), np.nan), np.full((records, n), np.nan)
    q, v = q0.copy(), v0.copy()
    room, between = kernel.scratch(plant.terms), kernel.stages(n)
    qs[0], vs[0] = q, v
    for k in range(steps):
        _step(plant, clock + k * step, step, q, v, room, between)
        if (k + 1) % stride == 0:
            if not (np.isfinite(q).all() and np.isfinite(v).all()):
                break
            qs[(k + 1) // stride], vs[(k + 1) // stride] = q, v
    return qs, vs


@njit(cache=True, inline="always")
def _step(
    plant: Plant,
    t: float,
    h: float,
    q: np.ndarray,
    v: np.ndarray,
    room: kernel.Scratch,
    s: kernel.Stages,
) -> None:
    """``kernel.runge_kutta_step`` with the plant's phases."""
    for stage in range(4):
        part = 0.0 if stage == 0 else h if stage == 3 else h / 2
        before = max(stage - 1, 0)
        for i in range(q.size):
            s.q[i] = q[i] + part * s.v[before, i] if stage else q[i]
            s.v[stage, i] = v[i] + part * s.a[before, i] if stage else v[i]
        set_phases(plant, t + part, s.q, s.v[stage])
        kernel.acceleration_by(
            plant.terms, plant.gears, plant.drive, t + part, s.q, s.v[stage], room, s.a[stage]
        )
    for i in range(q.size):
        q[i] += h / 6 * (s.v[0, i] + 2 * s.v[1, i] + 2 * s.v[2, i] + s.v[3, i])
        v[i] += h / 6 * (s.a[0, i] + 2 * s.a[1, i] + 2 * s.a[2, i] + s.a[3, i])
