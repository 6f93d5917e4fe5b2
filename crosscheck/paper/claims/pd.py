"""The numbers of one run under PD control that the paper's statements are about.

Accelerations are the detailed arm's less those of the rigid arm at level `coupled`; mesh quantities
are those of the shoulder's sun-planet pair, first planet.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from crosscheck.paper import signals
from crosscheck.paper.claims.measures import (
    RING_CYCLES,
    correlation,
    decay,
    fast,
    first_planet,
    geometry,
    recorded,
    resampled,
    rigid_arm,
)
from crosscheck.paper.fluctuation import THIRD_S
from crosscheck.paper.undefined import finite, quotient
from crosscheck.studies.study import Numbers
from models.scenario import PdDrive

FIRST_S = (0.0, 0.25)
SIDE_AFTER_S = 0.25  # the starting vibration no longer turns the mesh force
IMPACT_S = 0.1  # what follows a side change within this time belongs to it
RETURN_S = (1.3, 2.4)  # between the third fluctuation's side changes and the end's
FOURTH_S = 0.4
NEAR_S = 0.1  # stretch around the largest value that a spectrum is taken of
BANDS = (0.02, 0.003, 0.005, 0.01, 0.05)  # settling bands, over the step of 30 degrees
LOWEST_HZ, LOW_HZ, LINE_HZ = 20.0, 500.0, 50.0  # "low frequency"; half the width of a line
START_S = 1e-3  # at the very start the meshes touch without force


def transient(run: xr.Dataset) -> Numbers:
    """Figs. 11-14, 16-20: the fluctuations of the first 1.2 s."""
    rigid = rigid_arm(run)
    time = run["time"].values
    excess = run["theta_ddot"].values - resampled(rigid, "theta_ddot", time)
    gap = run["theta"].values - resampled(rigid, "theta", time)
    side, left = _side_change(time, first_planet(run["F_sp"]))
    third = _third_window(time, side)
    windows = (
        signals.window(time, START_S, FIRST_S[1]),
        signals.window(time, side, side + IMPACT_S),
        third,
    )
    return finite(
        {
            **_impacts(run, excess[:, 0], side, left),
            **_third(time, excess, third, side),
            **_spectra(run, excess, third),
            **_loads(run, excess[:, 0], third),
            **_contacts(run, windows),
            **_mesh_rates(run),
            "deviation_rad": signals.amplitude(gap),
            "rigid_peak": signals.amplitude(rigid["theta_ddot"].values[:, 0]),
            "theta_fast_rad": signals.amplitude(fast(time, gap[:, 0])[third]),
        }
    )


def whole(run: xr.Dataset) -> Numbers:
    """Figs. 10-14: all of the 3 s."""
    return {**transient(run), **finite({**_positioning(run), **_fourth(run)})}


def _side_change(time: np.ndarray, force: np.ndarray) -> tuple[float, float]:
    """Times [s] when the teeth first meet on the other side, and left the first one; nan if not."""
    after = signals.window(time, SIDE_AFTER_S, np.inf)
    side = signals.first_below(time[after], force[after], 0.0)
    if side is None:
        return float("nan"), float("nan")
    held = np.flatnonzero(force[: int(np.searchsorted(time, side))] > 0)
    return side, float(time[held[-1]]) if held.size else float("nan")


def _third_window(time: np.ndarray, side: float) -> slice:
    """0.5 to 1.2 s, without what follows a late side change."""
    late = np.isfinite(side) and side + IMPACT_S < THIRD_S[1] - NEAR_S
    return signals.window(time, max(THIRD_S[0], side + IMPACT_S) if late else THIRD_S[0], 1.2)


def _impacts(
    run: xr.Dataset, excess: np.ndarray, side: float, left: float
) -> dict[str, float | None]:
    """First and second fluctuation; the second is the excess over what was there before it."""
    time, force, x = run["time"].values, first_planet(run["F_sp"]), first_planet(run["x_sp"])
    start = signals.window(time, *FIRST_S)
    numbers: dict[str, float | None] = {
        "first": signals.amplitude(excess[start]),
        "first_decay_s": decay(time[start], excess[start]),
        "side_change_s": side,
    }
    if not np.isfinite(side):
        return numbers | dict.fromkeys(_SECOND)
    parting, meeting = np.searchsorted(time, (left, side))
    change = signals.window(time, side, side + IMPACT_S)
    onset = signals.onset(time[change], excess[change])
    return numbers | {
        "second": signals.amplitude(excess[change]),
        "second_decay_s": decay(time[change], excess[change]),
        "second_delay_s": None if onset is None else onset - side,
        "second_force_N": signals.amplitude(force[change]),
        "jump_um": 1e6 * (x[parting] - x[meeting]) if np.isfinite(left) else None,
        "flight_s": side - left,
        "other_side_um": 1e6 * x[change].min(),
    }


_SECOND = (
    "second",
    "second_decay_s",
    "second_delay_s",
    "second_force_N",
    "jump_um",
    "flight_s",
    "other_side_um",
)


def _third(
    time: np.ndarray, excess: np.ndarray, part: slice, side: float
) -> dict[str, float | None]:
    """Sizes [rad/s^2] and course of the third fluctuation."""
    window, shoulder = time[part], excess[part, 0]
    if not window.size:
        return dict.fromkeys(_THIRD)
    beginning = signals.amplitude(shoulder[: np.searchsorted(window, window[0] + NEAR_S)])
    onset = signals.onset(window, shoulder)
    return {
        "third": signals.amplitude(shoulder),
        "third_elbow": signals.amplitude(excess[part, 1]),
        "third_growth": quotient(signals.amplitude(shoulder), beginning),
        "third_gap_s": None if onset is None else onset - side,
    }


_THIRD = ("third", "third_elbow", "third_growth", "third_gap_s")


def _spectra(run: xr.Dataset, excess: np.ndarray, part: slice) -> dict[str, float | None]:
    """Lines of both joints' accelerations in the 0.1 s around the third fluctuation's peak."""
    time = run["time"].values[part]
    if not time.size:
        return {f"{name}{joint}{unit}": None for joint in _JOINTS for name, unit in _SPECTRAL}
    centre = time[int(np.abs(excess[part, 0]).argmax())]
    begin = min(max(centre - NEAR_S / 2, time[0]), time[-1] - NEAR_S)
    near = part.start + np.flatnonzero((time >= begin) & (time < begin + NEAR_S))
    numbers: dict[str, float | None] = {}
    for joint, name in enumerate(_JOINTS):
        values = excess[near, joint]
        static = abs(run["theta_ddot"].values[near, joint].mean())
        frequency, lines = signals.spectrum(run["time"].values[near], values)
        peak = signals.dominant_frequency(run["time"].values[near], values)
        numbers |= {
            f"frequency{name}_Hz": peak,
            f"overtone{name}": quotient(
                _line(frequency, lines, 2 * peak), _line(frequency, lines, peak)
            ),
            f"low_share{name}": _share(frequency, lines, LOWEST_HZ, LOW_HZ),
            f"line_share{name}": _share(frequency, lines, peak - LINE_HZ, peak + LINE_HZ),
            f"static_over_line{name}": quotient(static, _line(frequency, lines, peak)),
        }
    return numbers


_JOINTS = ("", "_elbow")
_SPECTRAL = (
    ("frequency", "_Hz"),
    ("overtone", ""),
    ("low_share", ""),
    ("line_share", ""),
    ("static_over_line", ""),
)


def _line(frequency: np.ndarray, lines: np.ndarray, at: float) -> float:
    """Largest line within LINE_HZ of a frequency; nan for none."""
    near = lines[np.abs(frequency - at) <= LINE_HZ]
    return float(near.max(initial=1e-300)) if np.isfinite(at) else np.nan


def _share(frequency: np.ndarray, lines: np.ndarray, low: float, high: float) -> float:
    """Share of the energy above LOWEST_HZ that lies between two frequencies; nan without energy."""
    energy = lines**2 * (frequency >= LOWEST_HZ)
    inside = (frequency >= low) & (frequency <= high)
    return quotient(float(energy[inside].sum()), float(energy.sum()))


def _loads(run: xr.Dataset, excess: np.ndarray, part: slice) -> dict[str, float | None]:
    """Mesh force, torque and speed in the third fluctuation."""
    time = run["time"].values
    torque, speed = run["torque"].values, run["theta_dot"].values[:, 0]
    force = first_planet(run["F_sp"])
    shaken = [fast(time, column) for column in torque.T]
    return {
        "third_force_N": signals.amplitude(force[part]),
        "third_force_fast_N": signals.amplitude(fast(time, force)[part]),
        "torque_fast_1": _share_of_largest(shaken[0][part], torque[:, 0]),
        "torque_fast_2": _share_of_largest(shaken[1][part], torque[:, 1]),
        "torque_follows": _envelopes_correlate(time, shaken[0][part], excess[part]),
        "speed_fast": _share_of_largest(fast(time, speed)[part], speed),
        "side_changes": float(_side_changes(force[part])) if force[part].size else None,
    }


def _share_of_largest(part: np.ndarray, whole: np.ndarray) -> float:
    return quotient(signals.amplitude(part), signals.amplitude(whole))


def _envelopes_correlate(time: np.ndarray, one: np.ndarray, other: np.ndarray) -> float:
    """Correlation of the largest magnitudes in every 10 ms."""
    if not one.size:
        return np.nan
    bins = np.arange(0, one.size, round(0.01 / (time[1] - time[0])))
    peaks = [np.maximum.reduceat(np.abs(values), bins) for values in (one, other)]
    return correlation(peaks[0], peaks[1])


def _side_changes(force: np.ndarray) -> int:
    """How often a mesh force, where it is not zero, changes its sign."""
    loaded = force[force != 0]
    return int(np.count_nonzero(np.diff(np.signbit(loaded))))


def _contacts(run: xr.Dataset, windows: tuple[slice, ...]) -> dict[str, float | None]:
    """In how many windows the acceleration passes zero, and the teeth part; share of time apart.

    Windows are counted if there are all.
    """
    force, acceleration = first_planet(run["F_sp"]), run["theta_ddot"].values[:, 0]
    begun = signals.window(run["time"].values, START_S, np.inf)
    shares: dict[str, float | None] = {"apart_share": signals.mean(force[begun] == 0)}
    if any(window.stop <= window.start for window in windows):
        return shares | dict.fromkeys(("zero_windows", "apart_windows"))
    return shares | {
        "zero_windows": float(sum(np.ptp(np.sign(acceleration[w])) > 0 for w in windows)),
        "apart_windows": float(sum((force[w] == 0).any() for w in windows)),
    }


def _mesh_rates(run: xr.Dataset) -> dict[str, float | None]:
    """What Eq. 11 neglects, how small the teeth's motion is, how far omega t is off its integral.

    Rates by central differences of the recorded displacements.
    """
    time, theta, speed = (run[name].values for name in ("time", "theta", "theta_dot"))
    x_sp, x_pr = first_planet(run["x_sp"]), first_planet(run["x_pr"])
    sp_rate, pr_rate = (np.gradient(x, time) for x in (x_sp, x_pr))
    r_cp = geometry(run).r_cp
    top = np.abs(speed[:, 0]).max()
    return {
        "mesh_rate_over_speed": quotient(np.abs([sp_rate, pr_rate]).max(), top),
        "neglected_in_eq11": quotient(np.abs(sp_rate + pr_rate).max(), 2 * r_cp * top),
        "mesh_over_gross": quotient(np.abs([x_sp, x_pr]).max(), 2 * r_cp * np.ptp(theta[:, 0])),
        "phase_gap_rad": RING_CYCLES * np.abs(speed[:, 0] * time - theta[:, 0]).max(),
    }


def _positioning(run: xr.Dataset) -> dict[str, float | None]:
    """Fig. 10: final errors [rad], overshoots and settling times [s] of both joints."""
    time, theta = run["time"].values, run["theta"].values
    drive = recorded(run)[1].drive
    assert isinstance(drive, PdDrive)
    target = float(np.mean(drive.target_rad))
    numbers: dict[str, float | None] = {}
    for joint in (1, 2):
        angle = theta[:, joint - 1]
        numbers |= {
            f"final_{joint}_rad": abs(angle[-1] - target),
            f"overshoot_{joint}": angle.max() / target - 1,
            **{
                f"settling_{joint}_{band:g}_s": signals.settling_time(
                    time, angle, target, band * target
                )
                for band in BANDS
            },
        }
    return numbers


def _return(time: np.ndarray, force: np.ndarray) -> float | None:
    """Time [s] of the first contact on the first side after the last one on the other."""
    part = signals.window(time, *RETURN_S)
    other_side = np.flatnonzero(force[part] < 0)
    if not other_side.size:
        return None
    after = slice(part.start + int(other_side[-1]), part.stop)
    return signals.first_above(time[after], force[after], 0.0)


def _fourth(run: xr.Dataset) -> dict[str, float | None]:
    """What happens when the teeth return to their first side."""
    time = run["time"].values
    back = _return(time, first_planet(run["F_sp"]))
    if back is None:
        return {"return_s": None, "fourth": None, "speed_at_return": None}
    rigid = resampled(rigid_arm(run), "theta_ddot", time)[:, 0]
    excess = run["theta_ddot"].values[:, 0] - rigid
    speed = np.abs(run["theta_dot"].values[:, 0])
    around = signals.window(time, back, back + FOURTH_S)
    return {
        "return_s": back,
        "fourth": signals.amplitude(excess[around]),
        "speed_at_return": speed[np.searchsorted(time, back)] / speed.max(),
    }
