"""The numbers of one run that the paper's statements are about: torque-driven experiments.

Mesh quantities are those of the shoulder's sun-planet pair, first planet. Every measure has all its
numbers for every run: None for what the run does not last for, or what does not happen in it.
"""

from __future__ import annotations

import json
from functools import lru_cache

import numpy as np
import xarray as xr
from scipy.ndimage import uniform_filter1d
from scipy.signal import find_peaks

from analytic.kinematics import StageGeometry, stage_geometry
from crosscheck.checks.trajectories import tip_position
from crosscheck.paper import signals
from crosscheck.paper.fluctuation import RIGID_STEP_S
from crosscheck.paper.undefined import finite, quotient
from crosscheck.registry import RIGID_LEVELS, build
from crosscheck.studies.study import Numbers
from models.arm import Arm
from models.scenario import Scenario, Start
from models.switches import Switches

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
NO_MESH = {
    "backlash_m": 0.0,
    "tooth_error_m": 0.0,
    "mesh_stiffness_amplitude_N_per_m": 0.0,
    "damping_ratio": 0.0,
}
RING_CYCLES = 99.0  # Eq. 12 over the carrier's rate


def constant_torque(run: xr.Dataset) -> Numbers:
    """Figs. 6-9: deviations from the rigid levels, mesh displacement and force."""
    time = run["time"].values
    late = signals.window(time, SETTLED_S, np.inf)
    start = slice(0, late.start)
    x, force = first_planet(run["x_sp"]), first_planet(run["F_sp"])
    speed = np.abs(run["theta_dot"].values[:, 0])
    error = recorded(run)[0].joints[0].tooth_error_m
    return finite(
        {
            **_deviations(run),
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


def back_and_forth(run: xr.Dataset) -> Numbers:
    """Fig. 15: the shoulder's largest distance [rad] from the rigid arm, early and late.

    ``own``: that of a rigid arm which starts OWN_SHIFT_RAD away, for that arm's own sensitivity.
    All at one step: the torque's square root at t = 0 then costs them the same and drops out.
    """
    time = run["time"].values
    step = float(run.attrs["step_s"])
    rigid, shifted = (
        resampled(rigid_arm(run, "coupled", step, shift), "theta", time)[:, 0]
        for shift in (0.0, OWN_SHIFT_RAD)
    )
    gaps = {"error": run["theta"].values[:, 0] - rigid, "own": shifted - rigid}
    return finite(
        {
            f"{kind}_{name}": signals.amplitude(gap[signals.window(time, *limits)])
            for kind, gap in gaps.items()
            for name, limits in ERROR_WINDOWS_S.items()
        }
    )


def _deviations(run: xr.Dataset) -> dict[str, float]:
    """Detailed less rigid, at every rigid level: joints [rad], tip [mm], late over early half."""
    time = run["time"].values
    arm, _ = recorded(run)
    half = time.size // 2
    numbers: dict[str, float] = {}
    for level in RIGID_LEVELS:
        rigid = resampled(rigid_arm(run, level), "theta", time)
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
    force = first_planet(run["F_sp"])[part]
    return correlation(_flat(force), _flat(np.sin(mesh_phase(run)[part])))


def _torque_gain(run: xr.Dataset, part: slice) -> float:
    """Torque of the meshes on the shoulder's carrier over the motor's, T / n."""
    arm, _ = recorded(run)
    stage, planets = geometry(run), arm.joints[0].planet_count
    forces = first_planet(run["F_sp"])[part] + first_planet(run["F_pr"])[part]
    motor = run["torque"].values[part, 0] / stage.n
    return quotient(planets * stage.r_cp * signals.mean(forces), signals.mean(motor))


def mesh_phase(run: xr.Dataset) -> np.ndarray:
    """The shoulder's sun mesh phase [rad], (times,), by the run's own law."""
    law = Switches.model_validate(json.loads(run.attrs["switches"])).phase
    if law == "omega_t":
        return RING_CYCLES * run["theta_dot"].values[:, 0] * run["time"].values
    return RING_CYCLES * run["theta"].values[:, 0]


def rigid_arm(
    run: xr.Dataset, level: str = "coupled", step_s: float = RIGID_STEP_S, shift_rad: float = 0.0
) -> xr.Dataset:
    """The rigid arm at a level of the ladder through the same experiment as ``run``.

    Its joints start at ``shift_rad``. The meshes do not matter to it, so runs share it.
    """
    arm, scenario = recorded(run)
    joints = tuple(joint.model_copy(update=NO_MESH) for joint in arm.joints)
    start = Start(theta_rad=shift_rad)
    update = {"step_s": step_s, "record_every": 1, "start": start}
    return _rigid_run(
        level,
        arm.model_copy(update={"joints": joints}).model_dump_json(),
        scenario.model_copy(update=update).model_dump_json(),
    )


@lru_cache(maxsize=32)
def _rigid_run(level: str, arm: str, scenario: str) -> xr.Dataset:
    model = build(
        f"analytic:{level}", Arm.model_validate_json(arm), Scenario.model_validate_json(scenario)
    )
    return model.simulate()[["theta", "theta_ddot"]]


def recorded(run: xr.Dataset) -> tuple[Arm, Scenario]:
    """The arm and the scenario that a run was made with."""
    arm = Arm.model_validate(json.loads(run.attrs["arm"]))
    return arm, Scenario.model_validate(json.loads(run.attrs["scenario"]))


def geometry(run: xr.Dataset) -> StageGeometry:
    """Radii [m] of the shoulder's gears."""
    return stage_geometry(recorded(run)[0].joints[0])


def first_planet(values: xr.DataArray) -> np.ndarray:
    """The shoulder's first planet, (times,)."""
    return values.values[:, 0, 0]


def resampled(run: xr.Dataset, name: str, time: np.ndarray) -> np.ndarray:
    """A smooth variable of the joints at other times, (times, joints)."""
    own = run["time"].values
    return np.array([np.interp(time, own, column) for column in run[name].values.T]).T


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
