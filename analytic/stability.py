"""The mesh modes, linearised in full contact, and the step that Runge-Kutta can take on them."""

from __future__ import annotations

import numpy as np

from crosscheck.analytic.derivation.gears import Gears, displacement_rows
from crosscheck.analytic.derivation.terms import Terms, mass_matrices
from crosscheck.models.experiment.drive import PD, DriveData

# RK4's stability function leaves the unit disc at 2.83 on the imaginary axis and 2.79 on the real.
_LARGEST_RADIUS = 3.0


def contact_eigenvalues(
    terms: Terms,
    gears: Gears,
    drive: DriveData,
    q: np.ndarray,
    stiffness: np.ndarray,
    sensor: np.ndarray | None = None,
) -> np.ndarray:
    """Eigenvalues [1/s] at pose q with every mesh in contact, shape (2 n,).

    stiffness [N/m], per mesh and planet; the controller's gains, friction and weight are included.
    sensor (n, joints): the controller receives sensor^T q in place of the joints' angles.
    """
    n = q.size
    mass = mass_matrices(terms, q)
    position, rate = np.zeros((n, n)), np.zeros((n, n))
    meshes = displacement_rows(gears, n)
    position += terms.mesh_map @ (stiffness[:, None] * meshes)
    rate -= meshes.T @ (gears.d[:, None] * meshes)
    rate[terms.theta, terms.theta] -= terms.friction
    for (row, wave), (cosine, sine) in zip(terms.weight, terms.weight_coeff, strict=True):
        angle = terms.angle_sums[wave] @ q
        position[row] += (sine * np.cos(angle) - cosine * np.sin(angle)) * terms.angle_sums[wave]
    if drive.code == PD:
        sensed = np.eye(n)[:, terms.theta] if sensor is None else sensor
        position -= terms.drive_map * drive.gains[:, 1] @ sensed.T
        rate -= terms.drive_map * drive.gains[:, 2] @ sensed.T
    zero, unit = np.zeros((n, n)), np.eye(n)
    lower = np.linalg.solve(mass, np.hstack([position, rate]))
    return np.linalg.eigvals(np.vstack([np.hstack([zero, unit]), lower]))


def runge_kutta_limit(eigenvalues: np.ndarray) -> float:
    """Largest step [s] by which RK4 makes no mode grow that would not; inf if nothing moves.

    A mode that grows by itself limits the step as an undamped one of its frequency does.
    """
    damped = np.minimum(eigenvalues.real, 0.0) + 1j * eigenvalues.imag
    fastest = np.abs(damped).max(initial=0.0)
    if fastest == 0:
        return float("inf")
    steps = np.linspace(0, _LARGEST_RADIUS / fastest, 3001)[1:]
    z = steps[:, None] * damped
    growth = np.abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24).max(axis=1)
    unstable = growth > 1 + 1e-9  # rounding of the rigid motion's zero eigenvalues
    return float(steps[np.argmax(unstable) - 1]) if unstable.any() else float(steps[-1])
