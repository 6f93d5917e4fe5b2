"""The acrobot's equations of motion as the paper of 1996 prints them: one term is missing.

It prints theta_2'' = (tau + phi_1 d_2 / d_1 - phi_2) / (m_2 l_c2^2 + I_2 - d_2^2 / d_1) and
theta_1'' = -(d_2 theta_2'' + phi_1) / d_1. That is how M theta'' + bias = (0, tau) is solved if
``mass_matrix`` and ``bias`` are as below. phi_1 and phi_2 contain the weights.
"""

from math import cos, pi, sin

from crosscheck import Equations

M1 = M2 = 1.0  # masses [kg]
L1 = 1.0  # length of the first link [m]
LC1 = LC2 = 0.5  # from a joint to the centre of mass of its link [m]
I1 = I2 = 1.0  # about the centres of mass [kg m^2]
G = 9.8  # gravity [m/s^2]


def mass_matrix(q):
    d_1 = M1 * LC1**2 + M2 * (L1**2 + LC2**2 + 2 * L1 * LC2 * cos(q[1])) + I1 + I2
    d_2 = M2 * (LC2**2 + L1 * LC2 * cos(q[1])) + I2
    return [[d_1, d_2], [d_2, M2 * LC2**2 + I2]]


def bias(q, v):
    phi_2 = M2 * LC2 * G * cos(q[0] + q[1] - pi / 2)
    turning = -M2 * L1 * LC2 * v[1] ** 2 * sin(q[1]) - 2 * M2 * L1 * LC2 * v[1] * v[0] * sin(q[1])
    return [turning + (M1 * LC1 + M2 * L1) * G * cos(q[0] - pi / 2) + phi_2, phi_2]


def acceleration(q, v, torque):
    ((d_1, d_2), (_, d_3)), (phi_1, phi_2) = mass_matrix(q), bias(q, v)
    second = (torque + phi_1 * d_2 / d_1 - phi_2) / (d_3 - d_2**2 / d_1)
    return [-(d_2 * second + phi_1) / d_1, second]


model = Equations(mass_matrix=mass_matrix, bias=bias, acceleration=acceleration, drive=["waist"])
