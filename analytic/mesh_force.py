"""The mesh force, Eqs. 4 and 15."""

from __future__ import annotations

from numba import njit

from analytic.backlash import dead_zone, dead_zone_tanh

EXACT, TANH = 0, 1


@njit(cache=True)
def mesh_force(law: int, gap: float, stiffness: float, b: float, sigma: float) -> float:
    """F = k f_k(gap, b) [N] of one mesh, gap = x - e [m]; stiffness: k at its phase.

    Eq. 15 prints k (x - e); the clearance function of Eq. 4 has to stay in it.
    """
    if law == TANH:
        return stiffness * dead_zone_tanh(gap, b, sigma)
    return stiffness * dead_zone(gap, b)


@njit(cache=True)
def in_contact(gap: float, b: float) -> bool:
    """Whether the teeth touch, by the exact clearance of Eq. 5."""
    return abs(gap) > b


@njit(cache=True)
def phase_force(
    gap: float, stiffness: float, stiffness_slope: float, error_slope: float, b: float
) -> float:
    """-dV/dphi [N m/rad] of V = k(phi) f_k(x - e(phi), b)^2 / 2; slopes: dk/dphi, de/dphi.

    What the potential of Eq. 15's force does to the angle that k and e depend on (not in the
    paper; Oh, Grosh and Barber 2005 on the energy that is missing without it).
    """
    travel = dead_zone(gap, b)
    return stiffness * travel * error_slope - stiffness_slope * travel**2 / 2
