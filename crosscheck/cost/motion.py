"""The motion along which costs are measured: given, or a seeded sum of sines within limits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline, make_lsq_spline

from crosscheck.checks.robot_states import motion_range
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.integration import integrate_steps
from crosscheck.models.robot.integration import FASTEST, require_regular
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import Robot
from crosscheck.recordings.record import Record
from crosscheck.recordings.smoothing import DEGREE, place_knots, select_spacing

HARMONICS = 5
PERIOD = 4.0  # period [s], longer where effort limits require it
SWEPT = 0.8  # largest share of a joint's range that the motion covers
RATE = 1.0  # largest rate of a joint without a velocity limit [rad/s] or [m/s]
GRID = 2000  # instants per period at which limits are enforced
FREE_STEPS = 800  # steps in which coordinates without a motor move for a period
LEEWAY = 1.01  # factor on a limit, for the instants in between
LEAST_S = 1.1  # shortest motion that can be given [s]; a run takes one second of it
State = tuple[np.ndarray, np.ndarray, np.ndarray]  # coordinates, rates, accelerations


@dataclass(frozen=True)
class SineMotion:
    """A periodic motion: each joint follows a sum of sines about a middle position.

    period [s]; middle (n,); sizes, phases (n, harmonics): of the sines; limited_by: name of the
    joint whose effort limit sets the period, empty if none does.
    """

    seed: int
    period: float
    middle: np.ndarray
    sizes: np.ndarray
    phases: np.ndarray
    limited_by: str = ""

    def __str__(self) -> str:
        why = f", as slow as the effort limit of {self.limited_by} asks" if self.limited_by else ""
        return f"sums of sines of seed {self.seed}, period {self.period:.3g} s{why}"

    def instants(self, count: int, before_end: float = 0.0) -> np.ndarray:
        """`count` evenly spaced times [s] over a period, end excluded; before_end has no effect."""
        return self.period * np.arange(count) / count

    def at(self, time: np.ndarray) -> State:
        """Coordinates, rates and accelerations at times [s], each (times, n)."""
        rates = 2 * np.pi * np.arange(1, HARMONICS + 1) / self.period
        angles = rates * time[:, None, None] + self.phases
        sines, cosines = self.sizes * np.sin(angles), self.sizes * np.cos(angles)
        return (
            self.middle + sines.sum(axis=2),
            (rates * cosines).sum(axis=2),
            -(rates**2 * sines).sum(axis=2),
        )


@dataclass(frozen=True)
class GivenMotion:
    """A motion as a spline (n,) of fifth degree over times [s] from first to last.

    where: its file, or words on where else it comes from.
    """

    where: str
    spline: BSpline
    first: float
    last: float

    def __str__(self) -> str:
        return f"{self.where}, {self.last - self.first:.3g} s"

    def at(self, time: np.ndarray) -> State:
        """Coordinates, rates and accelerations at times [s], each (times, n)."""
        return self.spline(time), self.spline(time, 1), self.spline(time, 2)

    def instants(self, count: int, before_end: float = 0.0) -> np.ndarray:
        """`count` evenly spaced times [s], the last one before_end [s] before the motion's end."""
        return np.linspace(self.first, self.last - before_end, count)


RobotMotion = SineMotion | GivenMotion


def fit_motion(record: Record) -> GivenMotion:
    """The motion of a record's angles, smoothed. Raises InputError if it is too short."""
    lasts = record.time[-1] - record.time[0]
    if lasts < LEAST_S:
        allowed = f"lasts {lasts:.3g} s; must last {LEAST_S:g} s at least"
        raise InputError(record.where, "", None, allowed)
    places = place_knots(record.time, select_spacing(record))
    spline = make_lsq_spline(record.time, record.position, places, DEGREE)
    return GivenMotion(record.where, spline, float(record.time[0]), float(record.time[-1]))


def make_excitation(model: RobotModel, seed: int, grid: int = GRID) -> SineMotion:
    """A random motion within limits of position, rate and effort; what has no motor stands still.

    Args:
        model: The model that gives the torques.
        seed: Seed of the draw.
        grid: Number of instants per period at which limits are enforced.
    """
    robot = model.robot
    rng = np.random.default_rng(seed)
    ranges = np.array([motion_range(robot, number) for number in robot.coordinates])
    limits = [robot.joints[number].limits for number in robot.coordinates]
    fastest = np.array([each.velocity if np.isfinite(each.velocity) else RATE for each in limits])
    shape = (len(ranges), HARMONICS)
    sizes = rng.uniform(0.3, 1, shape) / np.arange(1, HARMONICS + 1)
    phases = rng.uniform(0, 2 * np.pi, shape)
    drawn = SineMotion(seed, PERIOD, np.zeros(len(ranges)), sizes, phases)
    time = PERIOD * np.arange(grid) / grid
    q, v, _ = drawn.at(time)
    lowest, highest = q.min(axis=0), q.max(axis=0)
    swept = SWEPT * (ranges[:, 1] - ranges[:, 0]) / (highest - lowest)
    factor = np.minimum(swept, fastest / np.abs(v).max(axis=0))
    middle = ranges.mean(axis=1) - factor * (lowest + highest) / 2
    middle[robot.passive] = factor[robot.passive] = 0.0
    chosen = SineMotion(seed, PERIOD, middle, sizes * factor[:, None], phases)
    slower, limited_by = _find_period_factor(model, chosen.at(time))
    return replace(chosen, period=PERIOD * slower, limited_by=limited_by)


