"""The numbers of one run that the paper's statements are about: torque-driven experiments.

Mesh quantities are those of the shoulder's sun-planet pair, first planet. Every measure has all its
numbers for every run: None for what the run does not last for, or what does not happen in it. The
rigid arm beside a run is given at the run's own times.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.ndimage import uniform_filter1d

from crosscheck import signals
from crosscheck.analytic.paper.kinematics import stage_geometry
from crosscheck.audit.experiments.variant import Numbers
from crosscheck.audit.measures.run_signals import RunSignals
from crosscheck.audit.measures.stage import geared_joint
from crosscheck.audit.measures.undefined import floats_or_none, quotient
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.stiffness import SineStiffness
from crosscheck.registry import RIGID_LEVELS

SETTLED_S = 0.1  # constant torque: the starting transient is over
HALFWAY_S = 0.25
TURN_M = 2e-6  # a turning point of the ripple of 2 E = 10 um
DECAYED = 0.1  # of the largest value
RINGING_S = 0.0012  # two periods of the slower mesh mode
SMOOTHING_S = 0.01  # slower than the meshes' vibrations, faster than the arm's motion
# Back and forth: while errors are small; then every 0.2 s, by the end.
ERROR_WINDOWS_S = {
    "early": (0.1, 0.3),
    **{f"{end / 10:g}_s": (end / 10 - 0.2, end / 10) for end in range(4, 21, 2)},
}
FEWEST = 3  # samples that a straight trend can be taken off
RING_CYCLES = 99.0  # Eq. 12 over the carrier's rate


def measure_constant_torque(run: RunSignals, *rigid: RunSignals) -> Numbers:
    """Numbers of Figs. 6-9: deviations from the rigid levels, mesh displacement and force."""
    time, x, force = run.time, run.x_sp, run.F_sp
    late = signals.window(time, SETTLED_S, np.inf)
    start = slice(0, late.start)
    speed = np.abs(run.theta_dot[:, 0])
    others = (run.F_pr, *run.F_outer.T)  # pairs that the paper does not show, of first planets
    error = geared_joint(run.case.arm).sun_mesh.planet_mesh(0).tooth_error_m
    return floats_or_none(
        {
            **_deviations(run, dict(zip(RIGID_LEVELS, rigid, strict=True))),
            "x_middle_um": 1e6 * signals.middle(x[late]),
            "x_ripple_um": 1e6 * signals.peak_to_peak(x[late]),
            "vibration_decay_s": _ringing_s(time, force),
            "x_ripple_over_2E": quotient(signals.peak_to_peak(x[late]), 2 * error),
            "force_at_start_N": abs(force[0]),
            "ringing_N": signals.amplitude(fast_part(time, force, RINGING_S, start)),
            "force_decay": _calming(force, start, late),
            "others_decay": np.min([_calming(pair, start, late) for pair in others]),
            "others_decay_s": np.max([_ringing_s(time, pair) for pair in others]),
            "others_ripple_N": np.max([ripple(pair[late]) for pair in others]),
            "theta_1_rad": run.theta[-1, 0],
            "stroke_1": np.ptp(run.theta[:, 0]) / np.pi,
            "stroke_2": np.ptp(run.theta[:, 1]) / np.pi,
            "turns_gained": _turns_gained(time, x),
            "speeding_up": (np.diff(speed) > 0).mean(),
            "stiffness_follows": _stiffness_follows(run, late),
            "torque_gain": _torque_gain(run, late),
        }
    )


def _ringing_s(time: np.ndarray, force: np.ndarray) -> float:
    """Time [s] in which a mesh force's own vibration falls to a tenth."""
    return decay_time(time, fast_part(time, force, RINGING_S))


def _calming(force: np.ndarray, start: slice, late: slice) -> float:
    """The swing of a mesh force at the start over its swing later."""
    return quotient(ripple(force[start]), ripple(force[late]))


def measure_back_and_forth(run: RunSignals, rigid: RunSignals, shifted: RunSignals) -> Numbers:
    """Numbers of Fig. 15: the shoulder's largest distance [rad] from the rigid arm in every window.

    ``own``: that of the rigid arm ``shifted``, which starts a little away: its own sensitivity.
    """
    gaps = {
        "error": run.theta[:, 0] - rigid.theta[:, 0],
        "own": shifted.theta[:, 0] - rigid.theta[:, 0],
    }
    return floats_or_none(
        {
            f"{kind}_{name}": signals.amplitude(gap[signals.window(run.time, *limits)])
            for kind, gap in gaps.items()
            for name, limits in ERROR_WINDOWS_S.items()
        }
    )


def _deviations(run: RunSignals, levels: Mapping[str, RunSignals]) -> dict[str, float]:
    """Numbers of detailed less rigid, at every level: joints [rad], tip [mm], late over early."""
    arm, half = run.case.arm, run.time.size // 2
    tip = find_tip(run.theta, arm)
    numbers: dict[str, float] = {}
    for level, rigid in levels.items():
        gap = np.abs(run.theta - rigid.theta)
        distance = np.abs(tip - find_tip(rigid.theta, arm))
        numbers |= {
            f"deviation_1_{level}_rad": gap[:, 0].max(),
            f"deviation_2_{level}_rad": gap[:, 1].max(),
            f"growth_{level}": quotient(distance[half:].max(), distance[:half].max()),
            f"tip_{level}_mm": 1e3 * distance.max(),
            f"relative_{level}": quotient(gap.max(), np.abs(run.theta).max()),
            f"stroke_share_{level}": gap.max() / np.pi,
            f"own_share_{level}": quotient(gap[:, 0].max(), np.ptp(run.theta[:, 0])),
        }
    return numbers


