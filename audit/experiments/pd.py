"""The numbers of one run under PD control that the paper's statements are about.

Excess is the detailed arm's acceleration less that of the rigid arm at level `coupled`; mesh
quantities are those of the shoulder's sun-planet pair, first planet. The window of an event that
does not happen is empty, and what is measured in it is nan.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from crosscheck import signals
from crosscheck.analytic.paper.kinematics import stage_geometry
from crosscheck.audit.experiments.torque import RING_CYCLES, correlation, decay_time, fast_part
from crosscheck.audit.experiments.variant import Numbers
from crosscheck.audit.measures import events
from crosscheck.audit.measures.run_signals import RunSignals
from crosscheck.audit.measures.stage import geared_joint
from crosscheck.audit.measures.thresholds import MINOR
from crosscheck.audit.measures.undefined import floats_or_none, quotient
from crosscheck.models.experiment.scenario import PdDrive

FIRST_S = (0.0, 0.25)
CONVERGED_S = 0.15  # after an impact its vibration is followed for so long
FOURTH_S = 0.4
LOWEST_HZ, LOW_HZ, LINE_HZ = 20.0, 500.0, 50.0  # "low frequency"; half the width of a line
START_S = 1e-3  # at the very start the meshes touch without force
MULTIPLES = (2, 3, 4)  # of a frequency, that may stand out as well
# Over the median around it: of eleven lines of pure noise one does so in 2 of 10 000 spectra.
STANDS_OUT = 4.0
PEAKS_S = 0.01  # the largest magnitudes of so long each make an envelope
OptionalNumbers = dict[str, float | None]


@dataclass(frozen=True)
class _Fluctuations:
    """A run with the windows of its first three fluctuations. excess (times, joints)."""

    run: RunSignals
    excess: np.ndarray

    @cached_property
    def side(self) -> events.SideChange:
        """The teeth's change of sides; its times are nan without one."""
        nothing = events.SideChange(np.nan, np.nan)
        return events.side_change(self.run.time, self.run.F_sp) or nothing

    @cached_property
    def third_window(self) -> slice:
        return events.third_window(self.run.time, self.run.F_sp, self.run.F_outer[:, 0])

    @cached_property
    def peak_window(self) -> slice:
        """The samples of PEAK_S around the third fluctuation's peak; empty without one."""
        if self.third_window.stop <= self.third_window.start:
            return slice(0, 0)
        return events.third_peak(self.run.time, self.excess[:, 0], self.third_window)

    def window_after_contact(self, begin_s: float, end_s: float) -> slice:
        """The samples between two times after the side change's contact; empty without a change."""
        return signals.window(self.run.time, self.side.met_s + begin_s, self.side.met_s + end_s)


def measure_transient_pd(run: RunSignals, rigid: RunSignals) -> Numbers:
    """Numbers of Figs. 11-14 and 16-20: the fluctuations of the first 1.2 s."""
    fluctuations = _Fluctuations(run, run.theta_ddot - rigid.theta_ddot)
    gap = run.theta - rigid.theta
    return floats_or_none(
        {
            **_impacts(fluctuations),
            **_third_fluctuation(fluctuations),
            **_spectra(fluctuations),
            **_loads(fluctuations),
            **_contacts(fluctuations, rigid),
            **_mesh_rates(run),
            "deviation_rad": signals.amplitude(gap),
            "theta_fast_rad": signals.amplitude(
                fast_part(run.time, gap[:, 0], part=fluctuations.third_window)
            ),
            "planets_apart_m": run.planet_spread_m,
        }
    )


def measure_whole_pd(run: RunSignals, rigid: RunSignals) -> Numbers:
    """Numbers of Figs. 10-14: all of the 3 s."""
    more = {**_positioning(run), **_fourth_fluctuation(run, rigid)}
    more["gap_end_rad"] = signals.amplitude(run.theta[-1] - rigid.theta[-1])
    return {**measure_transient_pd(run, rigid), **floats_or_none(more)}


