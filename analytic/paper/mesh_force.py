"""The mesh force, Eqs. 4 and 15."""

from __future__ import annotations

import numpy as np

from crosscheck.analytic.paper.backlash import dead_zone, dead_zone_tanh

EXACT, TANH = 0, 1


def mesh_force(
    law: int,
    gap: np.ndarray | float,
    stiffness: np.ndarray | float,
    b: np.ndarray | float,
    sigma: np.ndarray | float,
) -> np.ndarray:
    """F = k f_k(gap, b) [N] of one mesh, gap = x - e [m]; stiffness: k at its phase.

    Eq. 15 prints k (x - e); the clearance function of Eq. 4 has to stay in it.
    """
    travel = dead_zone_tanh(gap, b, sigma) if law == TANH else dead_zone(gap, b)
    return stiffness * travel


def is_in_contact(gap: np.ndarray | float, b: np.ndarray | float) -> np.ndarray:
    """Whether the teeth touch, by the exact clearance of Eq. 5."""
    return np.abs(gap) > b


def phase_force(
    gap: np.ndarray | float,
    stiffness: np.ndarray | float,
    stiffness_slope: np.ndarray | float,
    error_slope: np.ndarray | float,
    b: np.ndarray | float,
) -> np.ndarray:
    """-dV/dphi [N m/rad] of V = k(phi) f_k(x - e(phi), b)^2 / 2; slopes: dk/dphi, de/dphi.

    What the potential of Eq. 15's force does to the angle that k and e depend on (not in the
    paper; Oh, Grosh and Barber 2005 on the energy that is missing without it).
    """
    travel = dead_zone(gap, b)
    return stiffness * travel * error_slope - stiffness_slope * travel**2 / 2
