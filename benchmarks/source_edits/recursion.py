"""A serial robot by Newton and Euler, all vectors in the base's frame."""

import numpy as np


def skew(u):
    """The matrix of u x."""
    return np.array([[0.0, -u[2], u[1]], [u[2], 0.0, -u[0]], [-u[1], u[0], 0.0]])


def exp_map(u, phi):
    """The rotation about a unit vector."""
    S = skew(u)
    return np.eye(3) + np.sin(phi) * S + (1.0 - np.cos(phi)) * S @ S


class Chain:
    """Equations of a robot of turning joints in a row."""

    def __init__(self, robot):
        self.robot = robot
        self.size = len(robot.joints)

    def poses(self, q):
        """Rotation, origin and axis of each link."""
        Rot, org = np.eye(3), np.zeros(3)
        listed = []
        for joint, angle in zip(self.robot.joints, q, strict=True):
            org = org + Rot @ joint.placement.position
            Rot = Rot @ joint.placement.rotation
            axis = Rot @ joint.axis
            Rot = Rot @ exp_map(joint.axis, angle)
            listed.append((Rot, org, axis))
        return listed

    def inverse_dynamics(self, q, v, a):
        """Torques of the joints."""
        poses = self.poses(q)
        omega, alpha, linear = np.zeros(3), np.zeros(3), -self.robot.gravity
        previous = np.zeros(3)
        wrenches = []
        for k, (Rot, org, axis) in enumerate(poses):
            arm = org - previous
            linear = linear + np.cross(alpha, arm) + np.cross(omega, np.cross(omega, arm))
            alpha = alpha + axis * a[k] + np.cross(omega, axis * v[k])
            omega = omega + axis * v[k]
            body = self.robot.bodies[k]
            lever = Rot @ body.com
            at_com = linear + np.cross(alpha, lever) + np.cross(omega, np.cross(omega, lever))
            inertia = Rot @ body.inertia @ Rot.T
            push = body.mass * at_com
            twist = inertia @ alpha + np.cross(omega, inertia @ omega)
            wrenches.append((push, twist + np.cross(org + lever, push)))
            previous = org
        torques = np.zeros(self.size)
        total_push, total_twist = np.zeros(3), np.zeros(3)
        for k in range(self.size - 1, -1, -1):
            push, twist = wrenches[k]
            total_push = total_push + push
            total_twist = total_twist + twist
            Rot, org, axis = poses[k]
            torques[k] = axis @ (total_twist - np.cross(org, total_push))
        return torques
