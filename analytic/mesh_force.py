"""The mesh force, Eqs. 4 and 15."""

from __future__ import annotations

from numba import njit

from analytic.backlash import dead_zone, dead_zone_tanh
from analytic.tooth_error import tooth_error

EXACT, TANH = 0, 1


@njit(cache=True)
def mesh_force(
    law: int, x: float, sine: float, stiffness: float, E: float, b: float, sigma: float
) -> float:
    """F = k f_k(x - e, b) [N] of one mesh; stiffness: k at its phase.

    Eq. 15 prints k (x - e); the clearance function of Eq. 4 has to stay in it.
    """
    gap = x - tooth_error(sine, E)
    if law == TANH:
        return stiffness * dead_zone_tanh(gap, b, sigma)
    return stiffness * dead_zone(gap, b)


@njit(cache=True)
def in_contact(x: float, sine: float, E: float, b: float) -> bool:
    """Whether the teeth touch, by the exact clearance of Eq. 5."""
    return abs(x - tooth_error(sine, E)) > b
