"""Weighted least squares over rows of correlated errors: blocks of rows are left out in turn."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.fft import irfft, rfft
from scipy.linalg import qr, solve_triangular
from scipy.special import stdtrit

from crosscheck.identification.sampling import ROWS

WEIGHTINGS = 3  # passes of weights by residuals
CONFIDENCE = 0.95  # confidence of an interval
MOST_BLOCKS, FEWEST_BLOCKS = 100, 20
# Blocks hold so many times for which residuals are alike: their sums are independent.
CORRELATION_TIMES = 4.0
TOGETHER = 1000  # rows of columns that are weighted at a time
LEAST_LEFT = 1.0  # least number of independent values of a joint
LEAST_FREE = 0.1  # least share of a residual's power at a frequency beside the columns
LOBES = 8  # lobes of a residual's correlation in the window that sums it
ALIKE = 1e6  # condition number of scaled columns from which on some of them are left out


@dataclass(frozen=True)
class LinearFit:
    """Estimates of linear parameters, with what they leave.

    values, errors (p,): estimates and their standard errors; pooled_errors (p,): these by one
    correlation of each joint's residual, all over the record, alone; taken, left (n,): how many
    independent values of each joint the parameters take up, and how many are left; freedom: that
    Student's distribution has; shown (rows, n): rows that count; sigma (n,): rms of each joint's
    residual; residual (rows, n); condition: of the columns, each scaled to size 1; weakest (p,):
    the direction, of those columns, that they show least; edges: first rows of the blocks, then the
    count of rows.
    """

    values: np.ndarray
    errors: np.ndarray
    pooled_errors: np.ndarray
    taken: np.ndarray
    left: np.ndarray
    freedom: int
    shown: np.ndarray
    sigma: np.ndarray
    residual: np.ndarray
    condition: float
    weakest: np.ndarray
    edges: np.ndarray

    @property
    def blocks(self) -> int:
        """Number of blocks of the record that errors are estimated by."""
        return len(self.edges) - 1

    @property
    def interval(self) -> float:
        """How many standard errors are half of a 95 % interval."""
        return self.quantile((1 + CONFIDENCE) / 2)

    @property
    def half_widths(self) -> np.ndarray:
        """Halves of 95 % intervals (p,)."""
        return self.errors * self.interval

    def quantile(self, probability: float) -> float:
        """The quantile of Student's distribution with the fit's degrees of freedom."""
        return float(stdtrit(self.freedom, probability))


class PartFit(NamedTuple):
    """The residual of a fit with some of the columns, weighted and in blocks as with all.

    name: what they are; parameters: how many in all; rms (n,): of each joint's residual [N m or N];
    weighted and predicted: rms in parts of the full fit's residual, of what was fitted, and of each
    block of the record as predicted from the others.
    """

    name: str
    parameters: int
    rms: np.ndarray
    weighted: float
    predicted: float


def fit_linear(
    columns: np.ndarray,
    torque: np.ndarray,
    shown: np.ndarray,
    starts: Sequence[int],
) -> LinearFit:
    """Fit torques by columns.

    Args:
        columns: Independent ones (rows, n, p).
        torque: What they shall make (rows, n).
        shown: Which of these say something (rows, n).
        starts: First rows of the recordings, then the count of rows.
    """
    torque, count = torque * shown, shown.sum(axis=0)
    scale, deviations = _column_sizes(columns, shown), joint_rms(torque, count)
    for _ in range(WEIGHTINGS):
        weights = deviations
        weighted = WeightedColumns(columns, shown / weights, scale)
        triangle, inverse, values = _solve(weighted, torque / weights)
        residual = torque - (columns @ values) * shown
        deviations = joint_rms(residual, count)
    edges = choose_blocks(residual, starts)
    changes, _ = _leave_out_blocks(weighted, inverse, residual / weights, edges)
    blocks = len(edges) - 1
    pooled, taken, left = _pool_variances(weighted, inverse, residual / weights, shown)
    inverse = inverse / scale[:, None]
    by_blocks = (blocks - 1) / blocks * ((changes @ inverse.T) ** 2).sum(axis=0)
    by_all = np.einsum("ij,jk,ik->i", inverse, pooled, inverse)
    _, singular, directions = np.linalg.svd(triangle)
    return LinearFit(
        values=values,
        errors=np.sqrt((by_blocks + by_all) / 2),
        pooled_errors=np.sqrt(by_all),
        taken=taken,
        left=left,
        freedom=2 * max(blocks - 1, 1),
        shown=shown,
        sigma=deviations,
        residual=residual,
        condition=float(singular[0] / singular[-1]),
        weakest=directions[-1],
        edges=edges,
    )


def fit_part(name: str, columns: np.ndarray, torque: np.ndarray, full: LinearFit) -> PartFit:
    """Fit torques (rows, n) by some of the columns (rows, n, part) that were fitted."""
    shown, sigma = full.shown, full.sigma
    weighted = WeightedColumns(columns, shown / sigma, _column_sizes(columns, shown))
    _, inverse, values = _solve(weighted, torque * shown / sigma)
    residual = (torque - columns @ values) * shown
    _, predicted = _leave_out_blocks(weighted, inverse, residual / sigma, full.edges)
    count = shown.sum(axis=0)
    sizes = (np.sqrt((each**2).sum() / count.sum()) for each in (residual / sigma, predicted))
    return PartFit(name, columns.shape[2], joint_rms(residual, count), *map(float, sizes))


def _solve(
    columns: WeightedColumns, right: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The triangle (p, p) of weighted columns, its inverse, and the values (p,) that fit best."""
    triangle = factor_columns(columns)
    inverse = solve_triangular(triangle, np.eye(len(triangle)))
    return triangle, inverse, inverse @ (inverse.T @ columns.project(right)) / columns.scale


