"""Every slip that an entry's own terms allow, and what it does to the entry's coefficients."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any, Literal, NamedTuple

import numpy as np

from crosscheck.trial.diagnose.keys import Entry, Key, Product
from crosscheck.trial.diagnose.polynomial import Monomial
from crosscheck.trial.diagnose.values import Alternative, Values, alternatives, named

Kind = Literal["sign", "factor", "dropped", "swapped", "angle", "extra"]
Change = Mapping[Key, np.ndarray]  # yours - right, (arms,) each
FACTORS = (2, 1 / 2, 3, 1 / 3, 4, 1 / 4, -2, -1 / 2, 3 / 2, 2 / 3, 6, 1 / 6, 12, 1 / 12)
PLAIN: tuple[tuple[Kind, str, float, float], ...] = (
    ("dropped", "", 0.0, 1.0),
    ("sign", "", -1.0, 1.0),
    ("factor", "", FACTORS[0], 1.02),
    # A half is more often a centre of mass where a length belongs.
    *(("factor", "", by, 1.2 + 0.05 * place) for place, by in enumerate(FACTORS[1:])),
)
MOST_SHARED = 12  # symbols of which a slip may concern all terms at once


class Suspect(NamedTuple):
    """A slip in these terms. cost: how far-fetched; yours, right: texts of what is swapped."""

    kind: Kind
    products: Entry
    change: Change
    cost: float
    yours: str = ""
    right: str = ""
    by: float | None = None
    key: Key | None = None  # of an angle: where yours stands

    @property
    def print(self) -> tuple[tuple[Key, str], ...]:
        """What it does to the last arm, whose numbers have nothing in common: equal if the same."""
        last = ((key, f"{change[-1]:.9e}") for key, change in self.change.items() if change[-1])
        return tuple(sorted(last))


class Group(NamedTuple):
    """Terms that one slip may concern together; cost: how far-fetched that is."""

    products: Entry
    cost: float


def groups(entry: Entry) -> list[Group]:
    """Each term; all; those before one wave; those with one symbol in common."""
    found = [Group((product,), 0.0) for product in entry]
    by_key: defaultdict[Key, list[Product]] = defaultdict(list)
    by_symbol: defaultdict[str, list[Product]] = defaultdict(list)
    for product in entry:
        by_key[product.key].append(product)
        for symbol in product.symbols:
            by_symbol[symbol].append(product)
    found.append(Group(entry, 0.02))
    found += [Group(tuple(each), 0.04) for each in by_key.values()]
    found += [Group(tuple(each), 0.06) for each in by_symbol.values()]
    for each in by_symbol.values():
        keys = {product.key for product in each}
        found += [Group(tuple(p for p in each if p.key == k), 0.12) for k in keys if len(keys) > 1]
    unique = {group.products: group for group in reversed(found) if group.products}
    return list(unique.values())


def change_by(products: Iterable[Product], of_each: Iterable[Any]) -> dict[Key, np.ndarray]:
    """Changes of products, added up for each key."""
    total: dict[Key, np.ndarray] = {}
    for product, change in zip(products, of_each, strict=True):
        total[product.key] = total[product.key] + change if product.key in total else change
    return total


class Suspects:
    """Of one entry, on arms whose values are arrays (arms,), the last one the unrelated numbers."""

    def __init__(self, entry: Entry, values: Values) -> None:
        self.entry, self.values = entry, values
        self.groups = groups(entry)
        self.size = {product: self._value(product.monomial) for product in entry}
        self.others = {
            symbol: list(alternatives(symbol, values))
            for symbol in {symbol for product in entry for symbol in product.symbols}
        }

    def _value(self, monomial: Monomial) -> np.ndarray:
        some = next(iter(self.values.values()))
        return monomial.value(self.values) + np.zeros(len(some))

    def all(self) -> list[Suspect]:
        """Without those of angles; each slip once, in its simplest form."""
        found: dict[Any, Suspect] = {}
        for suspect in (*self._factors(), *self._swaps()):
            mark = suspect.print
            if mark and (mark not in found or suspect.cost < found[mark].cost):
                found[mark] = suspect
        return list(found.values())

    def _factors(self) -> Iterator[Suspect]:
        for products, extra in self.groups:
            whole = change_by(products, (self.size[p] for p in products))
            for kind, yours, by, cost in (*PLAIN, *self._counts(products)):
                change = {key: (by - 1) * size for key, size in whole.items()}
                number = None if yours else float(by)
                yield Suspect(kind, products, change, cost + extra, yours, by=number)

    def _counts(self, products: Entry) -> Iterator[tuple[Kind, str, Any, float]]:
        """Factors that are a number of planets, or a ratio, of a joint that these terms concern."""
        joints = {named(symbol).joint for product in products for symbol in product.symbols}
        for symbol, count in self.values.items():
            stem, joint, _ = named(symbol)
            if stem in ("N", "n") and joint in joints:
                yield "factor", symbol, count, 1.25
                yield "factor", f"1/{symbol}", 1 / count, 1.25

    def _swaps(self) -> Iterator[Suspect]:
        for products, extra in self.groups:
            symbols = {symbol for product in products for symbol in product.symbols}
            for symbol in symbols if len(symbols) <= MOST_SHARED or extra <= 0.06 else ():
                yield from self._swapped(products, symbol, extra)

    def _swapped(self, products: Entry, symbol: str, extra: float) -> Iterator[Suspect]:
        """One symbol by another in all these products; in a single one also one of its powers."""
        inside = tuple(p for p in products if symbol in p.symbols)
        own = self.values[symbol]
        rests = [(_without(p.monomial, symbol), dict(p.monomial.powers)[symbol]) for p in inside]
        sizes = [(self._value(rest), power) for rest, power in rests]
        for other in (*self.others[symbol], *self._forms(symbol, single=len(products) == 1)):
            change = change_by(
                inside, (rest * (_power(other.value, p) - _power(own, p)) for rest, p in sizes)
            )
            cost = 1.0 + other.cost + extra
            yield Suspect("swapped", inside, change, cost, other.text, symbol)
        if len(products) == 1 and rests[0][1] >= 2:
            rest = sizes[0][0] * own ** (rests[0][1] - 1)
            fewer = _written(symbol, rests[0][1] - 1)
            for other in (Alternative("", np.ones_like(own), 0.1), *self.others[symbol]):
                change = {inside[0].key: rest * (other.value - own)}
                text = f"{other.text} {fewer}".strip()
                right = _written(symbol, rests[0][1])
                yield Suspect("swapped", inside, change, 1.15 + other.cost + extra, text, right)

    def _forms(self, symbol: str, *, single: bool) -> Iterator[Alternative]:
        """The symbol itself otherwise: its square, nothing, and in several terms its multiples."""
        value = self.values[symbol]
        yield Alternative(f"{symbol}^2", value**2, 0.5)
        yield Alternative("1", np.ones_like(value), 0.45)
        if not single:
            yield Alternative(f"-{symbol}", -value, 0.2)
            yield Alternative(f"2 {symbol}", 2 * value, 0.2)
            yield Alternative(f"{symbol}/2", value / 2, 0.2)

    def angles(self, keys: Sequence[Key]) -> Iterator[Suspect]:
        """Terms before one wave that stand before another of these keys instead."""
        for products, extra in self.groups:
            own = {product.key for product in products}
            if len(own) > 1:
                continue
            (key,) = own
            size = np.sum([self.size[p] for p in products], axis=0)
            for other in keys:
                if other == key:
                    continue
                for sign, cost in ((1, 1.0), (-1, 1.2)):
                    change = {key: -size, other: sign * size}
                    kind: Kind = "swapped" if other.signal != key.signal else "angle"
                    yield Suspect(kind, products, change, cost + extra, by=float(sign), key=other)


def _power(value: Any, power: int) -> Any:
    """A value of 0 has no negative powers: infinite, and so it fits nothing."""
    with np.errstate(divide="ignore"):
        return np.asarray(value, dtype=float) ** power


def _without(monomial: Monomial, symbol: str) -> Monomial:
    return Monomial(monomial.number, tuple(p for p in monomial.powers if p[0] != symbol))


def _written(symbol: str, power: int) -> str:
    return symbol if power == 1 else f"{symbol}^{power}"


def extras(foreign: Iterable[Product], keys: Sequence[Key], values: Values) -> Iterator[Suspect]:
    """Terms of other entries, or of none, before any of these keys, that are one too many."""
    arms = len(next(iter(values.values())))
    for monomial in dict.fromkeys(product.monomial for product in foreign):
        size = monomial.value(values) + np.zeros(arms)
        for key in keys:
            for by, cost in ((1, 0.0), (-1, 0.0), (2, 0.2), (-2, 0.2), (0.5, 0.2), (-0.5, 0.2)):
                product = Product(key, Monomial(monomial.number * Fraction(by), monomial.powers))
                change = {key: by * size}
                yield Suspect("extra", (product,), change, 2.0 + cost + 0.1 * len(monomial.powers))


def generic(values: Values) -> Iterator[Product]:
    """A mass; times a length; times two; an inertia."""
    of = defaultdict(list)
    for symbol in values:
        stem = named(symbol).stem
        kind = "length" if stem in LENGTHS else "mass" if stem[0] in "mM" else "inertia"
        if stem in LENGTHS or stem in INERTIAS or stem[0] in "mM":
            of[kind].append(symbol)
    for inertia in of["inertia"]:
        yield _product(inertia)
    for mass in of["mass"]:
        yield _product(mass)
        for place, first in enumerate(of["length"]):
            yield _product(mass, first)
            for second in of["length"][place:]:
                yield _product(mass, first, second)


LENGTHS = ("L", "d", "r_s", "r_p", "r_c", "r_cp")
INERTIAS = ("I_l", "J_r", "J_m")


def _product(*symbols: str) -> Product:
    powers = tuple(sorted((symbol, symbols.count(symbol)) for symbol in set(symbols)))
    return Product(Key(()), Monomial(1, powers))
