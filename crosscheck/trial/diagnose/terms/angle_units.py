"""Terms of an entry of which an angle alone is in degrees: no wave makes their difference."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from crosscheck.trial.diagnose.terms.candidates import group_terms
from crosscheck.trial.diagnose.terms.harmonic_fit import evaluate_entry
from crosscheck.trial.diagnose.terms.messages import format_wave, make_term
from crosscheck.trial.diagnose.terms.polynomial import EntryTerms
from crosscheck.trial.diagnose.terms.reference_terms import ReferenceTerms
from crosscheck.trial.judge.entries import EntryPlace, Explanation, TermError
from crosscheck.trial.judge.unit_mistakes import DEGREES

ALIKE = 1e-9  # largest residual of a unit, relative to the difference's largest value
# By what angles are multiplied, and the waves then, in words.
UNITS = {DEGREES: "{}, its angle in degrees,", 1 / DEGREES: "{}, its angle times pi/180,"}


class SampledDifference(NamedTuple):
    """Yours minus right of an entry (K,) on one arm, whose quantities by name are values.

    angles (K, joints): joint angles; signals (K,) by name; size: of the entry.
    """

    difference: np.ndarray
    size: float
    values: Mapping[str, float]
    angles: np.ndarray
    signals: Mapping[str, np.ndarray]

    def is_made_by(self, products: EntryTerms, unit: float) -> bool:
        """Whether the angles of these terms, multiplied by a unit, leave nothing of it."""
        there, right = (
            evaluate_entry(products, self.values, self.angles, self.signals, by)
            for by in (unit, 1.0)
        )
        left = np.abs(self.difference - (there - right)).max()
        return bool(left <= ALIKE * max(float(np.abs(self.difference).max()), self.size))


def explain_by_unit(
    place: EntryPlace, samples: Sequence[SampledDifference], terms: ReferenceTerms
) -> Explanation | None:
    """The terms of an entry that a unit of their angle makes wrong, on every arm; None for none."""
    for products in _list_waves(terms.entry(place)):
        for unit, words in UNITS.items():
            if all(each.is_made_by(products, unit) for each in samples):
                keys = dict.fromkeys(product.key for product in products)
                right = " and ".join(format_wave(key, terms) for key in keys)
                term = make_term(products, terms)
                return Explanation((TermError("angle", term, words.format(right), right),), 0.0)
    return None


def _list_waves(entry: EntryTerms) -> Iterator[EntryTerms]:
    """Terms before one wave, of which one error may be; then all terms before waves."""
    waves = tuple(product for product in entry if any(product.key.wave))
    for products, _ in group_terms(entry):
        if any(products[0].key.wave) and len({product.key for product in products}) == 1:
            yield products
    if waves:
        yield waves
