"""A second program for what `compare` estimates of a robot: NumPy and Pinocchio, no crosscheck.

It filters by a full Fourier matrix's sums, takes accelerations from the same transform, makes rows
of the band by a matrix of weights, row by row, estimates with singular values of all columns (not
base parameters), leaves out every block by fitting anew, and has a stationary residual's variances
by its rows' covariance. What links contain is found by the null space of columns.
"""

from collections.abc import Callable
from itertools import groupby, pairwise
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.polynomial import Polynomial

ORDER, PADDED, ROWS, SLOW, RAMP, UNSURE, TURN = 8, 20, 4, 0.01, 1e-6, 4, 0.25
WIDE, WIDER, DENSE, EDGE, REACH = 4, 2, 4, 4, 1
RANK = 1e-4  # of a singular value of scaled columns over random motions
WEIGHTINGS = 3


class Answer(NamedTuple):
    """Estimates and standard errors of friction and armature by name; rms of each joint."""

    values: dict[str, float]
    errors: dict[str, float]
    rms: np.ndarray


def low_pass(signal: np.ndarray, step: float, bandwidth: float) -> list[np.ndarray]:
    """A signal (rows, n) without what is above the bandwidth [Hz], and its two derivatives."""
    rows, pad = len(signal), min(int(PADDED / (bandwidth * step)), len(signal) - 1)
    before = 2 * signal[:1] - signal[1 : pad + 1][::-1]
    after = 2 * signal[-1:] - signal[-pad - 1 : -1][::-1]
    long = np.vstack([before, signal, after])
    place = np.arange(len(long))[:, None]
    rise = (long[-1] - long[0]) / (len(long) - 1)
    spectrum = np.fft.fft(long - long[0] - place * rise, axis=0)
    frequency = np.fft.fftfreq(len(long), step)[:, None]
    spectrum = spectrum / (1 + np.abs(frequency / bandwidth) ** (2 * ORDER))
    turned = 2j * np.pi * frequency
    plain, slope, curve = (
        np.fft.ifft(spectrum * turned**order, axis=0).real[pad : pad + rows] for order in (0, 1, 2)
    )
    return [plain + (long[0] + place * rise)[pad : pad + rows], slope + rise / step, curve]


def rows_of(
    model: pin.Model,
    q: np.ndarray,
    v: np.ndarray,
    a: np.ndarray,
    direction: np.ndarray,
    slope: np.ndarray,
) -> np.ndarray:
    """Columns (rows, n, parameters): links; offset, viscous, Coulomb, armature of joints; delay."""
    data, count = model.createData(), q.shape[1]
    table = []
    for at, rate, more, sign, rise in zip(q, v, a, direction, slope, strict=True):
        links = pin.computeJointTorqueRegressor(model, data, at, rate, more).copy()
        diagonals = [np.eye(count), np.diag(rate), np.diag(sign), np.diag(more), -rise[:, None]]
        table.append(np.hstack([links, *diagonals]))
    return np.array(table)


def identifiable(model: pin.Model, count: int) -> np.ndarray:
    """Whether random motions tell each parameter from all others."""
    rng = np.random.default_rng(7)
    q, v, a, slope = (rng.uniform(-2, 2, (150, count)) for _ in range(4))
    table = rows_of(model, q, v, a, np.sign(v), slope).reshape(150 * count, -1)
    table = table / lengths(table)
    _, singular, directions = np.linalg.svd(table)
    null = directions[(singular > RANK * singular[0]).sum() :]
    return (np.abs(null) < 1e-6).all(axis=0)


def lengths(table: np.ndarray) -> np.ndarray:
    """Of the columns; infinite for those that are nothing but rounding, which so count for none."""
    size = np.linalg.norm(table, axis=0)
    return np.where(size > 1e-12 * size.max(), size, np.inf)


