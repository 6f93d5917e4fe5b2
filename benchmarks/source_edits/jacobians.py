"""A serial robot by its bodies' Jacobians and their rates."""

from types import SimpleNamespace

import numpy as np


def turn(k, angle):
    c, s = np.cos(angle), np.sin(angle)
    K = np.cross(np.eye(3), k)
    return c * np.eye(3) + s * K + (1 - c) * np.outer(k, k)


def chain(robot):
    bodies, n = robot.bodies, len(robot.joints)

    def kinematics(q):
        R = np.eye(3)
        o = np.zeros(3)
        frames, origins, axes = [], [], []
        for i in range(n):
            place = robot.joints[i].placement
            o = o + R @ place.position
            R = R @ place.rotation
            z = R @ robot.joints[i].axis
            R = R @ turn(robot.joints[i].axis, q[i])
            frames.append(R)
            origins.append(o)
            axes.append(z)
        return frames, origins, axes

    def jacobians(i, frames, origins, axes):
        c = origins[i] + frames[i] @ bodies[i].com
        Jv = np.zeros((3, n))
        Jw = np.zeros((3, n))
        for j in range(i + 1):
            Jv[:, j] = np.cross(axes[j], c - origins[j])
            Jw[:, j] = axes[j]
        return c, Jv, Jw

    def mass_matrix(q):
        frames, origins, axes = kinematics(q)
        M = np.zeros((n, n))
        for i in range(n):
            _, Jv, Jw = jacobians(i, frames, origins, axes)
            inertia = frames[i] @ bodies[i].inertia @ frames[i].T
            M += bodies[i].mass * Jv.T @ Jv + Jw.T @ inertia @ Jw
        return M

    def bias(q, v):
        frames, origins, axes = kinematics(q)
        spins = np.cumsum([axes[i] * v[i] for i in range(n)], axis=0)
        h = np.zeros(n)
        for i in range(n):
            c, Jv, Jw = jacobians(i, frames, origins, axes)
            inertia = frames[i] @ bodies[i].inertia @ frames[i].T
            linear, turning = np.zeros(3), np.zeros(3)
            for j in range(i + 1):
                before = spins[j] - axes[j] * v[j]
                axis_rate = np.cross(before, axes[j])
                origin_rate = np.zeros(3)
                for k in range(j):
                    origin_rate += np.cross(axes[k], origins[j] - origins[k]) * v[k]
                lever_rate = Jv @ v - origin_rate
                linear += np.cross(axis_rate, c - origins[j]) * v[j]
                linear += np.cross(axes[j], lever_rate) * v[j]
                turning += axis_rate * v[j]
            w = Jw @ v
            h += bodies[i].mass * Jv.T @ linear
            h += Jw.T @ (inertia @ turning + np.cross(w, inertia @ w))
        return h

    def gravity(q):
        frames, origins, axes = kinematics(q)
        g = np.zeros(n)
        for i in range(n):
            _, Jv, _ = jacobians(i, frames, origins, axes)
            g -= bodies[i].mass * Jv.T @ robot.gravity
        return g

    return SimpleNamespace(mass_matrix=mass_matrix, bias=bias, gravity=gravity)
