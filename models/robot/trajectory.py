"""A robot's run as the Dataset of an arm's: over time, joint and, for stages, planet."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from crosscheck.models.experiment.drive import drive_data, torques_along
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import MESH_LAWS
from crosscheck.models.signal_map import map_robot
from crosscheck.models.trajectory import build_trajectory, recorded_times

if TYPE_CHECKING:
    import xarray as xr


def build_robot_trajectory(
    model: RobotModel, scenario: Scenario, q: np.ndarray, v: np.ndarray
) -> xr.Dataset:
    """The Dataset of a run with coordinates and rates q, v (records, n).

    Joints are all that move, in the robot's order; one that follows another has no torque of its
    own. What its own gears have is NaN where a joint has none. Values that are no state come from
    the model: accelerations, elastic forces, which are what holds the meshes at rest, and energy.
    """
    robot, time = model.robot, recorded_times(scenario)
    free, still = len(robot.coordinates), np.zeros_like(q)
    drive = drive_data(scenario, free, robot.motors)
    torques = torques_along(drive, time, q[:, :free], v[:, :free])
    a, forces = model.forward_dynamics(q, v, torques), list[np.ndarray]()
    if model.level == "geared" and robot.meshes:
        held = model.inverse_dynamics(q, still, still) - model.gravity(q)
        forces.append(held[:, free : free + len(robot.meshes)])
    if model.level == "geared" and robot.stages:
        forces.append(model.stage_forces(q))
    elastic = np.hstack(forces) if forces else None
    variables = map_robot(robot, model.level).record_run(drive, time, (q, v, a), elastic)
    variables["kinetic_energy"] = model.energy(q, v) - model.energy(q, still)
    name = f"{model.name}:{model.level}"
    return build_trajectory(name, robot, scenario, MESH_LAWS, time, **variables)
