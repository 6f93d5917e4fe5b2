"""Experiments that suit an arm: how hard to push it, how stiffly to control it, for how long.

An arm's own clock is its lowest mesh mode. The controller is slower than that by a fixed factor,
stiff enough to hold the arm against its weight, and gives way until the teeth in contact are stable
under it by the loop's own eigenvalues. Times and torques follow, so that an arm ten times as small
and fast goes through the same angles in a tenth of the time.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from crosscheck.checks.first_principles.composite import arm_pose, build_parts, mass_matrix
from crosscheck.checks.modes import stage_modes
from crosscheck.checks.scales import (
    geared_joints,
    largest_weights,
    meshes,
    motor_lever,
    stiffness_bound,
    weight_moments,
)
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import rigid_layout
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.arm.quantities import Duration, Gain, NumberRange, RateGain, Torque
from crosscheck.models.experiment.scenario import (
    ConstantDrive,
    Drive,
    PdDrive,
    Scenario,
    Start,
    expand_to_joints,
    make_bent_start,
)
from crosscheck.models.loading import load_scenario, validate_record
from crosscheck.registry import build, find_level_models, reference_model

# The controller's rate over that of the lowest mesh mode, and its rate [rad/s] without gears.
SLOWER, WITHOUT_GEARS = 2000.0, 4.0
DAMPING_RATIO = 0.7  # damping ratio of the controlled rigid arm: brisk, with hardly any overshoot
# How far motions go [rad], of a controller every joint in turn the other way.
SWING = 0.5
STEP_S, PD_S = 2.0, 8.0  # durations in units of the controller's 1 / rate
MOST_GAIN_HALVINGS = 40
COARSEST_STEPS, RECORDS = 4000, 1000
# Teeth bend by a tenth of their module at most, where they would shear; a machine's by a hundredth
# of that. Torques of a metre's bending would hide what forces of teeth are off by.
MOST_BENT = 0.1
FASTEST = 3.0  # joint rate of a check [rad/s]: a damping torque bends teeth no further
DIGITS = 6  # digits of gains and torques
# By which a check's gains, targets and torques differ from joint to joint: none stands for another.
LESS_STIFF, LESS_DAMPED, UNEQUAL = 0.11, 0.075, 0.1

ROUNDING = 1e-9  # largest pole that counts as 0, relative to the fastest one
TOLERATED = 0.1  # growth over a whole run, as the exponent of e: it changes no verdict


@dataclass(frozen=True)
class Sizes:
    """The numbers that experiments of an arm are made of, per joint where there are several.

    rate [rad/s]: the arm's clock, and the controller's rate unless it had to give way; inertia
    [kg m^2]: of the rigid arm, stretched out; proportional [N m/rad] and derivative [N m s/rad]:
    the controller's gains; step [N m]: a step of torque; mode_Hz: the lowest mesh mode, None
    without gears.
    """

    rate: float
    inertia: tuple[float, ...]
    proportional: tuple[float, ...]
    derivative: tuple[float, ...]
    step: tuple[float, ...]
    mode_Hz: float | None

    @property
    def target(self) -> tuple[float, ...]:
        """Angles that the controller drives the joints to [rad], from a stretched arm."""
        return tuple(SWING * (-1) ** joint for joint in range(len(self.inertia)))


def compute_sizes(arm: Arm) -> Sizes:
    """The Sizes of an arm; with the gentlest controller where none keeps its teeth stable."""
    still = ConstantDrive(kind="constant", torque_N_m=0.0)
    clockless = make_sized_scenario("sizing", still, 1.0, 1.0)
    modes = build(reference_model(), arm, clockless).mesh_modes()
    mode = float(modes[0]) if modes.size else None
    rate = WITHOUT_GEARS if mode is None else 2 * np.pi * mode / SLOWER
    scenario = make_sized_scenario("sizing", still, rate, 1.0)
    rigid = build(find_level_models("coupled")[0], arm, scenario)
    inertia = np.diag(rigid.mass_matrix(np.zeros(len(arm.joints))))
    held = -weight_moments(arm, np.zeros(inertia.size))
    bearable = bearable_torques(arm)
    step = _limit_values(Torque, np.minimum(inertia * rate**2 * SWING, bearable) + held)
    for halvings in range(MOST_GAIN_HALVINGS):
        stiff, damped = _gains(inertia, rate / 2**halvings, bearable)
        P = _limit_values(Gain, stiff + 2 * largest_weights(arm))
        D = _limit_values(RateGain, damped)
        sizes = Sizes(rate, tuple(map(float, inertia)), P, D, step, mode)
        if find_growing_mode(arm, make_pd_scenario(sizes)) is None:
            break
    return sizes


def bearable_torques(arm: Arm) -> np.ndarray:
    """Torques [N m], (joints,), that bend teeth by MOST_BENT modules; inf without gears."""
    torques = np.full(len(arm.joints), np.inf)
    for number, joint in geared_joints(arm):
        stiffest = joint.planet_count * max(stiffness_bound(m.stiffness) for m in meshes(joint))
        torques[number] = MOST_BENT * joint.module_m * stiffest * motor_lever(joint)
    return torques


def _gains(inertia: np.ndarray, rate: float, bearable: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gains [N m/rad], [N m s/rad], (joints,), of a controller that the teeth bear [N m]."""
    stiff = np.minimum(inertia * rate**2, bearable / SWING)
    return stiff, np.minimum(2 * DAMPING_RATIO * inertia * rate, bearable / FASTEST)


