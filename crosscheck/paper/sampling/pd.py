"""The numbers of one run under PD control that the paper's statements are about.

Accelerations are the detailed arm's less those of the rigid arm at level `coupled`; mesh quantities
are those of the shoulder's sun-planet pair, first planet.
"""

from __future__ import annotations

import numpy as np

from analytic.kinematics import stage_geometry
from crosscheck import signals
from crosscheck.paper import events
from crosscheck.paper.course import Course
from crosscheck.paper.events import IMPACT_S, PEAK_S, SETTLING_BANDS, SideChange
from crosscheck.paper.numbers import finite, quotient
from crosscheck.paper.sampling.torque import RING_CYCLES, correlation, decay, fast
from crosscheck.paper.stage import geared_joint
from crosscheck.studies.variant import Numbers
from models.scenario import PdDrive

FIRST_S = (0.0, 0.25)
AFTER_S = 1.2  # Fig. 14 ends
FOURTH_S = 0.4
LOWEST_HZ, LOW_HZ, LINE_HZ = 20.0, 500.0, 50.0  # "low frequency"; half the width of a line
START_S = 1e-3  # at the very start the meshes touch without force


def transient(run: Course, rigid: Course) -> Numbers:
    """Figs. 11-14, 16-20: the fluctuations of the first 1.2 s."""
    time = run.time
    excess = run.theta_ddot - rigid.theta_ddot
    gap = run.theta - rigid.theta
    side = events.side_change(time, run.F_sp)
    third = events.third_window(time, side.met_s if side else None)
    return finite(
        {
            **_impacts(run, excess[:, 0], side),
            **_third(time, excess, third, side),
            **_spectra(run, excess, third),
            **_loads(run, excess[:, 0], third),
            **_contacts(run, (_first_window(time), _second_window(time, side), third)),
            **_mesh_rates(run),
            "deviation_rad": signals.amplitude(gap),
            "rigid_peak": signals.amplitude(rigid.theta_ddot[:, 0]),
            "theta_fast_rad": signals.amplitude(fast(time, gap[:, 0])[third]),
            "planets_apart_m": run.planets_apart_m,
        }
    )


def whole(run: Course, rigid: Course) -> Numbers:
    """Figs. 10-14: all of the 3 s."""
    return {**transient(run, rigid), **finite({**_positioning(run), **_fourth(run, rigid)})}


def _first_window(time: np.ndarray) -> slice:
    return signals.window(time, START_S, FIRST_S[1])


def _second_window(time: np.ndarray, side: SideChange | None) -> slice:
    """What a side change brings; nothing without one."""
    return signals.window(time, side.met_s, side.met_s + IMPACT_S) if side else slice(0, 0)


def _impacts(run: Course, excess: np.ndarray, side: SideChange | None) -> dict[str, float | None]:
    """First and second fluctuation; the second is the excess over what was there before it."""
    time = run.time
    start = signals.window(time, *FIRST_S)
    numbers: dict[str, float | None] = {
        "first": signals.amplitude(excess[start]),
        "first_decay_s": decay(time[start], excess[start]),
        "after_start": signals.amplitude(excess[signals.window(time, FIRST_S[1], AFTER_S)]),
    }
    if side is None:
        return numbers | dict.fromkeys(_SECOND)
    return numbers | _second(run, excess, side)


def _second(run: Course, excess: np.ndarray, side: SideChange) -> dict[str, float | None]:
    """The fluctuation at a side change, and the teeth's way to the other side."""
    time, force, x = run.time, run.F_sp, run.x_sp
    change = _second_window(time, side)
    before = signals.window(time, side.met_s - IMPACT_S / 2, side.met_s)
    onset = signals.onset(time[change], excess[change])
    numbers: dict[str, float | None] = {
        "side_change_s": side.met_s,
        "second": signals.amplitude(excess[change]),
        "second_over_before": quotient(
            signals.amplitude(excess[change]), signals.amplitude(excess[before])
        ),
        "second_decay_s": decay(time[change], excess[change]),
        "second_delay_s": None if onset is None else onset - side.met_s,
        "second_force_N": signals.amplitude(force[change]),
        "other_side_um": 1e6 * x[change].min(),
        "jump_um": None,
        "flight_s": None,
    }
    if side.left_s is None:
        return numbers
    parting, meeting = np.searchsorted(time, (side.left_s, side.met_s))
    return numbers | {
        "jump_um": 1e6 * (x[parting] - x[meeting]),
        "flight_s": side.met_s - side.left_s,
    }


_SECOND = (
    "side_change_s",
    "second",
    "second_over_before",
    "second_decay_s",
    "second_delay_s",
    "second_force_N",
    "jump_um",
    "flight_s",
    "other_side_um",
)


def _third(
    time: np.ndarray, excess: np.ndarray, part: slice, side: SideChange | None
) -> dict[str, float | None]:
    """Sizes [rad/s^2] and course of the third fluctuation."""
    window, shoulder = time[part], excess[part, 0]
    if not window.size:
        return dict.fromkeys(_THIRD)
    beginning = signals.amplitude(shoulder[: np.searchsorted(window, window[0] + PEAK_S)])
    onset = events.third_onset(time, excess[:, 0], part)
    return {
        "third": signals.amplitude(shoulder),
        "third_elbow": signals.amplitude(excess[part, 1]),
        "third_growth": quotient(signals.amplitude(shoulder), beginning),
        "third_onset_s": onset,
        "third_gap_s": None if onset is None or side is None else onset - side.met_s,
    }


