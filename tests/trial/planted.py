"""Errors planted in the reference's own terms, and what is said of them."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.trial.changes.arms.letters import collect_arm_values, draw_unrelated_values
from crosscheck.trial.changes.arms.polynomial import Monomial
from crosscheck.trial.changes.arms.segments import (
    EntryTerms,
    Product,
    ReferenceTerms,
    build_reference_terms,
    evaluate_entry,
)
from crosscheck.trial.changes.arms.term_changes import Target, TermSample
from crosscheck.trial.changes.arms.term_search import FITS, search_changes
from crosscheck.trial.changes.arms.term_words import make_term_error
from crosscheck.trial.changes.arms.waves import WaveBasis, list_keys
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.judge.entries import EntryPlace, TermError

RELATIVE, ABSOLUTE = Coordinates(), Coordinates(links="absolute")
LUMPED = Coordinates("lumped")
GEARS = Coordinates("lumped", "absolute", "angles")
STATES = 200


@lru_cache
def terms(arm: Arm, coordinates: Coordinates, level: str = "") -> ReferenceTerms:
    """Of an arm in coordinates."""
    gearing = coordinates.gearing
    chosen = {"planets": gearing} if gearing != "rigid" else {}
    frame = build_frame(coordinates, arm)
    return build_reference_terms(frame, arm, usual_switches(arm, **chosen), level)


def explained(
    known: ReferenceTerms, place: EntryPlace, yours: EntryTerms, *arms: Arm
) -> list[tuple[TermError, ...]]:
    """What is said of an entry of M or bias with these terms, on all these arms."""
    angles = np.random.default_rng(3).uniform(-3, 3, (STATES, known.joints))
    samples, off, tolerance, fits = [], [], [], []
    basis = WaveBasis(list_keys(known, (), place.part), angles, {})
    for arm in arms:
        values = collect_arm_values(arm)
        right, mine = (evaluate_entry(e, values, angles) for e in (known.entry(place), yours))
        samples.append(TermSample(values, angles, {}))
        off.append(mine - right)
        size = float(np.abs(right).max() + np.abs(mine).max())
        tolerance.append(np.full(STATES, FITS * np.abs(off[-1]).max() + 1e-13 * size))
        fits.append(basis.fit(off[-1], size) or {})
    samples.append(samples[0]._replace(values=draw_unrelated_values(samples[0].values)))
    tolerances, keys = np.array(tolerance), dict.fromkeys(key for fit in fits for key in fit)
    target = Target(known, place, samples, np.array(off), tolerances, basis.keys)
    parts = {
        key: np.array([[fit.get(key, 0.0)] for fit in fits]) * target.column(key)[:-1]
        for key in keys
    }
    target = replace(target, parts=parts)
    return [
        tuple(make_term_error(change, known) for change in changes)
        for changes in search_changes(target)
    ]


def times(product: Product, by: float) -> Product:
    """A term by a factor."""
    return Product(product.key, Monomial(by * product.monomial.number, product.monomial.powers))


def swapped(product: Product, letter: str, other: str) -> Product:
    """A term with one letter for another, its power and all."""
    powers = dict(product.monomial.powers)
    if letter in powers:
        powers[other] = powers.get(other, 0) + powers.pop(letter)
    return Product(product.key, Monomial(product.monomial.number, tuple(sorted(powers.items()))))
