"""A model's answers, state by state; an answer that is not an array of numbers is refused."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from crosscheck.checks.first_principles.christoffel import christoffel_force
from crosscheck.checks.scales import arm_reach, geared_joints, meshes
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import Layout
from crosscheck.models.experiment.scenario import expand_to_joints
from crosscheck.models.interface import Model

# Quantities that no method of a model gives by itself.
CHRISTOFFEL, ABILITIES = "christoffel_force", "abilities"
CORNER_FORCE = "corner_force"  # the generalized force, at the corners of the mesh laws
START_MASS, FORCE_SLOPES = "start_mass", "force_slopes"
# Of angles [rad, rad/s] and displacements [m, m/s], of which forces are differenced.
TURN, SHIFT = 1e-4, 1e-6
OPENED = 1e-3  # of the sizes of joints' gaps, rates and accelerations
# How far and fast random states go; what is compared there is measured against its own size.
LEAST_PLAY_M, SLIDING_M_PER_S, TURNING_RAD_PER_S = 2e-5, 0.1, 3.0


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
    contacts = [mesh for _, joint in geared_joints(arm) for mesh in meshes(joint)]
    play = 3 * max((mesh.backlash_m for mesh in contacts), default=0.0)
    play = max(play, 3 * LEAST_PLAY_M)
    play += max((abs(mesh.static_error_m) for mesh in contacts), default=0.0)
    q_size = np.where(layout.angular, np.pi, play)
    v_size = np.where(layout.angular, TURNING_RAD_PER_S, SLIDING_M_PER_S)
    shape = (count, len(layout))
    t = generator.uniform(0, 2, count)
    q, v = (generator.uniform(-1, 1, shape) * size for size in (q_size, v_size))
    return States(t, q, v)


def evaluate_at_states(model: Model, expected: Layout, quantity: str, states: States) -> np.ndarray:
    """A model's answers at states, the states along the first axis.

    expected: the coordinates that it must have. Raises BadAnswer, and whatever the model raises.
    """
    if model.layout != expected:
        raise BadAnswer(f"coordinates are {model.layout.names}, must be {expected.names}")
    if quantity in WITHOUT_STATE:
        return np.array(WITHOUT_STATE[quantity](model))
    answer = AT_STATE[quantity]
    return np.array([answer(model, *state) for state in zip(*states, strict=True)])


def require_numbers(answer: object, what: str, shape: tuple[int, ...] | None) -> np.ndarray:
    """The answer, if it is an array of finite float64 of this shape. Raises BadAnswer."""
    if not isinstance(answer, np.ndarray):
        raise BadAnswer(f"{what} is a {type(answer).__name__}, must be an array")
    if answer.dtype != np.float64:
        raise BadAnswer(f"{what} is of type {answer.dtype}, must be float64")
    if shape is not None and answer.shape != shape:
        raise BadAnswer(f"{what} has shape {answer.shape}, must be {shape}")
    if not np.isfinite(answer).all():
        raise BadAnswer(f"{what} is not finite")
    return answer


def _mass_matrix(model: Model, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    return require_numbers(model.mass_matrix(q.copy()), "mass_matrix", (q.size, q.size))


def _at_time(method: str, model: Model, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    return require_numbers(getattr(model, method)(t, q.copy(), v.copy()), method, q.shape)


_generalized_force = partial(_at_time, "generalized_force")
_acceleration = partial(_at_time, "acceleration")


def _christoffel(model: Model, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    def mass_matrix(pose: np.ndarray) -> np.ndarray:
        return _mass_matrix(model, t, pose, v)

    return christoffel_force(mass_matrix, q, v, model.layout.angular)


def _widest_gap(model: Model, t: float, q: np.ndarray, v: np.ndarray) -> float:
    """Largest gap, rate or acceleration of the model's joints over its size.

    How far they are from what they must be with the joints opened on purpose counts too.
    """
    a = _acceleration(model, t, q, v)
    closed = _gaps(model.constraint_residual(q.copy(), v.copy(), a.copy()))
    reach = arm_reach(model.arm)
    angular = model.layout.angular
    sizes = [max(1.0, reach * float(np.abs(vector[angular]).max())) for vector in (v * 0, v, a)]
    size = np.array(sizes)[:, None]
    opened = OPENED * size * np.cos(np.arange(closed.size)).reshape(closed.shape)
    opened_residuals = _gaps(model.constraint_residual(q.copy(), v.copy(), a.copy(), opened.copy()))
    if opened_residuals.shape != opened.shape:
        raise BadAnswer("constraint_residual has other joints once they are opened")
    return float(max(np.abs(closed / size).max(), np.abs((opened_residuals - opened) / size).max()))


def _gaps(residuals: object) -> np.ndarray:
    """Gaps, rates and accelerations of joints, shape (3, gaps). Raises BadAnswer."""
    if not isinstance(residuals, tuple) or len(residuals) != 3:
        raise BadAnswer("constraint_residual is not gaps, rates and accelerations")
    gaps, *others = (require_numbers(r, "constraint_residual", None) for r in residuals)
    if gaps.size == 0 or any(other.shape != gaps.shape for other in others):
        raise BadAnswer("constraint_residual is empty, or its parts are of unequal shapes")
    return np.array([gaps.ravel(), *(other.ravel() for other in others)])


def _mesh_modes(model: Model) -> np.ndarray:
    modes = require_numbers(model.mesh_modes(), "mesh_modes", None)
    if modes.ndim != 1 or (modes <= 0).any() or (np.diff(modes) < 0).any():
        raise BadAnswer("mesh_modes are not positive frequencies in ascending order")
    return modes


def _contact_poles(model: Model) -> np.ndarray:
    poles = model.contact_poles()
    if not isinstance(poles, np.ndarray) or poles.shape != (2 * len(model.layout),):
        raise BadAnswer("contact_poles are not two for every coordinate")
    parts = np.array([poles.real, poles.imag])
    require_numbers(parts, "contact_poles", parts.shape)
    return parts[0] + 1j * parts[1]


def _largest_stable_step(model: Model) -> float:
    step = model.largest_stable_step()
    if not isinstance(step, float) or not step > 0:
        raise BadAnswer(f"largest_stable_step is {step!r}, must be a positive number")
    return step


def _start_pose(model: Model) -> np.ndarray:
    """Coordinates of the scenario's angles, the teeth centred, shape (n,)."""
    pose = np.zeros(len(model.layout))
    pose[model.layout.theta] = expand_to_joints(
        model.scenario.start.theta_rad, len(model.arm.joints)
    )
    return pose


