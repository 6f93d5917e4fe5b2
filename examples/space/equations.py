"""Hand-derived equations of a planar arm on a satellite that floats, for a trial.

The joints accelerate by the generalized inertia H* = H_m - H_bm' H_b^-1 H_bm of Umetani and Yoshida
(1989), as the base moves so that momenta are kept: H_b a_b + H_bm a_m + c_b = 0.

Derivation, with absolute angles s = (yaw, yaw + q1, yaw + q1 + q2) and complex numbers for vectors
in the plane. The shoulder is at p = x + i y. Body k has its centre of mass at p + c_0 e^(i s_0) for
the satellite, p + c_1 e^(i s_1) for the upper arm, p + l e^(i s_1) + c_2 e^(i s_2) for the forearm.
With b_k e^(i s_k) for the first moment of all that turns with s_k, and J_k for its inertia about
its joint, the kinetic energy is the sum of m |p'|^2 / 2, Re(conj(p') i b_k e^(i s_k)) s_k',
J_k s_k'^2 / 2 and b_2 l cos(s_2 - s_1) s_1' s_2'.
"""

from types import SimpleNamespace

import numpy as np

SUMS = np.tril(np.ones((3, 3)))  # absolute angles by yaw and the joints' angles


def equations(robot, lost=0.0):
    (m_0, m_1, m_2), (c_0, c_1, c_2), (j_0, j_1, j_2) = zip(
        *((body.mass, body.com[0], body.inertia[2, 2]) for body in robot.bodies[2:]), strict=True
    )
    length = robot.joints[4].placement.position[0]
    moments = np.array([m_0 * c_0, m_1 * c_1 + m_2 * length, m_2 * c_2])
    inertias = [j_0 + m_0 * c_0**2, j_1 + m_1 * c_1**2 + m_2 * length**2, j_2 + m_2 * c_2**2]

    def mass_matrix(q):
        angles = SUMS @ q[2:]
        turned = 1j * moments * np.exp(1j * angles)  # how the momentum grows by each rate
        coupled = np.diag(inertias)
        coupled[1, 2] = coupled[2, 1] = moments[2] * length * np.cos(angles[2] - angles[1])
        shift = np.array([turned.real, turned.imag]) @ SUMS
        turning = SUMS.T @ coupled @ SUMS
        turning[0, 2] = turning[2, 0] = turning[0, 2] - lost * j_2
        return np.block([[(m_0 + m_1 + m_2) * np.eye(2), shift], [shift.T, turning]])

    def bias(q, v):
        angles, rates = SUMS @ q[2:], SUMS @ v[2:]
        pull = -np.sum(moments * np.exp(1j * angles) * rates**2)  # centripetal, on the whole
        bend = moments[2] * length * np.sin(angles[2] - angles[1])
        turning = np.array([0.0, -bend * rates[2] ** 2, bend * rates[1] ** 2])
        return np.array([pull.real, pull.imag, *(SUMS.T @ turning)])

    def acceleration(q, v, torque):
        h, c = mass_matrix(q), bias(q, v)
        h_b, h_bm, h_m = h[:3, :3], h[:3, 3:], h[3:, 3:]
        carried = np.linalg.solve(h_b, np.column_stack([h_bm, c[:3]]))
        reduced = h_m - h_bm.T @ carried[:, :2]  # H*
        joints = np.linalg.solve(reduced, torque - c[3:] + h_bm.T @ carried[:, 2])
        return np.concatenate([-carried[:, :2] @ joints - carried[:, 2], joints])

    return SimpleNamespace(mass_matrix=mass_matrix, bias=bias, acceleration=acceleration)


def fixed_base(robot):
    """The usual slip: the joints accelerate by H_m, as if the base stood still."""
    right = equations(robot)

    def acceleration(q, v, torque):
        joints = np.linalg.solve(right.mass_matrix(q)[3:, 3:], torque - right.bias(q, v)[3:])
        return np.concatenate([np.zeros(3), joints])

    return SimpleNamespace(acceleration=acceleration)


def lost_reaction(robot):
    """A slip in H_bm: the forearm's own inertia does not turn the satellite back."""
    return equations(robot, lost=1.0)