def release_passive(model: RobotModel, motion: SineMotion) -> RobotMotion:
    """The motion with coordinates that no motor drives, if any, as they follow the others.

    They begin where the motion has them, at rates that make their momenta 0. Raises InputError
    where they come to a pole of their angles.
    """
    robot, free = model.robot, model.robot.passive
    if not free:
        return motion
    block, step = np.ix_(free, free), motion.period / FREE_STEPS

    def complete(t: float, at: np.ndarray, rate: np.ndarray) -> State:
        q, v, a = (each[0] for each in motion.at(np.array([t])))
        q[free], v[free] = at, rate
        return q, v, a

    def accelerate(t: float, at: np.ndarray, rate: np.ndarray) -> np.ndarray:
        q, v, a = (each[None] for each in complete(t, at, rate))
        needed = model.inverse_dynamics(q, v, a)[0, free]
        return -np.linalg.solve(model.mass_matrix(q)[0][block], needed)

    q, v, _ = complete(0.0, motion.middle[free], 0 * motion.middle[free])
    mass = model.mass_matrix(q[None])[0]
    start = q[free], -np.linalg.solve(mass[block], (mass @ v)[free])
    times = step * np.arange(FREE_STEPS + 1)
    with require_regular(robot):
        runs = integrate_steps(
            accelerate, lambda number: tuple(step * (number + np.array([0, 0.5, 1]))), *start, step
        )
        states = [start, *islice(runs, FREE_STEPS)]
    if not all((np.abs(rates) <= FASTEST).all() for _, rates in states):
        allowed = "come to a pole of their angles or run away; --motion states another motion"
        names = ", ".join(robot.coordinate_names[place] for place in free)
        raise InputError(robot.name, "joints", names, allowed)
    rows = [complete(t, *state)[0] for t, state in zip(times, states, strict=True)]
    spline = make_interp_spline(times, rows, k=DEGREE)
    return GivenMotion(f"sums of sines of seed {motion.seed}", spline, 0.0, motion.period)


def describe_passive(robot: Robot, q: np.ndarray) -> Iterator[str]:
    """How far each coordinate without a motor moves along a motion's coordinates q (times, n)."""
    units = {"rad": (np.degrees(1), "degrees"), "m": (1, "m")}
    for place in robot.passive:
        name, way = robot.coordinate_names[place], np.ptp(q[:, place])
        factor, unit = units[robot.joint_units[name]]
        yield f"{name} by {factor * way:.3g} {unit}"


def _find_period_factor(model: RobotModel, motion: State) -> tuple[float, str]:
    """The factor by which effort limits lengthen the period, and the joint whose limit does.

    Lengthening the period by a factor divides all torques but gravity's by its square.
    """
    q, v, a = motion
    weight = model.gravity(q)
    rest = model.inverse_dynamics(q, v, a) - weight
    longest, limited_by = 1.0, ""
    for column in model.robot.motors:
        number = model.robot.coordinates[column]
        joint, held, more = model.robot.joints[number], weight[:, column], rest[:, column]
        effort = joint.limits.effort
        if (np.abs(held) < effort).all():
            needed = np.abs(more) / (effort - np.sign(more) * held)
            factor = float(np.sqrt(needed.max()))
            if factor > longest:
                longest, limited_by = factor, joint.name
    return longest, limited_by


def find_exceeded_limits(robot: Robot, state: State, torques: np.ndarray) -> list[str]:
    """A line for every limit of the URDF that a motion or its motors' torques exceed."""
    messages = []
    q, v, _ = state
    for row, column in enumerate(robot.motors):
        joint, positions = robot.joints[robot.coordinates[column]], q[:, column]
        for name, most, limit in (
            ("velocity", np.abs(v[:, column]).max(), joint.limits.velocity),
            ("effort", np.abs(torques[:, row]).max(), joint.limits.effort),
        ):
            if most > LEEWAY * limit:
                messages.append(
                    f"{joint.name}: {name} of {most:.4g} is beyond its limit, {limit:g}"
                )
        if positions.min() < joint.limits.lower or positions.max() > joint.limits.upper:
            messages.append(f"{joint.name}: leaves its range")
    return messages
