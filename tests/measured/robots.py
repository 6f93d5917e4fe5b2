"""Recordings made of robots: stated motions, an engine's torques, friction and noise."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pinocchio as pin

from crosscheck.identification.compare import (
    NOTHING_ELSE,
    RecordComparison,
    SideResult,
    _judge_side,
    _Problem,
)
from crosscheck.identification.mechanism import SpatialRobot
from crosscheck.models.robot.robot import Level, Robot
from crosscheck.recordings.record import Record
from crosscheck.registry import build_robot_model
from tests.measured import records
from tests.robots import chains

COULOMB, VISCOUS = np.array([3.0, 2.0, 1.0]), np.array([2.0, 1.0, 0.5])
RATIO, ROTOR = 60.0, 1e-4  # whose reflected inertia is 0.36 kg m^2
POSITION_NOISE, TORQUE_NOISE = 1e-5, 0.2  # [rad], [N m]
STEP = 2e-3


SOLIDS = (
    chains.Solid(8.0, (0.1, 0.02, 0.1), (0.1, 0, 0, 0.2, 0, 0.15)),
    chains.Solid(5.0, (0.2, 0.01, 0.03), (0.03, 0, 0, 0.1, 0, 0.1)),
    chains.Solid(2.0, (0.1, 0.02, 0.05), (0.01, 0, 0, 0.03, 0, 0.03)),
)


def arm(text: str = "", solids: Sequence[chains.Solid] = SOLIDS) -> Robot:
    """Three joints whose axes are not parallel, a rotor at each; text: of another URDF."""
    links = [chains.link("base"), *map(chains.link, "abc", solids)]
    joints = [
        chains.joint("j1", "base", "a"),
        chains.joint("j2", "a", "b", axis=(0, 1, 0), at=(0.2, 0, 0.3)),
        chains.joint("j3", "b", "c", axis=(1, 0, 0), at=(0.4, 0, 0)),
    ]
    rotors = {name: chains.geared(RATIO, ROTOR) for name in ("j1", "j2", "j3")}
    return chains.robot(text or chains.urdf(*links, *joints), rotors)


def draw_arm(share: float, seed: int) -> Robot:
    """An arm whose links' parameters are known to a share by the file of the arm itself.

    Deviations are those of `[prior] links` in docs/explanation/recordings.md.
    """
    rng = np.random.default_rng([seed, 1])
    solids = []
    for body in list(pin.buildModelFromXML(arm().urdf).inertias)[1:]:
        values = body.toDynamicParameters()
        moment = (values[4] + values[6] + values[9]) / 3
        spread = [values[0], *[np.sqrt(values[0] * moment)] * 3, *[moment] * 6]
        drawn = values + share * np.array(spread) * rng.normal(size=10)
        own = pin.Inertia.FromDynamicParameters(drawn)
        upper = own.inertia[[0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]
        solids.append(chains.Solid(float(own.mass), own.lever.tolist(), upper.tolist()))
    return arm(solids=solids)


def motion(time: np.ndarray, count: int, seed: int) -> tuple[np.ndarray, ...]:
    """Positions, rates and accelerations (rows, count) of sums of sines."""
    rng = np.random.default_rng(seed)
    rates = 2 * np.pi * np.array([0.2, 0.5, 0.9, 1.4]) * (1 + 0.1 * np.arange(count))[:, None]
    sizes = rng.uniform(0.4, 0.8, rates.shape) / (1 + 0.3 * rates)
    return records.sum_sines(time, sizes, rates, rng.uniform(0, 2 * np.pi, rates.shape))


def recording(
    robot: Robot,
    level: Level,
    seed: int = 0,
    *,
    seconds: float = 10.0,
    friction: float = 1.0,
    encoder: float = 0.0,
    delay: float = 0.0,
    gain: float = 1.0,
) -> Record:
    """A recording of a level's torques in front of the gears, or behind them at the level links.

    friction: times COULOMB and VISCOUS; encoder [rad]: its steps; delay [s] and gain: of torques.
    """
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, seconds, STEP)
    q = motion(time, 3, seed)[0]
    at, rate, more = motion(time - delay, 3, seed)
    torque = build_robot_model("exudyn", robot, level).inverse_dynamics(at, rate, more)
    torque = gain * (torque + friction * (VISCOUS * rate + COULOMB * np.sign(rate)))
    torque = torque + TORQUE_NOISE * rng.normal(size=q.shape)
    q = q + POSITION_NOISE * rng.normal(size=q.shape)
    if encoder:
        q = encoder * np.round(q / encoder)
    return Record("a recording", time, q, torque, None)


def behind(given: Record) -> Record:
    """The recording, its torques stated to be those behind the gears."""
    return replace(given, motor_torque=None, joint_torque=given.motor_torque)


def compared(robot: Robot, given: Record) -> RecordComparison:
    """What it says of the robot, of which engines agree."""
    return records.compared(given, SpatialRobot(robot))


@lru_cache
def compared_arm(level: Level) -> tuple[Record, RecordComparison]:
    """A recording of a level of the arm, and what it says of the arm."""
    given = recording(arm(), level)
    return given, compared(arm(), given)


def first_side(robot: Robot, given: Record) -> SideResult:
    """What the first side says, without all that a comparison asks beside: a third of its time."""
    problem = records.first_problem(robot, given)
    return _judge_side(problem, problem.choose_bandwidth(), NOTHING_ELSE)


def both_sides(robot: Robot, given: Record) -> tuple[SideResult, SideResult]:
    """What that side says with any links, and with those of the file times a factor."""
    problem = records.first_problem(robot, given)
    identified = _judge_side(problem, problem.choose_bandwidth(), NOTHING_ELSE)
    scaled = _Problem(problem.robot, problem.samples, problem.side, "scaled")
    return identified, _judge_side(scaled, identified.bandwidth, NOTHING_ELSE)
