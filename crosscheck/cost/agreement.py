"""Do the models of a robot agree at random states? Every quantity, level and pair of engines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from crosscheck.cost.engines import engines, model_of
from crosscheck.cost.runs import mesh_rates, run, too_unlike
from crosscheck.cost.springs import springs, with_rotors_alone
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import Level, Robot

# Of each quantity's size. Rounding explains 1e-15 times the reach over the smallest lever arm.
TOLERANCE = 1e-10
ROUNDINGS = 1000 * np.finfo(float).eps  # times M's condition number: what solving with M may lose
QUANTITIES = {
    "mass matrix": "entry over the root of the two diagonal ones",
    "bias": "torque over the root of M's diagonal, of (v' M v)^1/2 times the sum of the rates",
    "gravity": "torque over the root of M's diagonal, of the weight over the root of the mass",
    "inverse dynamics": "torque as of bias, gravity and meshes, with (a' M a)^1/2",
    "forward dynamics": "acceleration times the root of M's diagonal, of what M can make of it",
    "energy": "of the kinetic energy, and of the weight at the farthest centre of mass",
    "momentum": "linear and angular, of the most that the kinetic energy allows",
    "tip": "distance over the reach",
    "run": "coordinate after a short free motion in equal steps, of how far any has moved",
}
LARGEST_TOLERANCE = 1e-3  # beyond it agreement would say nothing
SOLVED = ("forward dynamics", "run")  # which M's condition number may harm
RUNS, RUN_S, STEPS = 3, 0.1, 5  # of the states the first, and a run's time and steps
FORCE, DEEPEST = 10.0, 0.01  # of a drawn mesh: N m or N at its joint, parts of its pinion's radius


class DrawnStates(NamedTuple):
    """Random states: coordinates, rates, accelerations (states, n), torques (states, free)."""

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    torques: np.ndarray


RobotAnswers = dict[str, np.ndarray]  # what a model says of the states, by QUANTITIES


@dataclass(frozen=True)
class EngineDifference:
    """The largest difference of two models over the states, in parts of the quantity's size.

    failure: why there is none; then measured is infinite.
    """

    quantity: str
    level: Level
    left: str
    right: str
    measured: float
    tolerance: float
    failure: str = ""

    @property
    def agrees(self) -> bool:
        """Whether the difference is within the tolerance; never where a model failed."""
        return self.measured <= self.tolerance


def drawn(robot: Robot, count: int, seed: int) -> DrawnStates:
    """Random states of a robot, `count` of them.

    Coordinates are within their limits and at most +-pi or 1 m about the middle of these, rates
    within theirs and at most 2 rad/s or m/s.
    """
    rng = np.random.default_rng(seed)
    shape = (count, len(robot.coordinates))
    ranges = np.array([motion_range(robot, number) for number in robot.coordinates])
    most = [min(robot.joints[number].limits.velocity, 2.0) for number in robot.coordinates]
    q = rng.uniform(ranges[:, 0], ranges[:, 1], shape)
    v = rng.uniform(-1, 1, shape) * most
    return DrawnStates(q, v, rng.uniform(-5, 5, shape), rng.uniform(-10, 10, shape))


def motion_range(robot: Robot, number: int) -> tuple[float, float]:
    """The range of a joint's coordinate: its limits, at most +-pi or 1 m about their middle."""
    joint = robot.joints[number]
    half = np.pi if joint.kind == "revolute" else 1.0
    lower, upper = joint.limits.lower, joint.limits.upper
    if not np.isfinite([lower, upper]).all():
        middle = min(max(0.0, lower + half), upper - half)
        return middle - half, middle + half
    middle, half = (lower + upper) / 2, min(half, (upper - lower) / 2)
    return middle - half, middle + half


def compared(robot: Robot, states: DrawnStates) -> list[EngineDifference]:
    """Compare every pair of engines at each level that they promise; one that raises fails there.

    Raises InputError for a robot whose mass matrix has lost its digits.
    """
    found: list[EngineDifference] = []
    for level in robot.levels:
        own = with_meshes(robot, states) if level == "geared" else states
        answers: dict[str, RobotAnswers | Exception] = {}
        for engine in [name for name, entry in engines().items() if entry.promises(level)]:
            try:
                answers[engine] = _answers(model_of(engine, robot, level), own)
            except Exception as error:  # whatever an engine raises is told, and fails
                answers[engine] = error
        found += _comparisons(level, answers, robot, own)
    return found


