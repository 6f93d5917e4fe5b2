"""Tooth profile error, Eq. 14."""

from __future__ import annotations

from numba import vectorize


@vectorize(cache=True)
def tooth_error(sine: float, E: float) -> float:
    """e of Eq. 14 [m]; sine: that of the mesh phase; E: its magnitude [m]."""
    return E * sine
