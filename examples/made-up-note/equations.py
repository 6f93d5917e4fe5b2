"""The note's three equations as it prints them: Eq. 2 has lost a factor 2."""

import numpy as np

from crosscheck.trial.input.equations import Equations

L1 = 1.0  # length of the first link [m]
D1, D2 = 0.5, 0.35  # centres of mass [m]
M1, M2, PAYLOAD = 27.0, 18.9, 10.0  # [kg]
I1, I2 = M1 * (2 * D1) ** 2 / 12, M2 * (2 * D2) ** 2 / 12  # uniform rods [kg m^2]
ALPHA = I1 + M1 * D1**2 + (M2 + PAYLOAD) * L1**2
BETA = I2 + M2 * D2**2 + PAYLOAD * (2 * D2) ** 2
ETA = L1 * (M2 * D2 + PAYLOAD * 2 * D2)


def mass_matrix(q):  # Eq. 1
    both = BETA + ETA * np.cos(q[1])
    return [[ALPHA + both + ETA * np.cos(q[1]), both], [both, BETA]]


def bias(q, v):  # Eq. 2
    pull = ETA * np.sin(q[1])
    return [-pull * (v[0] + v[1]) * v[1], pull * v[0] ** 2]


def force(t, q, v, torque):  # Eq. 3
    return torque


model = Equations(mass_matrix=mass_matrix, bias=bias, force=force, level="links")
