"""Differences in the equations behind accelerations alone, entry by entry.

With the right M, h and f, M a + h - f of a user's acceleration a is f' - f - (h' - h) - (M' - M) a
of his own M', h' and f'. So its coefficients before waves times accelerations, products of rates
and what forces depend on are those of the entries' differences. The torques' part of f' is taken as
right: a row of the equations times any number has the same accelerations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations_with_replacement

import numpy as np

from crosscheck.trial.diagnose.terms.harmonic_fit import HarmonicBasis, HarmonicFit, make_term_keys
from crosscheck.trial.diagnose.terms.polynomial import TermKey
from crosscheck.trial.diagnose.terms.reference_terms import ReferenceTerms
from crosscheck.trial.judge.entries import EntryPlace

MOST_KEYS = 0.8  # largest ratio of keys to states at which a residual still shows
TORQUE = "T_"  # begins the signals that are torques


class BalanceBasis:
    """The fit of rows of M a + h - f.

    angles (K, joints); accelerations, rates (K, n): the user's; signals (K,): of the force, by
    name; force_keys: what it may depend on.
    """

    def __init__(
        self,
        terms: ReferenceTerms,
        angles: np.ndarray,
        accelerations: np.ndarray,
        rates: np.ndarray,
        signals: Mapping[str, np.ndarray],
        force_keys: Sequence[TermKey],
    ) -> None:
        size = accelerations.shape[1]
        moving = {
            product.key.wave
            for place, entry in terms.entries.items()
            for product in entry
            if place.part != "force"
        }
        # The places of row 0; of another row they are the same but for that.
        columns = {EntryPlace("mass_matrix", 0, j): -accelerations[:, j] for j in range(size)}
        pairs = combinations_with_replacement(range(size), 2)
        columns |= {
            EntryPlace("bias", 0, rates=(j, k)): -rates[:, j] * rates[:, k] for j, k in pairs
        }
        self.places = {
            key._replace(signal=str(place)): (place, key)
            for place in columns
            for key in make_term_keys(sorted(moving))
        }
        self.places |= {
            key: (EntryPlace("force", 0), key)
            for key in force_keys
            if not key.signal.startswith(TORQUE)
        }
        named = {str(place): column for place, column in columns.items()}
        self.basis = HarmonicBasis(list(self.places), angles, {**signals, **named})

    @property
    def is_determined(self) -> bool:
        """Whether there are enough states for as many coefficients."""
        states, keys = self.basis.table.shape
        return keys <= MOST_KEYS * states

    def fit(
        self, row: int, values: np.ndarray, scale: float, arm: Mapping[str, float]
    ) -> dict[EntryPlace, HarmonicFit]:
        """The differences of a row's entries that make these values (K,) of it."""
        whole = self.basis.fit(values, scale, arm)
        fits = dict[EntryPlace, HarmonicFit]()
        for key, coefficient in whole.coefficients.items():
            first, entry_key = self.places[key]
            place = EntryPlace(first.part, row, first.column, first.rates)
            fit = fits.setdefault(place, HarmonicFit(arm, {}, {}, whole.left_over))
            fits[place] = HarmonicFit(
                arm,
                {**fit.coefficients, entry_key: coefficient},
                {**fit.noise, entry_key: whole.noise[key]},
                whole.left_over,
            )
        return fits
