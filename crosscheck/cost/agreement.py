"""Do the models of a robot agree at random states? Every quantity, level and pair of engines."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from crosscheck.cost.engines import build_model, load_engines
from crosscheck.cost.runs import conditioning_error, mesh_rates, run
from crosscheck.cost.springs import replace_stages_by_rotors, tooth_springs
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import Level, Robot
from crosscheck.runner.outcomes import Failure, return_failures
from crosscheck.runner.workers import perform_all

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
ANSWERS_S = 1.0  # rough cost of a model's answers
FORCE, DEEPEST = 10.0, 0.01  # of a drawn mesh: N m or N at its joint, parts of its pinion's radius


class RandomStates(NamedTuple):
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


def sample_states(robot: Robot, count: int, seed: int) -> RandomStates:
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
    return RandomStates(q, v, rng.uniform(-5, 5, shape), rng.uniform(-10, 10, shape))


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


def compare_engines(robot: Robot, states: RandomStates) -> list[EngineDifference]:
    """Compare every pair of engines at each level that they promise.

    One that raises, crashes or hangs fails there.

    Raises InputError for a robot whose mass matrix has lost its digits.
    """
    tasks: list[EngineAnswers] = []
    for level in robot.levels:
        level_states = add_mesh_states(robot, states) if level == "geared" else states
        answering = [name for name, entry in load_engines().items() if entry.has_level(level)]
        tasks += [EngineAnswers(engine, robot, level, level_states) for engine in answering]
    answers = perform_all(tasks, os.cpu_count() or 1, lambda key: None)
    differences: list[EngineDifference] = []
    for level in robot.levels:
        level_states = next(task.states for task in tasks if task.level == level)
        by_engine = {engine: each for (engine, at), each in answers.items() if at == level}
        differences += _compare_answers(level, by_engine, robot, level_states)
    return differences


@dataclass(frozen=True)
class EngineAnswers:
    """The task of asking an engine's model of a robot at states, in a process of its own."""

    engine: str
    robot: Robot
    level: Level
    states: RandomStates
    cost: float = ANSWERS_S

    @property
    def key(self) -> tuple[str, Level]:
        """Name of the engine, and level."""
        return self.engine, self.level

    @return_failures
    def perform(self) -> RobotAnswers:
        """The model's answers, or the Failure that says why there are none."""
        return _evaluate_model(build_model(self.engine, self.robot, self.level), self.states)


def add_mesh_states(robot: Robot, states: RandomStates) -> RandomStates:
    """The states with x of each mesh added: on either flank, or between where there is backlash."""
    rng, shape = np.random.default_rng(0), (len(states.q), 1)
    columns = []
    for spring in tooth_springs(robot):
        deep = min(FORCE / abs(spring.lever) / spring.stiffness, DEEPEST * spring.radius)
        rate = np.sqrt(spring.stiffness / spring.mass)  # of swings while the joint stands
        x = rng.choice((-1, 1), shape) * (spring.backlash + deep * rng.uniform(-1, 1, shape))
        v, a = (deep * rate**order * rng.uniform(-1, 1, shape) for order in (1, 2))
        columns.append((x, v, a))
    q, v, a = (
        np.hstack([joints, *mesh_values])
        for joints, mesh_values in zip(states[:3], zip(*columns, strict=True), strict=True)
    )
    return RandomStates(q, v, a, states.torques)


