"""The mesh force and what it is made of: clearance, tooth error and spring, Eqs. 4-6, 14, 15."""

from __future__ import annotations

import numpy as np

EXACT, TANH = 0, 1


def dead_zone(x: np.ndarray | float, b: np.ndarray | float) -> np.ndarray:
    """f_k(x, b) of Eq. 5 [m]: displacement beyond a clearance of half width b; x, b [m]."""
    beyond = np.where(x > b, np.subtract(x, b), 0.0)
    return np.where(np.less_equal(x, np.negative(b)), np.add(x, b), beyond)


def dead_zone_tanh(
    x: np.ndarray | float, b: np.ndarray | float, sigma: np.ndarray | float
) -> np.ndarray:
    """f_k(x, b) of Eq. 6 [m], the smooth stand-in; x, b [m], sigma [1/m]."""
    right = np.tanh(sigma * np.subtract(x, b))
    left = np.tanh(sigma * np.add(x, b))
    return x + np.divide(x, 2) * (right - left) - np.divide(b, 2) * (right + left)


def tooth_error(sine: np.ndarray | float, E: np.ndarray | float) -> np.ndarray:
    """e of Eq. 14 [m]; sine: that of the mesh phase; E: its magnitude [m]."""
    return np.multiply(E, sine)


def total_error(
    phase: np.ndarray | float,
    E: np.ndarray | float,
    error_phase: np.ndarray | float,
    static_error: np.ndarray | float,
) -> np.ndarray:
    """e [m] where it has a phase of its own, by so much lead [rad], and a constant part [m]."""
    return static_error + tooth_error(np.sin(np.add(phase, error_phase)), E)


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
