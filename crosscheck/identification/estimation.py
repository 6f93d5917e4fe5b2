"""Weighted least squares over rows of correlated errors: blocks of rows are left out in turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.linalg import cholesky, qr, solve_triangular
from scipy.special import stdtrit

WEIGHTINGS = 3  # passes of weights by residuals
CONFIDENCE = 0.95  # of an interval
MOST_BLOCKS, FEWEST_BLOCKS = 100, 20
# Blocks hold so many times for which residuals are alike: their sums are independent.
CORRELATION_TIMES = 4.0
ALIKE = 1e6  # condition number of scaled columns up to which products of them are exact enough


@dataclass(frozen=True)
class LinearFit:
    """Estimates of linear parameters, with what they leave.

    values (p,); covariance (p, p): by leaving out blocks in turn; freedom: that Student's
    distribution has; shown (rows, n): rows that count; sigma (n,): rms of each joint's residual;
    residual (rows, n); predicted_error (rows, n): residual of each block by estimates from all
    others; condition: of the columns, each scaled to size 1; weakest (p,): the direction, of those
    columns, that they show least; edges: first rows of the blocks, then the count of rows.
    """

    values: np.ndarray
    covariance: np.ndarray
    freedom: int
    shown: np.ndarray
    sigma: np.ndarray
    residual: np.ndarray
    predicted_error: np.ndarray
    condition: float
    weakest: np.ndarray
    edges: np.ndarray

    @property
    def rms(self) -> np.ndarray:
        """Root mean square of each joint's residual (n,)."""
        return joint_rms(self.residual, self.shown.sum(axis=0))

    @property
    def errors(self) -> np.ndarray:
        """Standard errors (p,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def half_widths(self) -> np.ndarray:
        """Halves of 95 % intervals (p,)."""
        return self.errors * self.quantile((1 + CONFIDENCE) / 2)

    def quantile(self, probability: float) -> float:
        """Of Student's distribution with the fit's degrees of freedom."""
        return float(stdtrit(self.freedom, probability))

    def weighted_rms(self, sigma: np.ndarray) -> float:
        """Root mean square of all joints' residuals, in parts of sigma (n,)."""
        return float(np.sqrt(((self.residual / sigma) ** 2).sum() / self.shown.sum()))

    def weighted_prediction_rms(self, sigma: np.ndarray) -> float:
        """The same of the errors of predicting each block from the others."""
        return float(np.sqrt(((self.predicted_error / sigma) ** 2).sum() / self.shown.sum()))


def fit_linear(
    columns: np.ndarray,
    torque: np.ndarray,
    shown: np.ndarray,
    starts: Sequence[int],
    *,
    sigma: np.ndarray | None = None,
    edges: np.ndarray | None = None,
) -> LinearFit:
    """Fit torques by columns.

    Args:
        columns: Independent ones (rows, n, p).
        torque: What they shall make (rows, n).
        shown: Which of these say something (rows, n).
        starts: First rows of the recordings, then the count of rows.
        sigma: Weights' inverse (n,); by the residuals if left out.
        edges: First rows of the blocks, then the count of rows; by the residuals if left out.
    """
    rows, n, p = columns.shape
    columns, torque = columns * shown[:, :, None], torque * shown
    count = shown.sum(axis=0)
    weights = sigma
    if weights is None:
        weights = estimate_deviations(columns, torque, count, WEIGHTINGS - 1)
    scale = _column_sizes(columns)
    weighted = (columns / (weights[:, None] * scale)).reshape(rows * n, p)
    right = (torque / weights).ravel()
    basis, triangle = factor_columns(weighted)
    coefficients = basis.T @ right
    remains = (right - basis @ coefficients).reshape(rows, n)
    residual = remains * weights
    edges = choose_blocks(residual, starts) if edges is None else edges
    deviations, predicted = _leave_out_blocks(basis.reshape(rows, n, p), remains, edges)
    blocks = len(edges) - 1
    spread = (blocks - 1) / blocks * deviations.T @ deviations
    inverse = solve_triangular(triangle, np.eye(p)) / scale[:, None]
    _, singular, directions = np.linalg.svd(triangle)
    return LinearFit(
        values=inverse @ coefficients,
        covariance=inverse @ spread @ inverse.T,
        freedom=max(blocks - 1, 1),
        shown=shown,
        sigma=joint_rms(residual, count) if sigma is None else sigma,
        residual=residual,
        predicted_error=predicted * weights,
        condition=float(singular[0] / singular[-1]),
        weakest=directions[-1],
        edges=edges,
    )


