"""The numbers of one run that the paper's statements are about: torque-driven experiments.

Mesh quantities are those of the shoulder's sun-planet pair, first planet. Every measure has all its
numbers for every run: None for what the run does not last for, or what does not happen in it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import xarray as xr
from scipy.ndimage import uniform_filter1d
from scipy.signal import find_peaks

from analytic.kinematics import StageGeometry
from crosscheck import signals
from crosscheck.checks.trajectories import tip_position
from crosscheck.paper.reading import arm_of, first_mesh, resampled, switches_of
from crosscheck.paper.rigid import beside_every_level, without_gears
from crosscheck.paper.stage import paper_stage
from crosscheck.paper.undefined import finite, quotient
from crosscheck.registry import RIGID_LEVELS
from crosscheck.studies.study import Comparison, Numbers, Variant

SETTLED_S = 0.1  # constant torque: the starting transient is over
HALFWAY_S = 0.25
TURN_M = 2e-6  # a turning point of the ripple of 2 E = 10 um
DECAYED = 0.1  # of the largest value
RINGING_S = 0.0012  # two periods of the slower mesh mode
SMOOTHING_S = 0.01  # slower than the meshes' vibrations, faster than the arm's motion
# Back and forth: errors are small; then the last 0.2 s of each second.
ERROR_WINDOWS_S = {"early": (0.1, 0.3), "1_s": (0.8, 1.0), "2_s": (1.8, 2.0)}
FEWEST = 3  # samples that a straight trend can be taken off
OWN_SHIFT_RAD = 1e-6  # small enough to stay in proportion for 2 s
RING_CYCLES = 99.0  # Eq. 12 over the carrier's rate


def constant_torque(run: xr.Dataset, rigid: tuple[xr.Dataset, ...]) -> Numbers:
    """Figs. 6-9: deviations from the rigid levels, mesh displacement and force."""
    time = run["time"].values
    late = signals.window(time, SETTLED_S, np.inf)
    start = slice(0, late.start)
    x, force = first_mesh(run, "x_sp"), first_mesh(run, "F_sp")
    speed = np.abs(run["theta_dot"].values[:, 0])
    error = paper_stage(arm_of(run)).tooth_error_m
    return finite(
        {
            **_deviations(run, dict(zip(RIGID_LEVELS, rigid, strict=True))),
            "x_middle_um": 1e6 * signals.middle(x[late]),
            "x_ripple_um": 1e6 * signals.peak_to_peak(x[late]),
            "vibration_decay_s": decay(time, fast(time, force, RINGING_S)),
            "x_ripple_over_2E": quotient(signals.peak_to_peak(x[late]), 2 * error),
            "force_at_start_N": abs(force[0]),
            "force_overshoot": quotient(force.max(), signals.mean(force[late])),
            "force_decay": quotient(ripple(force[start]), ripple(force[late])),
            "turns_gained": _turns_gained(time, x),
            "speeding_up": (np.diff(speed) > 0).mean(),
            "stiffness_correlation": _stiffness_correlation(run, late),
            "torque_gain": _torque_gain(run, late),
        }
    )


CONSTANT_TORQUE = Comparison(constant_torque, beside_every_level)


def nudged(variant: Variant) -> tuple[Variant, ...]:
    """The rigid arm from the run's own start, and from OWN_SHIFT_RAD away.

    All at one step: the torque's square root at t = 0 then costs them the same and drops out.
    """
    rigid = without_gears(variant)
    shift = f"scenario.start.theta_rad={OWN_SHIFT_RAD!r}"
    return rigid, replace(rigid, settings=(*rigid.settings, shift))


def back_and_forth(run: xr.Dataset, others: tuple[xr.Dataset, ...]) -> Numbers:
    """Fig. 15: the shoulder's largest distance [rad] from the rigid arm, early and late.

    ``own``: that of a rigid arm which starts OWN_SHIFT_RAD away, for that arm's own sensitivity.
    """
    time = run["time"].values
    rigid, shifted = (resampled(other, "theta", time)[:, 0] for other in others)
    gaps = {"error": run["theta"].values[:, 0] - rigid, "own": shifted - rigid}
    return finite(
        {
            f"{kind}_{name}": signals.amplitude(gap[signals.window(time, *limits)])
            for kind, gap in gaps.items()
            for name, limits in ERROR_WINDOWS_S.items()
        }
    )


BACK_AND_FORTH = Comparison(back_and_forth, nudged)


def _deviations(run: xr.Dataset, levels: Mapping[str, xr.Dataset]) -> dict[str, float]:
    """Detailed less rigid, at every rigid level: joints [rad], tip [mm], late over early half."""
    time, arm = run["time"].values, arm_of(run)
    half = time.size // 2
    numbers: dict[str, float] = {}
    for level, arm_without in levels.items():
        rigid = resampled(arm_without, "theta", time)
        gap = np.abs(run["theta"].values - rigid)
        moved = run.assign(theta=(run["theta"].dims, rigid))
        tip = (tip_position(run, arm) - tip_position(moved, arm)).values
        distance = np.hypot(tip[:, 0], tip[:, 1])
        numbers |= {
            f"deviation_1_{level}_rad": gap[:, 0].max(),
            f"deviation_2_{level}_rad": gap[:, 1].max(),
            f"growth_{level}": quotient(distance[half:].max(), distance[:half].max()),
            f"tip_{level}_mm": 1e3 * distance.max(),
            f"relative_{level}": quotient(gap.max(), np.abs(run["theta"].values).max()),
            f"stroke_share_{level}": gap.max() / np.pi,
        }
    return numbers


def _turns_gained(time: np.ndarray, values: np.ndarray) -> float:
    """Turning points after HALFWAY_S less those before; nan if the run ends there."""
    if time[-1] <= HALFWAY_S:
        return np.nan
    return _turns(time, values, HALFWAY_S, np.inf) - _turns(time, values, 0, HALFWAY_S)


def _turns(time: np.ndarray, values: np.ndarray, begin: float, end: float) -> int:
    """Turning points of the slow course of values [m] in [begin, end), E's ripple, not ringing."""
    slow = (values - fast(time, values))[signals.window(time, begin, end)]
    return sum(len(find_peaks(sign * slow, prominence=TURN_M)[0]) for sign in (1, -1))


