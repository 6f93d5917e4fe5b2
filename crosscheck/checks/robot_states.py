"""Random states of a robot, and how large each quantity is there: what differences are parts of.

By Cauchy and Schwarz a torque is at most the root of M's diagonal times the root of the sum of m
times acceleration squared: so joints of a wrist are judged by their own size.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from crosscheck.checks.scales import ReasonedLimit
from crosscheck.models.robot.integration import conditioning_error
from crosscheck.models.robot.robot import Robot

# Of each quantity's size. Rounding explains 1e-15 times the reach over the smallest lever arm.
TOLERANCE = 1e-10
ROUNDINGS = 1000 * np.finfo(float).eps  # error of solving with M, over M's condition number
LARGEST_TOLERANCE = 1e-3  # beyond it agreement would say nothing
# Quantities that suffer from M's condition number.
SOLVED = ("forward_dynamics", "run", "acceleration")
# Parts that hold the weights beside the bias, of which it is what remains.
WITH_WEIGHTS = ("inverse_dynamics", "nonlinear effects")
SIZE_WORDS = {
    "mass_matrix": "entry over the root of the two diagonal ones",
    "bias": "torque over the root of M's diagonal, of (v' M v)^1/2 times the sum of the rates",
    "gravity": "torque over the root of M's diagonal, of the weight over the root of the mass",
    "inverse_dynamics": "torque as of bias, gravity, meshes and friction, with (a' M a)^1/2",
    "forward_dynamics": "acceleration times the root of M's diagonal, of what M can make of it",
    "energy": "of the kinetic energy, and of the weight at the farthest centre of mass",
    "momentum": "linear and angular, of the most that the kinetic energy allows",
    "tip": "distance over the reach",
    "run": "coordinate of a motion in equal steps, of how far any joint, or any mesh, has moved",
}


class RandomStates(NamedTuple):
    """Random states: coordinates, rates, accelerations (states, n), torques (states, free)."""

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    torques: np.ndarray

    def first(self, count: int) -> RandomStates:
        """The first of the states."""
        return RandomStates(*(each[:count] for each in self))


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


@dataclass(frozen=True)
class RobotSizes:
    """Natural sizes at states: of M (states, n, n), of the others (states, n) unless said.

    force: of torques less weights; balance: of all that accelerates; motion, weight, momentum
    (states, 6), energy, tip: (states,), where motion is (v' M v)^1/2; unit_accelerations: those
    that take a torque as large as a weight does; condition: number of M, scaled.
    """

    mass_matrix: np.ndarray
    bias: np.ndarray
    gravity: np.ndarray
    inverse_dynamics: np.ndarray
    forward_dynamics: np.ndarray
    force: np.ndarray
    balance: np.ndarray
    unit_accelerations: np.ndarray
    motion: np.ndarray
    energy: np.ndarray
    momentum: np.ndarray
    tip: np.ndarray
    condition: float

    @property
    def acceleration(self) -> np.ndarray:
        """Sizes of the acceleration under torques."""
        return self.forward_dynamics

    def entry_sizes(self, quantity: str, source: str = "") -> np.ndarray:
        """Sizes of a quantity's entries, (states, n) or (states, n, n).

        source: the part that it comes from; a bias that is inverse dynamics less the weights has
        their rounding.
        """
        if quantity == "bias" and source in WITH_WEIGHTS:
            return self.bias + self.gravity
        return getattr(self, quantity)

    def tolerance(self, quantity: str) -> float:
        """The tolerance of an entry relative to its size."""
        return max(TOLERANCE, ROUNDINGS * self.condition if quantity in SOLVED else 0.0)

    def natural_size(self, quantity: str, values: np.ndarray) -> np.ndarray:
        """Sizes of a quantity's components, broadcast to a model's values (states, ...)."""
        size: np.ndarray = getattr(self, quantity)
        return size if values.ndim == size.ndim else size[:, None]

    def limit(self, quantity: str) -> ReasonedLimit:
        """The tolerance of a difference relative to its size."""
        basis = f"{self.basis(quantity)}; size: {SIZE_WORDS[quantity]}"
        return ReasonedLimit(self.tolerance(quantity), basis)

    def basis(self, quantity: str) -> str:
        """Where the tolerance comes from."""
        reason = f"{TOLERANCE:g} of the entry's natural size, of which rounding explains 1e-15"
        if self.tolerance(quantity) > TOLERANCE:
            reason = f"{ROUNDINGS:.2g} times the condition number of M, {self.condition:.2g}"
        return reason


def compute_sizes(
    robot: Robot,
    mass_matrix: np.ndarray,
    states: RandomStates,
    *,
    pushes: np.ndarray | None = None,
    spinning: float = 0.0,
    least_gravity: float = 0.0,
) -> RobotSizes:
    """The natural sizes of a robot's quantities at states where M is mass_matrix (states, n, n).

    pushes (states, meshes) [N]: bounds of what works on x of each mesh; spinning [kg m^2]: inertias
    of all rotors; least_gravity [m/s^2]: of which weights are sized at least. Raises InputError for
    a robot whose mass matrix has lost its digits.
    """
    root = np.sqrt(np.diagonal(mass_matrix, axis1=1, axis2=2))
    if not (root > 0).all():
        raise conditioning_error(robot)
    roots = root[:, :, None] * root[:, None, :]
    values = np.linalg.eigvalsh(mass_matrix / roots)
    condition = float((values[:, -1] / values[:, 0]).max())
    if not 0 < ROUNDINGS * condition <= LARGEST_TOLERANCE:
        raise conditioning_error(robot)
    moving, accelerated = (
        np.sqrt(np.einsum("si,sij,sj->s", each, mass_matrix, each)) for each in states[1:3]
    )
    free = len(robot.coordinates)
    motion = moving * np.abs(states.v).sum(axis=1)
    mass = sum(body.mass for body in robot.bodies)
    weight = np.sqrt(mass) * max(least_gravity, float(np.linalg.norm(robot.gravity)))
    given = np.linalg.norm(states.torques / root[:, :free], axis=1)
    held = motion + weight
    if pushes is not None:
        held = held + (pushes / root[:, free:]).sum(axis=1)
    held = held + (robot.friction * np.abs(states.v[:, :free]) / root[:, :free]).sum(axis=1)
    reach, farthest = _reach(robot, states)
    turning = spinning + sum(float(np.trace(body.inertia)) for body in robot.bodies)
    momenta = np.repeat([np.sqrt(mass), np.sqrt(mass * farthest**2 + turning)], 3)
    return RobotSizes(
        mass_matrix=roots,
        bias=root * motion[:, None],
        gravity=root * weight,
        inverse_dynamics=root * (held + accelerated)[:, None],
        forward_dynamics=((held + given) / values[:, 0])[:, None] / root,
        force=root[:, :free] * weight + np.abs(states.torques),
        balance=root * (held + given)[:, None],
        unit_accelerations=weight / root,
        motion=moving,
        energy=moving**2 / 2 + weight * np.sqrt(mass) * farthest,
        momentum=moving[:, None] * momenta,
        tip=np.full(len(root), reach),
        condition=condition,
    )


def _reach(robot: Robot, states: RandomStates) -> tuple[float, float]:
    """Distances [m] from the base that the tip, and a centre of mass, have at most."""
    reach = sum(float(np.linalg.norm(joint.placement.position)) for joint in robot.joints)
    reach += float(np.linalg.norm(robot.frames[robot.tip].placement.position))
    sliding = [number - 1 for number in robot.slides]
    reach += float(np.abs(states.q[:, sliding]).max(axis=0).sum())
    return reach, reach + max(float(np.linalg.norm(body.com)) for body in robot.bodies)