def _start_mass(model: Model) -> np.ndarray:
    pose = _start_pose(model)
    return _mass_matrix(model, 0.0, pose, 0 * pose)


def _force_slopes(model: Model) -> np.ndarray:
    """Slopes of the generalized force by q and v, at rest in the start pose, shape (2, n, 2 n).

    The first are by differences of one size, the second by differences of twice that.
    """
    pose = _start_pose(model)
    start, slopes = np.append(pose, 0 * pose), []
    once = np.tile(np.where(model.layout.angular, TURN, SHIFT), 2)

    def force(state: np.ndarray) -> np.ndarray:
        q, v = np.split(state, 2)
        return _generalized_force(model, 0.0, q, v)

    for sizes in (once, 2 * once):
        differences = [force(start + step) - force(start - step) for step in np.diag(sizes)]
        slopes.append(np.stack(differences, axis=1) / (2 * sizes))
    return np.array(slopes)


AT_STATE: dict[str, Callable[[Model, float, np.ndarray, np.ndarray], np.ndarray | float]] = {
    "mass_matrix": _mass_matrix,
    "bias": lambda model, t, q, v: require_numbers(model.bias(q.copy(), v.copy()), "bias", q.shape),
    "generalized_force": _generalized_force,
    CORNER_FORCE: _generalized_force,
    "acceleration": _acceleration,
    CHRISTOFFEL: _christoffel,
    "constraint_residual": _widest_gap,
}
WITHOUT_STATE: dict[str, Callable[[Model], np.ndarray | float | list[str]]] = {
    "mesh_modes": _mesh_modes,
    "contact_poles": _contact_poles,
    "largest_stable_step": _largest_stable_step,
    ABILITIES: lambda model: sorted(model.abilities),
    START_MASS: _start_mass,
    FORCE_SLOPES: _force_slopes,
}