def with_meshes(robot: Robot, states: DrawnStates) -> DrawnStates:
    """The states with x of each mesh added: on either flank, or between where there is play."""
    rng, shape = np.random.default_rng(0), (len(states.q), 1)
    columns = []
    for spring in springs(robot):
        deep = min(FORCE / abs(spring.lever) / spring.stiffness, DEEPEST * spring.radius)
        rate = np.sqrt(spring.stiffness / spring.mass)  # of swings while the joint stands
        x = rng.choice((-1, 1), shape) * (spring.backlash + deep * rng.uniform(-1, 1, shape))
        v, a = (deep * rate**order * rng.uniform(-1, 1, shape) for order in (1, 2))
        columns.append((x, v, a))
    q, v, a = (
        np.hstack([joints, *own])
        for joints, own in zip(states[:3], zip(*columns, strict=True), strict=True)
    )
    return DrawnStates(q, v, a, states.torques)


def _answers(model: RobotModel, states: DrawnStates) -> RobotAnswers:
    """A model's answers at states. Raises ValueError for what is not finite or of another shape."""
    q, v, a, torques = states
    masses = model.mass_matrix(q)
    seconds = RUN_S  # whose steps resolve the swings of every mesh, and their dying out
    if model.level == "geared":
        seconds = min(RUN_S, STEPS / 2 / mesh_rates(model, masses).fastest)
    count, size = q.shape
    runs = min(count, RUNS)
    found = {
        "mass matrix": (masses, (count, size, size)),
        "bias": (model.bias(q, v), (count, size)),
        "gravity": (model.gravity(q), (count, size)),
        "inverse dynamics": (model.inverse_dynamics(q, v, a), (count, size)),
        "forward dynamics": (model.forward_dynamics(q, v, torques), (count, size)),
        "energy": (model.energy(q, v), (count,)),
        "momentum": (model.momentum(q, v), (count, 6)),
        "tip": (model.tip(q), (count, 3)),
        "run": (
            run(model, q[:RUNS], v[:RUNS], lambda time: 0 * torques[:RUNS], seconds, STEPS),
            (runs, size),
        ),
    }
    for name, (value, shape) in found.items():
        if value.shape != shape or not np.isfinite(value).all():
            raise ValueError(f"{name} is not finite, or not {shape}")
    return {name: value for name, (value, _) in found.items()}


def _comparisons(
    level: Level, answers: Mapping[str, RobotAnswers | Exception], robot: Robot, states: DrawnStates
) -> list[EngineDifference]:
    given = [each for each in answers.values() if isinstance(each, dict)]
    found: list[EngineDifference] = []
    for left, right in combinations(answers, 2):
        one, other = answers[left], answers[right]
        if isinstance(one, dict) and isinstance(other, dict):
            measured, condition = _measured(one, other, given[0], robot, states)
            if ROUNDINGS * condition > LARGEST_TOLERANCE:
                raise too_unlike(robot)
            for quantity, value in measured.items():
                harmed = ROUNDINGS * condition if quantity in SOLVED else 0.0
                tolerance = max(TOLERANCE, harmed)
                found.append(EngineDifference(quantity, level, left, right, value, tolerance))
            continue
        failed = " and ".join(
            f"{name} raised {type(each).__name__}: {each}"
            for name, each in ((left, one), (right, other))
            if isinstance(each, Exception)
        )
        found += [
            EngineDifference(quantity, level, left, right, float("inf"), TOLERANCE, failed)
            for quantity in QUANTITIES
        ]
    return found


