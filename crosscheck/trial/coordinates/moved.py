"""A model's answers carried from the project's coordinates q into a user's x, and back.

With q = phi(x), J = dphi/dx and q' = J u: M_x = J^T M J, h_x = J^T (h + M J' u), f_x = J^T f and
q'' = J a + J' u (Siciliano et al., Robotics, ch. 7: the equations of motion are covariant).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from crosscheck.models.interface import Model
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.coordinates.states import UserState
from crosscheck.trial.input.calls import SuppliedEquations


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
