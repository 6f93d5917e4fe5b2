"""Linearised motion of the geared arm in contact, along the motion that its controller asks for.

Under `omega_t` the phase contains the current speed, d phi / d theta_c' = c t: stiffness and tooth
error turn a speed into a mesh force, a velocity feedback whose gain grows with the clock and whose
sign follows cos(phi). Under `angle` only d phi / d theta_c = c is there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from crosscheck.analytic.model import AnalyticModel
from crosscheck.analytic.paper.mesh_frequency import OMEGA_T
from crosscheck.registry import build

BASE_STEP_S = 1e-4
LARGEST_FOLDS = 200.0  # e^200: an amplitude beyond meaning, but finite
# Of differences: phi = 99 theta needs 1e-4 rad to change by 1 %, and a mesh is pressed in by
# 1e-5 m, so that contact lasts.
STEP_RAD, STEP_M = 1e-6, 1e-9


class BaseMotion(NamedTuple):
    """The motion to linearise about: time (times,) [s]; q, v (times, n)."""

    time: np.ndarray
    q: np.ndarray
    v: np.ndarray


def compute_base_motion(model: AnalyticModel, every: int) -> BaseMotion:
    """The rigid arm's motion, every mesh pressed in just as far as it has to be to carry it.

    theta from the rigid level `coupled`; the mesh force from the rows of Eq. 21 for x, in which
    x'' = x' = 0; then x = e(phi) +- b + F / k(phi). No vibration, hence independent of damping.
    """
    scenario = model.scenario.model_copy(update={"step_s": BASE_STEP_S, "record_every": every})
    rigid = build("analytic:coupled", model.arm, scenario).simulate()
    time, gears, terms = rigid["time"].values, model.gears, model.terms
    q, v, a = (np.zeros((time.size, len(model.layout))) for _ in range(3))
    for state, name in ((q, "theta"), (v, "theta_dot"), (a, "theta_ddot")):
        state[:, terms.theta] = rigid[name].values
    force = np.empty((time.size, gears.x_index.size))
    for k, torque in enumerate(rigid["torque"].values):
        at = model.states.evaluate(0.0, q[k], v[k])
        required_force = at.mass_matrix @ a[k] + at.bias - terms.drive_map @ torque
        force[k] = np.linalg.solve(terms.mesh_map[gears.x_index], required_force[gears.x_index])
    turning = v * time[:, None] if gears.phase == OMEGA_T else q
    sine = np.sin(gears.offset + gears.rate * turning[:, gears.theta])
    stiffness = gears.k_m + gears.k_a * sine
    q[:, gears.x_index] = gears.E * sine + np.sign(force) * gears.b + force / stiffness
    return BaseMotion(time, q, v)


def jacobian(model: AnalyticModel, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The Jacobian d(q', q'') / d(q, q') with every mesh in contact, (2 n, 2 n), by differences."""
    n = q.size
    state, steps = np.concatenate([q, v]), np.full(2 * n, STEP_RAD)
    steps[model.gears.x_index] = STEP_M

    def accelerate(state: np.ndarray) -> np.ndarray:
        return model.acceleration(t, state[:n], state[n:])

    changes = [accelerate(state + step) - accelerate(state - step) for step in np.diag(steps)]
    lower = np.transpose(changes) / (2 * steps)
    return np.vstack([np.eye(n, 2 * n, n), lower])


class Modes(NamedTuple):
    """Frozen mesh modes followed along the motion, (times, modes): growth [1/s], frequency [Hz]."""

    growth: np.ndarray
    frequency: np.ndarray


def compute_mesh_modes(model: AnalyticModel, base: BaseMotion) -> Modes:
    """The oscillating eigenvalues of the Jacobian along the motion, each mode in its own column.

    A mode continues as the one whose shape, in rates, is most like its own at the instant before.
    """
    along = zip(base.time.tolist(), base.q, base.v, strict=True)
    poles, shapes = np.linalg.eig(np.array([jacobian(model, *state) for state in along]))
    order = np.argsort(poles.imag, axis=1)[:, -model.gears.x_index.size :]
    poles = np.take_along_axis(poles, order, axis=1)
    shapes = np.take_along_axis(shapes, order[:, None, :], axis=2)
    rates = shapes[:, shapes.shape[1] // 2 :]
    rates = rates / np.linalg.norm(rates, axis=1, keepdims=True)
    columns = np.empty(poles.shape, dtype=np.int64)
    columns[0] = np.arange(poles.shape[1])
    for k in range(1, len(columns)):
        before = rates[k - 1][:, columns[k - 1]]
        columns[k] = linear_sum_assignment(-np.abs(before.conj().T @ rates[k]))[1]
    poles = np.take_along_axis(poles, columns, axis=1)
    return Modes(poles.real, poles.imag / (2 * np.pi))


def predicted_amplitude(
    time: np.ndarray, growth: np.ndarray, first: np.ndarray, floor: np.ndarray
) -> np.ndarray:
    """The vibration that frozen growth rates let grow, (times,), in the unit of ``floor``.

    Every mode, growth (times, modes) [1/s], starts at its ``first`` (modes,), follows the integral
    of its growth rate and never falls below its noise floor (modes,); the largest of them.
    """
    folds = np.diff(time)[:, None] * (growth[1:] + growth[:-1]) / 2
    level = np.full(growth.shape, np.log(np.maximum(first, floor)))
    for k, step in enumerate(folds):
        level[k + 1] = np.maximum(level[k] + step, np.log(floor))
    return np.exp(np.minimum(level.max(axis=1), LARGEST_FOLDS))
