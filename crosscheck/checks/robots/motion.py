"""How a model moves: its energies, and its inverse and forward dynamics beside M and bias."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from crosscheck.checks.robots.case import (
    TURN_RAD,
    WEIGHTS,
    RobotLevel,
    SampledRobot,
    ask,
    check_share,
    plan_law,
    share_of,
)
from crosscheck.checks.robots.engines import (
    bias,
    energy,
    gravity,
    inverse_dynamics,
    mass_matrix,
)
from crosscheck.checks.robots.sizes import TOLERANCE
from crosscheck.checks.robots.weight import ROUNDED
from crosscheck.findings import Finding, Subject
from crosscheck.models.robot.interface import RobotModel
from crosscheck.planning.comparison import Comparison

LONGEST_S = 0.01  # of half a step along a motion


def rest_energy(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Energy of the weights alone (states,)."""
    q = case.states.q
    return ask(model, "energy", (len(q),), q, 0 * q)


def energy_rate(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """How fast the energy grows (states,) [W] as the states move on with their accelerations."""
    q, v, a, _ = case.states
    step, rate = _time_steps(case)[:, None], np.zeros(len(q))
    for far, weight in enumerate(WEIGHTS, start=1):
        for sign in (1, -1):
            t = sign * far * step
            moved = q + t * v + t**2 * a / 2, v + t * a
            rate += sign * weight * ask(model, "energy", (len(q),), *moved)
    return rate / step[:, 0]


def driven_forces(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """What inverse dynamics says of the accelerations that forward dynamics gives (states, n)."""
    q, v, _, torques = case.states
    a = ask(model, "forward_dynamics", q.shape, q, v, torques)
    return ask(model, "inverse_dynamics", q.shape, q, v, a)


def plan(models: Sequence[SampledRobot]) -> Iterator[Comparison | str]:
    """Comparisons of each model's energies and dynamics with its own M, bias and weights."""
    terms = mass_matrix, bias, gravity
    for sampled in models:
        questions = mass_matrix, energy, rest_energy
        yield plan_law(sampled, "kinetic-energy", questions, _check_kinetic_energy)
        yield plan_law(sampled, "energy-rate", (energy_rate, *terms), _check_energy_rate)
        yield plan_law(sampled, "inverse-dynamics", (inverse_dynamics, *terms), _check_inverse)
        yield plan_law(sampled, "forward-dynamics", [driven_forces], _check_forward)
    robot = models[0].case.robot
    if robot.stages:
        yield (
            "geared: forces of a stage's teeth, on its joint too, are compared between engines, and"
            " not with first principles"
        )


def _time_steps(case: RobotLevel) -> np.ndarray:
    """Steps (states,) [s] in which all joints together turn by no more than TURN_RAD."""
    turning = np.abs(case.states.v) @ case.turns
    return np.minimum(TURN_RAD / np.maximum(turning, 1e-300), LONGEST_S)


def _check_kinetic_energy(
    about: Subject, mass: np.ndarray, total: np.ndarray, rest: np.ndarray, case: RobotLevel
) -> Finding:
    v = case.states.v
    kinetic = np.einsum("si,sij,sj->s", v, mass, v) / 2
    basis = f"{TOLERANCE:g} of the kinetic energy, and of the weight at the farthest mass"
    return check_share(about, share_of(total - rest - kinetic, case.sizes.energy), TOLERANCE, basis)


def _check_energy_rate(
    about: Subject,
    rate: np.ndarray,
    mass: np.ndarray,
    bias_torques: np.ndarray,
    weights: np.ndarray,
    case: RobotLevel,
) -> Finding:
    """The energy grows by the power of all generalized forces, v . (M a + bias + gravity)."""
    _, v, a, _ = case.states
    force = np.einsum("sij,sj->si", mass, a) + bias_torques + weights
    summed = (
        np.einsum("sij,sj->si", np.abs(mass), np.abs(a)) + np.abs(bias_torques) + np.abs(weights)
    )
    size = (np.abs(v) * summed).sum(axis=1) + case.sizes.motion * case.sizes.momentum[:, 0]
    least = ROUNDED * case.sizes.energy / _time_steps(case) / TOLERANCE
    measured = share_of(rate - (force * v).sum(axis=1), np.maximum(size, least))
    basis = f"{TOLERANCE:g} of the powers that are summed, or what rounding leaves in the rate"
    return check_share(about, measured, TOLERANCE, basis)


def _check_inverse(
    about: Subject,
    given: np.ndarray,
    mass: np.ndarray,
    bias_torques: np.ndarray,
    weights: np.ndarray,
    case: RobotLevel,
) -> Finding:
    """Inverse dynamics is M a + bias + gravity, and what holds the springs of rotors' meshes."""
    q, v, a, _ = case.states
    rest = given - np.einsum("sij,sj->si", mass, a) - bias_torques - weights
    rows = np.ones(q.shape[1], dtype=bool)
    if case.level == "geared":
        for row, (_, mesh) in enumerate(case.robot.meshes, start=case.free):
            x, play = q[:, row], mesh.backlash_m
            held = mesh.stiffness_N_per_m * (x - np.clip(x, -play, play))
            held += np.where(np.abs(x) > play, mesh.damping_N_s_per_m * v[:, row], 0.0)
            rest[:, row] -= held
        rows[case.free + len(case.robot.meshes) :] = False
        rows[[case.leader(stage.joint) for stage in case.robot.stages]] = False
    size = case.sizes.inverse_dynamics[:, rows]
    basis = f"{TOLERANCE:g} of the torque's natural size; springs of meshes as the file has them"
    return check_share(about, share_of(rest[:, rows], size), TOLERANCE, basis)


def _check_forward(about: Subject, forces: np.ndarray, case: RobotLevel) -> Finding:
    """Accelerations under the motors' torques need these torques, at their joints and meshes."""
    residual = forces - case.states.torques @ case.drive
    quantity = "forward_dynamics"
    measured = share_of(residual, case.sizes.balance)
    return check_share(about, measured, case.sizes.tolerance(quantity), case.sizes.basis(quantity))
