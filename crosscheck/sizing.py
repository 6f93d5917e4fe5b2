"""Experiments that suit an arm: how hard to push it, how stiffly to control it, for how long.

An arm's own clock is its lowest mesh mode. The controller is slower than that by a fixed factor,
stiff enough to hold the arm against its weight, and gives way until the teeth in contact are stable
under it by the loop's own eigenvalues. Times and torques follow, so that an arm ten times as small
and fast is moved through the same angles in a tenth of the time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crosscheck.checks.scales import largest_weights
from crosscheck.checks.weights import weight_moments
from crosscheck.registry import build, lead, of_level
from crosscheck.stability import growth_of
from models.arm import Arm
from models.scenario import ConstantDrive, Drive, PdDrive, Scenario, Start

# The controller's rate over that of the lowest mesh mode, and its rate [rad/s] without gears.
SLOWER, WITHOUT_GEARS = 2000.0, 4.0
DAMPING_RATIO = 0.7  # of the controlled rigid arm: brisk, with no overshoot to speak of
# How far the motion goes [rad], every joint in turn the other way; what a step of torque reaches.
SWING, STEP_SWING = 0.5, 0.5
STEP_S, PD_S = 2.0, 8.0  # durations in units of the controller's 1 / rate
GENTLER = 40  # times that the controller may give way by half
COARSEST_STEPS, RECORDS = 4000, 1000
DIGITS = 6  # of gains and torques


@dataclass(frozen=True)
class Sizes:
    """What experiments of an arm are made of, per joint where there are several.

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
        """Where the controller drives the joints [rad], from a stretched arm."""
        return tuple(SWING * (-1) ** joint for joint in range(len(self.inertia)))


def sizes_of(arm: Arm) -> Sizes:
    """The sizes of an arm; where no controller keeps its teeth stable, of the gentlest."""
    still = ConstantDrive(kind="constant", torque_N_m=0.0)
    mode = _lowest_mode(arm, still)
    rate = WITHOUT_GEARS if mode is None else 2 * np.pi * mode / SLOWER
    rigid = build(of_level("coupled")[0], arm, scenario_of("sizing", still, rate, 1.0))
    inertia = np.diag(rigid.mass_matrix(np.zeros(len(arm.joints))))
    for halvings in range(GENTLER):
        sizes = _controlled(arm, inertia, rate, rate / 2**halvings, mode)
        if growth_of(arm, pd_scenario(sizes)) is None:
            break
    return sizes


def _lowest_mode(arm: Arm, still: Drive) -> float | None:
    modes = build(lead(), arm, scenario_of("sizing", still, 1.0, 1.0)).mesh_modes()
    return float(modes[0]) if modes.size else None


def _controlled(
    arm: Arm, inertia: np.ndarray, rate: float, controllers: float, mode: float | None
) -> Sizes:
    proportional = inertia * controllers**2 + 2 * largest_weights(arm)
    derivative = 2 * DAMPING_RATIO * inertia * controllers
    held = -weight_moments(arm, np.zeros(inertia.size))
    step = inertia * rate**2 * STEP_SWING + held
    own = tuple(map(float, inertia))
    P, D, torques = (tuple(map(_rounded, of)) for of in (proportional, derivative, step))
    return Sizes(rate, own, P, D, torques, mode)


def _rounded(value: float) -> float:
    """To DIGITS: eigenvalues, of which these are made, end in other digits on other processors."""
    return float(f"{value:.{DIGITS}g}")


def step_scenario(sizes: Sizes) -> Scenario:
    """A step of torque on every joint, beside what holds the stretched arm."""
    drive = ConstantDrive(kind="constant", torque_N_m=sizes.step)
    return scenario_of("torque-step", drive, sizes.rate, STEP_S)


def pd_scenario(sizes: Sizes) -> Scenario:
    """A motion of every joint under its controller."""
    drive = PdDrive(
        kind="pd",
        target_rad=sizes.target,
        proportional_N_m_per_rad=sizes.proportional,
        derivative_N_m_s_per_rad=sizes.derivative,
    )
    return scenario_of("pd-motion", drive, sizes.rate, PD_S)


def scenario_of(name: str, drive: Drive, rate: float, times: float) -> Scenario:
    """Of so many times 1 / rate, with steps that a plan makes as short as the teeth need."""
    duration = float(f"{times / rate:.3g}")
    return Scenario(
        schema_version=1,
        name=name,
        title="sized to the arm",
        duration_s=duration,
        step_s=duration / COARSEST_STEPS,
        record_every=COARSEST_STEPS // RECORDS,
        start=Start(),
        drive=drive,
    )