@dataclass(frozen=True)
class WeightedColumns:
    """Columns (rows, n, p) times weights (rows, n), of length 1 by their lengths scale (p,).

    They are made a few rows at a time: all of them, once more, would be most of the memory.
    """

    columns: np.ndarray
    weights: np.ndarray
    scale: np.ndarray

    def select(self, first: int, last: int) -> np.ndarray:
        """These rows of all joints (rows n, p)."""
        part = self.columns[first:last] * self.weights[first:last, :, None]
        part /= self.scale
        return part.reshape(-1, len(self.scale))

    def pieces(self) -> Iterator[tuple[slice, np.ndarray]]:
        """All rows, some at a time, and which."""
        for first in range(0, len(self.columns), TOGETHER):
            rows = slice(first, first + TOGETHER)
            yield rows, self.select(rows.start, rows.stop)

    def project(self, right: np.ndarray) -> np.ndarray:
        """Products (p,) of the columns with a right-hand side (rows, n)."""
        return np.sum([piece.T @ right[rows].ravel() for rows, piece in self.pieces()], axis=0)


def factor_columns(columns: WeightedColumns) -> np.ndarray:
    """The triangle (p, p) that makes columns of an orthonormal basis of theirs."""
    triangle = np.zeros((0, len(columns.scale)))
    for _, piece in columns.pieces():
        rows = np.concatenate([triangle, piece])
        triangle = qr(rows, mode="r", check_finite=False)[0][: len(columns.scale)]
    return triangle


def find_condition(columns: np.ndarray, sigma: np.ndarray) -> float:
    """The condition number of columns (rows, n, p), each scaled to size 1, in weights 1 / sigma."""
    every = np.ones(columns.shape[:2], dtype=bool)
    weighted = WeightedColumns(columns, every / sigma, _column_sizes(columns, every))
    return float(np.linalg.cond(factor_columns(weighted)))


