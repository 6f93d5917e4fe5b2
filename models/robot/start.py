"""State of a robot at the start of a scenario."""

from __future__ import annotations

import numpy as np

from crosscheck.models.experiment.scenario import Scenario, expand_to_joints, planet_offsets
from crosscheck.models.robot.robot import Level, Robot


def start_state(robot: Robot, level: Level, scenario: Scenario) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and rates (n,) at the start of a scenario, in the order of RobotModel.

    Displacements are at first contact, x = b and the static error, or 0, with the scenario's
    offsets: that of the sun's mesh is a rotor's too. Of free planets every ring mesh touches, and
    the sun is advanced until the first of its meshes does. Gears of a joint that follows another
    have that one's.
    """
    start = scenario.start
    free, joints = robot.coordinates, len(robot.coordinates)
    q = list(expand_to_joints(start.theta_rad, joints))
    touches = float(start.mesh == "contact")
    offsets = start.sun_planet_offset_m, start.planet_ring_offset_m
    sun, ring = (expand_to_joints(each, joints) for each in offsets)

    def place_of(joint: int) -> int:
        mimic = robot.joints[joint].mimic
        return free.index(joint if mimic is None else mimic.joint)

    if level == "geared":
        for rotor, rotor_mesh in robot.meshes:
            q.append(touches * rotor_mesh.backlash_m + sun[place_of(rotor.joint)])
        for stage in robot.stages:
            place, gears = place_of(stage.joint), stage.gears
            x_sp, x_pr = (
                [
                    touches * (teeth.static_error_m + teeth.backlash_m) + offset[place]
                    for teeth in map(mesh.planet_mesh, stage.groups)
                ]
                for mesh, offset in ((gears.sun_mesh, sun), (gears.ring_mesh, ring))
            )
            if stage.has_free_planets:
                q.append(min(map(sum, zip(x_sp, x_pr, strict=True))))
                each = (0.0,) * len(x_pr)  # planets of a following joint have equal starts
                if stage.joint in free:
                    each = planet_offsets(start, place, len(x_pr))
                q += [x + offset for x, offset in zip(x_pr, each, strict=True)]
            else:
                q += [*x_sp, *x_pr]
    v = np.zeros(len(q))
    v[:joints] = expand_to_joints(start.theta_dot_rad_per_s, joints)
    return np.array(q, dtype=float), v
