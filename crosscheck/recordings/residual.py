"""What a record's torques leave of models' inverse dynamics, in units of the record's noise.

The residual r = torque - ID(angles) is summed with every B-spline of the smoothing as a weight. Its
noise is that of the torques, and that of the angles through the accelerations of their splines:
neighbouring accelerations have correlated errors, and the sums' covariance has all of it. Divided
by its Cholesky factor the sums are independent, of variance one if the model is right.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.sparse import csr_array

from crosscheck.models.interface import Model
from crosscheck.recordings.smoothing import Block

RowsCallback = Callable[[int], None]
DIFFERENCE = 1e-6  # [rad, rad/s, rad/s^2]
ROUNDED = 1e-12  # of a covariance's mean variance: what keeps it definite


@dataclass(frozen=True)
class Fit:
    """How well one model explains a record.

    chi2: sum of squares of the residuals whitened by the model's own noise; freedom: its degrees of
    freedom; spread: logarithm of the determinant of that noise's covariance; left and noise
    (joints,) [N m]: rms of the smoothed residual, and what the record's noise makes of it.
    """

    chi2: float
    spread: float
    freedom: int
    left: np.ndarray
    noise: np.ndarray


def fit_models(
    blocks: Iterable[Block], models: Sequence[Model], on_rows: RowsCallback
) -> list[Fit]:
    """The fit of each model, over all blocks."""
    shape = len(models), len(models[0].arm.joints)
    chi2, spread, freedom, rows = np.zeros(len(models)), np.zeros(len(models)), 0, 0
    left, noise = np.zeros(shape), np.zeros(shape)
    for block in blocks:
        inverse = np.linalg.inv(block.gram)
        size, joints = len(block.gram), shape[1]
        for number, model in enumerate(models):
            whiten, covariance = whitening(block, model)
            sums = block.summed(block.torques - model.inverse_dynamics(*block.motion))
            chi2[number] += (whiten(sums) ** 2).sum()
            spread[number] += np.linalg.slogdet(covariance)[1]
            left[number] += np.einsum("kj,kl,lj->j", sums, inverse, sums)
            for joint in range(joints):
                part = slice(joint * size, (joint + 1) * size)
                noise[number, joint] += np.trace(inverse @ covariance[part, part])
        freedom += size * joints
        rows += len(block.time)
        on_rows(rows)
    return [
        Fit(float(each), float(wide), freedom, np.sqrt(of / rows), np.sqrt(by / rows))
        for each, wide, of, by in zip(chi2, spread, left, noise, strict=True)
    ]


@dataclass(frozen=True)
class NormalEquations:
    """Normal equations of a linear fit with columns A and residual r: A' A, A' r and r' r."""

    matrix: np.ndarray
    right: np.ndarray
    chi2: float
    freedom: int

    def leading(self, count: int) -> NormalEquations:
        """The equations of the first columns alone."""
        return replace(self, matrix=self.matrix[:count, :count], right=self.right[:count])

    def left(self, better: float) -> float:
        """Chi squared per degree of freedom of a fit that lowers chi squared by so much."""
        return (self.chi2 - better) / self.freedom


def build_normal_equations(
    blocks: Iterable[Block],
    model: Model,
    changed: Sequence[tuple[Model, float]],
    on_rows: RowsCallback,
    *,
    coulomb: bool = False,
) -> NormalEquations:
    """Normal equations for what should be added to the parameters.

    Args:
        changed: Models with one parameter larger by so much, on which the torques depend linearly.
        on_rows: Called with the number of rows that are done.
        coulomb: Whether columns for a Coulomb friction [N m] of every joint follow.
    """
    joints = len(model.arm.joints) if coulomb else 0
    count, freedom, chi2, rows = len(changed) + joints, 0, 0.0, 0
    matrix, right = np.zeros((count, count)), np.zeros(count)
    for block in blocks:
        whiten, _ = whitening(block, model)
        base = model.inverse_dynamics(*block.motion)
        residual = whiten(block.summed(block.torques - base))
        columns = []
        for other, by in changed:
            slope = (other.inverse_dynamics(*block.motion) - base) / by
            columns.append(whiten(block.summed(slope)))
        for joint in range(joints):
            slope = np.zeros_like(base)
            slope[:, joint] = np.sign(block.rates[:, joint])
            columns.append(whiten(block.summed(slope)))
        table = np.stack(columns, axis=1)
        matrix += table.T @ table
        right += table.T @ residual
        chi2 += residual @ residual
        freedom += residual.size
        rows += len(block.time)
        on_rows(rows)
    return NormalEquations(matrix, right, float(chi2), freedom)


def whitening(block: Block, model: Model) -> tuple[Callable[[np.ndarray], np.ndarray], np.ndarray]:
    """A function that divides sums (size, joints) by their noise; their covariance by joint."""
    slopes, joints, size = _slopes(model, block), block.angles.shape[1], len(block.gram)
    inverse = np.linalg.inv(block.gram)
    first = block.bases[0]
    # A row of the derivatives has its entries in the same columns as that of the basis.
    places = first.indices.reshape(len(block.time), -1)
    entries = [np.take_along_axis(each.toarray(), places, axis=1) for each in block.bases]
    # What a change of the splines' coefficients does to the sums.
    through = np.empty((joints, joints, size, size))
    for j, k in np.ndindex(joints, joints):
        rows = sum(slope[:, j, k, None] * each for slope, each in zip(slopes, entries, strict=True))
        changed = csr_array((np.ravel(rows), first.indices, first.indptr), first.shape)
        through[j, k] = (first.T @ changed).toarray()
    covariance = np.einsum(
        "l,jlab,bc,kldc->jakd", block.angle_noise**2, through, inverse, through, optimize=True
    )
    for joint, noise in enumerate(block.torque_noise):
        covariance[joint, :, joint, :] += noise**2 * block.gram
    flat = covariance.reshape(joints * size, joints * size)
    # Joints of other sizes: their variances are made alike before they are factored.
    scale = np.sqrt(np.diag(flat))
    alike = flat / np.outer(scale, scale) + ROUNDED * np.eye(len(flat))
    factor = cholesky(alike, lower=True)

    def whiten(sums: np.ndarray) -> np.ndarray:
        return solve_triangular(factor, sums.T.ravel() / scale, lower=True)

    return whiten, flat


def _slopes(model: Model, block: Block) -> list[np.ndarray]:
    """Slopes of the torques by angles, rates and accelerations, each (rows, joints, joints)."""
    here, slopes = model.inverse_dynamics(*block.motion), []
    for number, signal in enumerate(block.motion):
        columns = []
        for joint in range(signal.shape[1]):
            moved = [*block.motion]
            moved[number] = signal.copy()
            moved[number][:, joint] += DIFFERENCE
            columns.append((model.inverse_dynamics(*moved) - here) / DIFFERENCE)
        slopes.append(np.stack(columns, axis=2))
    return slopes
