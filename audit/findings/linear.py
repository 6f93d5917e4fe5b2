"""Linearised motion of the geared arm in contact, along the motion that its controller asks for.

Under `omega_t` the phase contains the current speed, d phi / d theta_c' = c t: stiffness and tooth
error turn a speed into a mesh force, a velocity feedback whose gain grows with the clock and whose
sign follows cos(phi). Under `angle` only d phi / d theta_c = c is there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from crosscheck.analytic.derivation.gears import Gears
from crosscheck.analytic.derivation.terms import Terms
from crosscheck.analytic.kernel.equations import TermEquations
from crosscheck.analytic.kernel.states import StateEvaluator
from crosscheck.analytic.model import AnalyticModel
from crosscheck.analytic.paper.mesh_frequency import OMEGA_T
from crosscheck.models.experiment.drive import PD, DriveData
from crosscheck.models.loading import Case
from crosscheck.registry import build

BASE_STEP_S = 1e-4
LARGEST_FOLDS = 200.0  # e^200: an amplitude beyond meaning, but finite


@dataclass(frozen=True)
class Plant:
    """A geared arm in an experiment; weights (meshes, n): of q or v t in the phase, per m or rad.

    The mesh phase is one linear form per mesh: phi = offset + w . q (law `angle`), or
    phi = offset + (w . v) t (law `omega_t`).
    """

    weights: np.ndarray
    equations: TermEquations

    @property
    def terms(self) -> Terms:
        """The terms of the equations."""
        return self.equations.terms

    @property
    def gears(self) -> Gears:
        """The gears of the equations."""
        return self.equations.gears

    @property
    def drive(self) -> DriveData:
        """The drive of the equations."""
        return self.equations.drive

    @property
    def is_clock_driven(self) -> bool:
        """Whether the phases go by the clock: law `omega_t`."""
        return self.gears.phase == OMEGA_T

    @cached_property
    def states(self) -> StateEvaluator:
        """The evaluator of what the equations say of states."""
        return StateEvaluator(self.equations)


def build_plant(model: AnalyticModel) -> Plant:
    """The plant of a model."""
    meshes = model.gears
    weights = np.zeros((meshes.x_index.size, len(model.coordinates)))
    weights[np.arange(meshes.x_index.size), meshes.theta] = meshes.rate
    return Plant(weights, model.term_equations)


class BaseMotion(NamedTuple):
    """The motion to linearise about: time (times,) [s]; q, v (times, n); force (times, meshes)."""

    time: np.ndarray
    q: np.ndarray
    v: np.ndarray
    force: np.ndarray


def compute_base_motion(case: Case, plant: Plant, every: int) -> BaseMotion:
    """The rigid arm's motion, every mesh pressed in just as far as it has to be to carry it.

    theta from the rigid level `coupled`; the mesh force from the rows of Eq. 21 for x, in which
    x'' = x' = 0; then x = e(phi) +- b + F / k(phi). No vibration, hence independent of damping.
    """
    update = {"step_s": BASE_STEP_S, "record_every": every}
    rigid = build("analytic:coupled", case.arm, case.scenario.model_copy(update=update)).simulate()
    time, n = rigid["time"].values, plant.weights.shape[1]
    q, v, a = (np.zeros((time.size, n)) for _ in range(3))
    for state, name in ((q, "theta"), (v, "theta_dot"), (a, "theta_ddot")):
        state[:, plant.terms.theta] = rigid[name].values
    gears, force = plant.gears, np.empty((time.size, plant.gears.x_index.size))
    for k, torque in enumerate(rigid["torque"].values):
        at = plant.states.evaluate(0.0, q[k], v[k])
        required_force = at.mass_matrix @ a[k] + at.bias - plant.terms.drive_map @ torque
        force[k] = np.linalg.solve(
            plant.terms.mesh_map[gears.x_index], required_force[gears.x_index]
        )
    sine = np.sin(phases(plant, time, q, v))
    stiffness = gears.k_m + gears.k_a * sine
    q[:, gears.x_index] = gears.E * sine + np.sign(force) * gears.b + force / stiffness
    return BaseMotion(time, q, v, force)


def phases(plant: Plant, time: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The mesh phase phi [rad], (times, meshes), along a motion q, v (times, n)."""
    moving = v * time[:, None] if plant.is_clock_driven else q
    return plant.gears.offset + moving @ plant.weights.T


