"""What a difference in an entry is measured against, and what rounding may make of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crosscheck.checks.states import EPS, LOOSEST, ROUNDINGS, component_sizes
from crosscheck.trial.frame import Frame
from crosscheck.trial.states import State


@dataclass(frozen=True)
class Sizes:
    """Natural sizes in a user's coordinates: mass (n, n); rate_terms (n, n, n); rows of each part.

    roundings: of the map, how many a difference may hold.
    """

    mass: np.ndarray
    rate_terms: np.ndarray
    bias: np.ndarray
    force: np.ndarray
    acceleration: np.ndarray
    roundings: float

    @property
    def tolerance(self) -> float:
        """Relative to these sizes."""
        return LOOSEST + ROUNDINGS * EPS * self.roundings

    @property
    def basis(self) -> str:
        """In words."""
        return (
            f"{LOOSEST:g} + {ROUNDINGS} eps x {self.roundings:.3g}, the conditioning of the"
            " coordinates' map, of each entry's natural size"
        )

    def of(self, quantity: str) -> np.ndarray:
        """Of a part."""
        found = {"mass_matrix": self.mass, "rate_terms": self.rate_terms, "force": self.force}
        return {**found, "bias": self.bias, "acceleration": self.acceleration}[quantity]


def sizes_of(
    frame: Frame,
    states: Sequence[State],
    mass: np.ndarray,
    force: np.ndarray | None,
    acceleration: np.ndarray | None,
) -> Sizes:
    """From a trusted M (count, n, n), force and acceleration (count, n) at states.

    M_ij is of size sqrt(M_ii M_jj); a bias of sqrt(M_ii) times the root of u M u and the joints'
    rate; a term of it in u_j u_k of that over the rates' own sizes; a force or acceleration that
    vanishes has what its inertia makes of the others.
    """
    rates = np.array([state.u for state in states])
    turning = np.array([state.v[frame.layout.angular] for state in states])
    diagonal = np.sqrt(np.einsum("kii->ki", mass).max(axis=0))
    lively = np.sqrt(np.einsum("ki,kij,kj->k", rates, mass, rates).mean() * (turning**2).mean())
    of_rates = np.sqrt((rates**2).mean(axis=0))
    return Sizes(
        mass=np.outer(diagonal, diagonal),
        rate_terms=(diagonal * lively)[:, None, None] / np.outer(of_rates, of_rates),
        bias=diagonal * lively,
        force=_rows(force, diagonal),
        acceleration=_rows(acceleration, 1 / diagonal),
        roundings=max(_skeel(frame.jacobian(state.x)) for state in states),
    )


def _rows(values: np.ndarray | None, weight: np.ndarray) -> np.ndarray:
    if values is None:
        return weight
    shared = float(np.sqrt(((values / weight) ** 2).mean()))
    return component_sizes(values, weight * (shared or 1.0))


def _skeel(jacobian: np.ndarray) -> float:
    """Skeel's condition number: of rounding in what is solved, whatever the units of its rows."""
    return float((np.abs(np.linalg.inv(jacobian)) @ np.abs(jacobian)).sum(axis=1).max())
