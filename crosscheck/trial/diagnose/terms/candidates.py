"""Every error that an entry's own terms allow, and what it does to the entry's coefficients."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import product as combinations
from typing import Any, NamedTuple

import numpy as np

from crosscheck.trial.diagnose.terms.polynomial import (
    EntryTerms,
    Monomial,
    Product,
    TermKey,
    format_power,
)
from crosscheck.trial.diagnose.terms.values import (
    STEMS_BY_QUANTITY,
    Alternative,
    Values,
    generate_alternatives,
    generate_ratios,
    parse_symbol,
)
from crosscheck.trial.judge.entries import ErrorKind

Change = Mapping[TermKey, np.ndarray]  # yours - right, (arms,) each
FACTORS = (2, 1 / 2, 3, 1 / 3, 4, 1 / 4, -2, -1 / 2, 3 / 2, 2 / 3, 6, 1 / 6, 12, 1 / 12)
PLAIN: tuple[tuple[ErrorKind, str, float, float], ...] = (
    ("dropped", "", 0.0, 1.0),
    ("sign", "", -1.0, 1.0),
    ("factor", "", FACTORS[0], 1.02),
    # A half is more often a centre of mass where a length belongs.
    *(("factor", "", by, 1.2 + 0.05 * place) for place, by in enumerate(FACTORS[1:])),
)
TIMES = ((1, 0.0), (-1, 0.0), (2, 0.2), (-2, 0.2), (0.5, 0.2), (-0.5, 0.2))
# Terms that one error may concern together, and how far-fetched that is.
TermGroup = tuple[EntryTerms, float]
Fits = Callable[[np.ndarray], np.ndarray]  # of changes (terms, arms): which make a difference
LENGTHS = ("L", "d", "r_s", "r_p", "r_c", "r_cp")
INERTIAS = ("I_l", "J_r", "J_m")
MULTIPLES = 3  # number of multiples of a symbol, the last of its alternatives
MOST_SHARED = 12  # symbols of which an error may concern all terms at once


class Candidate(NamedTuple):
    """An error in some terms of an entry.

    change: what it changes; cost: how far-fetched it is; user_text, reference_text: texts of what
    is swapped.
    """

    kind: ErrorKind
    products: EntryTerms
    change: Change
    cost: float
    user_text: str = ""
    reference_text: str = ""
    by: float | None = None
    key: TermKey | None = None  # of an angle: where yours stands

    @property
    def fingerprint(self) -> frozenset[tuple[TermKey, str]]:
        """The changes on the last arm, whose numbers are unrelated: equal for the same error."""
        last = ((key, change[-1]) for key, change in self.change.items())
        return frozenset((key, f"{number:.9e}") for key, number in last if number)


def group_terms(entry: EntryTerms) -> list[TermGroup]:
    """Terms that one error may concern: each; all; of one wave or symbol; of a joint's masses."""
    term_groups: list[TermGroup] = [((product,), 0.0) for product in entry]
    by_key: defaultdict[TermKey, list[Product]] = defaultdict(list)
    by_symbol: defaultdict[str, list[Product]] = defaultdict(list)
    for product in entry:
        by_key[product.key].append(product)
        for symbol in product.symbols:
            by_symbol[symbol].append(product)
    term_groups.append((entry, 0.02))
    term_groups += [(tuple(each), 0.04) for each in by_key.values()]
    term_groups += [(tuple(each), 0.06) for each in by_symbol.values()]
    for each in by_symbol.values():
        keys = {product.key for product in each}
        term_groups += [(tuple(p for p in each if p.key == k), 0.12) for k in keys if len(keys) > 1]
    term_groups += _joint_masses(entry)
    unique = {group[0]: group for group in reversed(term_groups) if group[0]}
    return list(unique.values())


def _joint_masses(entry: EntryTerms) -> Iterator[TermGroup]:
    """Groups of terms with masses of one joint's bodies but links, before the same lever.

    Of equivalent masses, which spin: all that its sun and planets reflect.
    """
    levers: defaultdict[Any, list[Product]] = defaultdict(list)
    for product in entry:
        masses = [parse_symbol(s) for s in product.symbols if s[0] == "m" and s != "m_payload"]
        if masses and masses[0].stem != "m":
            lever = tuple(p for p in product.monomial.powers if parse_symbol(p[0]).stem in LENGTHS)
            levers[masses[0].joint, lever, product.key].append(product)
        if joint := find_reflecting_joint(product):
            levers[joint, "reflected", product.key].append(product)
    yield from ((tuple(each), 0.05) for each in levers.values() if len(each) > 1)