def _leave_out_blocks(
    columns: WeightedColumns, inverse: np.ndarray, remains: np.ndarray, edges: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Changes of the coefficients without each block, and the errors of predicting it.

    inverse (p, p): of the triangle, which makes the columns their orthonormal basis.
    """
    deviations, predicted = [], np.empty_like(remains)
    for first, last in pairwise(edges):
        part = columns.select(first, last) @ inverse
        gram = part.T @ part
        change = np.linalg.lstsq(
            np.eye(len(gram)) - gram, part.T @ remains[first:last].ravel(), rcond=1e-10
        )[0]
        deviations.append(-change)
        predicted[first:last] = remains[first:last] + (part @ change).reshape(-1, remains.shape[1])
    return np.array(deviations), predicted


def _pool_variances(
    columns: WeightedColumns, inverse: np.ndarray, remains: np.ndarray, shown: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The coefficients' variances (p, p), for residuals of one correlation over the record.

    Their correlations in a window, each joint's and between joints, are one for all rows, so that
    these variances vary less by chance than those of few blocks: an error of one position is in the
    torques of several joints. Then how many independent values of each joint the coefficients take
    up, and how many are left (n,).
    """
    rows, count = remains.shape
    taken, left, independent = np.empty((3, count))
    lobes = []
    for joint in range(count):
        correlation, reach = _correlate(remains[:, joint])
        alike = max(2 * _window(reach) @ correlation[:reach] ** 2 - 1, ROWS / 2)
        basis = _whiten(columns, inverse, joint)
        taken[joint] = (basis**2).sum()
        independent[joint] = shown[:, joint].sum() / alike
        left[joint] = max(independent[joint] - taken[joint], LEAST_LEFT)
        lobes.append(reach)
    # One window for all, of a spectrum that is nowhere negative, keeps variances positive.
    reach = min(max(lobes), rows)
    around = np.zeros(2 * rows)
    around[:reach] = _window(reach)
    around[2 * rows - reach + 1 :] = around[reach - 1 : 0 : -1]

    def smooth(power: np.ndarray) -> np.ndarray:
        smoothed: np.ndarray = rfft(irfft(power, 2 * rows) * around)
        return smoothed

    number = np.sqrt(np.maximum(shown.sum(axis=0), 1))
    spectra = rfft((remains - remains.mean(axis=0)) / number, 2 * rows, axis=0).T
    turned = [rfft(_whiten(columns, inverse, joint), 2 * rows, axis=0) for joint in range(count)]
    # Of residuals the columns have taken their share, most at the frequencies that they have.
    free = [
        1 - smooth((np.abs(each) ** 2).sum(axis=1) / n**2).real
        for each, n in zip(turned, number, strict=True)
    ]
    spectra /= np.sqrt(np.maximum(free, LEAST_FREE))
    both = np.full(rows + 1, 2.0)  # signs of a frequency
    both[[0, -1]] = 1.0
    total = np.zeros_like(inverse)
    for first in range(count):
        for second in range(first, count):
            power = smooth(spectra[first] * spectra[second].conj()) * both
            part = (turned[first].conj().T @ (power[:, None] * turned[second])).real
            total += part if first == second else part + part.T
    return total / (2 * rows), taken, left


def _whiten(columns: WeightedColumns, inverse: np.ndarray, joint: int) -> np.ndarray:
    """Rows (rows, p) of a joint in the columns' orthonormal basis."""
    rows: np.ndarray = (columns.columns[:, joint] * columns.weights[:, joint, None]) @ (
        inverse / columns.scale[:, None]
    )
    return rows


def choose_blocks(residual: np.ndarray, starts: Sequence[int]) -> np.ndarray:
    """First rows of blocks, then the count of rows: none spans two recordings.

    residual (rows, n): its correlation in time says how long blocks have to be.
    """
    rows = len(residual)
    length = CORRELATION_TIMES * max(
        count_alike_rows(residual[first:last], joint)
        for first, last in pairwise(starts)
        for joint in range(residual.shape[1])
    )
    length = min(max(length, rows / MOST_BLOCKS), rows / FEWEST_BLOCKS)
    edges = [0]
    for first, last in pairwise(starts):
        count = max(round((last - first) / length), 1)
        edges += np.linspace(first, last, count + 1).round().astype(int)[1:].tolist()
    return np.array(edges)


def count_alike_rows(residual: np.ndarray, joint: int) -> float:
    """The variance of a joint's mean residual over that of independent rows.

    The sum of its correlation in a window: of a band of noise the first lobe alone is 1.2 times the
    whole. At least 1.
    """
    correlation, reach = _correlate(residual[:, joint])
    return max(float(2 * _window(reach) @ correlation[:reach] - 1), 1.0)


def _window(reach: int) -> np.ndarray:
    """Parzen's weights of so many lags, from 0 on."""
    share = np.arange(reach) / reach
    return np.where(share < 0.5, 1 - 6 * share**2 * (1 - share), 2 * (1 - share) ** 3)


def _correlate(signal: np.ndarray) -> tuple[np.ndarray, int]:
    """A signal's correlation with itself, by rows between them, and how many of these count.

    They are some lobes, of which the first ends where it is first negative.
    """
    signal = signal - signal.mean()
    power = np.abs(np.fft.rfft(signal, 2 * len(signal))) ** 2
    correlation = np.fft.irfft(power)[: len(signal)]
    negative = np.flatnonzero(correlation <= 0)
    first = int(negative[0]) if negative.size else len(correlation)
    reach = max(min(LOBES * first, len(correlation)), 1)
    return correlation / (correlation[0] or 1.0), reach  # of nothing too


def joint_rms(values: np.ndarray, count: np.ndarray) -> np.ndarray:
    """Root mean square of each joint's values (n,), so many of which count; 1 where none do."""
    return _positive(np.sqrt((values**2).sum(axis=0) / np.maximum(count, 1)))


def _column_sizes(columns: np.ndarray, shown: np.ndarray) -> np.ndarray:
    """Lengths (p,) of columns (rows, n, p) in the rows that count; 1 for nothing but zeros."""
    squares = [(columns[counted, joint] ** 2).sum(axis=0) for joint, counted in enumerate(shown.T)]
    return _positive(np.sqrt(np.sum(squares, axis=0)))


def _positive(values: np.ndarray) -> np.ndarray:
    """The values, 1 in place of those that are 0."""
    return np.where(values > 0, values, 1.0)