_THIRD = ("third", "third_elbow", "third_growth", "third_onset_s", "third_gap_s")


def _spectra(run: Course, excess: np.ndarray, part: slice) -> dict[str, float | None]:
    """Lines of both joints' accelerations in the 0.1 s around the third fluctuation's peak."""
    time = run.time
    if not time[part].size:
        return {f"{name}{joint}{unit}": None for joint in _JOINTS for name, unit in _SPECTRAL}
    near = events.third_peak(time, excess[:, 0], part)
    numbers: dict[str, float | None] = {}
    for joint, name in enumerate(_JOINTS):
        values = excess[near, joint]
        static = abs(run.theta_ddot[near, joint].mean())
        frequency, lines = signals.spectrum(time[near], values)
        peak = signals.dominant_frequency(time[near], values)
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


def _loads(run: Course, excess: np.ndarray, part: slice) -> dict[str, float | None]:
    """Mesh force, torque and speed in the third fluctuation."""
    time = run.time
    torque, speed = run.torque, run.theta_dot[:, 0]
    force = run.F_sp
    shaken = [fast(time, column) for column in torque.T]
    return {
        "third_force_N": signals.amplitude(force[part]),
        "third_force_fast_N": signals.amplitude(fast(time, force)[part]),
        "torque_fast_1": _share_of_largest(shaken[0][part], torque[:, 0]),
        "torque_fast_2": _share_of_largest(shaken[1][part], torque[:, 1]),
        "torque_follows": _envelopes_correlate(time, shaken[0][part], excess[part]),
        "speed_fast": _share_of_largest(fast(time, speed)[part], speed),
        "side_changes": float(events.count_side_changes(force[part])) if force[part].size else None,
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


def _contacts(run: Course, windows: tuple[slice, ...]) -> dict[str, float | None]:
    """In how many windows the acceleration passes zero, and the teeth part; share of time apart.

    Windows are counted if there are all.
    """
    force, acceleration = run.F_sp, run.theta_ddot[:, 0]
    begun = signals.window(run.time, START_S, np.inf)
    shares: dict[str, float | None] = {"apart_share": signals.mean(force[begun] == 0)}
    if any(window.stop <= window.start for window in windows):
        return shares | dict.fromkeys(("zero_windows", "apart_windows"))
    return shares | {
        "zero_windows": float(sum(np.ptp(np.sign(acceleration[w])) > 0 for w in windows)),
        "apart_windows": float(sum((force[w] == 0).any() for w in windows)),
    }


def _mesh_rates(run: Course) -> dict[str, float | None]:
    """What Eq. 11 neglects, how small the teeth's motion is, how far omega t is off its integral.

    Rates by central differences of the recorded displacements.
    """
    time, theta, speed = (run.time, run.theta, run.theta_dot)
    x_sp, x_pr = run.x_sp, run.x_pr
    sp_rate, pr_rate = (np.gradient(x, time) for x in (x_sp, x_pr))
    r_cp = stage_geometry(geared_joint(run.case.arm)).r_cp
    top = np.abs(speed[:, 0]).max()
    return {
        "mesh_rate_over_speed": quotient(np.abs([sp_rate, pr_rate]).max(), top),
        "neglected_in_eq11": quotient(np.abs(sp_rate + pr_rate).max(), 2 * r_cp * top),
        "mesh_over_gross": quotient(np.abs([x_sp, x_pr]).max(), 2 * r_cp * np.ptp(theta[:, 0])),
        "phase_gap_rad": RING_CYCLES * np.abs(speed[:, 0] * time - theta[:, 0]).max(),
    }


def _positioning(run: Course) -> dict[str, float | None]:
    """Fig. 10: final errors [rad], overshoots and settling times [s] of both joints."""
    time, theta = run.time, run.theta
    drive = run.case.scenario.drive
    assert isinstance(drive, PdDrive)
    target = float(np.mean(drive.target_rad))
    numbers: dict[str, float | None] = {}
    for joint in (1, 2):
        angle = theta[:, joint - 1]
        numbers |= {
            f"final_{joint}_rad": abs(angle[-1] - target),
            f"overshoot_{joint}": events.overshoot(angle, target),
            **{
                f"settling_{joint}_{band:g}_s": events.settling(time, angle, target, band)
                for band in SETTLING_BANDS
            },
        }
    return numbers


def _fourth(run: Course, rigid: Course) -> dict[str, float | None]:
    """What happens when the teeth return to their first side."""
    time = run.time
    back = events.teeth_return(time, run.F_sp)
    if back is None:
        return {"return_s": None, "fourth": None, "speed_at_return": None}
    excess = run.theta_ddot[:, 0] - rigid.theta_ddot[:, 0]
    speed = np.abs(run.theta_dot[:, 0])
    around = signals.window(time, back, back + FOURTH_S)
    return {
        "return_s": back,
        "fourth": signals.amplitude(excess[around]),
        "speed_at_return": speed[np.searchsorted(time, back)] / speed.max(),
    }