def find_reflecting_joint(product: Product) -> int:
    """The joint whose sun or planets a term reflects; 0 of any other term."""
    symbols = map(parse_symbol, product.symbols)
    return next((symbol.joint for symbol in symbols if symbol.stem in ("M_s", "M_p")), 0)


def add_changes(products: Iterable[Product], of_each: Iterable[Any]) -> dict[TermKey, np.ndarray]:
    """The changes of products, each (arms,), added up for each key."""
    total: dict[TermKey, np.ndarray] = {}
    for product, change in zip(products, of_each, strict=True):
        total[product.key] = total[product.key] + change if product.key in total else change
    return total


class CandidateSet:
    """The candidate errors of one entry.

    values: arrays (arms,) by symbol, the last arm having the unrelated numbers.
    """

    def __init__(self, entry: EntryTerms, values: Values) -> None:
        self.entry, self.values = entry, values
        self.groups = group_terms(entry)
        self.size = {product: self._value(product.monomial) for product in entry}
        self.others = {
            symbol: list(generate_alternatives(symbol, values))
            for symbol in {symbol for product in entry for symbol in product.symbols}
        }
        self.forms = {symbol: list(self._forms(symbol)) for symbol in self.others}
        self._power_changes: dict[tuple[str, int, int], np.ndarray] = {}

    def _value(self, monomial: Monomial) -> np.ndarray:
        some = next(iter(self.values.values()))
        return monomial.value(self.values) + np.zeros(len(some))

    def list_term_candidates(self) -> list[Candidate]:
        """Candidates but for those of angles; each error once, in its simplest form."""
        candidates: dict[Any, Candidate] = {}
        for candidate in self._generate_term_candidates():
            mark = candidate.fingerprint
            if mark and (mark not in candidates or candidate.cost < candidates[mark].cost):
                candidates[mark] = candidate
        return list(candidates.values())

    def _generate_term_candidates(self) -> Iterator[Candidate]:
        """Candidates: factors of every group of terms; then one symbol in the place of another."""
        for products, extra in self.groups:
            whole = add_changes(products, (self.size[p] for p in products))
            for kind, user_text, by, cost in (*PLAIN, *self._counts(products)):
                change = {key: (by - 1) * size for key, size in whole.items()}
                plain = None if user_text else float(by)
                yield Candidate(kind, products, change, cost + extra, user_text, by=plain)
        for products, extra in self.groups:
            symbols = {symbol for product in products for symbol in product.symbols}
            for symbol in symbols:
                yield from self._generate_ratios(products, symbol, extra)
            for symbol in symbols if len(symbols) <= MOST_SHARED or extra <= 0.06 else ():
                yield from self._generate_swaps(products, symbol, extra)
                if all(abs(product.monomial.number) == 2 for product in products):
                    once = tuple(  # a coupling that is written twice, once wrong
                        Product(key, Monomial(Fraction(number) / 2, powers))
                        for key, (number, powers) in products
                    )
                    yield from self._generate_swaps(once, symbol, extra + 0.15)

    def _counts(self, products: EntryTerms) -> Iterator[tuple[ErrorKind, str, Any, float]]:
        """Factors that are a number of planets, or a ratio, of a joint that these terms concern.

        Of a single term also another of the entry's symbols.
        """
        joints = {parse_symbol(symbol).joint for product in products for symbol in product.symbols}
        joints |= {
            parse_symbol(product.key.signal).joint for product in products if product.key.signal
        }
        for symbol, count in self.values.items():
            stem, joint, _ = parse_symbol(symbol)
            if stem in ("N", "n") and joint in joints:
                yield "factor", symbol, count, 1.25
                yield "factor", f"1/{symbol}", 1 / count, 1.25
                yield "factor", f"{symbol}^2", count**2, 1.3
                yield "factor", f"1/{symbol}^2", count**-2, 1.3
            if stem == "N" and joint in joints:
                yield "factor", f"sqrt({symbol})", count**0.5, 1.3
                yield "factor", f"1/sqrt({symbol})", count**-0.5, 1.3
            elif len(products) == 1 and symbol in self.others and np.all(count):
                yield "factor", symbol, count, 1.45

    def _generate_swaps(
        self, products: EntryTerms, symbol: str, extra: float
    ) -> Iterator[Candidate]:
        """Candidates with one symbol by another in all products; of one power also one of it."""
        inside = tuple(p for p in products if symbol in p.symbols)
        symbol_value = self.values[symbol]
        sizes = []  # of the products without the symbol, and its powers
        for _, (number, powers) in inside:
            rest = Monomial(number, tuple(power for power in powers if power[0] != symbol))
            sizes.append((self._value(rest), dict(powers)[symbol]))
        in_powers = len({power for _, power in sizes}) > 1
        alternatives = [*self.others[symbol], *self.forms[symbol]]
        # Of one power throughout, a multiple of the symbol is but a factor of the terms.
        for place, other in enumerate(alternatives if in_powers else alternatives[:-MULTIPLES]):
            change = add_changes(
                inside,
                (
                    rest * self._change_power(symbol, place, other.value, power)
                    for rest, power in sizes
                ),
            )
            cost = 1.0 + other.cost + extra
            yield Candidate("swapped", inside, change, cost, other.text, symbol)
        power, *others = {power for _, power in sizes}
        if not others and power >= 2:
            fewer, right = format_power(symbol, power - 1), format_power(symbol, power)
            named = [other for other in self.others[symbol] if other.text.isidentifier()]
            for other in (Alternative("", np.ones_like(symbol_value), 0.1), *named):
                by = symbol_value ** (power - 1) * (other.value - symbol_value)
                change = add_changes(inside, (rest * by for rest, _ in sizes))
                text = f"{other.text} {fewer}".strip()
                yield Candidate("swapped", inside, change, 1.15 + other.cost + extra, text, right)

    def _generate_ratios(
        self, products: EntryTerms, symbol: str, extra: float
    ) -> Iterator[Candidate]:
        """Candidates with another ratio of the gears of this mass, to the power of their r_cp."""
        radius = f"r_cp{parse_symbol(symbol).joint}"
        inside = tuple(p for p in products if {symbol, radius} <= set(p.symbols))
        for right, other in generate_ratios(symbol, self.values) if inside else ():
            sizes = ((self.size[p], dict(p.monomial.powers)[radius]) for p in inside)
            change = add_changes(inside, (size * (other.value**p - 1) for size, p in sizes))
            yield Candidate("swapped", inside, change, 1.0 + other.cost + extra, other.text, right)

    def _change_power(self, symbol: str, place: int, value: Any, power: int) -> np.ndarray:
        """Change of a symbol's power if the alternative with this value takes its place."""
        key = symbol, place, power
        if key not in self._power_changes:
            right = _power(self.values[symbol], power)
            self._power_changes[key] = _power(value, power) - right
        return self._power_changes[key]

    def _forms(self, symbol: str) -> Iterator[Alternative]:
        """Forms of the symbol itself: its square, nothing, and last its multiples.

        Of a component of gravity also its sign alone, for g is written as a positive number.
        """
        value = self.values[symbol]
        if parse_symbol(symbol).stem in STEMS_BY_QUANTITY["gravity"]:
            yield Alternative("-1", -np.ones_like(value), 0.45)
        yield Alternative(f"{symbol}^2", value**2, 0.5)
        yield Alternative("1", np.ones_like(value), 0.45)
        yield Alternative(f"-{symbol}", -value, 0.3)
        yield Alternative(f"2 {symbol}", 2 * value, 0.3)
        yield Alternative(f"{symbol}/2", value / 2, 0.3)

    def generate_angle_candidates(self, keys: Sequence[TermKey]) -> Iterator[Candidate]:
        """Candidates in which terms before one wave stand before another of these keys instead."""
        for products, extra in self.groups:
            group_keys = {product.key for product in products}
            if len(group_keys) > 1:
                continue
            (key,) = group_keys
            size = np.sum([self.size[p] for p in products], axis=0)
            for other in keys:
                if other == key:
                    continue
                for sign, cost in ((1, 1.0), (-1, 1.2)):
                    change = {key: -size, other: sign * size}
                    kind: ErrorKind = "swapped" if other.signal != key.signal else "angle"
                    cost += 0.4 * (kind == "swapped")  # rather a term is missing
                    yield Candidate(kind, products, change, cost + extra, by=float(sign), key=other)


