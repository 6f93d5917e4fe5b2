"""Questions to a model at many states; an answer that is not an array of numbers is refused.

A question is a function of a model and of a setting, which has the states: an arm's or a robot's. A
check that no method of a model answers by itself defines its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks.arm_sizes import ArmSizes
from crosscheck.checks.first_principles.slopes import SlopeRule, make_exact_rule
from crosscheck.checks.scales import SLIDING_M_PER_S, TURNING_RAD_PER_S, largest_displacement
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import Layout, geared_layout, rigid_layout
from crosscheck.models.errors import describe_type
from crosscheck.models.loading import Case


class BadAnswer(ValueError):
    """An answer of a model that is not what its interface says."""


class States(NamedTuple):
    """States of a model: t (count,) [s]; q, v (count, n) in its coordinates."""

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray


def sample_states(layout: Layout, arm: Arm, count: int, seed: int) -> States:
    """Random states in any pose and brisk motion, with teeth on either flank or out of contact."""
    generator = np.random.default_rng(seed)
    q_size = np.where(layout.angular, np.pi, largest_displacement(arm))
    v_size = np.where(layout.angular, TURNING_RAD_PER_S, SLIDING_M_PER_S)
    shape = (count, len(layout))
    t = generator.uniform(0, 2, count)
    q, v = (generator.uniform(-1, 1, shape) * size for size in (q_size, v_size))
    return States(t, q, v)


@dataclass(frozen=True)
class Setting:
    """An arm in a case, and a seed's random states; level: of a rigid arm, empty with gears."""

    case: Case
    level: str
    count: int = 1
    seed: int = 0

    @property
    def arm(self) -> Arm:
        """The arm."""
        return self.case.arm

    @cached_property
    def layout(self) -> Layout:
        """The coordinates that a model must have."""
        return rigid_layout(self.arm) if self.level else geared_layout(*self.case[::2])

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        return self.layout.names

    @cached_property
    def states(self) -> States:
        """The states."""
        return sample_states(self.layout, self.arm, self.count, self.seed)

    @property
    def first(self) -> States:
        """The states at which slopes are taken: all of them."""
        return self.states

    @property
    def slope_rule(self) -> SlopeRule:
        """How slopes of M are taken."""
        return make_exact_rule(self.layout.angular)

    @property
    def turns(self) -> np.ndarray:
        """How far joints turn with each coordinate (n,), per rad or m."""
        return np.where(self.layout.angular, 1.0, 0.0)

    @cached_property
    def sizes(self) -> ArmSizes:
        """Natural sizes at the states."""
        return ArmSizes(self.case, self.layout, self.level, self.states)


def require_numbers(answer: object, what: str, shape: tuple[int, ...] | None) -> np.ndarray:
    """The answer, if it is an array of finite float64 of this shape. Raises BadAnswer."""
    if not isinstance(answer, np.ndarray):
        raise BadAnswer(f"{what} is {describe_type(answer)}, must be an array")
    if answer.dtype != np.float64:
        raise BadAnswer(f"{what} is of type {answer.dtype}, must be float64")
    if shape is not None and answer.shape != shape:
        raise BadAnswer(f"{what} has shape {answer.shape}, must be {shape}")
    if not np.isfinite(answer).all():
        raise BadAnswer(f"{what} is not finite")
    return answer


def ask(model: Any, method: str, shape: tuple[int, ...], *given: np.ndarray) -> np.ndarray:
    """Answers of a method at states, the first axis of all that is given, of this shape.

    A model that takes one state at a time is asked state by state. Raises BadAnswer, and whatever
    the model raises.
    """
    answer = getattr(model, method)
    if model.takes_many_states:
        return require_numbers(answer(*given), method, shape)
    states = zip(*given, strict=True)
    answers = (answer(*(x.copy() for x in state)) for state in states)
    return np.array([require_numbers(each, method, shape[1:]) for each in answers])


@dataclass(frozen=True)
class MethodQuestion:
    """A question that a method answers: which one, and what it is given of the states.

    shape: of the answer at a state, -1 for the number of coordinates; name: of the quantity, if it
    is not the method's.
    """

    method: str
    given: tuple[str, ...]
    shape: tuple[int, ...]
    name: str = ""

    @property
    def __name__(self) -> str:
        return self.name or self.method

    def __call__(self, model: Any, setting: Any) -> np.ndarray:
        """The answers (states, ...)."""
        count, n = setting.states.q.shape
        shape = count, *(n if size < 0 else size for size in self.shape)
        return ask(model, self.method, shape, *(getattr(setting.states, x) for x in self.given))


mass_matrix = MethodQuestion("mass_matrix", ("q",), (-1, -1))
bias = MethodQuestion("bias", ("q", "v"), (-1,))
# Of arms, whose experiment drives them.
generalized_force = MethodQuestion("generalized_force", ("t", "q", "v"), (-1,))
acceleration = MethodQuestion("acceleration", ("t", "q", "v"), (-1,))
SWITCHED = generalized_force, acceleration  # what other switches change
EQUATIONS = mass_matrix, bias, *SWITCHED
# Of robots.
gravity = MethodQuestion("gravity", ("q",), (-1,))
inverse_dynamics = MethodQuestion("inverse_dynamics", ("q", "v", "a"), (-1,))
forward_dynamics = MethodQuestion("forward_dynamics", ("q", "v", "torques"), (-1,))
energy = MethodQuestion("energy", ("q", "v"), ())
momentum = MethodQuestion("momentum", ("q", "v"), (6,))
tip = MethodQuestion("tip", ("q",), (3,))
DYNAMICS = mass_matrix, bias, gravity, inverse_dynamics, forward_dynamics
ROBOT_QUESTIONS = *DYNAMICS, energy, momentum, tip
