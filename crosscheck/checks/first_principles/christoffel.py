"""The bias that follows from a mass matrix, by Christoffel's symbols, with no formula of a model.

c_i = sum over j, k of (dM_ij/dq_k - 1/2 dM_jk/dq_i) q_j' q_k'  (Siciliano et al., Robotics, 7.2).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

# The mass matrix of a chain of revolute joints holds no harmonic of a joint angle above the second
# (a rotation enters a velocity once, the energy squares it). For such f, f' is exactly a weighted
# sum of central differences over pi / 4 and 3 pi / 4: sum of w sin(m h) = m / 2 for m = 1, 2.
SHIFTS = np.pi / 4, 3 * np.pi / 4
WEIGHTS = (np.sqrt(0.5) + 1) / 2, (np.sqrt(0.5) - 1) / 2
# Mesh displacements must not enter M at all; over so much [m] a trace of them would show.
DISPLACEMENT_M = 1e-4


def christoffel_force(
    mass_matrix: Callable[[np.ndarray], np.ndarray],
    q: np.ndarray,
    v: np.ndarray,
    angular: np.ndarray,
) -> np.ndarray:
    """The force C(q, v) v that follows from a mass matrix alone, shape (n,).

    angular (n,): which coordinates are angles [rad]; the others are displacements [m].
    """

    def difference(k: int, shift: float) -> np.ndarray:
        forth, back = q.copy(), q.copy()
        forth[k] += shift
        back[k] -= shift
        return mass_matrix(forth) - mass_matrix(back)

    derivatives = []  # dM/dq_k
    for k, is_angle in enumerate(angular):
        if is_angle:
            weighed = (w * difference(k, h) for w, h in zip(WEIGHTS, SHIFTS, strict=True))
            derivatives.append(sum(weighed))
        else:
            derivatives.append(difference(k, DISPLACEMENT_M) / (2 * DISPLACEMENT_M))
    slopes = np.array(derivatives)
    along = np.einsum("kij,j,k->i", slopes, v, v)
    return along - np.einsum("ijk,j,k->i", slopes, v, v) / 2
