"""Tooth profile error, Eq. 14."""

from __future__ import annotations

import numpy as np
from numba import vectorize


@vectorize(cache=True)
def tooth_error(sine: float, E: float) -> float:
    """e of Eq. 14 [m]; sine: that of the mesh phase; E: its magnitude [m]."""
    return E * sine


@vectorize(cache=True)
def whole_error(phase: float, sine: float, E: float, lead: float, static: float) -> float:
    """e [m] where it has a phase of its own, by so much lead [rad], and a constant part [m].

    sine: that of the mesh phase [rad].
    """
    if lead == 0.0:
        return static + tooth_error(sine, E)
    return static + tooth_error(np.sin(phase + lead), E)
