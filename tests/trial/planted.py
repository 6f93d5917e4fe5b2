"""Errors planted in the reference terms's own entries, and what is told of them."""

from functools import lru_cache

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.diagnose.terms.explain import explain
from crosscheck.trial.diagnose.terms.harmonic_fit import (
    HarmonicBasis,
    HarmonicFit,
    evaluate_entry,
    minimum_state_count,
)
from crosscheck.trial.diagnose.terms.polynomial import EntryTerms, Monomial, Product, TermKey
from crosscheck.trial.diagnose.terms.reference_terms import ReferenceTerms, build_reference_terms
from crosscheck.trial.diagnose.terms.values import collect_arm_values
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.judge.entries import EntryPlace, Explanation

RELATIVE, ABSOLUTE = Coordinates(), Coordinates(links="absolute")
LUMPED = Coordinates("lumped")
GEARS = Coordinates("lumped", "absolute", "angles")


def terms(arm: Arm, coordinates: Coordinates) -> ReferenceTerms:
    """Of an arm in coordinates."""
    return _dictionary(arm, coordinates.gearing, coordinates.links, coordinates.gears)


@lru_cache
def _dictionary(arm: Arm, gearing: str, links: str, gears: str) -> ReferenceTerms:
    chosen = {"planets": gearing} if gearing != "rigid" else {}
    frame = build_frame(Coordinates(gearing, links, gears), arm)
    return build_reference_terms(frame, arm, usual_switches(arm, **chosen))


@lru_cache
def _fitting(known: ReferenceTerms) -> tuple[np.ndarray, HarmonicBasis]:
    angles = np.random.default_rng(3).uniform(-3, 3, (minimum_state_count(known), known.joints))
    return angles, HarmonicBasis.from_angle_sums(known, angles)


def observed(arm: Arm, known: ReferenceTerms, place: EntryPlace, yours: EntryTerms) -> HarmonicFit:
    """An entry of M or bias with these terms, against the right ones."""
    angles, fitting = _fitting(known)
    values = collect_arm_values(arm)
    right = evaluate_entry(known.entry(place), values, angles)
    mine = evaluate_entry(yours, values, angles)
    return fitting.fit(mine - right, float(np.abs(right).max() + np.abs(mine).max()), values)


def explained(
    known: ReferenceTerms, place: EntryPlace, yours: EntryTerms, *arms: Arm
) -> Explanation | None:
    """What is said of an entry with these terms, on all these arms."""
    return explain(place, [observed(arm, known, place, yours) for arm in arms], known)


def term(number: float, *symbols: str, wave: tuple[int, ...], function: str = "cos") -> Product:
    """number * symbols before a wave."""
    powers = tuple(sorted((symbol, symbols.count(symbol)) for symbol in set(symbols)))
    return Product(TermKey(wave, function), Monomial(number, powers))


def times(product: Product, by: float) -> Product:
    """A term by a factor."""
    return Product(product.key, Monomial(by * product.monomial.number, product.monomial.powers))


def swapped(product: Product, symbol: str, other: str) -> Product:
    """A term with one symbol for another, its power and all."""
    powers = dict(product.monomial.powers)
    if symbol in powers:
        powers[other] = powers.get(other, 0) + powers.pop(symbol)
    return Product(product.key, Monomial(product.monomial.number, tuple(sorted(powers.items()))))
