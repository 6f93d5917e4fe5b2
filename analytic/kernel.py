"""Eq. 21 compiled: M(q) q'' + C(q, q') q' + D q' = F, and its fourth-order Runge-Kutta.

All functions work in place on float64 arrays in SI units; `terms`, `gears` and `drive` are the
flat records of analytic.terms, analytic.gears and models.drive. Small functions are inlined:
a call that passes records of arrays counts references to each of them, which costs more than what
the function does (measured: 6.7 us a step without, 3.4 us with). What an evaluation needs to
write on is made once for all steps (2.5 us).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from analytic.gears import Gears
from analytic.mesh_force import in_contact, mesh_force, phase_force
from analytic.mesh_frequency import mesh_phase
from analytic.stiffness import stiffness, stiffness_slope
from analytic.terms import Terms
from analytic.tooth_error import whole_error
from models.drive import DriveData, joint_torque


class Scratch(NamedTuple):
    """What one evaluation writes on: M (n, n), C v (n,), cosine and sine of waves . q (waves,).

    filled (n,): which columns of a row are not 0.
    """

    matrix: np.ndarray
    gyroscopic: np.ndarray
    cosines: np.ndarray
    sines: np.ndarray
    filled: np.ndarray


@njit(cache=True, inline="always")
def scratch(terms: Terms) -> Scratch:
    """Room for evaluations of these terms."""
    waves, n = terms.waves.shape
    waved = np.empty(waves), np.empty(waves)
    return Scratch(np.empty((n, n)), np.empty(n), *waved, np.empty(n, dtype=np.int64))


@njit(cache=True, inline="always")
def wave_angle(waves: np.ndarray, wave: int, q: np.ndarray) -> float:
    """w . q [rad] of one wave; a loop, for it is too short to pay for a call into BLAS."""
    angle = 0.0
    for k in range(q.size):
        angle += waves[wave, k] * q[k]
    return angle


@njit(cache=True, inline="always")
def mass_matrix_by(terms: Terms, q: np.ndarray, cosines: np.ndarray, out: np.ndarray) -> None:
    """M(q) into out (n, n), the cosines of its waves into cosines (waves,)."""
    out[:] = 0.0
    for wave in range(cosines.size):
        cosines[wave] = np.cos(wave_angle(terms.waves, wave, q))
    for i in range(terms.mass.shape[0]):
        row, col, wave = terms.mass[i, 0], terms.mass[i, 1], terms.mass[i, 2]
        out[row, col] += terms.mass_coeff[i] * cosines[wave]


@njit(cache=True)
def mass_matrix(terms: Terms, q: np.ndarray, out: np.ndarray) -> None:
    """M(q) into out (n, n)."""
    mass_matrix_by(terms, q, np.empty(terms.waves.shape[0]), out)


@njit(cache=True, inline="always")
def bias_by(terms: Terms, q: np.ndarray, v: np.ndarray, sines: np.ndarray, out: np.ndarray) -> None:
    """C(q, v) v into out (n,), the sines of its waves into sines (waves,)."""
    out[:] = 0.0
    for wave in range(sines.size):
        sines[wave] = np.sin(wave_angle(terms.waves, wave, q))
    for i in range(terms.bias.shape[0]):
        row, wave = terms.bias[i, 0], terms.bias[i, 1]
        rates = v[terms.bias[i, 2]] * v[terms.bias[i, 3]]
        out[row] += terms.bias_coeff[i] * sines[wave] * rates


@njit(cache=True)
def bias(terms: Terms, q: np.ndarray, v: np.ndarray, out: np.ndarray) -> None:
    """C(q, v) v into out (n,)."""
    bias_by(terms, q, v, np.empty(terms.waves.shape[0]), out)


@njit(cache=True, inline="always")
def displacement(gears: Gears, i: int, q: np.ndarray) -> float:
    """x [m] of mesh i (or, of rates, x'): a coordinate, or the difference of two."""
    if gears.less[i] < 0:
        return q[gears.where[i]]
    return q[gears.where[i]] - q[gears.less[i]]


@njit(cache=True, inline="always")
def gap_of(gears: Gears, i: int, phase: float, sine: float, q: np.ndarray) -> float:
    """x - e [m] of mesh i at its phase [rad]."""
    lead, static = gears.lead[i], gears.static[i]
    return displacement(gears, i, q) - whole_error(phase, sine, gears.E[i], lead, static)


@njit(cache=True, inline="always")
def elastic_force(gears: Gears, i: int, gap: float, phase: float, sine: float) -> float:
    """Elastic force per planet [N] of mesh i by its gap x - e [m], at its phase [rad]."""
    k = stiffness(gears.law, i, phase, sine, gears.k_m[i], gears.k_a[i])
    return mesh_force(gears.dead_zone, gap, k, gears.b[i], gears.sigma[i])


@njit(cache=True, inline="always")
def elastic_forces(gears: Gears, t: float, q: np.ndarray, v: np.ndarray, out: np.ndarray) -> None:
    """Elastic force per planet [N] of every mesh into out (meshes,)."""
    for i in range(out.size):
        phase = phase_of(gears, i, t, q, v)
        sine = np.sin(phase)
        out[i] = elastic_force(gears, i, gap_of(gears, i, phase, sine, q), phase, sine)


@njit(cache=True)
def force_on_angle(gears: Gears, i: int, gap: float, phase: float, sine: float) -> float:
    """What the potential of mesh i, of all its planets, does to its joint's angle [N m]."""
    k = stiffness(gears.law, i, phase, sine, gears.k_m[i], gears.k_a[i])
    slope = stiffness_slope(gears.law, i, phase, gears.k_a[i])
    turn = np.cos(phase + gears.lead[i])
    on_phase = phase_force(gap, k, slope, gears.E[i] * turn, gears.b[i])
    return gears.planets[i] * gears.rate[i] * on_phase


@njit(cache=True, inline="always")
def phase_of(gears: Gears, i: int, t: float, q: np.ndarray, v: np.ndarray) -> float:
    """The argument [rad] of the sines of Eqs. 8 and 14 of mesh i."""
    joint = gears.theta[i]
    return mesh_phase(gears.phase, gears.rate[i], gears.offset[i], t, q[joint], v[joint])


@njit(cache=True, inline="always")
def torque(terms: Terms, drive: DriveData, j: int, t: float, q: np.ndarray, v: np.ndarray) -> float:
    """Output-side torque [N m] of joint j by its angle and rate."""
    sensed = terms.theta[j]
    return joint_torque(
        drive.code,
        drive.gains[j],
        drive.table_time,
        drive.table_torque[j],
        t,
        q[sensed],
        v[sensed],
    )


@njit(cache=True, inline="always")
def generalized_force(
    terms: Terms,
    gears: Gears,
    drive: DriveData,
    t: float,
    q: np.ndarray,
    v: np.ndarray,
    out: np.ndarray,
) -> None:
    """F - D v of Eqs. 21-22, friction and weight into out (n,)."""
    out[:] = 0.0
    for j in range(terms.drive_map.shape[1]):
        effort = torque(terms, drive, j, t, q, v)
        for place in range(terms.drive_rows.first[j], terms.drive_rows.first[j + 1]):
            row = terms.drive_rows.rows[place]
            out[row] += terms.drive_map[row, j] * effort
        out[terms.theta[j]] -= terms.friction[j] * v[terms.theta[j]]
    for i in range(terms.weight.shape[0]):
        angle = wave_angle(terms.waves, terms.weight[i, 1], q)
        pull = terms.weight_coeff[i, 0] * np.cos(angle) + terms.weight_coeff[i, 1] * np.sin(angle)
        out[terms.weight[i, 0]] += pull
    for i in range(gears.where.size):
        phase = phase_of(gears, i, t, q, v)
        sine = np.sin(phase)
        gap = gap_of(gears, i, phase, sine, q)
        force = elastic_force(gears, i, gap, phase, sine)
        for place in range(terms.mesh_rows.first[i], terms.mesh_rows.first[i + 1]):
            row = terms.mesh_rows.rows[place]
            out[row] += terms.mesh_map[row, i] * force
        if gears.damps_apart or in_contact(gap, gears.b[i]):
            damper = gears.d[i] * displacement(gears, i, v)
            out[gears.where[i]] -= damper
            if gears.less[i] >= 0:
                out[gears.less[i]] += damper
        if gears.conservative:
            out[gears.theta[i]] += force_on_angle(gears, i, gap, phase, sine)


@njit(cache=True, inline="always")
def solve(matrix: np.ndarray, right: np.ndarray, filled: np.ndarray) -> None:
    """Gaussian elimination with partial pivoting in place; the solution replaces `right`.

    For the few unknowns here a call into LAPACK costs more than the elimination itself. Only the
    columns of a pivot's row that are not 0, noted in filled (n,), are worked on: of gears two or
    three.
    """
    n = right.size
    for column in range(n):
        pivot = column
        for row in range(column + 1, n):
            if abs(matrix[row, column]) > abs(matrix[pivot, column]):
                pivot = row
        if pivot != column:
            for k in range(column, n):
                matrix[column, k], matrix[pivot, k] = matrix[pivot, k], matrix[column, k]
            right[column], right[pivot] = right[pivot], right[column]
        count = 0
        for k in range(column + 1, n):
            if matrix[column, k] != 0.0:
                filled[count] = k
                count += 1
        for row in range(column + 1, n):
            if matrix[row, column] == 0.0:
                continue
            factor = matrix[row, column] / matrix[column, column]
            for place in range(count):
                k = filled[place]
                matrix[row, k] -= factor * matrix[column, k]
            right[row] -= factor * right[column]
    for row in range(n - 1, -1, -1):
        for k in range(row + 1, n):
            right[row] -= matrix[row, k] * right[k]
        right[row] /= matrix[row, row]


@njit(cache=True, inline="always")
def acceleration_by(
    terms: Terms,
    gears: Gears,
    drive: DriveData,
    t: float,
    q: np.ndarray,
    v: np.ndarray,
    room: Scratch,
    out: np.ndarray,
) -> None:
    """q'' into out (n,), worked out in ``room``."""
    mass_matrix_by(terms, q, room.cosines, room.matrix)
    bias_by(terms, q, v, room.sines, room.gyroscopic)
    generalized_force(terms, gears, drive, t, q, v, out)
    for row in range(q.size):
        out[row] -= room.gyroscopic[row]
    solve(room.matrix, out, room.filled)


@njit(cache=True)
def acceleration(
    terms: Terms,
    gears: Gears,
    drive: DriveData,
    t: float,
    q: np.ndarray,
    v: np.ndarray,
    out: np.ndarray,
) -> None:
    """q'' into out (n,)."""
    acceleration_by(terms, gears, drive, t, q, v, scratch(terms), out)


class Stages(NamedTuple):
    """What a Runge-Kutta step writes on: a stage's q (n,), all stages' v and q'' (4, n)."""

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray


@njit(cache=True, inline="always")
def stages(n: int) -> Stages:
    """Room for the steps of n coordinates."""
    return Stages(np.empty(n), np.empty((4, n)), np.empty((4, n)))


@njit(cache=True, inline="always")
def runge_kutta_step(
    terms: Terms,
    gears: Gears,
    drive: DriveData,
    t: float,
    h: float,
    q: np.ndarray,
    v: np.ndarray,
    room: Scratch,
    s: Stages,
) -> None:
    """One classical fourth-order step [s] of (q, v), in place."""
    for stage in range(4):
        part = 0.0 if stage == 0 else h if stage == 3 else h / 2
        before = max(stage - 1, 0)
        for i in range(q.size):
            s.q[i] = q[i] + part * s.v[before, i] if stage else q[i]
            s.v[stage, i] = v[i] + part * s.a[before, i] if stage else v[i]
        acceleration_by(terms, gears, drive, t + part, s.q, s.v[stage], room, s.a[stage])
    for i in range(q.size):
        q[i] += h / 6 * (s.v[0, i] + 2 * s.v[1, i] + 2 * s.v[2, i] + s.v[3, i])
        v[i] += h / 6 * (s.a[0, i] + 2 * s.a[1, i] + 2 * s.a[2, i] + s.a[3, i])


@njit(cache=True)
def integrate(
    terms: Terms,
    gears: Gears,
    drive: DriveData,
    q0: np.ndarray,
    v0: np.ndarray,
    step: float,
    steps: int,
    stride: int,
) -> tuple[np.ndarray, np.ndarray]:
    """States every `stride` steps: q and v of shape (steps // stride + 1, n).

    Stops at the first record that is not finite; the records after it stay NaN.
    """
    records = steps // stride + 1
    qs, vs = np.full((records, q0.size), np.nan), np.full((records, q0.size), np.nan)
    q, v = q0.copy(), v0.copy()
    room, between = scratch(terms), stages(q.size)
    qs[0], vs[0] = q, v
    for k in range(steps):
        runge_kutta_step(terms, gears, drive, k * step, step, q, v, room, between)
        if (k + 1) % stride == 0:
            if not (np.isfinite(q).all() and np.isfinite(v).all()):
                break
            qs[(k + 1) // stride], vs[(k + 1) // stride] = q, v
    return qs, vs
