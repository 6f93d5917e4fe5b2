"""Eq. 21 at single states by NumPy, term by term: what machine code of the same terms must say."""

from typing import NamedTuple

import numpy as np

from crosscheck.analytic.derivation.gears import Gears
from crosscheck.analytic.derivation.terms import Terms
from crosscheck.analytic.paper.mesh_force import is_in_contact, mesh_force, phase_force
from crosscheck.analytic.paper.mesh_frequency import mesh_phase
from crosscheck.analytic.paper.stiffness import stiffness, stiffness_slope
from crosscheck.analytic.paper.tooth_error import total_error
from crosscheck.models.experiment.drive import DriveData, torques_along


class Parts(NamedTuple):
    """Of a model."""

    terms: Terms
    gears: Gears
    drive: DriveData


class Quantities(NamedTuple):
    """At a state: M (n, n), bias, force and accelerations (n,), elastic forces (meshes,) [N]."""

    mass_matrix: np.ndarray
    bias: np.ndarray
    force: np.ndarray
    acceleration: np.ndarray
    mesh_forces: np.ndarray


def quantities(parts: Parts, t: float, q: np.ndarray, v: np.ndarray) -> Quantities:
    """Of a model at time t [s] and a state q, v (n,)."""
    terms, n = parts.terms, q.size
    angle, mass, bias = terms.angle_sums @ q, np.zeros((n, n)), np.zeros(n)
    row, column, wave = terms.mass.T
    np.add.at(mass, (row, column), terms.mass_coeff * np.cos(angle[wave]))
    row, wave, a, b = terms.bias.T
    np.add.at(bias, row, terms.bias_coeff * np.sin(angle[wave]) * v[a] * v[b])
    force, elastic = _force(parts, t, q, v, angle)
    return Quantities(mass, bias, force, np.linalg.solve(mass, force - bias), elastic)


def _force(
    parts: Parts, t: float, q: np.ndarray, v: np.ndarray, angle: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    terms, gears, drive = parts
    theta = terms.theta
    torque = torques_along(drive, np.array([t]), q[None, theta], v[None, theta])[0]
    force = terms.drive_map @ torque
    force[theta] -= terms.friction * v[theta]
    row, wave = terms.weight.T
    turned = np.stack([np.cos(angle[wave]), np.sin(angle[wave])], axis=1)
    np.add.at(force, row, (terms.weight_coeff * turned).sum(axis=1))
    elastic = np.zeros(gears.x_index.size)
    for i in range(elastic.size):
        elastic[i] = _mesh(gears, i, t, q, v, force)
    return force + terms.mesh_map @ elastic, elastic


def _mesh(gears: Gears, i: int, t: float, q: np.ndarray, v: np.ndarray, force: np.ndarray) -> float:
    """Elastic force per planet [N]; damper and work on the angle are added to the force."""
    joint, row = gears.theta[i], np.zeros(q.size)
    row[gears.x_index[i]] = 1.0
    if gears.subtract_index[i] >= 0:
        row[gears.subtract_index[i]] = -1.0
    phase = mesh_phase(gears.phase, gears.rate[i], gears.offset[i], t, q[joint], v[joint])
    gap = row @ q - total_error(phase, gears.E[i], gears.error_phase[i], gears.static_error[i])
    k = stiffness(gears.law, i, phase, gears.k_m[i], gears.k_a[i])
    if gears.damps_without_contact or is_in_contact(gap, gears.b[i]):
        force -= gears.d[i] * (row @ v) * row
    if gears.conservative:
        slope = stiffness_slope(gears.law, i, phase, gears.k_a[i])
        error_slope = gears.E[i] * np.cos(phase + gears.error_phase[i])
        on_phase = phase_force(gap, k, slope, error_slope, gears.b[i])
        force[joint] += gears.planets[i] * gears.rate[i] * on_phase
    return float(mesh_force(gears.dead_zone, gap, k, gears.b[i], gears.sigma[i]))


def runge_kutta(
    parts: Parts, start: tuple[np.ndarray, np.ndarray], step: float, steps: int, stride: int
) -> tuple[np.ndarray, np.ndarray]:
    """States q, v (steps // stride + 1, n) from a start, by classical steps [s]."""
    state, n, kept = np.concatenate(start), start[0].size, [np.concatenate(start)]

    def rates(t: float, at: np.ndarray) -> np.ndarray:
        return np.concatenate([at[n:], quantities(parts, t, at[:n], at[n:]).acceleration])

    for k in range(steps):
        t = k * step
        one = rates(t, state)
        two = rates(t + step / 2, state + step / 2 * one)
        three = rates(t + step / 2, state + step / 2 * two)
        four = rates(t + step, state + step * three)
        state = state + step / 6 * (one + 2 * two + 2 * three + four)
        if (k + 1) % stride == 0:
            kept.append(state)
    whole = np.array(kept)
    return whole[:, :n], whole[:, n:]