def jacobian(plant: Plant, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The Jacobian d(q', q'') / d(q, q') with every mesh in contact, (2 n, 2 n)."""
    n, gears = q.size, plant.gears
    at = plant.states.evaluate(t, q, v)
    position = -_inertia_by_q(plant.terms, q, v, at.acceleration)
    rate = -_bias_by_v(plant.terms, q, v)
    # Per mesh, of F = k(phi) f_k(x - e(phi)): dF/dx = k, dF/dphi = k_a cos f_k - k E cos.
    phi = phases(plant, np.array([t]), q[None], v[None])[0]
    stiffness = gears.k_m + gears.k_a * np.sin(phi)
    gap = q[gears.x_index] - gears.E * np.sin(phi)
    pressed = gap - np.sign(gap) * gears.b
    by_phase = (gears.k_a * pressed - stiffness * gears.E) * np.cos(phi)
    position[:, gears.x_index] += plant.terms.mesh_map * stiffness
    turned = plant.terms.mesh_map @ (by_phase[:, None] * plant.weights)
    if plant.is_clock_driven:
        rate += turned * t
    else:
        position += turned
    rate[gears.x_index, gears.x_index] -= gears.d
    if plant.drive.code == PD:
        sensed, drive_map = plant.terms.theta, plant.terms.drive_map
        position[:, sensed] -= drive_map * plant.drive.gains[:, 1]
        rate[:, sensed] -= drive_map * plant.drive.gains[:, 2]
    lower = np.linalg.solve(at.mass_matrix, np.hstack([position, rate]))
    return np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower])


def _inertia_by_q(terms: Terms, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """The derivative d(M a + C v) / dq at constant v and a, (n, n)."""
    out, angle = np.zeros((q.size, q.size)), terms.angle_sums @ q
    for (row, column, wave), coeff in zip(terms.mass, terms.mass_coeff, strict=True):
        out[row] -= coeff * np.sin(angle[wave]) * a[column] * terms.angle_sums[wave]
    for (row, wave, i, j), coeff in zip(terms.bias, terms.bias_coeff, strict=True):
        out[row] += coeff * np.cos(angle[wave]) * v[i] * v[j] * terms.angle_sums[wave]
    return out


def _bias_by_v(terms: Terms, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The derivative d(C v) / dv, (n, n)."""
    out, angle = np.zeros((q.size, q.size)), terms.angle_sums @ q
    for (row, wave, i, j), coeff in zip(terms.bias, terms.bias_coeff, strict=True):
        factor = coeff * np.sin(angle[wave])
        out[row, i] += factor * v[j]
        out[row, j] += factor * v[i]
    return out


class Modes(NamedTuple):
    """Frozen mesh modes followed along the motion, (times, modes): growth [1/s], frequency [Hz]."""

    growth: np.ndarray
    frequency: np.ndarray

    @property
    def largest_growth(self) -> np.ndarray:
        """Growth rate [1/s] of the least stable mode, (times,)."""
        return self.growth.max(axis=1)


def compute_mesh_modes(plant: Plant, base: BaseMotion) -> Modes:
    """The oscillating eigenvalues of the Jacobian along the motion, each mode in its own column.

    A mode continues as the one whose shape, in rates, is most like its own at the instant before.
    """
    along = zip(base.time, base.q, base.v, strict=True)
    poles, shapes = np.linalg.eig(np.array([jacobian(plant, float(t), q, v) for t, q, v in along]))
    order = np.argsort(poles.imag, axis=1)[:, -plant.gears.x_index.size :]
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
