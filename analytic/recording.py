"""What a run of the plain kernel leaves behind, worked out along its recorded states."""

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
) -> tuple[np.ndarray, np.ndarray]:
    """(accelerations (times, n), mesh forces (times, meshes)) at states qs, vs (times, n)."""
    times, n = qs.shape
    accelerations, forces = np.empty((times, n)), np.empty((times, gears.where.size))
    for k in range(times):
        q, v = qs[k], vs[k]
        kernel.acceleration(terms, gears, drive, time[k], q, v, accelerations[k])
        kernel.elastic_forces(gears, time[k], q, v, forces[k])
    return accelerations, forces


@njit(cache=True)
def kinetic_energy(terms: Terms, qs: np.ndarray, vs: np.ndarray) -> np.ndarray:
    """(times,) [J] at states qs, vs (times, n)."""
    times, n = qs.shape
    energy, matrix = np.empty(times), np.empty((n, n))
    for k in range(times):
        kernel.mass_matrix(terms, qs[k], matrix)
        energy[k] = vs[k] @ (matrix @ vs[k]) / 2
    return energy