def _limit_values(kind: Any, values: Iterable[float], digits: int = DIGITS) -> tuple[float, ...]:
    """The values, kept within the range of a kind of number, to so many digits.

    Eigenvalues, of which these are made, end in other digits on other processors.
    """
    limit = next(each for each in kind.__metadata__ if isinstance(each, NumberRange))
    kept = (min(max(float(value), limit.least), limit.most) for value in values)
    return tuple(float(f"{value:.{digits}g}") for value in kept)


@lru_cache
def make_unequal_gains_scenario(arm: Arm) -> Scenario:
    """An experiment with unequal gains and targets at every joint, from the arm's data alone.

    The controller is slower than the lowest mode of a stage with its carrier locked, as that of
    Sizes is.
    """
    content, numbers = arm.model_dump(), np.arange(len(arm.joints))
    stretched = arm_pose(content, 0.0 * numbers)
    turned = np.diag(mass_matrix(build_parts(content), stretched, rigid_layout(arm)))
    lowest = [float(stage_modes(joint)[0]) for _, joint in geared_joints(arm)]
    rate = 2 * np.pi * min(lowest) / SLOWER if lowest else WITHOUT_GEARS
    stiff, damped = _gains(turned, rate, bearable_torques(arm))
    drive = PdDrive(
        kind="pd",
        target_rad=tuple(map(float, SWING + UNEQUAL * numbers)),
        proportional_N_m_per_rad=_limit_values(Gain, stiff * (1 - LESS_STIFF * numbers)),
        derivative_N_m_s_per_rad=_limit_values(RateGain, damped * (1 - LESS_DAMPED * numbers)),
    )
    return load_scenario("pd").model_copy(update={"drive": drive})


def make_step_scenario(sizes: Sizes) -> Scenario:
    """An experiment: a step of torque on every joint, beside what holds the stretched arm."""
    drive = ConstantDrive(kind="constant", torque_N_m=sizes.step)
    return make_sized_scenario("torque-step", drive, sizes.rate, STEP_S)


def make_pd_scenario(sizes: Sizes) -> Scenario:
    """An experiment: a motion of every joint under its controller."""
    drive = PdDrive(
        kind="pd",
        target_rad=sizes.target,
        proportional_N_m_per_rad=sizes.proportional,
        derivative_N_m_s_per_rad=sizes.derivative,
    )
    return make_sized_scenario("pd-motion", drive, sizes.rate, PD_S)


def make_sized_scenario(name: str, drive: Drive, rate: float, times: float) -> Scenario:
    """An experiment ``times`` / rate [s] long; a plan makes its steps as short as teeth need."""
    (duration,) = _limit_values(Duration, [times / rate], digits=3)
    grid = {"step_s": duration / COARSEST_STEPS, "record_every": COARSEST_STEPS // RECORDS}
    motion = {"duration_s": duration, "start": Start(), "drive": drive}
    return build_scenario(name, title="sized to the arm", **grid, **motion)


def build_scenario(name: str, **fields: Any) -> Scenario:
    """An experiment sized to an arm.

    Raises InputError where a number that the arm asks for is outside of what a scenario may have.
    """
    data = {"schema_version": 1, "name": name, **fields}
    return validate_record(Scenario, data, f"experiment {name}, sized to the arm")


def make_bent_scenario(
    name: str, steps: int, records: int, step_s: float, torques: np.ndarray
) -> Scenario:
    """An experiment that starts bent; held torques [N m], (joints,), less from joint to joint."""
    numbers = np.arange(torques.size)
    return build_scenario(
        name,
        duration_s=steps * step_s,
        step_s=step_s,
        record_every=steps // records,
        start=make_bent_start(torques.size),
        drive=make_torque_drive(torques * (1 - UNEQUAL * numbers)),
    )


def make_torque_drive(torques: Iterable[float]) -> ConstantDrive:
    """A drive of these torques [N m], as large as a scenario's may be at most."""
    return ConstantDrive(kind="constant", torque_N_m=_limit_values(Torque, torques, digits=17))


@dataclass(frozen=True)
class GrowingMode:
    """A mode of the closed loop that grows with the teeth in contact: its rate and frequency."""

    rate_per_s: float
    frequency_Hz: float

    def __str__(self) -> str:
        grows = f"{self.rate_per_s:+.3g} 1/s at {self.frequency_Hz:.4g} Hz"
        return f"the loop is unstable while teeth touch: {grows}"


def find_growing_mode(arm: Arm, scenario: Scenario) -> GrowingMode | None:
    """The fastest-growing vibration of a scenario's loop, at its start and its target.

    It is None if none grows to speak of within its duration. A fall is no vibration.
    """
    poses = [scenario]
    if isinstance(scenario.drive, PdDrive):
        there = expand_to_joints(scenario.drive.target_rad, len(arm.joints))
        start = scenario.start.model_copy(update={"theta_rad": there})
        poses.append(scenario.model_copy(update={"start": start}))
    worst = GrowingMode(0.0, 0.0)
    for pose in poses:
        poles = build(reference_model(), arm, pose, usual_switches(arm)).contact_poles()
        rounding = ROUNDING * np.abs(poles).max()
        vibrations = poles[poles.imag > rounding]
        if vibrations.size:
            fastest = vibrations[np.argmax(vibrations.real)]
            if fastest.real > max(rounding, worst.rate_per_s):
                worst = GrowingMode(float(fastest.real), float(fastest.imag) / (2 * np.pi))
    return worst if worst.rate_per_s * scenario.duration_s > TOLERATED else None
