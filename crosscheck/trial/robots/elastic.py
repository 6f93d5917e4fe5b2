"""A robot with elastic joints: coordinates of links and motors, springs between them.

M. W. Spong, Modeling and control of elastic joint robots, J. Dyn. Sys. Meas. Control 109, 1987: a
rotor's energy is that of its own spin, so that M is that of the links beside N^2 J of each motor.
A motor's angle is stated on the output side, as its joint's.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.models.robot.robot import BASE, Joint, LinkFrame, Placement, Robot, RobotBody
from crosscheck.trial.input.equations import Equations

ELASTIC = "elastic"  # the level that equations state
MOTOR = "motor_"  # how the coordinates of motors begin
POINT_KG = 1e-3  # mass of a motor's link, on its axis: it changes nothing


def build_elastic_robot(robot: Robot, where: str) -> tuple[Robot, np.ndarray]:
    """The robot with a joint for each elastic joint's motor, and the springs K (n, n) [N m/rad].

    Each motor turns on the base and has its joint's rotor, so that engines need no teeth. Raises
    InputError for a robot without springs, or with ones that give way otherwise.
    """
    motors = [rotor for rotor in robot.rotors if rotor.mesh is not None]
    if not motors or robot.stages or any(joint.mimic for joint in robot.joints):
        reason = "is of robots with a mesh at a rotor, without mimics and planetary stages"
        raise InputError(where, "level", ELASTIC, reason)
    still, origin = Placement(np.eye(3), np.zeros(3)), np.zeros(3)
    root = next(name for name, frame in robot.frames.items() if frame.body == BASE)
    joints, bodies, frames = list(robot.joints), list(robot.bodies), dict(robot.frames)
    rotors, urdf = list(robot.rotors), ""
    stiffness = np.zeros((len(joints) + len(motors),) * 2)
    for rotor in motors:
        mesh, driven, number = rotor.mesh, robot.joints[rotor.joint], len(joints)
        assert mesh is not None  # as was chosen
        if mesh.backlash_m or mesh.damping_N_s_per_m:
            reason = f"needs springs alone; the mesh of {driven.name} has backlash or damping"
            raise InputError(where, "level", ELASTIC, reason)
        name, axis = f"{MOTOR}{driven.name}", np.array([0.0, 0.0, 1.0])
        joints.append(Joint(name, driven.kind, BASE, still, axis, driven.limits, None))
        bodies.append(RobotBody(POINT_KG, origin, np.zeros((3, 3))))
        frames[name] = LinkFrame(number, still)
        turned_rotor = replace(rotor, joint=number, stator=root, axis=axis, mesh=None)
        rotors[rotors.index(rotor)] = turned_rotor
        urdf += (
            f'<link name="{name}"><inertial><mass value="{POINT_KG}"/><inertia ixx="0" ixy="0"'
            f' ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link><joint name="{name}"'
            f' type="{driven.kind}"><parent link="{root}"/><child link="{name}"/>'
            '<axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>'
        )
        ends = np.zeros(len(stiffness))
        ends[[rotor.joint, number]] = 1.0, -1.0
        torque = mesh.stiffness_N_per_m * (mesh.pinion_base_radius_m * rotor.ratio) ** 2
        stiffness += torque * np.outer(ends, ends)
    changed = replace(
        robot,
        urdf=robot.urdf.replace("</robot>", f"{urdf}</robot>"),
        joints=tuple(joints),
        bodies=tuple(bodies),
        rotors=tuple(rotors),
        frames=frames,
    )
    return changed, stiffness


def drive_motors(equations: Equations, robot: Robot) -> Equations:
    """The equations at the level that a robot with motors has, its motors driven."""
    names = robot.coordinate_names
    driven = [number + 1 for number, name in enumerate(names) if name.startswith(MOTOR)]
    drive = driven if equations.drive is None else equations.drive
    return replace(equations, level="armature", drive=drive)