def _impacts(fluctuations: _Fluctuations) -> OptionalNumbers:
    """Numbers of the fluctuations at the start and at a side change, and the teeth's way across."""
    run, (left_s, met_s) = fluctuations.run, fluctuations.side
    time, force, excess = run.time, run.F_sp, fluctuations.excess[:, 0]
    start = signals.window(time, 0.0, CONVERGED_S)
    first = signals.amplitude(excess[signals.window(time, *FIRST_S)])
    later = signals.amplitude(excess[signals.window(time, FIRST_S[1], events.THIRD_S[1])])
    change, impact = (
        fluctuations.window_after_contact(0.0, events.IMPACT_S),
        fluctuations.window_after_contact(0.0, CONVERGED_S),
    )
    second = signals.amplitude(excess[change])
    parted_s = met_s if np.isnan(left_s) else left_s
    before = excess[signals.window(time, parted_s - events.IMPACT_S / 2, parted_s)]
    onset = signals.onset(time[change], excess[change])
    after = force[fluctuations.window_after_contact(0.0, events.THIRD_S[1] - met_s)]
    # Without the last time nan is a place, too: that of the last sample.
    parting, meeting = run.x_sp[np.searchsorted(time[:-1], (left_s, met_s))]
    return {
        "first": first,
        "first_decay_s": decay_time(time[start], excess[start]),
        "after_start": later,
        "side_change_s": met_s,
        "second": second,
        "second_over_before": quotient(second, signals.amplitude(before)),
        "second_decay_s": decay_time(time[impact], excess[impact]),
        "second_delay_s": None if onset is None else onset - met_s,
        "second_force_N": signals.amplitude(
            force[fluctuations.window_after_contact(0.0, events.AT_ONCE_S)]
        ),
        "bouncing_s": None if np.isnan(met_s) else events.bounce_duration(time, force, met_s),
        "opposite_share": signals.mean_value(after[after != 0] < 0),
        "jump_um": None if np.isnan(left_s) else 1e6 * (parting - meeting),
        "flight_s": met_s - left_s,
    }


def _third_fluctuation(fluctuations: _Fluctuations) -> OptionalNumbers:
    """Numbers of the third fluctuation: sizes [rad/s^2] and course."""
    time, part, excess = fluctuations.run.time, fluctuations.third_window, fluctuations.excess
    size, elbow = (signals.amplitude(excess[part, joint]) for joint in (0, 1))
    soon_s = time[part].min(initial=np.inf) + events.PEAK_S
    beginning = signals.amplitude(excess[part, 0][time[part] < soon_s])
    onset = signals.onset(time[part], excess[part, 0])
    return {
        "third": size,
        "third_elbow": elbow,
        "third_growth": quotient(size, beginning),
        "third_onset_s": onset,
        "third_gap_s": None if onset is None else onset - fluctuations.side.met_s,
    }


def _spectra(fluctuations: _Fluctuations) -> OptionalNumbers:
    """Spectral numbers of both joints' excess in the 0.1 s around the third fluctuation's peak.

    Where the excess is below MINOR, only how little it is.
    """
    near, numbers = fluctuations.peak_window, OptionalNumbers()
    for joint, name in enumerate(("", "_elbow")):
        values = fluctuations.excess[near, joint]
        frequency, lines = signals.spectrum(fluctuations.run.time[near], values)
        peak = signals.dominant_frequency(fluctuations.run.time[near], values)
        line = _line(frequency, lines, peak)
        static = abs(signals.mean_value(fluctuations.run.theta_ddot[near, joint]))
        numbers |= {f"line{name}": line, f"static_over_line{name}": quotient(static, line)}
        is_evident = signals.amplitude(values) >= MINOR
        multiples = [n * peak for n in MULTIPLES] if is_evident else []
        evident = {
            f"frequency{name}_Hz": peak,
            f"overtones{name}": float(
                sum(_is_prominent(frequency, lines, at, peak) for at in multiples)
            ),
            f"low_share{name}": _share(frequency, lines, LOWEST_HZ, LOW_HZ),
            f"line_share{name}": _share(frequency, lines, peak - LINE_HZ, peak + LINE_HZ),
        }
        numbers |= evident if is_evident else dict.fromkeys(evident)
    return numbers


