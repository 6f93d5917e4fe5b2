"""What a trial asks a model: one part of its equations at random states, in a user's coordinates.

Each question is a task of its own, so that a part that raises, hangs or takes its process down
costs that part alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np

from crosscheck.models.interface import Model
from crosscheck.models.loading import Case
from crosscheck.registry import MODELS
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.tasks import built
from crosscheck.trial.coordinates.differences import christoffel_terms, difference_steps, rate_terms
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.coordinates.states import UserState, states_of
from crosscheck.trial.input.calls import SuppliedEquations
from crosscheck.trial.input.traces import told_failure
from crosscheck.trial.model import HandedModel


class FrameEquations(Protocol):
    """Equations of motion in the coordinates of a frame, whoever's they are.

    x, u (n,): coordinates and rates.
    """

    @property
    def frame(self) -> Frame: ...

    def mass_matrix(self, x: np.ndarray) -> np.ndarray:
        """M_x, shape (n, n)."""
        ...

    def bias(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        """h_x, shape (n,)."""
        ...

    def force(self, state: UserState) -> np.ndarray:
        """f_x, shape (n,)."""
        ...

    def acceleration(self, state: UserState) -> np.ndarray:
        """x'', shape (n,)."""
        ...


@dataclass(frozen=True)
class Own:
    """What was handed over; it is in these coordinates already."""

    handed: SuppliedEquations
    frame: Frame

    def mass_matrix(self, x: np.ndarray) -> np.ndarray:
        """See FrameEquations."""
        return self.handed.mass_matrix(x)

    def bias(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        """See FrameEquations."""
        return self.handed.bias(x, u)

    def force(self, state: UserState) -> np.ndarray:
        """See FrameEquations."""
        return self.handed.force(state.t, state.x, state.u, state.torque)

    def acceleration(self, state: UserState) -> np.ndarray:
        """See FrameEquations."""
        return self.handed.acceleration(state.t, state.x, state.u, state.torque)


@dataclass(frozen=True)
class Moved:
    """A model of the arm, answering in the coordinates of a frame."""

    model: Model
    frame: Frame

    def mass_matrix(self, x: np.ndarray) -> np.ndarray:
        """See FrameEquations."""
        jacobian = self.frame.jacobian(x)
        return jacobian.T @ self.model.mass_matrix(self.frame.position(x)) @ jacobian

    def bias(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        """See FrameEquations."""
        q, jacobian = self.frame.position(x), self.frame.jacobian(x)
        inertial = self.model.mass_matrix(q) @ self.frame.drift(x, u)
        return jacobian.T @ (self.model.bias(q, jacobian @ u) + inertial)

    def force(self, state: UserState) -> np.ndarray:
        """See FrameEquations."""
        force = self.model.generalized_force(state.t, state.q, state.v)
        return self.frame.jacobian(state.x).T @ force

    def acceleration(self, state: UserState) -> np.ndarray:
        """See FrameEquations."""
        moving = self.model.acceleration(state.t, state.q, state.v)
        drift = self.frame.drift(state.x, state.u)
        return np.linalg.solve(self.frame.jacobian(state.x), moving - drift)


# A tooth force or a bias takes a user's Python this long [s] at most.
CALL_S = 2e-4
SPEEDS = (-1.0, 2.0)
AGAIN = "_again"
Answers = Callable[[FrameEquations, Sequence[UserState]], list[np.ndarray]]


@dataclass(frozen=True)
class StateQuestion:
    """A part of a model, at states of a seed, in the coordinates of the handed model ``asker``.

    model: whose answer, the asker's own or another's.
    """

    asker: str
    model: str
    case: Case
    quantity: str
    count: int
    seed: int

    @property
    def key(self) -> StateQuestion:
        """Itself."""
        return self

    @property
    def cost(self) -> float:
        """Rough seconds."""
        calls = len(self.case.arm.joints) ** 2 if self.quantity in BY_RATES else 1
        return 0.5 + self.count * calls * max(MODELS[self.model].call_s, CALL_S)

    def perform(self) -> np.ndarray | Failure:
        """The answers, state by state along the first axis, or why there are none."""
        try:
            return self._answers()
        except BaseException as error:  # also SystemExit and KeyboardInterrupt out of a model
            return told_failure(error)

    def _answers(self) -> np.ndarray:
        asker = built(self.asker, self.case)
        assert isinstance(asker, HandedModel)  # as it was registered
        case, frame = self.case, asker.frame
        states = states_of(frame, case.arm, case.scenario, self.count, self.seed)
        model = built(self.model, self.case)
        source: FrameEquations = Moved(model, frame)
        if isinstance(model, HandedModel):
            repeated = self.quantity.endswith(AGAIN)
            source = Own(model.asked_again if repeated else model.handed, frame)
        return np.array(QUESTIONS[self.quantity](source, states))


def _masses(source: FrameEquations, states: Sequence[UserState]) -> list[np.ndarray]:
    return [source.mass_matrix(state.x) for state in states]


def _biases(source: FrameEquations, states: Sequence[UserState]) -> list[np.ndarray]:
    return [source.bias(state.x, state.u) for state in states]


def _rate_terms(source: FrameEquations, states: Sequence[UserState]) -> list[np.ndarray]:
    found = []
    for state in states:
        steps = difference_steps(source.frame.jacobian(state.x), source.frame.layout.angular)
        found.append(rate_terms(partial(source.bias, state.x), state.x.size, steps))
    return found


def _christoffel(source: FrameEquations, states: Sequence[UserState]) -> list[np.ndarray]:
    found, curved = [], source.frame.matrix is None
    for state in states:
        steps = difference_steps(source.frame.jacobian(state.x), source.frame.layout.angular)
        found.append(christoffel_terms(source.mass_matrix, state.x, steps, curved=curved))
    return found


def _at_other_speeds(source: FrameEquations, states: Sequence[UserState]) -> list[np.ndarray]:
    """h(x, s u) / s^2 and h(x, 0): shape (count, speeds + 1, n)."""
    return [
        np.array(
            [source.bias(state.x, speed * state.u) / speed**2 for speed in SPEEDS]
            + [source.bias(state.x, 0 * state.u)]
        )
        for state in states
    ]


def _forces(source: FrameEquations, states: Sequence[UserState]) -> list[np.ndarray]:
    return [source.force(state) for state in states]


def _accelerations(source: FrameEquations, states: Sequence[UserState]) -> list[np.ndarray]:
    return [source.acceleration(state) for state in states]


def _by_torques(source: FrameEquations, states: Sequence[UserState]) -> list[np.ndarray]:
    """f at no torque, each alone, twice each alone, all together: (2 m + 2, n) at each state."""
    found = []
    for state in states:
        alone = np.diag(state.torque)
        torques = [0 * state.torque, *alone, *(2 * alone), state.torque]
        found.append(np.array([source.force(state._replace(torque=each)) for each in torques]))
    return found


def _inverse_dynamics(source: FrameEquations, states: Sequence[UserState]) -> list[np.ndarray]:
    """As handed over, M a + h, and the a of both, at other states' rates: (3, n) at each state."""
    assert isinstance(source, Own)  # nobody else is asked
    found = []
    for state, other in zip(states, [*states[1:], states[0]], strict=True):
        own = source.handed.inverse_dynamics(state.x, state.u, other.u)
        whole = source.mass_matrix(state.x) @ other.u + source.bias(state.x, state.u)
        found.append(np.array([own, whole, other.u]))
    return found


def _again(ask: Answers) -> Answers:
    """The same once more, the last state first."""
    return lambda source, states: ask(source, states[::-1])[::-1]


REPEATED: dict[str, Answers] = {
    "mass_matrix": _masses,
    "bias": _biases,
    "force": _forces,
    "acceleration": _accelerations,
}
QUESTIONS: dict[str, Answers] = {
    **REPEATED,
    **{f"{part}{AGAIN}": _again(ask) for part, ask in REPEATED.items()},
    "rate_terms": _rate_terms,
    "christoffel": _christoffel,
    "other_speeds": _at_other_speeds,
    "by_torques": _by_torques,
    "inverse_dynamics": _inverse_dynamics,
}
BY_RATES = ("rate_terms", "christoffel")
