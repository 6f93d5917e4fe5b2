"""What a run of the compiled kernel leaves behind, worked out along its recorded states."""

from __future__ import annotations

import numpy as np
from numba import njit

from analytic import kernel
from analytic.gears import Gears
from analytic.terms import Terms
from models.drive import DriveData


@njit(cache=True)
def along(
    terms: Terms, gears: Gears, drive: DriveData, time: np.ndarray, qs: np.ndarray, vs: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(accelerations (times, n), mesh forces (times, meshes), torques (times, joints),
    kinetic energy (times,)) at recorded states qs, vs of shape (times, n)."""
    times, n = qs.shape
    joints = terms.drive_map.shape[1]
    accelerations, forces = np.empty((times, n)), np.empty((times, gears.where.size))
    efforts, energy, matrix = np.empty((times, joints)), np.empty(times), np.empty((n, n))
    for k in range(times):
        q, v = qs[k], vs[k]
        kernel.acceleration(terms, gears, drive, time[k], q, v, accelerations[k])
        kernel.elastic_forces(gears, time[k], q, v, forces[k])
        for j in range(joints):
            efforts[k, j] = kernel.torque(terms, drive, j, time[k], q, v)
        kernel.mass_matrix(terms, q, matrix)
        energy[k] = v @ (matrix @ v) / 2
    return accelerations, forces, efforts, energy
