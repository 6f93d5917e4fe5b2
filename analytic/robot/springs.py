"""Gears of a robot: sizes and swings of elastic parts, and rotors that represent stages."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.derivation.gears import PlacedStage, displacement_rows, gather_gears
from crosscheck.analytic.derivation.stage import gear_masses
from crosscheck.analytic.paper.kinematics import stage_geometry
from crosscheck.analytic.paper.stiffness import peak_stiffness
from crosscheck.analytic.stability import runge_kutta_limit
from crosscheck.models.experiment.drive import PD, drive_data
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.robot.integration import conditioning_error, require_regular
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import MESH_LAWS, JointStage, Level, Robot, Rotor
from crosscheck.models.robot.start import start_state

QUARTER = np.pi / 2


@dataclass(frozen=True)
class ToothSpring:
    """Teeth of a rotor's mesh, or of planets that move as one with sun or ring, as one spring on x.

    row (n,): x by the robot's coordinates at the level geared; lever [m], or 1 of a joint that
    slides: x by the joint's coordinate while all other gears roll, so the joint's torque T presses
    teeth by T / lever, with the ratio's sign; stiffness [N/m]: on average; stiffest [N/m]; error
    [m]: bound of the teeth's; radius [m] of the smaller gear; mass [kg]: J / r^2 of the lighter
    one, which swings on it.
    """

    name: str
    joint: int
    row: np.ndarray
    lever: float
    stiffness: float
    stiffest: float
    damping: float
    backlash: float
    error: float
    radius: float
    mass: float


def tooth_springs(robot: Robot) -> tuple[ToothSpring, ...]:
    """The tooth springs of a robot: of rotors, then planet by planet, each sun before ring."""
    springs, free = [], len(robot.coordinates)
    rows = np.eye(free + robot.mesh_coordinates)
    for place, (rotor, mesh) in enumerate(robot.meshes, free):
        radius, k = mesh.pinion_base_radius_m, mesh.stiffness_N_per_m
        name = f"mesh of {robot.joints[rotor.joint].name}"
        constants = k, k, mesh.damping_N_s_per_m, mesh.backlash_m, 0.0
        swinging = radius, rotor.inertia / radius**2
        place_and_lever = rows[place], rotor.ratio * radius
        springs.append(ToothSpring(name, rotor.joint, *place_and_lever, *constants, *swinging))
    for stage, columns in zip(robot.stages, robot.stage_columns, strict=True):
        springs += _planet_springs(robot, stage, columns.start)
    return tuple(springs)


def _planet_springs(robot: Robot, stage: JointStage, first: int) -> Iterator[ToothSpring]:
    """Sun and ring mesh of planets that move as one; first: place of the stage's coordinates."""
    placed = PlacedStage(stage.gears, 0, first, stage.has_free_planets)
    gears = gather_gears([placed], [0], MESH_LAWS)
    geometry, (sun_mass, planet_mass) = stage_geometry(stage.gears), gear_masses(stage.gears)
    rows = displacement_rows(gears, len(robot.coordinates) + robot.mesh_coordinates)
    peaks = peak_stiffness(gears.law, gears.k_m, gears.k_a)
    for mesh, planets in enumerate(gears.planets):
        planet, side = divmod(mesh, 2)
        whose = f"planet {planet + 1} of " if stage.has_free_planets else ""
        masses = min(sun_mass, planets * planet_mass), planets * planet_mass
        yield ToothSpring(
            f"{('sun', 'ring')[side]} mesh of {whose}{robot.joints[stage.joint].name}",
            stage.joint,
            rows[mesh],
            geometry.n * geometry.r_s,
            planets * gears.k_m[mesh],
            planets * peaks[mesh],
            gears.d[mesh],
            gears.b[mesh],
            abs(gears.static_error[mesh]) + gears.E[mesh],
            min(geometry.r_s, geometry.r_p),
            masses[side],
        )


def drive_matrix(robot: Robot, level: Level) -> np.ndarray:
    """Generalized forces (free, n) of each motor's torque: a rotor or a sun has it over its ratio.

    So x of a rotor's mesh has it over its lever; a sun presses x_sp + x_pr of any of its planets.
    """
    free = robot.coordinates
    if level != "geared":
        return np.eye(len(free))
    drive = np.eye(len(free), len(free) + robot.mesh_coordinates)
    springs = tooth_springs(robot)
    for place in range(len(free), drive.shape[1]):
        spring = next(each for each in springs if each.row[place])
        if spring.joint in free and spring.row[place] > 0:
            drive[free.index(spring.joint), place] = 1 / spring.lever
    return drive