def _evaluate_model(model: RobotModel, states: RandomStates) -> RobotAnswers:
    """A model's answers at states. Raises ValueError for what is not finite or of another shape."""
    q, v, a, torques = states
    masses = model.mass_matrix(q)
    seconds = RUN_S  # whose steps resolve the swings of every mesh, and their dying out
    if model.level == "geared":
        seconds = min(RUN_S, STEPS / 2 / mesh_rates(model, masses).fastest)
    count, size = q.shape
    runs = min(count, RUNS)
    results = {
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
    for name, (value, shape) in results.items():
        if value.shape != shape or not np.isfinite(value).all():
            raise ValueError(f"{name} is not finite, or not {shape}")
    return {name: value for name, (value, _) in results.items()}


def _compare_answers(
    level: Level, answers: Mapping[str, RobotAnswers | Failure], robot: Robot, states: RandomStates
) -> list[EngineDifference]:
    given = [each for each in answers.values() if isinstance(each, dict)]
    differences: list[EngineDifference] = []
    for left, right in combinations(answers, 2):
        left_answers, right_answers = answers[left], answers[right]
        if isinstance(left_answers, dict) and isinstance(right_answers, dict):
            measured, condition = _measure_differences(
                left_answers, right_answers, given[0], robot, states
            )
            if ROUNDINGS * condition > LARGEST_TOLERANCE:
                raise conditioning_error(robot)
            for quantity, value in measured.items():
                harmed = ROUNDINGS * condition if quantity in SOLVED else 0.0
                tolerance = max(TOLERANCE, harmed)
                differences.append(EngineDifference(quantity, level, left, right, value, tolerance))
            continue
        failed = " and ".join(
            f"{name} raised {each}"
            for name, each in ((left, left_answers), (right, right_answers))
            if isinstance(each, Failure)
        )
        differences += [
            EngineDifference(quantity, level, left, right, float("inf"), TOLERANCE, failed)
            for quantity in QUANTITIES
        ]
    return differences


def _measure_differences(
    left: RobotAnswers, right: RobotAnswers, scale: RobotAnswers, robot: Robot, states: RandomStates
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
    inertia += sum(rotor.inertia for rotor in replace_stages_by_rotors(robot).rotors)
    free = len(turning)
    held, given = bias + weight, np.linalg.norm(states.torques / diagonal[:, :free], axis=1)
    if diagonal.shape[1] > free:
        held = held + (_pushes(robot, states) / diagonal[:, free:]).sum(axis=1)
    reach = sum(float(np.linalg.norm(joint.placement.position)) for joint in robot.joints)
    reach += float(np.linalg.norm(robot.frames[robot.tip].placement.position))
    sliding = np.flatnonzero(~np.array(turning))
    reach += float(np.abs(states.q[:, sliding]).max(axis=0).sum())
    differences = {name: np.abs(left[name] - right[name]) for name in QUANTITIES}
    moved = np.abs(scale["run"] - states.q[:RUNS])
    farthest = reach + max(float(np.linalg.norm(body.com)) for body in robot.bodies)
    joined = np.sqrt(mass * farthest**2 + inertia)
    momenta = np.split(differences["momentum"], 2, axis=1), (np.sqrt(mass), joined)
    parts = {
        "mass matrix": [(differences["mass matrix"] / roots).max(axis=(1, 2))],
        "bias": [_share((differences["bias"] / diagonal).max(axis=1), bias)],
        "gravity": [_share((differences["gravity"] / diagonal).max(axis=1), weight)],
        "inverse dynamics": [
            _share((differences["inverse dynamics"] / diagonal).max(axis=1), held + accelerated)
        ],
        "forward dynamics": [
            _share(
                (differences["forward dynamics"] * diagonal).max(axis=1) * values[:, 0],
                held + given,
            )
        ],
        "energy": [
            _share(differences["energy"], motion**2 / 2 + weight * np.sqrt(mass) * farthest)
        ],
        "momentum": [
            _share(part.max(axis=1), motion * most) for part, most in zip(*momenta, strict=True)
        ],
        "tip": [_share(differences["tip"].max(axis=1), np.full(len(bias), reach))],
        "run": [
            _share(differences["run"][:, part].max(axis=1), moved[:, part].max(axis=1))
            for part in (slice(free), slice(free, None))
            if moved[:, part].size
        ],
    }
    return {
        name: float(max(each.max() for each in part)) for name, part in parts.items()
    }, condition


def _pushes(robot: Robot, states: RandomStates) -> np.ndarray:
    """Bounds of what springs, dampers and motors do to x of each mesh (states, meshes) [N]."""
    bounds, free = [], robot.coordinates
    for place, spring in enumerate(tooth_springs(robot), len(free)):
        force = spring.stiffest * (np.abs(states.q[:, place]) + spring.error)
        force += spring.damping * np.abs(states.v[:, place])
        if spring.joint in free:
            torque = np.abs(states.torques[:, free.index(spring.joint)])
            force += torque / abs(spring.lever)
        bounds.append(force)
    return np.stack(bounds, axis=1)


def _norm(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    return np.sqrt(np.einsum("si,sij,sj->s", vector, matrix, vector))


def _share(difference: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Part of a size that a difference is; 0 for none, huge where there is no size."""
    return np.where(difference == 0, 0.0, difference / np.maximum(size, 1e-300))
