"""A robot by Lagrange's equations of CasADi expressions."""

from types import SimpleNamespace

import casadi as ca
import numpy as np


def rodrigues(axis, angle):
    """Rotation about a numeric unit axis by a symbolic angle."""
    K = ca.skew(axis)
    return ca.SX.eye(3) + ca.sin(angle) * K + (1 - ca.cos(angle)) * ca.mtimes(K, K)


def lagrange(robot):
    """The parts as functions of numbers."""
    n = len(robot.joints)
    q, v = ca.SX.sym("q", n), ca.SX.sym("v", n)
    kinetic, potential = 0, 0
    R, p = ca.SX.eye(3), ca.SX.zeros(3)
    for k in range(n):
        joint, body = robot.joints[k], robot.bodies[k]
        p = p + R @ joint.placement.position
        R = R @ joint.placement.rotation @ rodrigues(joint.axis, q[k])
        com = p + R @ body.com
        speed = ca.jtimes(com, q, v)
        Rdot = ca.reshape(ca.jtimes(ca.vec(R), q, v), 3, 3)
        W = R.T @ Rdot
        spin = ca.vertcat(W[2, 1], W[0, 2], W[1, 0])
        kinetic = kinetic + body.mass * ca.dot(speed, speed) / 2
        kinetic = kinetic + spin.T @ body.inertia @ spin / 2
        potential = potential - body.mass * ca.dot(robot.gravity, com)
    M = ca.hessian(kinetic, v)[0]
    momentum = M @ v
    h = ca.jtimes(momentum, q, v) - ca.gradient(kinetic, q)
    G = ca.gradient(potential, q)
    inertia = ca.Function("M", [q], [M])
    coriolis = ca.Function("h", [q, v], [h])
    weight = ca.Function("G", [q], [G])
    return SimpleNamespace(
        mass_matrix=lambda q: np.array(inertia(q)),
        bias=lambda q, v: np.array(coriolis(q, v)).ravel(),
        gravity=lambda q: np.array(weight(q)).ravel(),
    )
