"""Angles of a record as splines, with the noise that they leave and what it does to slopes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import BSpline, make_lsq_spline
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csr_array, diags_array, eye_array

from crosscheck.models.errors import InputError
from crosscheck.recordings.record import Record

DEGREE = 5  # accelerations are cubic in time between knots
SPACINGS = tuple(2**power for power in range(2, 11))  # samples between knots
INTERVALS = 64  # between knots in a block, each of which has a spline of its own
LEAST_ROWS = 64
TRIED, MOST_TRIED = 3, 8192  # parts by which the distance of the knots is chosen, and their rows
# Of a variance, by how much fewer knots may raise it, in standard deviations of its estimate.
RAISED = 3.0
LEAST_NOISE = 1e-9  # of a signal's size: a simulated one may have less
ROUNDING = 1e-13  # of a signal's size: what a spline of a constant leaves
LEAST_SIZE = 1e-3  # [rad, N m], of a signal that is zero or near it


@dataclass(frozen=True)
class Block:
    """Rows of a record with their spline.

    bases: B-splines, their slopes and curvatures at the rows, each (rows, size); gram = bases[0]'
    bases[0]; angles, rates and accelerations (rows, joints) of the splines; torques as recorded.
    angle_noise and torque_noise (joints,): standard deviations of one sample.
    """

    time: np.ndarray
    bases: tuple[csr_array, csr_array, csr_array]
    gram: np.ndarray
    angles: np.ndarray
    rates: np.ndarray
    accelerations: np.ndarray
    torques: np.ndarray
    angle_noise: np.ndarray
    torque_noise: np.ndarray

    @property
    def motion(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Angles, rates and accelerations of the splines, each (rows, joints)."""
        return self.angles, self.rates, self.accelerations

    def summed(self, rows: np.ndarray) -> np.ndarray:
        """Rows (rows, joints) summed with every B-spline as a weight (size, joints)."""
        return self.bases[0].T @ rows


def select_evenly(pieces: Sequence[Block], most: int) -> list[Block]:
    """At most `most` of the blocks, evenly over the record."""
    count = min(len(pieces), most)
    return [pieces[n] for n in np.linspace(0, len(pieces) - 1, count).round().astype(int)]


def smooth_record(record: Record, torques: np.ndarray, spacing: int) -> Iterator[Block]:
    """The record, block by block; torques (rows, joints) [N m]; spacing: samples between knots."""
    rows = record.time.size
    count = max(round(rows / (INTERVALS * spacing)), 1)
    edges = np.linspace(0, rows, count + 1).round().astype(int)
    for first, last in pairwise(map(int, edges)):
        time, angles, given = (each[first:last] for each in (record.time, record.angles, torques))
        places = place_knots(time, spacing)
        bases = _basis(time, places, 0), _basis(time, places, 1), _basis(time, places, 2)
        gram = (bases[0].T @ bases[0]).toarray()
        factored, free = cho_factor(gram), time.size - len(gram)
        noise = []
        for signal in (angles, given):
            residuals = signal - bases[0] @ cho_solve(factored, bases[0].T @ signal)
            least = LEAST_NOISE * np.maximum(np.abs(signal).max(axis=0), LEAST_SIZE)
            noise.append(np.maximum(np.sqrt((residuals**2).sum(axis=0) / free), least))
        fitted = cho_solve(factored, bases[0].T @ angles)
        smooth, rates, accelerations = (basis @ fitted for basis in bases)
        yield Block(time, bases, gram, smooth, rates, accelerations, given, noise[0], noise[1])


def select_spacing(record: Record) -> int:
    """Samples between knots: half of the most that leave no more than the record's noise.

    A spline that follows the motion leaves white noise, whose variance does not fall with more
    knots. Raises InputError for too few rows.
    """
    rows = record.time.size
    if rows < LEAST_ROWS:
        raise InputError(record.where, "", None, f"has {rows} rows; must be at least {LEAST_ROWS}")
    possible = [each for each in SPACINGS if rows >= 8 * each]
    taken = min(rows, MOST_TRIED)
    firsts = np.linspace(0, rows - taken, TRIED).astype(int) if rows > taken else [0]
    parts = [slice(int(first), int(first) + taken) for first in firsts]

    def residual_variance(part: slice, spacing: int) -> np.ndarray:
        """Variance (joints,) [rad^2] of the angles about their splines."""
        time, angles = record.time[part], record.angles[part]
        places = place_knots(time, spacing)
        residuals = angles - make_lsq_spline(time, angles, places, DEGREE)(time)
        return (residuals**2).sum(axis=0) / (len(time) - (places.size - DEGREE - 1))

    variances = np.array(
        [np.mean([residual_variance(part, each) for part in parts], axis=0) for each in possible]
    )
    # A joint that stands still leaves rounding, which other knots may lower or raise.
    least = (ROUNDING * np.abs(record.angles).max(axis=0)) ** 2
    variances = np.maximum(variances, least)
    scatter = 1 + RAISED * np.sqrt(2 / (len(parts) * taken))
    enough = (variances <= scatter * variances[0]).all(axis=1)
    enough &= np.cumprod(enough).astype(bool)  # and every finer one too
    best = int(np.flatnonzero(enough)[-1])
    return possible[max(best - 1, 0)]


def place_knots(time: np.ndarray, spacing: int) -> np.ndarray:
    """Knots [s] with equally many samples between them, the ends DEGREE times more."""
    count = max(round((time.size - 1) / spacing), 1)
    places = np.linspace(0, time.size - 1, count + 1)
    inner = np.interp(places, np.arange(time.size), time)
    return np.concatenate([np.repeat(inner[0], DEGREE), inner, np.repeat(inner[-1], DEGREE)])


def _basis(time: np.ndarray, knots: np.ndarray, derivative: int) -> csr_array:
    """Derivatives of the B-splines at these times (times, size): splines of a lower degree."""
    steps = eye_array(knots.size - DEGREE - 1, format="csr")
    for degree in range(DEGREE, DEGREE - derivative, -1):
        spans = knots[degree + 1 : -1] - knots[1 : -degree - 1]
        steps = diags_array(degree / spans) @ (steps[1:] - steps[:-1])
        knots = knots[1:-1]
    design = csr_array(BSpline.design_matrix(time, knots, DEGREE - derivative))
    return design @ steps if derivative else design
