"""The numbers of one run under PD control that the paper's statements are about.

Excess is the detailed arm's acceleration less that of the rigid arm at level `coupled`; mesh
quantities are those of the shoulder's sun-planet pair, first planet.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from crosscheck import signals
from crosscheck.analytic.paper.kinematics import stage_geometry
from crosscheck.audit.experiments.torque import RING_CYCLES, correlation, decay, fast
from crosscheck.audit.experiments.variant import Numbers
from crosscheck.audit.measures import events
from crosscheck.audit.measures.course import Course
from crosscheck.audit.measures.events import (
    AT_ONCE_S,
    IMPACT_S,
    PEAK_S,
    STABLE_S,
    THIRD_S,
    SideChange,
)
from crosscheck.audit.measures.stage import geared_joint
from crosscheck.audit.measures.thresholds import MINOR
from crosscheck.audit.measures.undefined import finite, quotient
from crosscheck.models.experiment.scenario import PdDrive

FIRST_S = (0.0, 0.25)
CONVERGED_S = 0.15  # after an impact its vibration is followed for so long
FOURTH_S = 0.4
LOWEST_HZ, LOW_HZ, LINE_HZ = 20.0, 500.0, 50.0  # "low frequency"; half the width of a line
START_S = 1e-3  # at the very start the meshes touch without force
MULTIPLES = (2, 3, 4)  # of a frequency, that may stand out as well
# Over the median around it: of eleven lines of pure noise one does so in 2 of 10 000 spectra.
STANDS_OUT = 4.0
Found = dict[str, float | None]


@dataclass(frozen=True)
class _Looked:
    """A run with the windows of its first three fluctuations. excess (times, joints)."""

    run: Course
    excess: np.ndarray

    @cached_property
    def side(self) -> SideChange | None:
        return events.side_change(self.run.time, self.run.F_sp)

    @cached_property
    def start(self) -> slice:
        return signals.window(self.run.time, *FIRST_S)

    @cached_property
    def second(self) -> slice:
        """What a side change brings; nothing without one."""
        return self.within(0.0, IMPACT_S)

    @cached_property
    def third(self) -> slice:
        return events.third_after(self.run.time, self.run.F_sp, self.run.F_outer[:, 0])

    @cached_property
    def near(self) -> slice:
        """PEAK_S around the third fluctuation's peak; nothing without one."""
        if self.third.stop <= self.third.start:
            return slice(0, 0)
        return events.third_peak(self.run.time, self.excess[:, 0], self.third)

    def within(self, begin_s: float, end_s: float) -> slice:
        """Counted from the contact after the side change; nothing without one."""
        if self.side is None:
            return slice(0, 0)
        return signals.window(self.run.time, self.side.met_s + begin_s, self.side.met_s + end_s)


def transient(run: Course, rigid: Course) -> Numbers:
    """Figs. 11-14, 16-20: the fluctuations of the first 1.2 s."""
    looked = _Looked(run, run.theta_ddot - rigid.theta_ddot)
    gap = run.theta - rigid.theta
    return finite(
        {
            **_first(looked),
            **_second(looked),
            **_third(looked),
            **_spectra(looked),
            **_loads(looked),
            **_contacts(looked, rigid),
            **_mesh_rates(run),
            "deviation_rad": signals.amplitude(gap),
            "theta_fast_rad": signals.amplitude(fast(run.time, gap[:, 0], part=looked.third)),
            "planets_apart_m": run.planets_apart_m,
        }
    )


def whole(run: Course, rigid: Course) -> Numbers:
    """Figs. 10-14: all of the 3 s."""
    more = {**_positioning(run), **_fourth(run, rigid)}
    more["gap_end_rad"] = signals.amplitude(run.theta[-1] - rigid.theta[-1])
    return {**transient(run, rigid), **finite(more)}


def _first(looked: _Looked) -> Found:
    time, excess = looked.run.time, looked.excess[:, 0]
    later = looked.excess[signals.window(looked.run.time, FIRST_S[1], THIRD_S[1]), 0]
    impact = signals.window(time, 0.0, CONVERGED_S)
    return {
        "first": signals.amplitude(excess[looked.start]),
        "first_decay_s": decay(time[impact], excess[impact]),
        "after_start": signals.amplitude(later),
    }


