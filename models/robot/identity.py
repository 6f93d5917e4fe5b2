"""Links with which a rotor that turns as a body equals its reflected inertia."""

from __future__ import annotations

import numpy as np

from crosscheck.models.robot.robot import Robot

PARALLEL = 1e-4  # sine of an angle that is but the rounding of printed ones, such as 1.5708


def find_identity_joints(robot: Robot) -> list[str]:
    """Names of joints at which coupled is armature with other inertias of the two links.

    J (w + N q')^2 = J (1 - N) w^2 + J N (w + q')^2 + J N (N - 1) q'^2, w the rate of the link
    before about the joint's axis: the stator must be on that link, the rotor's axis along this one.
    """
    names = []
    for rotor in robot.rotors:
        joint, stator = robot.joints[rotor.joint], robot.frames[rotor.stator]
        before = stator.placement.rotation @ rotor.axis
        along = joint.placement.rotation @ joint.axis
        if (
            joint.kind == "revolute"
            and stator.body == joint.parent
            and np.linalg.norm(np.cross(before, along)) < PARALLEL
        ):
            names.append(joint.name)
    return list(dict.fromkeys(names))
