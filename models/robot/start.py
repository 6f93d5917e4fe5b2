"""State of a robot at the start of a scenario."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from crosscheck.models.experiment.scenario import Scenario, expand_to_joints

if TYPE_CHECKING:
    from crosscheck.models.robot.interface import RobotModel


def start_state(model: RobotModel, scenario: Scenario) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and rates (n,) at the start of a scenario, in the order of RobotModel.

    Displacements are at first contact, x = b and the static error, or 0; the scenario's offsets
    are those of planetary stages. A stage of a joint that follows another has that one's.
    """
    robot, start = model.robot, scenario.start
    free, joints = robot.coordinates, len(robot.coordinates)
    q = list(expand_to_joints(start.theta_rad, joints))
    touches = float(start.mesh == "contact")
    offsets = start.sun_planet_offset_m, start.planet_ring_offset_m
    sun, ring = (expand_to_joints(each, joints) for each in offsets)
    if model.level == "geared":
        q += [touches * mesh.backlash_m for _, mesh in robot.meshes]
        for stage in robot.stages:
            mimic = robot.joints[stage.joint].mimic
            place = free.index(stage.joint if mimic is None else mimic.joint)
            for mesh, offset in ((stage.gears.sun_mesh, sun), (stage.gears.ring_mesh, ring)):
                teeth = mesh.planet_mesh(0)
                q.append(touches * (teeth.static_error_m + teeth.backlash_m) + offset[place])
    v = np.zeros(len(q))
    v[:joints] = expand_to_joints(start.theta_dot_rad_per_s, joints)
    return np.array(q, dtype=float), v
