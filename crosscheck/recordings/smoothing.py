"""Angles of a record as splines, with the noise that they leave and what it does to slopes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from math import pi

import numpy as np
from scipy.interpolate import BSpline, make_lsq_spline
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csr_array

from crosscheck.models.errors import InputError
from crosscheck.models.experiment.drive import drive_data, torques_along
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.recordings.record import Record

# Factors of rates over the slope of the angles if one has another unit, and their share.
FACTORS = {
    "the rates are in degrees per second": 180 / pi,
    "the rates are in revolutions per minute": 30 / pi,
    "the angles are in degrees": pi / 180,
    "the times are in milliseconds": 1e3,
    "the times are in seconds": 1e-3,
}
SAME = 0.02
DEGREE = 5  # accelerations are cubic in time between knots
SPACINGS = tuple(2**power for power in range(2, 11))  # samples between knots
RATE_BLOCKS = 10  # blocks in which stated rates are compared with slopes
INTERVALS = 64  # between knots in a block, each of which has a spline of its own
TRIED, MOST_TRIED = 3, 8192  # parts by which the distance of the knots is chosen, and their rows
# Rise of a variance that fewer knots may cause, in standard deviations of its estimate.
RAISED = 3.0
LEAST_NOISE = 1e-9  # noise over a signal's size; a simulated one may have less
ROUNDING = 1e-13  # residual of a spline of a constant, over a signal's size
LEAST_SIZE = 1e-3  # [rad, N m], of a signal that is zero or near it


@dataclass(frozen=True)
class Block:
    """Rows of a record with their spline.

    knots [s]: of its B-splines; basis: these at the rows (rows, size); gram = basis' basis;
    position and rates (rows, joints) of the splines; torques as recorded. position_noise and
    torque_noise (joints,): standard deviations of one sample.
    """

    time: np.ndarray
    knots: np.ndarray
    basis: csr_array
    gram: np.ndarray
    position: np.ndarray
    rates: np.ndarray
    torques: np.ndarray
    position_noise: np.ndarray
    torque_noise: np.ndarray


def smooth_record(record: Record, torques: np.ndarray, spacing: int, most: int) -> Iterator[Block]:
    """At most so many blocks of a record, evenly over it.

    torques (rows, joints) [N m]; spacing: samples between knots.
    """
    rows = record.time.size
    count = max(round(rows / (INTERVALS * spacing)), 1)
    edges = np.linspace(0, rows, count + 1).round().astype(int)
    pairs = list(pairwise(map(int, edges)))
    for place in np.linspace(0, count - 1, min(count, most)).round().astype(int):
        rows_in = slice(*pairs[place])
        time, positions, given = (each[rows_in] for each in (record.time, record.position, torques))
        places = place_knots(time, spacing)
        basis = csr_array(BSpline.design_matrix(time, places, DEGREE))
        gram = (basis.T @ basis).toarray()
        factored, free = cho_factor(gram), time.size - len(gram)
        noise = []
        for signal in (positions, given):
            residuals = signal - basis @ cho_solve(factored, basis.T @ signal)
            least = LEAST_NOISE * np.maximum(np.abs(signal).max(axis=0), LEAST_SIZE)
            noise.append(np.maximum(np.sqrt((residuals**2).sum(axis=0) / free), least))
        spline = BSpline(places, cho_solve(factored, basis.T @ positions), DEGREE)
        fitted = spline(time), spline(time, nu=1)
        yield Block(time, places, basis, gram, *fitted, given, noise[0], noise[1])


def select_spacing(record: Record) -> int:
    """Samples between knots: half of the most that leave no more than the record's noise.

    A spline that follows the motion leaves white noise, whose variance does not fall with more
    knots.
    """
    rows = record.time.size
    possible = [each for each in SPACINGS if rows >= 8 * each]
    taken = min(rows, MOST_TRIED)
    firsts = np.linspace(0, rows - taken, TRIED).astype(int) if rows > taken else [0]
    parts = [slice(int(first), int(first) + taken) for first in firsts]

    def residual_variance(part: slice, spacing: int) -> np.ndarray:
        """Variance (joints,) [rad^2] of the angles about their splines."""
        time, angles = record.time[part], record.position[part]
        places = place_knots(time, spacing)
        residuals = angles - make_lsq_spline(time, angles, places, DEGREE)(time)
        return (residuals**2).sum(axis=0) / (len(time) - (places.size - DEGREE - 1))

    # A joint that stands still leaves rounding, which other knots may lower or raise.
    least = (ROUNDING * np.abs(record.position).max(axis=0)) ** 2
    scatter = 1 + RAISED * np.sqrt(2 / (len(parts) * taken))
    limit, enough = np.full(record.position.shape[1], np.inf), 0
    for spacing in possible:
        mean = np.mean([residual_variance(part, spacing) for part in parts], axis=0)
        variance = np.maximum(mean, least)
        if not (variance <= limit).all():
            break
        limit = limit if enough else scatter * variance
        enough += 1
    return possible[max(enough - 2, 0)]


def check_rates(record: Record) -> None:
    """Raise InputError if the record's rates are not the slopes of its angles.

    The error names the unit if the rates are off by the factor of another unit.
    """
    if record.rates is None:
        return
    spacing = select_spacing(record)
    blocks = list(smooth_record(record, np.zeros_like(record.position), spacing, RATE_BLOCKS))
    rows = np.searchsorted(record.time, np.concatenate([block.time for block in blocks]))
    slopes = np.concatenate([block.rates for block in blocks])
    pairs = zip(record.rates[rows].T, slopes.T, strict=True)
    for joint, (given, slope) in enumerate(pairs, 1):
        power = float(slope @ slope)
        factor = float(given @ slope) / power if power > 0 else 1.0
        left = given - factor * slope
        if abs(factor - 1) < 0.1 or float(left @ left) > 0.1 * float(given @ given):
            continue
        message = f"is {factor:.4g} times the slope of theta_{joint}"
        cause = next((c for c, of in FACTORS.items() if abs(factor / of - 1) < SAME), "")
        reason = f"{message}: {cause}" if cause else message
        raise InputError(record.where, f"theta_dot_{joint}", None, reason)


def add_drive_torques(record: Record, scenario: Scenario) -> Record:
    """The record with the torques that a scenario's drive has along its motion."""
    drive = drive_data(scenario, record.position.shape[1])
    spacing, nothing = select_spacing(record), np.zeros_like(record.position)
    parts = [
        torques_along(drive, each.time, each.position, each.rates)
        for each in smooth_record(record, nothing, spacing, len(record.time))
    ]
    return replace(record, motor_torque=np.concatenate(parts))


def place_knots(time: np.ndarray, spacing: int) -> np.ndarray:
    """Knots [s] with equally many samples between them, the ends DEGREE times more."""
    count = round((time.size - 1) / spacing)
    places = np.linspace(0, time.size - 1, count + 1)
    inner = np.interp(places, np.arange(time.size), time)
    return np.concatenate([np.repeat(inner[0], DEGREE), inner, np.repeat(inner[-1], DEGREE)])