def _second(looked: _Looked) -> Found:
    """The fluctuation at a side change, and the teeth's way to the other side."""
    run, side, change = looked.run, looked.side, looked.second
    if side is None:
        return dict.fromkeys(_SECOND)
    time, force = run.time, run.F_sp
    excess = looked.excess[:, 0]
    left_s = side.met_s if side.left_s is None else side.left_s
    before = excess[signals.window(time, left_s - IMPACT_S / 2, left_s)]
    onset = signals.onset(time[change], excess[change])
    impact = looked.within(0.0, CONVERGED_S)
    later = force[looked.within(0.0, THIRD_S[1] - side.met_s)]
    return {
        "side_change_s": side.met_s,
        "second": signals.amplitude(excess[change]),
        "second_over_before": quotient(
            signals.amplitude(excess[change]), signals.amplitude(before)
        ),
        "second_decay_s": decay(time[impact], excess[impact]),
        "second_delay_s": None if onset is None else onset - side.met_s,
        "second_force_N": signals.amplitude(force[looked.within(0.0, AT_ONCE_S)]),
        "bouncing_s": events.bouncing(time, force, side.met_s),
        "opposite_share": signals.mean(later[later != 0] < 0),
        **_flight(run, side),
    }


def _flight(run: Course, side: SideChange) -> Found:
    """From the last contact of the first flanks to the first of the others."""
    if side.left_s is None:
        return {"jump_um": None, "flight_s": None}
    parting, meeting = np.searchsorted(run.time, (side.left_s, side.met_s))
    return {
        "jump_um": 1e6 * (run.x_sp[parting] - run.x_sp[meeting]),
        "flight_s": side.met_s - side.left_s,
    }


_SECOND = (
    "side_change_s",
    "second",
    "second_over_before",
    "second_decay_s",
    "second_delay_s",
    "second_force_N",
    "bouncing_s",
    "opposite_share",
    "jump_um",
    "flight_s",
)


def _third(looked: _Looked) -> Found:
    """Sizes [rad/s^2] and course of the third fluctuation."""
    time, part, side = looked.run.time, looked.third, looked.side
    window, shoulder = time[part], looked.excess[part, 0]
    if not window.size:
        return dict.fromkeys(_THIRD)
    beginning = signals.amplitude(shoulder[: np.searchsorted(window, window[0] + PEAK_S)])
    onset = events.third_onset(time, looked.excess[:, 0], part)
    return {
        "third": signals.amplitude(shoulder),
        "third_elbow": signals.amplitude(looked.excess[part, 1]),
        "third_growth": quotient(signals.amplitude(shoulder), beginning),
        "third_onset_s": onset,
        "third_gap_s": None if onset is None or side is None else onset - side.met_s,
    }


_THIRD = ("third", "third_elbow", "third_growth", "third_onset_s", "third_gap_s")


def _spectra(looked: _Looked) -> Found:
    """Of both joints' accelerations in the 0.1 s around the third fluctuation's peak."""
    time, near = looked.run.time, looked.near
    if not time[near].size:
        return {f"{name}{joint}{unit}": None for joint in _JOINTS for name, unit in _SPECTRAL}
    numbers: Found = {}
    for joint, name in enumerate(_JOINTS):
        static = abs(looked.run.theta_ddot[near, joint].mean())
        found = _lines(time[near], looked.excess[near, joint], static)
        numbers |= {f"{key}{name}{unit}": found[key] for key, unit in _SPECTRAL}
    return numbers


_JOINTS = ("", "_elbow")
_SPECTRAL = (
    ("line", ""),
    ("static_over_line", ""),
    ("frequency", "_Hz"),
    ("overtones", ""),
    ("low_share", ""),
    ("line_share", ""),
)


