"""A user's equations of an arm behind fixed signatures: parts as given, or worked out of others."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import CannotDo
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.input.calls import (
    TAKES,
    Arguments,
    MotorCall,
    NamedCall,
    add_motors,
    call_part,
    find_motors,
    make_named_calls,
)
from crosscheck.trial.input.equations import Equations, PartReading

WEIGHTS, FRICTION = "weights", "friction"
READINGS = {  # of what a part holds beside what its name says
    ("inverse_dynamics", WEIGHTS): "is not 0 at rest: read as M a + bias + gravity",
    ("inverse_dynamics", FRICTION): "has the joints' friction",
    (
        "bias",
        WEIGHTS,
    ): "is not 0 at rest: read as nonlinear effects, C v + g, of which g is its gravity",
    ("bias", FRICTION): "has the joints' friction",
}
PARTS_OF_MOTION = frozenset({"bias", "inverse_dynamics"})
ROUNDING = 1e-9  # of a bias at rest, relative to what it is in motion


@dataclass(frozen=True)
class SuppliedEquations:
    """Equations of an arm, each part by its fixed signature, or worked out from others.

    M, bias and gravity without a force are M x'' + h + g = tau: the force is what the torques do.

    given: parts that the user's functions are; has: these and what follows from them; motors: the
    joints that have one, from 0; held: which parts hold weights or friction beside M a + bias;
    left: which of these stand on the left of the equation, so that the force is without them. A
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
    held: frozenset[tuple[str, str]] = frozenset()
    left: frozenset[str] = frozenset()

    @property
    def readings(self) -> list[str]:
        """Sentences on what parts hold beside what their names say."""
        judged = dict.fromkeys(self.left & {FRICTION}, ": judged as a part of the force")
        return [
            f"{part} {READINGS[part, held]}{judged.get(held, '')}"
            for part, held in sorted(self.held)
        ]

    def answer(self, part: str, arguments: Arguments) -> np.ndarray:
        """The answer of a method to those of the arguments that it takes."""
        takes = TAKES["force" if part == "whole_force" else part]
        answer: np.ndarray = getattr(self, part)(*(arguments[name] for name in takes))
        return answer

    def mass_matrix(self, x: np.ndarray) -> np.ndarray:
        """M(x), shape (n, n)."""
        if "mass_matrix" in self.given:
            return self._call_part("mass_matrix", x=x)
        zero, units = np.zeros(len(x)), np.eye(len(x))
        rest = self._call_at_rest("inverse_dynamics", x)
        columns = [
            self._call_part("inverse_dynamics", x=x, v=zero, a=unit) - rest for unit in units
        ]
        return np.stack(columns, axis=1)

    def bias(self, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """C(x, v) v, shape (n,), which stands on the left of the equation."""
        if "coriolis" in self.given and "bias" not in self.given:
            return self._call_part("coriolis", x=x, v=v) @ v
        part = "bias" if "bias" in self.given else "inverse_dynamics"
        rest = self._call_at_rest(part, x) if (part, WEIGHTS) in self.held else 0.0
        return self.call_moving(part, x, v) - rest - self._compute_held_friction(part, x, v)

    def force(self, t: float, x: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Sum of all forces at time t [s], shape (n,), on the right of the equation."""
        if "force" not in self.given and "force" in self.has:
            joints: np.ndarray = self.frame.jacobian(x)[self.frame.layout.theta]
            force = joints.T @ torque
        else:
            force = self._call_part("force", t=t, x=x, v=v, torque=torque)
        if FRICTION not in self.left:
            return force
        part = min(part for part, held in self.held if held == FRICTION)
        return force - self._find_friction(part, x, v)

    def whole_force(self, t: float, x: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """The force with the weights, whether these are in it or apart, shape (n,)."""
        force = self.force(t, x, v, torque)
        return force - self.gravity(x) if "gravity" in self.has else force

    def gravity(self, x: np.ndarray) -> np.ndarray:
        """Forces that hold the weights, shape (n,), on the left of the equation."""
        parts = [part for part, held in self.held if held == WEIGHTS]
        if "gravity" in self.given or not parts:
            return self._call_part("gravity", x=x)
        return self._call_at_rest(min(parts), x)

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
        """The user's inverse dynamics without weights and friction, M(x) a + bias(x, v), (n,)."""
        whole = self._call_part("inverse_dynamics", x=x, v=v, a=a)
        weights: np.ndarray | float = 0.0
        if ("inverse_dynamics", WEIGHTS) in self.held:
            weights = self.gravity(x) if "gravity" in self.has else -self._find_resting_force(x)
        return whole - weights - self._compute_held_friction("inverse_dynamics", x, v)

    def _find_resting_force(self, x: np.ndarray) -> np.ndarray:
        """The force at rest and without torques, which is that of the weights alone."""
        return self.force(0.0, x, np.zeros(len(x)), np.zeros(len(self.arm.joints)))

    def call_moving(self, part: str, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Bias or inverse dynamics as they are given, without acceleration, shape (n,)."""
        a = {"a": np.zeros(len(x))} if part == "inverse_dynamics" else {}
        return self._call_part(part, x=x, v=v, **a)

    def _call_at_rest(self, part: str, x: np.ndarray) -> np.ndarray:
        return self.call_moving(part, x, np.zeros(len(x)))

    def _compute_held_friction(self, part: str, x: np.ndarray, v: np.ndarray) -> np.ndarray | float:
        return self._find_friction(part, x, v) if (part, FRICTION) in self.held else 0.0

    def _find_friction(self, part: str, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """A part's friction, shape (n,): what changes its sign with the rates, as no bias does.

        That of the file where the force has friction too, which is then judged there alone.
        """
        if FRICTION in self.left:
            return _find_odd(partial(self.call_moving, part, x), v)
        return self.friction(x, v)

    def friction(self, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """What the friction of the arm's file holds back, shape (n,), on the left."""
        coefficients = np.array([joint.friction_N_m_s_per_rad for joint in self.arm.joints])
        joints: np.ndarray = self.frame.jacobian(x)[self.frame.layout.theta]
        friction: np.ndarray = joints.T @ (coefficients * (joints @ v))
        return friction

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
    if is_rigid:
        held, left = equations.reading or find_part_reading(bound)
        bound = replace(bound, held=held, left=left)
    if WEIGHTS in bound.left:
        has.add("gravity")
    is_whole = is_rigid and has >= {"mass_matrix", "bias", "gravity"}
    if is_whole or FRICTION in bound.left:
        has.add("force")
    if has >= {"mass_matrix", "bias", "force"}:
        has.add("acceleration")
    return replace(bound, has=frozenset(has))


def find_part_reading(bound: SuppliedEquations) -> PartReading:
    """What parts of equations hold, by the answers at a place, at rest and in motion.

    A bias holds what has no part of its own and is not in a given force; inverse dynamics hold
    what the force has too, but then it is not on the left.
    """
    is_table = bound.equations.table is not None  # which has no bias at rest at all states
    parts = bound.given & ({"inverse_dynamics"} if is_table else PARTS_OF_MOTION)
    if not parts or (is_table and "force" in bound.given):
        return PartReading()
    x = np.linspace(0.3, 0.9, len(bound.frame.names))
    v, held, forced = x + 0.4, set[tuple[str, str]](), set[str]()
    has_weights = any(bound.arm.gravity_m_per_s2)
    try:
        friction = bound.friction(x, v)

        def find_held(function: Callable[[np.ndarray], np.ndarray], sign: int) -> set[str]:
            rest = np.abs(function(0 * v))
            is_heavy = has_weights and (rest > ROUNDING * np.abs(function(v)).max()).any()
            is_rubbing = friction.any() and _is_nearer(_find_odd(function, v), sign * friction)
            return {what for what, is_so in ((WEIGHTS, is_heavy), (FRICTION, is_rubbing)) if is_so}

        if "force" in bound.given:
            no_torque = np.zeros(len(bound.arm.joints))
            forced = find_held(partial(bound.force, 0.0, x, torque=no_torque), -1)
        apart = forced | ({WEIGHTS} if "gravity" in bound.given else set())
        for part in sorted(parts):
            beside = apart if part == "bias" else set()
            held |= {
                (part, what) for what in find_held(partial(bound.call_moving, part, x), 1) - beside
            }
    except Exception:  # of the user's functions, which the trial reports
        return PartReading()
    left = {what for _, what in held} - forced
    if has_weights and not (WEIGHTS in left or bound.given & {"gravity", "force"}):
        left.discard(FRICTION)  # a force without weights is not judged
    return PartReading(frozenset(held), frozenset(left))


def _find_odd(function: Callable[[np.ndarray], np.ndarray], v: np.ndarray) -> np.ndarray:
    """What of a function changes its sign with the rates."""
    return (function(v) - function(-v)) / 2


def _is_nearer(value: np.ndarray, expected: np.ndarray) -> bool:
    """Whether any row of a value is nearer to what is expected than to nothing."""
    return bool((np.abs(value - expected) < np.abs(value)).any())