def _measured(
    one: RobotAnswers, other: RobotAnswers, scale: RobotAnswers, robot: Robot, states: DrawnStates
) -> tuple[dict[str, float], float]:
    """Difference of each quantity, in parts of its size by `scale`; condition number of scaled M.

    By Cauchy and Schwarz a torque is at most the root of M's diagonal times the root of the sum of
    m times acceleration squared: so joints of a wrist are judged by their own size.
    """
    diagonal = np.sqrt(np.diagonal(scale["mass matrix"], axis1=1, axis2=2))
    roots = diagonal[:, :, None] * diagonal[:, None, :]
    values = np.linalg.eigvalsh(scale["mass matrix"] / roots)
    condition = float((values[:, -1] / values[:, 0]).max())
    turning = [robot.joints[number].kind == "revolute" for number in robot.coordinates]
    motion, accelerated = (_norm(scale["mass matrix"], each) for each in (states.v, states.a))
    bias = motion * np.abs(states.v).sum(axis=1)
    mass = sum(body.mass for body in robot.bodies)
    weight = np.full(len(bias), np.linalg.norm(robot.gravity) * np.sqrt(mass))
    inertia = sum(float(np.trace(body.inertia)) for body in robot.bodies)
    inertia += sum(rotor.inertia for rotor in with_rotors_alone(robot).rotors)
    free = len(turning)
    held, given = bias + weight, np.linalg.norm(states.torques / diagonal[:, :free], axis=1)
    if diagonal.shape[1] > free:
        held = held + (_pushes(robot, states) / diagonal[:, free:]).sum(axis=1)
    reach = sum(float(np.linalg.norm(joint.placement.position)) for joint in robot.joints)
    reach += float(np.linalg.norm(robot.frames[robot.tip].placement.position))
    sliding = np.flatnonzero(~np.array(turning))
    reach += float(np.abs(states.q[:, sliding]).max(axis=0).sum())
    apart = {name: np.abs(one[name] - other[name]) for name in QUANTITIES}
    moved = np.abs(scale["run"] - states.q[:RUNS])
    farthest = reach + max(float(np.linalg.norm(body.com)) for body in robot.bodies)
    joined = np.sqrt(mass * farthest**2 + inertia)
    momenta = np.split(apart["momentum"], 2, axis=1), (np.sqrt(mass), joined)
    parts = {
        "mass matrix": [(apart["mass matrix"] / roots).max(axis=(1, 2))],
        "bias": [_share((apart["bias"] / diagonal).max(axis=1), bias)],
        "gravity": [_share((apart["gravity"] / diagonal).max(axis=1), weight)],
        "inverse dynamics": [
            _share((apart["inverse dynamics"] / diagonal).max(axis=1), held + accelerated)
        ],
        "forward dynamics": [
            _share((apart["forward dynamics"] * diagonal).max(axis=1) * values[:, 0], held + given)
        ],
        "energy": [_share(apart["energy"], motion**2 / 2 + weight * np.sqrt(mass) * farthest)],
        "momentum": [
            _share(own.max(axis=1), motion * most) for own, most in zip(*momenta, strict=True)
        ],
        "tip": [_share(apart["tip"].max(axis=1), np.full(len(bias), reach))],
        "run": [
            _share(apart["run"][:, own].max(axis=1), moved[:, own].max(axis=1))
            for own in (slice(free), slice(free, None))
            if moved[:, own].size
        ],
    }
    return {name: float(max(each.max() for each in own)) for name, own in parts.items()}, condition


def _pushes(robot: Robot, states: DrawnStates) -> np.ndarray:
    """Bounds of what springs, dampers and motors do to x of each mesh (states, meshes) [N]."""
    found, free = [], robot.coordinates
    for place, spring in enumerate(springs(robot), len(free)):
        force = spring.stiffest * (np.abs(states.q[:, place]) + spring.error)
        force += spring.damping * np.abs(states.v[:, place])
        if spring.joint in free:
            torque = np.abs(states.torques[:, free.index(spring.joint)])
            force += torque / abs(spring.lever)
        found.append(force)
    return np.stack(found, axis=1)


def _norm(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    return np.sqrt(np.einsum("si,sij,sj->s", vector, matrix, vector))


def _share(apart: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Part of a size that a difference is; 0 for none, huge where there is no size."""
    return np.where(apart == 0, 0.0, apart / np.maximum(size, 1e-300))