def _power(value: Any, power: int) -> Any:
    """The power of a value; infinite for a negative power of 0, and so it fits nothing."""
    with np.errstate(divide="ignore"):
        return np.asarray(value, dtype=float) ** power


def generate_extras(
    groups: Iterable[EntryTerms], fits_by_key: Mapping[TermKey, Fits], values: Values
) -> Iterator[Candidate]:
    """Candidates of extra terms, of any entry or of none, that make what is off before a key."""
    sums = list(dict.fromkeys(tuple(product.monomial for product in group) for group in groups))
    arms = len(next(iter(values.values())))
    sizes = np.array(
        [sum(each.value(values) for each in all_of) + np.zeros(arms) for all_of in sums]
    )
    for key, fits in fits_by_key.items():
        for by, cost in TIMES if sums else ():
            for place in np.flatnonzero(fits(by * sizes)).tolist():
                products = tuple(
                    Product(key, Monomial(number * Fraction(by), powers))
                    for number, powers in sums[place]
                )
                far = 2.0 + cost + 0.1 * max(len(product.monomial.powers) for product in products)
                yield Candidate("extra", products, {key: by * sizes[place]}, far)


def generate_reactions(
    groups: Iterable[EntryTerms], fits_by_key: Mapping[TermKey, Fits], values: Values
) -> Iterator[Candidate]:
    """Candidates of terms that are there with both signs, so nowhere, if one has another lever.

    So a force between two links acts on both; the lever is a length that all of a group have.
    """
    for group in dict.fromkeys(groups):
        size = np.sum([product.monomial.value(values) for product in group], axis=0)
        shared = set.intersection(*({*product.monomial.powers} for product in group))
        for symbol in sorted(name for name, power in shared if power == 1):
            if parse_symbol(symbol).stem not in ("L", "d"):
                continue
            for other in generate_alternatives(symbol, values):
                made = size * (other.value / values[symbol] - 1)
                for key, by in combinations(fits_by_key, (1, -1)):
                    if fits_by_key[key](by * made[None]).all():
                        products = tuple(
                            Product(key, Monomial(by * each.monomial.number, each.monomial.powers))
                            for each in group
                        )
                        change = {key: by * made}
                        cost = 2.1 + other.cost
                        yield Candidate("swapped", products, change, cost, other.text, symbol)


