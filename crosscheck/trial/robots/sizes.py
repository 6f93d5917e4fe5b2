"""How large each entry of a robot's equations is by nature, at each state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.cost.agreement import LARGEST_TOLERANCE, ROUNDINGS, TOLERANCE, RandomStates
from crosscheck.cost.runs import conditioning_error
from crosscheck.models.errors import InputError
from crosscheck.models.robot.robot import RIGID, Level, Robot

# Parts that hold the weights beside the bias, of which it is what remains.
WITH_WEIGHTS = ("inverse_dynamics", "nonlinear effects")
EARTH = 10.0  # m/s^2, of robots that stand in space


@dataclass(frozen=True)
class RobotSizes:
    """Natural sizes at states, by Cauchy and Schwarz: of torques over the root of M's diagonal.

    mass_matrix (states, n, n); the others (states, n); tolerances: by quantity, as parts of these.
    unit_accelerations (states, n): those that take a torque as large as a weight does.
    """

    mass_matrix: np.ndarray
    bias: np.ndarray
    gravity: np.ndarray
    inverse_dynamics: np.ndarray
    force: np.ndarray
    acceleration: np.ndarray
    balance: np.ndarray
    unit_accelerations: np.ndarray
    condition: float

    def entry_sizes(self, quantity: str, source: str = "") -> np.ndarray:
        """Sizes of a quantity's entries, (states, n) or (states, n, n).

        source: the part that it comes from; a bias that is inverse dynamics less the weights has
        their rounding.
        """
        if quantity == "bias" and source in WITH_WEIGHTS:
            return self.bias + self.gravity
        sizes: np.ndarray = getattr(self, quantity)
        return sizes

    def tolerance(self, quantity: str) -> float:
        """What an entry may differ, as a part of its size."""
        solved = ROUNDINGS * self.condition if quantity == "acceleration" else 0.0
        return max(TOLERANCE, solved)

    def basis(self, quantity: str) -> str:
        """Where the tolerance comes from."""
        reason = f"{TOLERANCE:g} of the entry's natural size, of which rounding explains 1e-15"
        if self.tolerance(quantity) > TOLERANCE:
            reason = f"{ROUNDINGS:.2g} times the condition number of M, {self.condition:.2g}"
        return reason


def compute_sizes_by_level(
    robot: Robot, stated: str, states: RandomStates
) -> dict[Level, RobotSizes]:
    """The sizes at each rigid level.

    Levels whose mass matrix is singular are left out. Raises InputError where none remains, or
    where the one that equations state is one of them.
    """
    sizes: dict[Level, RobotSizes] = {}
    for level in RIGID:
        try:
            sizes[level] = compute_sizes(robot, level, states)
        except InputError:
            if level == stated:
                raise
    if not sizes:
        raise conditioning_error(robot)
    return sizes


def compute_sizes(robot: Robot, level: Level, states: RandomStates) -> RobotSizes:
    """The natural sizes of a robot's equations at a level.

    Raises InputError for a robot whose mass matrix has lost its digits.
    """
    mass = AnalyticRobot(robot, level).mass_matrix(states.q)
    root = np.sqrt(np.diagonal(mass, axis1=1, axis2=2))
    if not (root > 0).all():
        raise conditioning_error(robot)
    roots = root[:, :, None] * root[:, None, :]
    values = np.linalg.eigvalsh(mass / roots)
    condition = float((values[:, -1] / values[:, 0]).max())
    if not 0 < ROUNDINGS * condition <= LARGEST_TOLERANCE:
        raise conditioning_error(robot)
    moving, accelerated = (
        np.sqrt(np.einsum("si,sij,sj->s", each, mass, each)) for each in (states.v, states.a)
    )
    motion = moving * np.abs(states.v).sum(axis=1)
    total = np.sqrt(sum(body.mass for body in robot.bodies))
    weight = total * max(EARTH, float(np.linalg.norm(robot.gravity)))
    given = np.linalg.norm(states.torques / root, axis=1)
    pushed = motion + weight + given
    return RobotSizes(
        mass_matrix=roots,
        bias=root * motion[:, None],
        gravity=root * weight,
        inverse_dynamics=root * (motion + weight + accelerated)[:, None],
        force=root * weight + np.abs(states.torques),
        acceleration=(pushed / values[:, 0])[:, None] / root,
        balance=root * pushed[:, None],
        unit_accelerations=weight / root,
        condition=condition,
    )