def _lines(time: np.ndarray, values: np.ndarray, static: float) -> Found:
    """What a spectrum tells; where values are less than MINOR only how little that is."""
    frequency, lines = signals.spectrum(time, values)
    peak = signals.largest_of(frequency, lines, signals.VIBRATION_HZ).frequency_Hz
    line = _line(frequency, lines, peak)
    sizes: Found = {"line": line, "static_over_line": quotient(static, line)}
    if signals.amplitude(values) < MINOR:
        return sizes | dict.fromkeys(("frequency", "overtones", "low_share", "line_share"))
    return sizes | {
        "frequency": peak,
        "overtones": float(sum(_stands_out(frequency, lines, n * peak, peak) for n in MULTIPLES)),
        "low_share": _share(frequency, lines, LOWEST_HZ, LOW_HZ),
        "line_share": _share(frequency, lines, peak - LINE_HZ, peak + LINE_HZ),
    }


def _line(frequency: np.ndarray, lines: np.ndarray, at: float) -> float:
    """Largest line within LINE_HZ of a frequency; nan for none."""
    near = lines[np.abs(frequency - at) <= LINE_HZ]
    return float(near.max()) if near.size else np.nan


def _stands_out(frequency: np.ndarray, lines: np.ndarray, at: float, fundamental: float) -> bool:
    """Whether a line does of what lies around it, up to half a fundamental away."""
    around = lines[np.abs(frequency - at) <= fundamental / 2]
    return _line(frequency, lines, at) >= STANDS_OUT * np.median(around)


def _share(frequency: np.ndarray, lines: np.ndarray, low: float, high: float) -> float:
    """Share of the energy above LOWEST_HZ that lies between two frequencies; nan without energy."""
    energy = lines**2 * (frequency >= LOWEST_HZ)
    inside = (frequency >= low) & (frequency <= high)
    return quotient(float(energy[inside].sum()), float(energy.sum()))


def _loads(looked: _Looked) -> Found:
    """Mesh force, torque and speed in the third fluctuation."""
    run, part = looked.run, looked.third
    time, torque, speed, force = run.time, run.torque, run.theta_dot[:, 0], run.F_sp
    shaken = [fast(time, column, part=part) for column in torque.T]
    changes = events.passages(force[part][force[part] != 0])
    return {
        "third_force_N": signals.amplitude(force[part]),
        "third_force_fast_N": signals.amplitude(fast(time, force, part=part)),
        "torque_fast_1": _share_of_largest(shaken[0], torque[:, 0]),
        "torque_fast_2": _share_of_largest(shaken[1], torque[:, 1]),
        "torque_follows": _envelopes_correlate(time, shaken[0], looked.excess[part, 0]),
        "torque_frequency_Hz": _frequency(looked, shaken[0]),
        "speed_fast": quotient(
            signals.amplitude(fast(time, speed, part=part)), signals.mean(np.abs(speed[part]))
        ),
        "side_changes": float(changes.size) if force[part].size else None,
    }


def _frequency(looked: _Looked, values: np.ndarray) -> float | None:
    """Dominant one of the third fluctuation's values in the 0.1 s around its peak."""
    near, begin = looked.near, looked.third.start
    if near.stop <= near.start or signals.amplitude(looked.excess[near, 0]) < MINOR:
        return None
    inside = values[near.start - begin : near.stop - begin]
    return signals.dominant_frequency(looked.run.time[near], inside, LOWEST_HZ)


def _share_of_largest(part: np.ndarray, whole: np.ndarray) -> float:
    return quotient(signals.amplitude(part), signals.amplitude(whole))


def _envelopes_correlate(time: np.ndarray, one: np.ndarray, other: np.ndarray) -> float:
    """Correlation of the largest magnitudes in every 10 ms."""
    if not one.size:
        return np.nan
    bins = np.arange(0, one.size, round(0.01 / (time[1] - time[0])))
    peaks = [np.maximum.reduceat(np.abs(values), bins) for values in (one, other)]
    return correlation(peaks[0], peaks[1])