def group_by_wave(entry: EntryTerms) -> Iterator[EntryTerms]:
    """Each term of an entry, and all that stand before one wave."""
    yield from ((product,) for product in entry)
    for key in {product.key: None for product in entry}:
        yield tuple(product for product in entry if product.key == key)


def generate_products(values: Values, *, weighing: bool) -> Iterator[EntryTerms]:
    """Products of a mass and up to two lengths, and inertias; of weights, gravity and a lever."""
    of = defaultdict(list)
    for symbol in values:
        stem = parse_symbol(symbol).stem
        if stem in LENGTHS or stem in INERTIAS or stem[0] in "mM":
            of["length" if stem in LENGTHS else "mass" if stem[0] in "mM" else "inertia"].append(
                symbol
            )
    if weighing:
        along = [symbol for symbol in STEMS_BY_QUANTITY["gravity"] if symbol in values]
        yield from (_product(*each) for each in combinations(of["mass"], along, of["length"]))
        return
    for inertia in of["inertia"]:
        yield _product(inertia)
    for mass in of["mass"]:
        yield _product(mass)
        for place, first in enumerate(of["length"]):
            yield _product(mass, first)
            for second in of["length"][place:]:
                yield _product(mass, first, second)


def _product(*symbols: str) -> EntryTerms:
    powers = tuple(sorted((symbol, symbols.count(symbol)) for symbol in set(symbols)))
    return (Product(TermKey(()), Monomial(1, powers)),)