def find_tip(theta: np.ndarray, arm: Arm) -> np.ndarray:
    """The last link's end [m] (times,) as complex numbers, from relative angles (times, joints)."""
    lengths = np.array([link.length_m for link in arm.links])
    along = np.exp(1j * np.cumsum(theta, axis=1))
    return (along * lengths).sum(axis=1)  # a product of matrices takes 20 times as long


def _turns_gained(time: np.ndarray, values: np.ndarray) -> float:
    """Turning points after HALFWAY_S less those before; nan if the run ends there.

    Of the slow course of values [m]: E's ripple, not ringing.
    """
    if time[-1] <= HALFWAY_S:
        return np.nan
    from scipy.signal import find_peaks  # a second, for this alone

    counts = []
    for part in (signals.window(time, HALFWAY_S, np.inf), signals.window(time, 0, HALFWAY_S)):
        slow = values[part] - fast_part(time, values, part=part)
        turns = [find_peaks(sign * slow, prominence=TURN_M)[0] for sign in (1, -1)]
        counts.append(sum(map(len, turns)))
    return counts[0] - counts[1]


def _stiffness_follows(run: RunSignals, part: slice) -> float:
    """Relative change of the mesh force over the stiffness's; nan if that is not Eq. 8's.

    1 where the deflection decides, 0 where the load does: the slope of both, each over its mean
    and less its straight trend.
    """
    law = geared_joint(run.case.arm).sun_mesh.planet_mesh(0).stiffness
    if not isinstance(law, SineStiffness):
        return np.nan
    depth = law.amplitude_N_per_m / law.mean_N_per_m
    stiffness = _remove_trend(depth * np.sin(mesh_phase(run)[part]))
    force = quotient(1.0, signals.mean_value(run.F_sp[part])) * _remove_trend(run.F_sp[part])
    return quotient(float(stiffness @ force), float(stiffness @ stiffness))


def _torque_gain(run: RunSignals, part: slice) -> float:
    """The meshes' torque on the shoulder's carrier over the motor's torque T / n."""
    joint = geared_joint(run.case.arm)
    geometry = stage_geometry(joint)
    forces = run.F_sp[part] + run.F_pr[part]
    motor = run.torque[part, 0] / geometry.n
    on_carrier = joint.planet_count * geometry.r_cp * signals.mean_value(forces)
    return quotient(on_carrier, signals.mean_value(motor))


def mesh_phase(run: RunSignals) -> np.ndarray:
    """The shoulder's sun mesh phase [rad], (times,), by the run's own law."""
    if run.case.switches.phase == "omega_t":
        return RING_CYCLES * run.theta_dot[:, 0] * run.time
    return RING_CYCLES * run.theta[:, 0]


def fast_part(
    time: np.ndarray, values: np.ndarray, over_s: float = SMOOTHING_S, part: slice = slice(None)
) -> np.ndarray:
    """Values (times,) less their moving average over ``over_s``, taken twice; of ``part`` alone.

    The start is reflected. Within ``over_s`` of the last sample the average is not defined: 0.
    """
    samples = 2 * int(over_s / (time[1] - time[0]) / 2) + 1
    quick = np.zeros(values.size)
    if values.size > samples:
        slow = uniform_filter1d(uniform_filter1d(values, samples), samples)
        quick[:-samples] = (values - slow)[:-samples]
    return quick[part]


def decay_time(time: np.ndarray, values: np.ndarray) -> float:
    """Time [s] from the first sample until values stay below a tenth of the largest; nan if all 0.

    Counted from the event, not from the largest value, so that a vibration that grows does not
    converge at once. One that does not converge gives the time of all samples: it takes longer.
    """
    size = np.abs(values)
    if size.max(initial=0.0) == 0:
        return np.nan
    last = np.flatnonzero(size >= DECAYED * size.max())[-1]
    return float(time[last] - time[0])


def ripple(values: np.ndarray) -> float:
    """Peak to peak of values less their straight trend, so that a slow drift does not count."""
    return signals.peak_to_peak(_remove_trend(values))


def _remove_trend(values: np.ndarray) -> np.ndarray:
    """Values less their straight trend; empty if they are too few to have one."""
    if values.size < FEWEST:
        return np.empty(0)
    step = np.arange(values.size) - (values.size - 1) / 2
    slope = step @ values / (step @ step)
    return values - values.mean() - slope * step


def correlation(first: np.ndarray, second: np.ndarray) -> float:
    """Pearson's correlation of two signals; nan where one does not vary or is too short."""
    if first.size < FEWEST or np.ptp(first) == 0 or np.ptp(second) == 0:
        return np.nan
    return float(np.corrcoef(first, second)[0, 1])