def _contacts(looked: _Looked, rigid: Course) -> Found:
    """Zero acceleration and open teeth in the three fluctuations, if there are all.

    Accelerations that pass zero count where the excess, not the rigid arm's own course, brings
    them there.
    """
    run, windows = looked.run, _three(looked)
    apart = run.F_sp == 0
    shares: Found = {"apart_share": signals.mean(apart[signals.window(run.time, START_S, np.inf)])}
    if any(window.stop <= window.start for window in windows):
        return shares | dict.fromkeys(("zero_windows", "apart_windows", "apart_at_zero"))
    own, shaken = run.theta_ddot[:, 0], np.abs(looked.excess[:, 0]) > MINOR
    reversed_ = shaken & (own * rigid.theta_ddot[:, 0] < 0)
    zeros = np.concatenate([w.start + events.passages(own[w]) for w in windows])
    zeros = zeros[shaken[zeros]]
    return shares | {
        "zero_windows": float(sum(reversed_[w].any() for w in windows)),
        "apart_windows": float(sum(apart[w].any() for w in windows)),
        "apart_at_zero": signals.mean(apart[zeros] | apart[zeros + 1]),
    }


def _three(looked: _Looked) -> tuple[slice, slice, slice]:
    """Windows of the first three fluctuations; the second's with the flight before the impact."""
    start = signals.window(looked.run.time, START_S, FIRST_S[1])
    side = looked.side
    flight_s = 0.0 if side is None or side.left_s is None else side.met_s - side.left_s
    return start, looked.within(-flight_s, IMPACT_S), looked.third


def _mesh_rates(run: Course) -> Found:
    """What Eq. 11 neglects, how small the teeth's motion is, how far omega t is off its integral.

    Rates by central differences of the recorded displacements, once the start is over: there the
    arm itself has no speed yet.
    """
    time, theta, speed = (run.time, run.theta, run.theta_dot)
    x_sp, x_pr, later = run.x_sp, run.x_pr, signals.window(time, FIRST_S[1], np.inf)
    sp_rate, pr_rate = (np.gradient(x, time[1] - time[0])[later] for x in (x_sp, x_pr))
    r_cp = stage_geometry(geared_joint(run.case.arm)).r_cp
    top = np.abs(speed[:, 0]).max()
    fastest = max(map(signals.amplitude, (sp_rate, pr_rate)))
    furthest = max(map(signals.amplitude, (x_sp, x_pr)))
    return {
        "mesh_rate_over_speed": quotient(fastest, top),
        "neglected_in_eq11": quotient(signals.amplitude(sp_rate + pr_rate), 2 * r_cp * top),
        "mesh_over_gross": quotient(furthest, 2 * r_cp * np.ptp(theta[:, 0])),
        "phase_gap_rad": RING_CYCLES * np.abs(speed[:, 0] * time - theta[:, 0]).max(),
    }


def _positioning(run: Course) -> Found:
    """Fig. 10: both joints' way to 30 degrees, and how near they are late."""
    drive = run.case.scenario.drive
    assert isinstance(drive, PdDrive)
    target = float(np.mean(drive.target_rad))
    numbers: Found = {}
    for joint, angle in enumerate(run.theta.T, start=1):
        numbers |= {
            f"final_{joint}_rad": abs(angle[-1] - target),
            f"overshoot_{joint}": events.overshoot(angle, target),
            f"setback_{joint}": events.setback(angle, target),
            f"late_distance_{joint}": events.distance_from(run.time, angle, target, STABLE_S),
        }
    return numbers


def _fourth(run: Course, rigid: Course) -> Found:
    """What happens when the teeth return to their first side."""
    time = run.time
    back = events.teeth_return(time, run.F_sp)
    if back is None:
        return dict.fromkeys(("return_s", "fourth", "fourth_over_before", "speed_at_return"))
    excess = run.theta_ddot[:, 0] - rigid.theta_ddot[:, 0]
    speed = np.abs(run.theta_dot[:, 0])
    after, before = (
        signals.amplitude(excess[signals.window(time, *part)])
        for part in ((back, back + IMPACT_S), (back - IMPACT_S, back - IMPACT_S / 2))
    )
    return {
        "return_s": back,
        "fourth": signals.amplitude(excess[signals.window(time, back, back + FOURTH_S)]),
        "fourth_over_before": quotient(after, before),
        "speed_at_return": speed[np.searchsorted(time, back)] / speed.max(),
    }