def _line(frequency: np.ndarray, lines: np.ndarray, at: float) -> float:
    """The largest line within LINE_HZ of a frequency; nan if there is none."""
    return signals.amplitude(lines[np.abs(frequency - at) <= LINE_HZ])


def _is_prominent(frequency: np.ndarray, lines: np.ndarray, at: float, fundamental: float) -> bool:
    """Whether a line is at least STANDS_OUT times the median within half a fundamental."""
    around = lines[np.abs(frequency - at) <= fundamental / 2]
    return _line(frequency, lines, at) >= STANDS_OUT * np.median(around)


def _share(frequency: np.ndarray, lines: np.ndarray, low: float, high: float) -> float:
    """Share of the energy above LOWEST_HZ that lies between two frequencies; nan without energy."""
    energy = lines**2 * (frequency >= LOWEST_HZ)
    inside = (frequency >= low) & (frequency <= high)
    return quotient(float(energy[inside].sum()), float(energy.sum()))


def _loads(fluctuations: _Fluctuations) -> OptionalNumbers:
    """Numbers of mesh force, torque and speed in the third fluctuation."""
    run, part, near = fluctuations.run, fluctuations.third_window, fluctuations.peak_window
    time, speed, force = run.time, run.theta_dot[:, 0], run.F_sp
    shaken = [fast_part(time, column, part=part) for column in run.torque.T]
    of_largest = [
        quotient(signals.amplitude(quick), signals.amplitude(column))
        for quick, column in zip(shaken, run.torque.T, strict=True)
    ]
    frequency = None
    if signals.amplitude(fluctuations.excess[near, 0]) >= MINOR:
        inside = shaken[0][near.start - part.start : near.stop - part.start]
        frequency = signals.dominant_frequency(time[near], inside, LOWEST_HZ)
    slow = signals.mean_value(np.abs(speed[part]))
    changes = events.zero_crossings(force[part][force[part] != 0])
    return {
        "third_force_N": signals.amplitude(force[part]),
        "third_force_fast_N": signals.amplitude(fast_part(time, force, part=part)),
        "torque_fast_1": of_largest[0],
        "torque_fast_2": of_largest[1],
        "torque_follows": _envelope_correlation(time, shaken[0], fluctuations.excess[part, 0]),
        "torque_frequency_Hz": frequency,
        "speed_fast": quotient(signals.amplitude(fast_part(time, speed, part=part)), slow),
        "side_changes": float(changes.size) if force[part].size else None,
    }


def _envelope_correlation(time: np.ndarray, first: np.ndarray, second: np.ndarray) -> float:
    """Correlation of two signals' largest magnitudes in every 10 ms; nan for empty signals."""
    if not first.size:
        return np.nan
    bins = np.arange(0, first.size, round(PEAKS_S / (time[1] - time[0])))
    return correlation(*(np.maximum.reduceat(np.abs(values), bins) for values in (first, second)))


