"""M, bias and force as plain functions: two links and a payload, the paper's arm without gears.

crosscheck trial examples/plain_functions.py:model paper-labelled
"""

import numpy as np

from crosscheck import Equations

L1, L2 = 1.0, 0.7  # lengths [m], of two uniform rods
D1, D2 = 0.5, 0.35  # centres of mass [m]
M1, M2, PAYLOAD = 27.0, 18.9, 10.0  # masses [kg]
I1, I2 = M1 * L1**2 / 12, M2 * L2**2 / 12  # about the centres [kg m^2]

SHOULDER = I1 + M1 * D1**2 + (M2 + PAYLOAD) * L1**2
ELBOW = I2 + M2 * D2**2 + PAYLOAD * L2**2
COUPLING = (M2 * D2 + PAYLOAD * L2) * L1


def mass_matrix(q):
    both = ELBOW + COUPLING * np.cos(q[1])
    return [[SHOULDER + both + COUPLING * np.cos(q[1]), both], [both, ELBOW]]


def bias(q, v):
    pull = COUPLING * np.sin(q[1])
    return [-pull * (2 * v[0] + v[1]) * v[1], pull * v[0] ** 2]


def force(t, q, v, torque):
    return torque


model = Equations(mass_matrix=mass_matrix, bias=bias, force=force, level="links")