def largest_stable_step(model: RobotModel, scenario: Scenario) -> float:
    """The step [s] up to which classical Runge-Kutta is stable on meshes, friction and controller.

    By the motion linearised at rest, all teeth in contact at peak stiffness, at the start and in
    four poses, to which joints that no motor drives turn only within their ranges.
    """
    robot, free = model.robot, len(model.robot.coordinates)
    start, _ = start_state(robot, model.level, scenario)
    poses = np.tile(start, (5, 1))
    poses[1:, :free] = QUARTER * np.arange(4)[:, None]
    for place in robot.passive:
        limits = robot.joints[robot.coordinates[place]].limits
        poses[1:, place] = np.clip(poses[1:, place], limits.lower, limits.upper)
    still, none = np.zeros_like(poses), np.zeros((5, free))
    inverse = np.linalg.inv(model.mass_matrix(poses))
    begun = model.forward_dynamics(poses, still, none)
    moved = [model.forward_dynamics(poses, still, none + unit) for unit in np.eye(free)]
    driven = np.stack(moved, axis=2) - begun[:, :, None]
    drive = drive_data(scenario, free, robot.motors)
    gains = drive.gains if drive.code == PD else np.zeros((free, 3))
    stiffness, damping = np.zeros((2, start.size, start.size))
    damping[:free, :free] = np.diag(robot.friction)
    for spring in tooth_springs(robot) if start.size > free else ():
        stiffness += spring.stiffest * np.outer(spring.row, spring.row)
        damping += spring.damping * np.outer(spring.row, spring.row)
    steps = []
    for per_force, per_torque in zip(inverse, driven, strict=True):
        position, rate = -per_force @ stiffness, -per_force @ damping
        position[:, :free] -= per_torque * gains[:, 1]
        rate[:, :free] -= per_torque * gains[:, 2]
        size = len(position)
        matrix = np.block([[np.zeros((size, size)), np.eye(size)], [position, rate]])
        steps.append(runge_kutta_limit(np.linalg.eigvals(matrix)))
    return min(steps)


class MeshRates(NamedTuple):
    """Rates of swings on springs [rad/s] (states, springs), as if other joints' meshes were apart.

    A stage's stand from the fastest on; of free planets some are 0. fastest: of all swings and
    of their dying out [1/s] while all are in contact.
    """

    swings: np.ndarray
    fastest: float


def mesh_rates(robot: Robot, mass_matrices: np.ndarray) -> MeshRates:
    """Rates of the swings on a robot's meshes; mass_matrices: M at each state, (states, n, n).

    Raises InputError for a robot whose mass matrix cannot be inverted.
    """
    with require_regular(robot):
        inverse = np.linalg.inv(mass_matrices)
    rows = np.array([spring.row for spring in tooth_springs(robot)])
    inverse = rows @ inverse @ rows.T  # by a force on each spring, how the springs accelerate
    if not (inverse.diagonal(axis1=1, axis2=2) > 0).all():
        raise conditioning_error(robot)
    joints, stiffness, stiffest, damping = np.transpose(
        [(mesh.joint, mesh.stiffness, mesh.stiffest, mesh.damping) for mesh in tooth_springs(robot)]
    )

    def modes(indices: np.ndarray, sizes: np.ndarray) -> np.ndarray:
        """Eigenvalues (states, own), the smallest first, of springs, or dampers, at places."""
        root = np.sqrt(sizes[indices])
        block = inverse[:, indices[:, None], indices] * np.outer(root, root)
        return np.maximum(np.linalg.eigvalsh(block), 0.0)

    swings, every = np.zeros((len(inverse), joints.size)), np.arange(joints.size)
    for joint in joints:
        mesh = np.flatnonzero(joints == joint)
        swings[:, mesh] = np.sqrt(modes(mesh, stiffness))[:, ::-1]
    fastest = max(np.sqrt(modes(every, stiffest).max()), modes(every, damping).max())
    return MeshRates(swings, float(fastest))


def friction_rate(robot: Robot, mass_matrices: np.ndarray) -> float:
    """The fastest rate [1/s] at which friction alone slows a robot's joints.

    mass_matrices: M at each state, (states, n, n). Raises InputError for one that is singular.
    """
    root, free = np.sqrt(robot.friction), len(robot.coordinates)
    if not root.any():
        return 0.0
    with require_regular(robot):
        inverse = np.linalg.inv(mass_matrices)[:, :free, :free]
    return float(np.linalg.eigvalsh(inverse * np.outer(root, root)).max())


def replace_stages_by_rotors(robot: Robot) -> Robot:
    """The robot, each stage as two rotors on the link of its ring, which rigid gears amount to."""
    rotors = [rotor for stage in robot.stages for rotor in stage_rotors(robot, stage)]
    return replace(robot, rotors=(*robot.rotors, *rotors), stages=())


def stage_rotors(robot: Robot, stage: JointStage) -> tuple[Rotor, Rotor]:
    """The two rotors that represent a stage: the sun, and the planets together."""
    gears, joint = stage.gears, robot.joints[stage.joint]
    geometry, (sun_mass, planet_mass) = stage_geometry(gears), gear_masses(gears)
    stator, frame = next(entry for entry in robot.frames.items() if entry[1].body == joint.parent)
    axis = frame.placement.rotation.T @ joint.placement.rotation @ joint.axis
    inertia = gears.planet_count * planet_mass * geometry.r_p**2
    return (
        Rotor(stage.joint, geometry.n, sun_mass * geometry.r_s**2, stator, axis),
        Rotor(stage.joint, -geometry.r_cp / geometry.r_p, inertia, stator, axis),
    )