def _contacts(fluctuations: _Fluctuations, rigid: RunSignals) -> OptionalNumbers:
    """Numbers of zero acceleration and open teeth in the three fluctuations, if there are all.

    Accelerations that pass zero count where the excess, not the rigid arm's own course, brings
    them there. The second fluctuation's window begins with the flight before the impact.
    """
    run, time = fluctuations.run, fluctuations.run.time
    is_open = run.F_sp == 0
    left_s, met_s = fluctuations.side
    flight_s = 0.0 if np.isnan(left_s) else met_s - left_s
    windows = (
        signals.window(time, START_S, FIRST_S[1]),
        fluctuations.window_after_contact(-flight_s, events.IMPACT_S),
        fluctuations.third_window,
    )
    shares: OptionalNumbers = {
        "apart_share": signals.mean_value(is_open[signals.window(time, START_S, np.inf)])
    }
    if any(window.stop <= window.start for window in windows):
        return shares | dict.fromkeys(("zero_windows", "apart_windows", "apart_at_zero"))
    acceleration, shaken = run.theta_ddot[:, 0], np.abs(fluctuations.excess[:, 0]) > MINOR
    reversed_ = shaken & (acceleration * rigid.theta_ddot[:, 0] < 0)
    zeros = np.concatenate([w.start + events.zero_crossings(acceleration[w]) for w in windows])
    zeros = zeros[shaken[zeros]]
    return shares | {
        "zero_windows": float(sum(reversed_[w].any() for w in windows)),
        "apart_windows": float(sum(is_open[w].any() for w in windows)),
        "apart_at_zero": signals.mean_value(is_open[zeros] | is_open[zeros + 1]),
    }


def _mesh_rates(run: RunSignals) -> OptionalNumbers:
    """Numbers of what Eq. 11 neglects, how far teeth move, and how far omega t is off its integral.

    Rates by central differences of the recorded displacements, once the start is over: there the
    arm itself has no speed yet.
    """
    time, theta, speed = run.time, run.theta[:, 0], run.theta_dot[:, 0]
    later, x = signals.window(time, FIRST_S[1], np.inf), (run.x_sp, run.x_pr)
    sp_rate, pr_rate = (np.gradient(each, time[1] - time[0])[later] for each in x)
    r_cp = stage_geometry(geared_joint(run.case.arm)).r_cp
    top = np.abs(speed).max()
    fastest, furthest = (max(map(signals.amplitude, each)) for each in ((sp_rate, pr_rate), x))
    return {
        "mesh_rate_over_speed": quotient(fastest, top),
        "neglected_in_eq11": quotient(signals.amplitude(sp_rate + pr_rate), 2 * r_cp * top),
        "mesh_over_gross": quotient(furthest, 2 * r_cp * np.ptp(theta)),
        "phase_gap_rad": RING_CYCLES * np.abs(speed * time - theta).max(),
    }


def _positioning(run: RunSignals) -> OptionalNumbers:
    """Numbers of Fig. 10: both joints' way to 30 degrees, and how near they are late."""
    drive, numbers = run.case.scenario.drive, OptionalNumbers()
    assert isinstance(drive, PdDrive)
    target = float(np.mean(drive.target_rad))
    for joint, angle in enumerate(run.theta.T, start=1):
        late = events.distance_from(run.time, angle, target, events.STABLE_S)
        numbers |= {
            f"final_{joint}_rad": abs(angle[-1] - target),
            f"overshoot_{joint}": events.overshoot(angle, target),
            f"setback_{joint}": events.setback(angle, target),
            f"late_distance_{joint}": late,
        }
    return numbers


def _fourth_fluctuation(run: RunSignals, rigid: RunSignals) -> OptionalNumbers:
    """Numbers of what happens when the teeth return to their first side."""
    back = events.teeth_return(run.time, run.F_sp)
    back = np.nan if back is None else back
    excess, speed = run.theta_ddot[:, 0] - rigid.theta_ddot[:, 0], np.abs(run.theta_dot[:, 0])
    after, before, fourth = (
        signals.amplitude(excess[signals.window(run.time, *part)])
        for part in (
            (back, back + events.IMPACT_S),
            (back - events.IMPACT_S, back - events.IMPACT_S / 2),
            (back, back + FOURTH_S),
        )
    )
    there = slice(int(np.searchsorted(run.time, back)), None)
    return {
        "return_s": back,
        "fourth": fourth,
        "fourth_over_before": quotient(after, before),
        "speed_at_return": signals.mean_value(speed[there][:1]) / speed.max(),
    }
