"""Errors planted in the reference terms's own entries, and what is told of them."""

from functools import lru_cache

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.trial.coordinates.frame import frame_of
from crosscheck.trial.diagnose.explain import explain
from crosscheck.trial.diagnose.polynomial import Entry, Monomial, Product, TermKey
from crosscheck.trial.diagnose.reference_terms import ReferenceTerms, reference_terms_of
from crosscheck.trial.diagnose.values import values_of
from crosscheck.trial.diagnose.waves import Fitting, Observed, entry_values, states_wanted
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.judge.places import EntryPlace, Explanation

RELATIVE, ABSOLUTE = Coordinates(), Coordinates(links="absolute")
LUMPED = Coordinates("lumped")
GEARS = Coordinates("lumped", "absolute", "angles")


def terms(arm: Arm, coordinates: Coordinates) -> ReferenceTerms:
    """Of an arm in coordinates."""
    return _dictionary(arm, coordinates.gearing, coordinates.links, coordinates.gears)


@lru_cache
def _dictionary(arm: Arm, gearing: str, links: str, gears: str) -> ReferenceTerms:
    chosen = {"planets": gearing} if gearing != "rigid" else {}
    frame = frame_of(Coordinates(gearing, links, gears), arm)
    return reference_terms_of(frame, arm, usual_switches(arm, **chosen))


@lru_cache
def _fitting(known: ReferenceTerms) -> tuple[np.ndarray, Fitting]:
    angles = np.random.default_rng(3).uniform(-3, 3, (states_wanted(known), known.joints))
    return angles, Fitting.of_waves(known, angles)


def observed(arm: Arm, known: ReferenceTerms, place: EntryPlace, yours: Entry) -> Observed:
    """An entry of M or bias with these terms, against the right ones."""
    angles, fitting = _fitting(known)
    values = values_of(arm)
    right = entry_values(known.entry(place), values, angles)
    mine = entry_values(yours, values, angles)
    return fitting.fit(mine - right, float(np.abs(right).max() + np.abs(mine).max()), values)


def explained(
    known: ReferenceTerms, place: EntryPlace, yours: Entry, *arms: Arm
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
