"""A motion that shows what a record's own does not: the best of random ones within limits."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from crosscheck.cost.motion import SineMotion, State, make_excitation
from crosscheck.identification.estimation import find_condition
from crosscheck.identification.structure import make_sample
from crosscheck.identification.terms import build_columns
from crosscheck.models.robot.robot import Robot
from crosscheck.registry import build_robot_model, reference_engine

DRAWN = 100  # motions among which the best is suggested
GRID = 200  # instants per period: many times the parameters, 40 in the fastest sine's period
PERIODS = 10  # periods that are written: blocks of rows need many
TABLE_ROWS = 2000  # rows in a period


@dataclass(frozen=True)
class Excitation:
    """The motion of the least condition number among those drawn.

    condition: of the columns of the record's parameters along it, in the record's weights.
    """

    motion: SineMotion
    condition: float

    def tabulate(self) -> tuple[np.ndarray, State]:
        """Times (rows,) [s] and states (rows, n) of a run from rest to rest.

        In its first and last period time itself passes faster and slower: the path, and so limits
        of position and rate, are those of the motion.
        """
        period = self.motion.period
        whole = PERIODS * period
        time = np.linspace(0.0, whole + 2 * period, (PERIODS + 2) * TABLE_ROWS + 1)
        first = np.clip(time / period, 0.0, 1.0)
        last = np.clip((whole + 2 * period - time) / period, 0.0, 1.0)
        steady = np.clip(time - period, 0.0, whole)
        passed = period * (_ramp(first) + 0.5 - _ramp(last)) + steady
        rate = np.minimum(first**2 * (3 - 2 * first), last**2 * (3 - 2 * last))
        change = 6 * (first * (1 - first) - last * (1 - last)) / period
        q, v, a = self.motion.at(passed)
        slope, curve = rate[:, None], change[:, None]
        return time, (q, v * slope, a * slope**2 + v * curve)


def _ramp(share: np.ndarray) -> np.ndarray:
    """Integral of the rate of time 3 s^2 - 2 s^3, from 0 to the share."""
    return share**3 - share**4 / 2


def suggest_excitation(
    robot: Robot,
    positions: np.ndarray,
    shared: np.ndarray,
    chosen: np.ndarray,
    measured: np.ndarray,
    sigma: np.ndarray,
) -> Excitation:
    """The best of random motions within the URDF's limits of position, rate and effort.

    Args:
        robot: Its file's links and rotors give the torques for the limits of effort.
        positions: Of the record (rows, n): where the robot was it may be again, whatever limits say
            (for joints that turn without end files often hold a range of 0).
        shared: Rates of motors that several joints turn, for rates of joints (shared, n).
        chosen: Numbers of the columns that are asked for.
        measured: Whether a joint's torque is measured (n,).
        sigma: Weights' inverse of measured joints.
    """
    robot = _widen_limits(robot, positions)
    model = build_robot_model(reference_engine(), robot, "coupled")

    def compute_condition(motion: SineMotion) -> float:
        time = motion.instants(GRID)
        q, v, a = motion.at(time)
        torque = model.inverse_dynamics(q, v, a)
        slope = (np.roll(torque, -1, axis=0) - np.roll(torque, 1, axis=0)) / (2 * time[1])
        samples = make_sample((q, v, a), torque, slope, shared, float(time[1]))
        columns = build_columns(robot, shared, samples).select(chosen)
        return find_condition(columns.values[:, measured], sigma)

    drawn = [make_excitation(model, seed, GRID) for seed in range(DRAWN)]
    best = min(drawn, key=compute_condition)
    motion = make_excitation(model, best.seed)
    return Excitation(motion, compute_condition(motion))


def _widen_limits(robot: Robot, positions: np.ndarray) -> Robot:
    """The robot with ranges that hold the positions (rows, n) of its free joints."""
    joints = list(robot.joints)
    lowest, highest = positions.min(axis=0).tolist(), positions.max(axis=0).tolist()
    for number, low, high in zip(robot.coordinates, lowest, highest, strict=True):
        limits = joints[number].limits
        wider = replace(limits, lower=min(limits.lower, low), upper=max(limits.upper, high))
        joints[number] = replace(joints[number], limits=wider)
    return replace(robot, joints=tuple(joints))


def format_excitation(excitation: Excitation, slides: Collection[int]) -> str:
    """CSV text of the motion from rest to rest: times, positions and rates, with units.

    slides: numbers, from 1, of the joints that slide.
    """
    time, (q, v, _) = excitation.tabulate()
    units = {number: "m" if number in slides else "rad" for number in range(1, q.shape[1] + 1)}
    names = ["t_s", *(f"theta_{number}_{unit}" for number, unit in units.items())]
    names += [f"theta_dot_{number}_{unit}_per_s" for number, unit in units.items()]
    rows = np.column_stack([time, q, v]).tolist()
    return "\n".join([",".join(names), *(",".join(f"{x:.9g}" for x in row) for row in rows)]) + "\n"
