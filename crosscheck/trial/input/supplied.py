"""A user's equations of an arm behind fixed signatures: parts as given, or worked out of others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import CannotDo
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.input.calls import (
    MotorCall,
    NamedCall,
    add_motors,
    call_part,
    find_motors,
    make_named_calls,
)
from crosscheck.trial.input.equations import Equations


@dataclass(frozen=True)
class SuppliedEquations:
    """Equations of an arm, each part by its fixed signature, or worked out from others.

    M, bias and gravity without a force are M x'' + h + g = tau: the force is what the torques do.

    given: parts that the user's functions are; has: these and what follows from them; motors: the
    joints that have one, from 0; holds_weights: whether inverse_dynamics holds the weights too. A
    method whose part is not there raises CannotDo. Arrays are float64: x, v, a (n,) in the user's
    coordinates; torque (joints,) [N m] on the output side. Raises BadAnswer for an answer that is
    no array of finite numbers of the right shape, and whatever the user's function raises.
    """

    equations: Equations
    arm: Arm
    frame: Frame
    given: frozenset[str]
    has: frozenset[str]
    motors: tuple[int, ...]
    calls: Mapping[str, NamedCall | MotorCall] = field(repr=False)
    holds_weights: bool = False

    def mass_matrix(self, x: np.ndarray) -> np.ndarray:
        """M(x), shape (n, n)."""
        if "mass_matrix" in self.given:
            return self._call_part("mass_matrix", x=x)
        zero, units = np.zeros(len(x)), np.eye(len(x))
        rest = self.hold_at_rest(x)
        columns = [
            self._call_part("inverse_dynamics", x=x, v=zero, a=unit) - rest for unit in units
        ]
        return np.stack(columns, axis=1)

    def bias(self, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """C(x, v) v, shape (n,), which stands on the left of the equation."""
        if "bias" in self.given:
            return self._call_part("bias", x=x, v=v)
        if "coriolis" in self.given:
            return self._call_part("coriolis", x=x, v=v) @ v
        return self.inverse_dynamics(x, v, np.zeros(len(x)))

    def force(self, t: float, x: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Sum of all forces at time t [s], shape (n,), on the right of the equation."""
        if "force" not in self.given and "force" in self.has:
            joints: np.ndarray = self.frame.jacobian(x)[self.frame.layout.theta]
            return joints.T @ torque
        return self._call_part("force", t=t, x=x, v=v, torque=torque)

    def whole_force(self, t: float, x: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """The force with the weights, whether these are in it or apart, shape (n,)."""
        force = self.force(t, x, v, torque)
        return force - self.gravity(x) if "gravity" in self.has else force

    def gravity(self, x: np.ndarray) -> np.ndarray:
        """Forces that hold the weights, shape (n,), on the left of the equation."""
        return self.hold_at_rest(x) if self.holds_weights else self._call_part("gravity", x=x)

    def hold_at_rest(self, x: np.ndarray) -> np.ndarray:
        """The inverse dynamics of no motion, shape (n,)."""
        return self._call_part("inverse_dynamics", x=x, v=np.zeros(len(x)), a=np.zeros(len(x)))

    def acceleration(
        self, t: float, x: np.ndarray, v: np.ndarray, torque: np.ndarray
    ) -> np.ndarray:
        """x'' at time t [s], shape (n,). Raises numpy's LinAlgError where M is singular."""
        if "acceleration" in self.given:
            return self._call_part("acceleration", t=t, x=x, v=v, torque=torque)
        balance = self.whole_force(t, x, v, torque) - self.bias(x, v)
        mass = self.mass_matrix(x)
        # The units of x must not choose the pivots.
        size = np.sqrt(np.abs(np.diag(mass)))
        size = np.where(size > 0, size, 1.0)
        return np.linalg.solve(mass / np.outer(size, size), balance / size) / size

    def inverse_dynamics(self, x: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """The user's inverse dynamics without the weights, M(x) a + bias(x, v), shape (n,)."""
        whole = self._call_part("inverse_dynamics", x=x, v=v, a=a)
        return whole - self.gravity(x) if self.holds_weights else whole

    def _call_part(self, part: str, **arguments: Any) -> np.ndarray:
        """The answer of the user's function to copies of the arguments, (n,) or (n, n)."""
        if part not in self.given:
            raise CannotDo(f"the equations have no {part}")
        return call_part(self.calls[part], part, len(self.frame.names), arguments)


def bind_equations(equations: Equations, arm: Arm, frame: Frame) -> SuppliedEquations:
    """The equations, bound to an arm and in a frame of it. Raises InputError."""
    calls = make_named_calls(equations)
    motors = find_motors(equations, calls, arm.coordinate_names)
    motor_calls = add_motors(calls, equations, motors)
    has = set(calls)
    if has & {"coriolis", "inverse_dynamics"}:
        has.add("bias")
    if "inverse_dynamics" in calls:
        has.add("mass_matrix")
    bound = SuppliedEquations(
        equations, arm, frame, frozenset(calls), frozenset(has), motors, motor_calls
    )
    is_rigid = equations.coordinates.gearing == "rigid"
    holds_weights = is_rigid and not has & {"gravity", "force"} and _has_weights(bound)
    if holds_weights:
        has.add("gravity")
    if has >= {"mass_matrix", "bias", "gravity"} and is_rigid:
        has.add("force")
    if has >= {"mass_matrix", "bias", "force"}:
        has.add("acceleration")
    return replace(bound, has=frozenset(has), holds_weights=holds_weights)


def _has_weights(bound: SuppliedEquations) -> bool:
    """Whether the inverse dynamics of no motion hold something: Newton and Euler's in gravity."""
    if "inverse_dynamics" not in bound.given or not any(bound.arm.gravity_m_per_s2):
        return False
    try:
        return bool(bound.hold_at_rest(np.linspace(0.3, 0.9, len(bound.frame.names))).any())
    except Exception:  # of the user's function, which the trial reports
        return False