def _stiffness_correlation(run: xr.Dataset, part: slice) -> float:
    """Of the mesh force with the mesh stiffness, both less their straight trend."""
    force = first_mesh(run, "F_sp")[part]
    return correlation(_flat(force), _flat(np.sin(mesh_phase(run)[part])))


def _torque_gain(run: xr.Dataset, part: slice) -> float:
    """Torque of the meshes on the shoulder's carrier over the motor's, T / n."""
    stage, planets = geometry(run), arm_of(run).joints[0].planet_count
    forces = first_mesh(run, "F_sp")[part] + first_mesh(run, "F_pr")[part]
    motor = run["torque"].values[part, 0] / stage.n
    return quotient(planets * stage.r_cp * signals.mean(forces), signals.mean(motor))


def mesh_phase(run: xr.Dataset) -> np.ndarray:
    """The shoulder's sun mesh phase [rad], (times,), by the run's own law."""
    if switches_of(run).phase == "omega_t":
        return RING_CYCLES * run["theta_dot"].values[:, 0] * run["time"].values
    return RING_CYCLES * run["theta"].values[:, 0]


def geometry(run: xr.Dataset) -> StageGeometry:
    """Radii [m] of the shoulder's gears."""
    return paper_stage(arm_of(run)).geometry


def fast(time: np.ndarray, values: np.ndarray, over_s: float = SMOOTHING_S) -> np.ndarray:
    """Values (times,) less their moving average over ``over_s``, taken twice; 0 at the very ends.

    The average is not defined within ``over_s`` of the last sample; the start is reflected.
    """
    samples = 2 * int(over_s / (time[1] - time[0]) / 2) + 1
    slow = uniform_filter1d(uniform_filter1d(values, samples), samples)
    quick = values - slow
    quick[-samples:] = 0.0
    return quick


def decay(time: np.ndarray, values: np.ndarray) -> float:
    """Time [s] from the largest value until the last one above a tenth of it; nan if all are 0."""
    size = np.abs(values)
    if size.max(initial=0.0) == 0:
        return np.nan
    return float(time[np.flatnonzero(size >= DECAYED * size.max())[-1]] - time[size.argmax()])


def ripple(values: np.ndarray) -> float:
    """Peak to peak less the straight trend, so that a slow drift does not count."""
    return signals.peak_to_peak(_flat(values))


def _flat(values: np.ndarray) -> np.ndarray:
    """Less their straight trend; nothing is left of too few to have one."""
    if values.size < FEWEST:
        return np.empty(0)
    step = np.arange(values.size)
    return values - np.polyval(np.polyfit(step, values, 1), step)


def correlation(one: np.ndarray, other: np.ndarray) -> float:
    """Pearson's; nan where one of them does not vary."""
    if one.size < FEWEST or np.ptp(one) == 0 or np.ptp(other) == 0:
        return np.nan
    return float(np.corrcoef(one, other)[0, 1])
