"""Runs of robots by the traced kernel, and the step that Runge-Kutta can take on one."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.analytic.kernel.batch import Batch, Records
from crosscheck.analytic.kernel.event_kernel import integrate_with_events
from crosscheck.analytic.paper.stiffness import peak_stiffness
from crosscheck.analytic.robot.equations import RobotEquations
from crosscheck.analytic.stability import runge_kutta_limit
from crosscheck.models.experiment.drive import PD, drive_data
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.interface import require_finite
from crosscheck.models.robot.robot import Level, Robot
from crosscheck.models.robot.start import start_state
from crosscheck.models.trajectory import recorded_times

if TYPE_CHECKING:
    from crosscheck.models.robot.interface import RobotModel

QUARTER = np.pi / 2


class RobotMember:
    """A robot at a level in an experiment, as a batch takes it."""

    def __init__(self, robot: Robot, level: Level, scenario: Scenario) -> None:
        self.robot, self.level, self.scenario = robot, level, scenario
        self.drive = drive_data(scenario, len(robot.coordinates))
        self.equations = RobotEquations(robot, level, self.drive)

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates at the start."""
        return start_state(self.robot, self.level, self.scenario)

    @cached_property
    def edges(self) -> np.ndarray:
        """Half clearances (meshes,) [m], in the order of the kernel's meshes."""
        rotors = [mesh.backlash_m for _, mesh in self.robot.meshes]
        count = self.equations.structure.rotor_meshes
        return np.concatenate([rotors[:count], self.equations.gears.b])


def run_robot(model: RobotModel, scenario: Scenario) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and rates (records, n) by fixed steps. Raises Diverged."""
    batch = Batch([RobotMember(model.robot, model.level, scenario)], lanes=1)
    parts = list(batch.run(scenario.steps // scenario.stride, scenario.stride, 2**14))
    return _finite(model, scenario, Records(*map(np.concatenate, zip(*parts, strict=True))))


def run_precisely(
    model: RobotModel, scenario: Scenario, rtol: float
) -> tuple[np.ndarray, np.ndarray]:
    """The same by adaptive steps that end where contacts change. Raises Diverged."""
    member = RobotMember(model.robot, model.level, scenario)
    records = integrate_with_events(member, rtol).records
    return _finite(model, scenario, records)


def _finite(
    model: RobotModel, scenario: Scenario, records: Records
) -> tuple[np.ndarray, np.ndarray]:
    time = recorded_times(scenario)
    q, v = (each.reshape(len(time), -1) for each in records[:2])
    require_finite(f"{model.name}:{model.level}", time, q, v)
    return q, v


def largest_stable_step(model: RobotModel, scenario: Scenario) -> float:
    """The step [s] up to which classical Runge-Kutta is stable on meshes and controller.

    By the motion linearised at rest, all teeth in contact at peak stiffness, at the start and in
    four poses.
    """
    member, free = RobotMember(model.robot, model.level, scenario), len(model.robot.coordinates)
    start, _ = member.start()
    poses = np.tile(start, (5, 1))
    poses[1:, :free] = QUARTER * np.arange(4)[:, None]
    still, none = np.zeros_like(poses), np.zeros((5, free))
    inverse = np.linalg.inv(model.mass_matrix(poses))
    begun = model.forward_dynamics(poses, still, none)
    moved = [model.forward_dynamics(poses, still, none + unit) for unit in np.eye(free)]
    driven = np.stack(moved, axis=2) - begun[:, :, None]
    gains = member.drive.gains if member.drive.code == PD else np.zeros((free, 3))
    stiffness, damping = _peaks(member)
    limits = []
    for per_force, per_torque in zip(inverse, driven, strict=True):
        position, rate = -per_force * stiffness, -per_force * damping
        position[:, :free] -= per_torque * gains[:, 1]
        rate[:, :free] -= per_torque * gains[:, 2]
        size = len(position)
        matrix = np.block([[np.zeros((size, size)), np.eye(size)], [position, rate]])
        limits.append(runge_kutta_limit(np.linalg.eigvals(matrix)))
    return min(limits)


def _peaks(member: RobotMember) -> tuple[np.ndarray, np.ndarray]:
    """Peak stiffness and damping (n,) of the meshes on their displacements; 0 of joints."""
    robot, gears = member.robot, member.equations.gears
    free, count = len(robot.coordinates), member.equations.structure.rotor_meshes
    stiffness, damping = np.zeros((2, len(member.equations.structure.coordinates)))
    for place, (_, mesh) in enumerate(robot.meshes[:count], free):
        stiffness[place], damping[place] = mesh.stiffness_N_per_m, mesh.damping_N_s_per_m
    stiffness[gears.x_index] = gears.planets * peak_stiffness(gears.law, gears.k_m, gears.k_a)
    damping[gears.x_index] = gears.d
    return stiffness, damping