def estimate_deviations(
    columns: np.ndarray, torque: np.ndarray, count: np.ndarray, passes: int = WEIGHTINGS
) -> np.ndarray:
    """Root mean squares (n,) of what a fit leaves at each joint, weighted by these themselves.

    Rows of a joint have one weight, so that their products are summed once for all weights.

    Args:
        columns: Of the unknowns (rows, n, p), 0 in rows that do not count.
        torque: What they shall make (rows, n), 0 there too.
        count: How many rows of each joint count (n,).
        passes: Of weights by residuals, the first by the torques.
    """
    scale = _column_sizes(columns)
    by_joint = [columns[:, joint] for joint in range(columns.shape[1])]
    products = np.array([each.T @ each for each in by_joint]) / np.outer(scale, scale)
    right = [each.T @ made / scale for each, made in zip(by_joint, torque.T, strict=True)]
    deviations = joint_rms(torque, count)
    for _ in range(passes):
        weights = deviations**-2
        values = np.linalg.lstsq(
            np.tensordot(weights, products, 1), weights @ np.array(right), rcond=None
        )[0]
        deviations = joint_rms(torque - columns @ (values / scale), count)
    return deviations


def factor_columns(columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """An orthonormal basis (rows, p) of columns, and the triangle (p, p) that makes them of it.

    By Cholesky's factor of their products, twice (Yamamoto, Nakatsukasa, Yanagisawa and Fukaya,
    2015): as exact as reflections and several times as quick; by these where they are too alike.
    """
    basis, triangle = columns, np.eye(columns.shape[1])
    for _ in range(2):
        try:
            factor = cholesky(basis.T @ basis, check_finite=False)
        except np.linalg.LinAlgError:
            return _reflect(columns)
        if np.linalg.cond(factor) > ALIKE:
            return _reflect(columns)
        basis, triangle = basis @ np.linalg.inv(factor), factor @ triangle
    return basis, triangle


def _reflect(columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same by Householder's reflections."""
    basis, triangle = qr(columns, mode="economic", check_finite=False)
    return basis, triangle


def find_condition(columns: np.ndarray, sigma: np.ndarray) -> float:
    """The condition number of columns (rows, n, p), each scaled to size 1, in weights 1 / sigma."""
    scale = _column_sizes(columns)
    weighted = (columns / scale / sigma[:, None]).reshape(-1, columns.shape[2])
    return float(np.linalg.cond(qr(weighted, mode="r", check_finite=False)[0][: len(scale)]))


def _leave_out_blocks(
    basis: np.ndarray, remains: np.ndarray, edges: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """What leaving out each block changes of the coefficients; the errors of predicting it."""
    deviations, predicted = [], np.empty_like(remains)
    for first, last in pairwise(edges):
        part = basis[first:last].reshape(-1, basis.shape[2])
        gram = part.T @ part
        change = np.linalg.lstsq(
            np.eye(len(gram)) - gram, part.T @ remains[first:last].ravel(), rcond=1e-10
        )[0]
        deviations.append(-change)
        predicted[first:last] = remains[first:last] + (part @ change).reshape(last - first, -1)
    return np.array(deviations), predicted


def choose_blocks(residual: np.ndarray, starts: Sequence[int]) -> np.ndarray:
    """First rows of blocks, then the count of rows: none spans two recordings.

    residual (rows, n): its correlation in time says how long blocks have to be.
    """
    rows = len(residual)
    length = CORRELATION_TIMES * max(
        correlation_rows(residual[first:last], joint)
        for first, last in pairwise(starts)
        for joint in range(residual.shape[1])
    )
    length = min(max(length, rows / MOST_BLOCKS), rows / FEWEST_BLOCKS)
    edges = [0]
    for first, last in pairwise(starts):
        count = max(round((last - first) / length), 1)
        edges += np.linspace(first, last, count + 1).round().astype(int)[1:].tolist()
    return np.array(edges)


def correlation_rows(residual: np.ndarray, joint: int) -> float:
    """Rows for which a joint's residual is alike: the sum of its correlation to its first zero."""
    signal = residual[:, joint] - residual[:, joint].mean()
    power = np.abs(np.fft.rfft(signal, 2 * len(signal))) ** 2
    correlation = np.fft.irfft(power)[: len(signal)]
    if not correlation[0] > 0:
        return 1.0
    correlation = correlation / correlation[0]
    negative = np.flatnonzero(correlation <= 0)
    first = int(negative[0]) if negative.size else len(correlation)
    return float(1 + 2 * correlation[1:first].sum())


def joint_rms(values: np.ndarray, count: np.ndarray) -> np.ndarray:
    """Root mean square of each joint's values (n,), so many of which count; 1 where none do."""
    return _positive(np.sqrt((values**2).sum(axis=0) / np.maximum(count, 1)))


def _column_sizes(columns: np.ndarray) -> np.ndarray:
    """Lengths (p,) of columns (rows, n, p); 1 for those of nothing but zeros."""
    return _positive(np.sqrt(np.einsum("rnp,rnp->p", columns, columns)))


def _positive(values: np.ndarray) -> np.ndarray:
    """The values, 1 in place of those that are 0."""
    return np.where(values > 0, values, 1.0)
