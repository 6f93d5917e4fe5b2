"""A second program for links that are possible bodies: NumPy and Pinocchio's regressors alone.

Pseudo-inertias are kept positive by their eigenvalues: least squares and the cone of positive
matrices in turn (alternating directions), without logarithms, triangles or second derivatives.
"""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from crosscheck.recordings.record import Record
from tests.measured.second_refinement import add_rotors, find_deviations, prior_rows
from tests.measured.second_robot import sample_rows

PENALTY, PASSES, AT_REST = 300.0, 20_000, 1e-10


def pseudo_inertia(values: np.ndarray) -> np.ndarray:
    """Of ten parameters of a body, as Pinocchio has it."""
    m, x, y, z, xx, xy, yy, xz, yz, zz = values
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    first = np.array([x, y, z])
    half = np.trace(inertia) / 2 * np.eye(3) - inertia
    return np.block([[half, first[:, None]], [first[None], np.array([[m]])]])


def fit_possible(
    urdf: str, given: Record, bandwidth: float, share: float, ratios: Sequence[float] | None
) -> tuple[float, np.ndarray, np.ndarray]:
    """Chi squared, links' parameters (10 each), and what is estimated beside them.

    ratios: of coupled rotors, None for armature.
    """
    signals = sample_rows(urdf, given.time, given.position, given.motor_torque, bandwidth)
    model, count = signals.model, signals.q.shape[1]
    weights = signals.moving / find_deviations(signals)
    table = signals.table()
    if ratios:
        table = add_rotors(model, table, ratios)
    precision, mean = prior_rows(model, share)
    bodies = 10 * count
    linear = table.shape[2]
    prior = np.hstack([np.diag(precision), np.zeros((bodies, linear - bodies))])
    whole = np.vstack([(table * weights[:, :, None]).reshape(-1, linear), prior])
    target = np.concatenate([(signals.torque * weights).ravel(), precision * mean])
    size = np.linalg.norm(whole, axis=0)
    basis, triangle = np.linalg.qr(whole / size)
    right = basis.T @ target
    scales = [_scale(body) for body in list(model.inertias)[1:]]
    cone = np.zeros((16 * count, linear))
    for place in range(bodies):
        body, number = divmod(place, 10)
        unit = pseudo_inertia(np.eye(10)[number]) / np.outer(scales[body], scales[body])
        cone[16 * body : 16 * body + 16, place] = unit.ravel() / size[place]
    inverse = np.linalg.inv(triangle.T @ triangle + PENALTY * cone.T @ cone)
    inside, summed = np.zeros(16 * count), np.zeros(16 * count)
    for _ in range(PASSES):
        values = inverse @ (triangle.T @ right + PENALTY * cone.T @ (inside - summed))
        eigenvalues, axes = np.linalg.eigh((cone @ values + summed).reshape(-1, 4, 4))
        nearest = (axes * np.maximum(eigenvalues, 0.0)[:, None, :]) @ axes.transpose(0, 2, 1)
        moved = np.abs(nearest.ravel() - inside).max()
        inside = nearest.ravel()
        summed = summed + cone @ values - inside
        if max(moved, np.abs(cone @ values - inside).max()) < AT_REST:
            break
    left = target - whole @ (values / size)
    found = values / size
    return float(left @ left), found[:bodies], found[bodies:]


def _scale(body: pin.Inertia) -> np.ndarray:
    """Sizes of a pseudo-inertia's rows."""
    radius = np.sqrt(np.trace(body.inertia) / body.mass)
    return np.sqrt(body.mass) * np.array([radius, radius, radius, 1.0])
