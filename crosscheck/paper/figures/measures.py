"""Numbers read off the figures' trajectories."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.ndimage import uniform_filter1d

from crosscheck import signals
from crosscheck.envelope import envelope
from crosscheck.paper import events
from crosscheck.paper.numbers import finite, quotient
from crosscheck.paper.reading import first_mesh
from crosscheck.paper.undefined import known
from crosscheck.studies.study import Numbers

# The part of it in which the paper's arm fluctuates: for spectra that can be compared.
SPECTRUM_S = (1.0, 1.2)
# Longer than seven periods of the third fluctuation, too short for the arm's own motion.
BIN_S = 0.005
LOWEST_HZ, HIGHEST_HZ = 100.0, 6000.0
FREE_VIBRATION_S = 0.0025


def swing(time: np.ndarray, values: np.ndarray, begin: float, end: float) -> float:
    """Half of the largest peak-to-peak value within 5 ms, in the window [s]; nan if it is empty."""
    part = signals.window(time, begin, end)
    if part.stop <= part.start:
        return np.nan
    bins = max(1, round((end - begin) / BIN_S))
    _, low, high = envelope(time[part], values[part], bins)
    return float((high - low).max() / 2)


def force_swing(run: xr.Dataset) -> float:
    """Of F_sp1 [N] in the third fluctuation."""
    return swing(run["time"].values, first_mesh(run, "F_sp"), *events.THIRD_S)


def third_force(run: xr.Dataset) -> Numbers:
    """The same, for a run that is not kept."""
    return finite({"force_swing_N": force_swing(run)})


def energy_peak(run: xr.Dataset, r_cp: tuple[float, ...]) -> tuple[float, float]:
    """Largest kinetic energy [J], and what the drive has worked by then [J].

    r_cp: carrier radius times cos(pressure angle) of every joint [m]. The drive turns the sun:
    T theta_s' / n = T (theta' + (x_sp' + x_pr') / (2 r_cp)), summed over recorded intervals.
    """
    energy = run["kinetic_energy"].values
    last = int(np.argmax(energy))
    meshes = run["x_sp"].values[:, :, 0] + run["x_pr"].values[:, :, 0]
    turned = run["theta"].values + meshes / (2 * np.array(r_cp))
    torque = run["torque"].values
    work = (torque[1:] + torque[:-1]) / 2 * np.diff(turned, axis=0)
    return float(energy[last]), float(work[:last].sum())


class Impact(NamedTuple):
    """The first contact of the opposite flanks: when, its peak, how long the teeth bounce."""

    contact_s: float | None
    peak_N: float | None
    bouncing_s: float | None


def impact(time: np.ndarray, force: np.ndarray) -> Impact:
    """What follows the first contact of the opposite flanks, a vibration's included."""
    contact = events.opposite_contact(time, force, events.ANY_CONTACT_AFTER_S)
    if contact is None:
        return Impact(None, None, None)
    part = signals.window(time, contact, contact + events.IMPACT_S)
    apart = np.flatnonzero(force[part] >= 0)
    last = time[part][apart[-1]] if apart.size else contact
    return Impact(contact, float(-force[part].min()), float(last - contact))


def cycles(time: np.ndarray, values: np.ndarray, middle: float, level: float) -> float:
    """Slow cycles: half the number of passages from middle - level to middle + level or back.

    Values are averaged over 2.5 ms first: the mesh's free vibration does not count. nan for a run
    that ends before.
    """
    if not known(middle) or time.size <= 1:
        return np.nan
    width = max(1, round(FREE_VIBRATION_S / (time[1] - time[0])))
    smooth = uniform_filter1d(values, width, mode="nearest")
    return events.arrivals(time, smooth - middle, level / events.SIDE).size / 2


class Line(NamedTuple):
    """The largest line of a spectrum above 100 Hz: where, how large, and over the median.

    nan where there is no line.
    """

    frequency_Hz: float
    size_rad_per_s2: float
    prominence: float


def line(run: xr.Dataset, joint: int) -> Line:
    """Of a joint's acceleration, 1.0 to 1.2 s; the median from 100 to 6000 Hz."""
    time, values = spectrum_part(run, joint)
    frequency, amplitudes = signals.spectrum(time, values)
    heard = amplitudes[(frequency >= LOWEST_HZ) & (frequency <= HIGHEST_HZ)]
    if not heard.size:
        return Line(np.nan, np.nan, np.nan)
    largest = float(heard.max())
    median = float(np.median(heard))
    return Line(
        signals.dominant_frequency(time, values, LOWEST_HZ), largest, quotient(largest, median)
    )


def spectrum_part(run: xr.Dataset, joint: int) -> tuple[np.ndarray, np.ndarray]:
    """Time and acceleration of a joint, counted from 0, in the window of the spectra."""
    time = run["time"].values
    part = signals.window(time, *SPECTRUM_S)
    return time[part], run["theta_ddot"].values[part, joint]