def solve(table: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The least of the parameters that leave least; only identifiable ones of it mean anything."""
    size = lengths(table)
    return np.linalg.lstsq(table / size, right, rcond=1e-9)[0] / size


class Signals(NamedTuple):
    """Rows of a recording in a band: torque, and which joints move (rows, n).

    Its motion is in a wider band, at denser rows; weights (rows, dense rows) make the rows of it.
    """

    model: pin.Model
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    direction: np.ndarray
    slope: np.ndarray
    torque: np.ndarray
    moving: np.ndarray
    weights: np.ndarray

    def table(self, zeros: np.ndarray | float = 0.0) -> np.ndarray:
        """Columns (rows, n, parameters) where positions are so much more."""
        dense = rows_of(self.model, self.q + zeros, self.v, self.a, self.direction, self.slope)
        return np.tensordot(self.weights, dense, 1)


def sample_rows(
    urdf: str, time: np.ndarray, position: np.ndarray, torque: np.ndarray, bandwidth: float
) -> Signals:
    """The rows of a recording in SI units at even times."""
    model = pin.buildModelFromXML(urdf)
    model.gravity.linear = np.array([0.0, 0.0, -9.81])
    step = (time[-1] - time[0]) / (len(time) - 1)
    wide = bandwidth * min(WIDE, 1 / (ROWS * bandwidth * step))
    q, v, a = low_pass(position, step, wide)
    fastest = np.abs(v).max(axis=0)
    edge = int(EDGE / (wide * step))
    above = np.std((position - q)[edge:-edge], axis=0) / np.sqrt(0.5 / step - wide)
    unsure = UNSURE * 2 * np.pi * above * np.sqrt(wide**3 / 3)
    sign, torque = np.clip(v / (RAMP * fastest), -1, 1), np.array(torque)
    hidden = np.abs(v) < np.maximum(np.minimum(unsure, SLOW * fastest), RAMP * fastest)
    for joint, flags in enumerate(hidden.T):
        for signal in (sign, torque):
            signal[:, joint] = bridge(signal[:, joint], flags, int(TURN / (wide * step)))
    direction = low_pass(sign, step, WIDER * wide)[0]
    torque, slope, _ = low_pass(torque, step, WIDER * wide)
    apart_rows = max(1 / (DENSE * ROWS * bandwidth * step), 1)
    rows = np.arange(edge, len(q) - edge, apart_rows).astype(int)
    periods = bandwidth * step * rows
    inside = (periods - periods[0] > REACH) & (periods[-1] - periods > REACH)
    weights = []
    for centre in periods[inside][:: round(1 / (ROWS * bandwidth * step * apart_rows))]:
        apart = periods - centre
        window = 0.54 + 0.46 * np.cos(np.pi * apart / REACH)
        weight = np.where(np.abs(apart) <= REACH, np.sinc(2 * apart) * window, 0.0)
        weights.append(weight / weight.sum())
    matrix = np.array(weights)
    moving = np.abs(matrix @ v[rows]) > SLOW * fastest
    dense = (each[rows] for each in (q, v, a, direction, slope))
    return Signals(model, *dense, matrix @ torque[rows], moving, matrix)


def bridge(signal: np.ndarray, flags: np.ndarray, most: int) -> np.ndarray:
    """Cubics of least squares in place of short runs of flagged rows, by as many beside them."""
    bridged, first = signal.copy(), 0
    for flag, run in groupby(flags.tolist()):
        last = first + len(list(run))
        reach = max(2, (last - first + 1) // 2)
        if flag and last - first <= most and first >= reach and last + reach <= len(signal):
            beside = np.r_[first - reach : first, last : last + reach]
            curve = Polynomial.fit(beside, signal[beside], 3)
            bridged[first:last] = curve(np.arange(first, last))
        first = last
    return bridged


class TableFit(NamedTuple):
    """Values and variances of parameters; rms of each joint, and the weights' inverse."""

    values: np.ndarray
    variances: np.ndarray
    rms: np.ndarray


def fit_table(table: np.ndarray, torque: np.ndarray, moving: np.ndarray) -> TableFit:
    """Weighted least squares of torques (rows, n) by a table (rows, n, parameters)."""
    values, residual, used = weigh(table, torque, moving)
    edges = block_edges(np.where(moving, residual, 0.0))
    without = []
    for first, last in pairwise(edges):
        kept = np.r_[0:first, last : len(torque)]
        able_rows = moving[kept]
        weighted = (table[kept] / used[:, None])[able_rows]
        without.append(solve(weighted, (torque[kept] / used)[able_rows]))
    blocks = len(without)
    # Of the deviations from the whole fit, not from their mean.
    spread = (blocks - 1) / blocks * ((np.array(without) - values) ** 2).sum(axis=0)
    spread = (spread + stationary_variances(table, residual, used, moving)) / 2
    return TableFit(values, spread, spread_of(residual, moving))


def weigh(
    table: np.ndarray, torque: np.ndarray, moving: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Parameters, residuals (rows, n), and the deviations by which joints were weighted at last."""
    sigma = spread_of(torque, moving)
    for _ in range(WEIGHTINGS):
        used = sigma
        values = solve((table / used[:, None])[moving], (torque / used)[moving])
        residual = torque - table @ values
        sigma = spread_of(residual, moving)
    return values, residual, used


def estimate(
    urdf: str, time: np.ndarray, position: np.ndarray, torque: np.ndarray, bandwidth: float
) -> Answer:
    """Estimates of a recording in SI units at even times."""
    signals = sample_rows(urdf, time, position, torque, bandwidth)
    model, count = signals.model, signals.q.shape[1]
    fit = fit_table(signals.table(), signals.torque, signals.moving)
    names = [
        f"{kind} of {name}"
        for kind in ("offset", "viscous", "coulomb", "armature")
        for name in list(model.names)[1:]
    ]
    names.append("delay of all torques")
    places = {name: 10 * count + number for number, name in enumerate(names)}
    able = identifiable(model, count)
    places = {name: place for name, place in places.items() if able[place]}
    return Answer(
        {name: float(fit.values[place]) for name, place in places.items()},
        {name: float(np.sqrt(fit.variances[place])) for name, place in places.items()},
        fit.rms,
    )


Torques = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]


def restrict(signals: Signals, torques: Torques, more: Torques) -> TableFit:
    """The fit of friction, a delay and one number, which comes last.

    torques, more: of a motion, with the number as it is and with one unit more of it.
    """
    motion, count = (signals.q, signals.v, signals.a), signals.q.shape[1]
    given = torques(*motion)
    column = np.tensordot(signals.weights, more(*motion) - given, 1)
    friction = [*range(10 * count, 13 * count), 14 * count]
    table = np.concatenate([signals.table()[:, :, friction], column[:, :, None]], axis=2)
    return fit_table(table, signals.torque - signals.weights @ given, signals.moving)


def stationary_variances(
    table: np.ndarray, residual: np.ndarray, sigma: np.ndarray, moving: np.ndarray
) -> np.ndarray:
    """Of the parameters, where residuals have one correlation at all times, joint with joint."""
    rows, count, _ = table.shape
    counted = np.where(moving[:, :, None], table / sigma[:, None], 0.0).reshape(rows * count, -1)
    size = lengths(counted)
    inverse = np.linalg.pinv(counted / size, rcond=1e-9) / size[:, None]
    centred = np.where(moving, residual / sigma, 0.0)
    centred = centred - centred.mean(axis=0)
    reach, lags = min(8 * max(map(first_negative, centred.T)), rows), np.arange(2 * rows)
    taper = parzen(np.minimum(lags, 2 * rows - lags) / reach)
    parts = inverse.reshape(-1, rows, count)
    basis, singular, _ = np.linalg.svd(counted / size, full_matrices=False)
    bases = basis.T[singular > 1e-9 * singular[0]].reshape(-1, rows, count)
    signals, total = [], np.zeros(len(size))
    for joint, shown in enumerate(moving.sum(axis=0)):
        power = (np.abs(np.fft.fft(bases[:, :, joint], 2 * rows)) ** 2).sum(axis=0) / shown
        free = 1 - np.fft.fft(np.fft.ifft(power) * taper).real
        wave = np.fft.fft(centred[:, joint], 2 * rows) / np.sqrt(shown)
        signals.append(wave / np.sqrt(np.maximum(free, 0.1)))
    places = (np.arange(rows) - np.arange(rows)[:, None]) % (2 * rows)
    for one in range(count):
        for other in range(count):
            products = np.fft.ifft(signals[one].conj() * signals[other]).real
            covariance = (products * taper)[places]
            total += ((parts[:, :, one] @ covariance) * parts[:, :, other]).sum(axis=1)
    return total


def parzen(share: np.ndarray) -> np.ndarray:
    """Parzen's window, by its distance from the middle in parts of its reach."""
    inner, outer = 1 - 6 * share**2 + 6 * share**3, 2 * np.maximum(1 - share, 0) ** 3
    return np.where(share < 0.5, inner, outer)


def first_negative(signal: np.ndarray) -> int:
    """Rows after which a signal's correlation is negative for the first time."""
    negative = np.correlate(signal, signal, "full")[len(signal) - 1 :] <= 0
    return int(negative.argmax()) if negative.any() else len(signal)


def spread_of(values: np.ndarray, moving: np.ndarray) -> np.ndarray:
    """Root mean square of each joint's values where it moves."""
    pairs = zip(values.T, moving.T, strict=True)
    return np.array([np.sqrt((column[able] ** 2).mean()) for column, able in pairs])


def block_edges(residual: np.ndarray) -> np.ndarray:
    """First rows of blocks of four correlation times, from 20 to 100 of them."""
    rows, longest = len(residual), max(rows_alike(signal) for signal in residual.T)
    length = min(max(4 * longest, rows / 100), rows / 20)
    return np.linspace(0, rows, round(rows / length) + 1).round().astype(int)


def rows_alike(signal: np.ndarray) -> float:
    """For how many rows a signal is alike: its correlation, lag by lag."""
    centred = signal - signal.mean()
    correlation = np.correlate(centred, centred, "full")[len(signal) - 1 :] / (centred @ centred)
    end = min(8 * first_negative(centred), len(signal))
    return max(2 * float(parzen(np.arange(end) / end) @ correlation[:end]) - 1, 1.0)
