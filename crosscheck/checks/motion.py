"""How a model moves: its energies, and its inverse and forward dynamics beside M and bias."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from crosscheck.checks.answers import ask, bias, energy, gravity, inverse_dynamics, mass_matrix
from crosscheck.checks.energy import ALONG_RAD
from crosscheck.checks.first_principles.mesh_energy import (
    POINTS,
    energy_slope,
    highest_harmonic,
    planet_springs,
)
from crosscheck.checks.first_principles.slopes import SMOOTH_WEIGHTS, compute_slopes
from crosscheck.checks.robot_states import TOLERANCE
from crosscheck.checks.sampled import TURN_RAD, RobotLevel, Subjects
from crosscheck.checks.scales import EPS, check_share, mesh_damping, share_of
from crosscheck.findings import Finding, Subject
from crosscheck.models.arm.layout import MESHES
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import JointStage
from crosscheck.planning.comparison import Comparison

ROUNDED = 100 * EPS  # rounding error of an energy, which sums masses at their heights
LONGEST_S = 0.01  # longest half step along a motion [s]


def rest_energy(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Energy of the weights alone (states,)."""
    q = case.states.q
    return ask(model, "energy", (len(q),), q, 0 * q)


def energy_slopes(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Slopes of the energy at rest (first states, n)."""

    def energies(q: np.ndarray) -> np.ndarray:
        return ask(model, "energy", (len(q),), q, 0 * q)

    return compute_slopes(energies, case.first.q, case.slope_rule).T


def energy_rate(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """How fast the energy grows (states,) [W] as the states move on with their accelerations."""
    q, v, a, _ = case.states
    step, rate = _time_steps(case)[:, None], np.zeros(len(q))
    for far, weight in enumerate(SMOOTH_WEIGHTS, start=1):
        for sign in (1, -1):
            t = sign * far * step
            moved = q + t * v + t**2 * a / 2, v + t * a
            rate += sign * weight * ask(model, "energy", (len(q),), *moved)
    return rate / step[:, 0]


def driven_forces(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Torques by inverse dynamics for the accelerations of forward dynamics (states, n)."""
    q, v, _, torques = case.states
    a = ask(model, "forward_dynamics", q.shape, q, v, torques)
    return ask(model, "inverse_dynamics", q.shape, q, v, a)


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Comparisons of each model's energies and dynamics with its own M, bias and weights."""
    terms = mass_matrix, bias, gravity
    for sampled in subjects.robots:
        if sampled.setting.robot.gravity.any():
            heights = gravity, energy_slopes
            yield sampled.plan_law("gravity-from-energy", heights, _check_slopes)
        questions = mass_matrix, energy, rest_energy
        yield sampled.plan_law("kinetic-energy", questions, _check_kinetic_energy)
        yield sampled.plan_law("energy-rate", (energy_rate, *terms), _check_energy_rate)
        yield sampled.plan_law("inverse-dynamics", (inverse_dynamics, *terms), _check_inverse)
        yield sampled.plan_law("forward-dynamics", [driven_forces], _check_forward)


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


def _check_slopes(
    about: Subject, given: np.ndarray, slopes: np.ndarray, case: RobotLevel
) -> Finding:
    sizes, count = case.sizes, len(slopes)
    height = (sizes.energy - sizes.motion**2 / 2)[:count, None]
    least = ROUNDED * height / case.steps / TOLERANCE
    size = np.maximum(sizes.gravity[:count], least)
    basis = f"{TOLERANCE:g} of the torque's natural size, or the rounding of the slopes"
    return check_share(about, share_of(given[:count] - slopes, size), TOLERANCE, basis)


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
    summed = np.einsum("sij,sj->si", np.abs(mass), np.abs(a)) + np.abs(bias_torques)
    summed = summed + np.abs(weights)
    size = (np.abs(v) * summed).sum(axis=1) + case.sizes.motion * case.sizes.momentum[:, 0]
    least = ROUNDED * case.sizes.energy / _time_steps(case) / TOLERANCE
    measured = share_of(rate - (force * v).sum(axis=1), np.maximum(size, least))
    basis = f"{TOLERANCE:g} of the powers that are summed, or the rounding of the rate"
    return check_share(about, measured, TOLERANCE, basis)


def _check_inverse(
    about: Subject,
    given: np.ndarray,
    mass: np.ndarray,
    bias_torques: np.ndarray,
    weights: np.ndarray,
    case: RobotLevel,
) -> Finding:
    """Inverse dynamics is M a + bias + gravity, and what holds meshes' springs, and friction."""
    rest = given - np.einsum("sij,sj->si", mass, case.states.a) - bias_torques - weights
    rest -= held_friction(case)
    if case.level == "geared":
        rest -= held_teeth(case)
    basis = f"{TOLERANCE:g} of the torque's natural size; springs, friction as the file has them"
    return check_share(about, share_of(rest, case.sizes.inverse_dynamics), TOLERANCE, basis)


def held_friction(case: RobotLevel) -> np.ndarray:
    """Friction torque that the motors overcome at the states (states, n), joint by joint."""
    robot, held = case.robot, np.zeros_like(case.states.v)
    for number, joint in enumerate(robot.joints):
        per_rate = 1.0 if joint.mimic is None else joint.mimic.multiplier
        leader = case.leader(number)
        held[:, leader] += per_rate * joint.friction * (per_rate * case.states.v[:, leader])
    return held


def held_teeth(case: RobotLevel) -> np.ndarray:
    """Torques that hold springs and dampers of all meshes (states, n), by the file's data.

    A spring that stiffens with its joint's angle, or whose teeth's error grows, turns that joint.
    """
    robot, (q, v, *_), held = case.robot, case.states, np.zeros_like(case.states.q)
    for row, (_, mesh) in enumerate(robot.meshes, start=case.free):
        x, play = q[:, row], mesh.backlash_m
        held[:, row] = mesh.stiffness_N_per_m * (x - np.clip(x, -play, play))
        held[:, row] += np.where(np.abs(x) > play, mesh.damping_N_s_per_m * v[:, row], 0.0)
    factors, offsets = robot.joint_map
    angles = q[:, : case.free] @ factors.T + offsets
    for columns, stage in zip(robot.stage_columns, robot.stages, strict=True):
        gears, sides = stage.gears, (stage.gears.sun_mesh, stage.gears.ring_mesh)
        waves = [side.planet_mesh(n).stiffness for side in sides for n in stage.groups]
        step = ALONG_RAD / gears.ring_teeth / max(map(highest_harmonic, waves))
        way = angles[:, stage.joint] + step * POINTS[:, None]
        for planet in range(gears.planet_count):
            x_sp, x_pr = rows = _displacement_rows(stage, planet)
            displacements = q[:, columns] @ x_sp, q[:, columns] @ x_pr
            springs = planet_springs(gears, planet, way, displacements)
            for along, name, spring in zip(rows, MESHES, springs, strict=True):
                reach = spring.gap[0] - np.clip(spring.gap[0], -spring.backlash, spring.backlash)
                damped = mesh_damping(gears, name, planet) * (v[:, columns] @ along)
                force = spring.stiffness[0] * reach + np.where(reach, damped, 0.0)
                held[:, columns] += force[:, None] * along
                slope = energy_slope(spring, step)
                held[:, : case.free] += slope[:, None] * factors[stage.joint]
    return held


def _displacement_rows(stage: JointStage, planet: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows of x_sp and x_pr of a planet by its stage's coordinates, with the sun's advance x_s."""
    if not stage.has_free_planets:
        return np.array([1.0, 0.0]), np.array([0.0, 1.0])
    coordinates = np.eye(1 + stage.gears.planet_count)
    return coordinates[0] - coordinates[1 + planet], coordinates[1 + planet]


def _check_forward(about: Subject, forces: np.ndarray, case: RobotLevel) -> Finding:
    """Accelerations under the motors' torques need these torques, at their joints and meshes."""
    residual = forces - case.states.torques @ case.drive
    quantity = "forward_dynamics"
    measured = share_of(residual, case.sizes.balance)
    return check_share(about, measured, case.sizes.tolerance(quantity), case.sizes.basis(quantity))
