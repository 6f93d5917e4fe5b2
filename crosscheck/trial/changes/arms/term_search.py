"""Finds changes of terms that make the difference of entries, and nothing else, on every arm."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement
from itertools import product as choices

import numpy as np

from crosscheck.trial.changes.arms.letters import (
    GEAR_PARTS,
    RADII,
    STEMS_BY_QUANTITY,
    Values,
    parse_letter,
)
from crosscheck.trial.changes.arms.polynomial import Monomial
from crosscheck.trial.changes.arms.segments import EntryTerms, Product, TermKey
from crosscheck.trial.changes.arms.term_changes import LEVERS, ChangePool, TermChange, TermTable

FITS = 1e-9  # largest residual of a change, relative to the difference
ROUNDING = 1e-11  # largest part of an effect that counts as 0
MOST_PAIRED = 1500
MOST_OTHERS = 6
UNLIKELY = 1.6  # a cost from which a term too many may be as likely
FAR_FETCHED = 0.5  # largest cost above the likeliest explanation's that is reported
MOST_PER_KEY = 8
MOST_WRONG = 4  # waves and signals that are off, for terms of other entries to be tried
USUAL_FACTOR = re.compile(r"(?:1/)?[Nn](\d+)(?:\^2)?")  # a number of planets, a ratio
GEARS = GEAR_PARTS | RADII  # stems of letters
TIMES = ((1, 0.0), (-1, 0.0), (2, 0.2), (-2, 0.2), (0.5, 0.2), (-0.5, 0.2))
ChangeSet = tuple[TermChange, ...]


@dataclass(frozen=True, eq=False)
class Target:
    """What changes must make: differences (A, R) on each arm, and what these may be off.

    table: the terms of the entries, with one arm more, of unrelated numbers; keys: waves and
    signals that may stand where others belong; parts: the difference taken apart by waves (A, R).
    """

    table: TermTable
    difference: np.ndarray
    tolerance: np.ndarray
    keys: Sequence[TermKey]
    parts: Mapping[TermKey, np.ndarray]

    def find_singles(
        self, pool: ChangePool, difference: np.ndarray | None = None
    ) -> list[ChangeSet]:
        """Changes of which each makes a difference, all of it if none is given."""
        wanted = self.difference if difference is None else difference
        arms = len(wanted)
        fits = (np.abs(pool.effects[:, :arms] - wanted) <= self.tolerance).all(axis=(1, 2))
        return [(pool.pick(number),) for number in np.flatnonzero(fits).tolist()]


def search_changes(target: Target, others: Iterable[TermChange] = ()) -> list[ChangeSet]:
    """The changes that make a target, likeliest first: one; one for each wave; two together.

    others: further changes, such as other laws of a mesh.
    """
    pool = target.table.build_pool(target.keys)
    single = target.find_singles(pool) if pool else []
    more = list(others)
    if min(map(cost, single), default=UNLIKELY) >= UNLIKELY and 0 < len(target.parts) <= MOST_WRONG:
        more += _list_extra_terms(target)
    arms = len(target.difference)
    single += [
        (each,)
        for each in more
        if (np.abs(each.effect[:arms] - target.difference) <= target.tolerance).all()
    ]
    found = single or _find_covers(target, pool, more) or _find_pairs(target, pool, more)
    return select_likely(found)


def select_likely(found: Iterable[ChangeSet]) -> list[ChangeSet]:
    """Those of the likeliest kinds, each once, for what does the same on all arms is the same."""
    unique: dict[object, ChangeSet] = {}
    for changes in sorted(found, key=cost):
        unique.setdefault(_fingerprint(changes), changes)
    likely = _merge_equal_factors(list(unique.values()))
    least = cost(likely[0]) if likely else 0.0
    return [each for each in likely if cost(each) <= least + FAR_FETCHED][: MOST_OTHERS + 1]


def cost(changes: ChangeSet) -> float:
    """How far-fetched several changes are together."""
    return sum(change.cost for change in changes)


def _fingerprint(changes: ChangeSet) -> tuple[str, ...]:
    """Total effect on the last arm, whose numbers are unrelated."""
    total = np.sum([change.effect[-1] for change in changes], axis=0)
    size = np.abs(total).max()
    kept = np.where(np.abs(total) > ROUNDING * size, total, 0.0)
    return tuple(f"{number:.8e}" for number in kept)


def _merge_equal_factors(found: Sequence[ChangeSet]) -> list[ChangeSet]:
    """The changes, of factors that are the same number on the arm one alone.

    It is the count or ratio of gears where these are usual, in terms of the same joint's gears, and
    the plain number elsewhere.
    """
    kept: dict[object, ChangeSet] = {}
    for number, changes in enumerate(found):
        key: object = number
        if len(changes) == 1 and changes[0].kind == "factor":
            made = changes[0].effect[0]
            key = changes[0].terms, tuple(f"{entry:.8e}" for entry in made)
        other = kept.get(key)
        if other is None or _factor_rank(changes[0]) < _factor_rank(other[0]):
            kept[key] = changes
    return list(kept.values())


def _factor_rank(change: TermChange) -> int:
    """Rank of a factor by how usual it is in its terms, 0 the most usual."""
    if not change.yours:
        return 1
    match = USUAL_FACTOR.fullmatch(change.yours)
    of_gears = [
        {
            parse_letter(name).joint
            for name in (product.key.signal, *product.letters)
            if name == product.key.signal or parse_letter(name).stem in GEARS
        }
        for product in change.products
    ]
    return 0 if match and all(int(match[1]) in joints for joints in of_gears) else 2


def _find_covers(
    target: Target, pool: ChangePool | None, more: Sequence[TermChange]
) -> list[ChangeSet]:
    """Sets of changes of which each makes the difference before one wave."""
    if pool is None or not 1 < len(target.parts) <= MOST_WRONG:
        return []
    arms = len(target.difference)
    chosen = []
    for part in target.parts.values():
        found = target.find_singles(pool, part)
        found += [
            (each,)
            for each in more
            if (np.abs(each.effect[:arms] - part) <= target.tolerance).all()
        ]
        if not found:
            return []
        chosen.append([each for (each,) in select_likely(found)][:MOST_PER_KEY])
    return list(choices(*chosen)) if len(chosen) <= 3 else [tuple(each[0] for each in chosen)]


def _find_pairs(
    target: Target, pool: ChangePool | None, more: Sequence[TermChange]
) -> list[ChangeSet]:
    """Pairs of changes that make the difference together, found by sorting one side."""
    wanted = target.difference
    shape = (0, *target.difference.shape)
    effects = np.zeros(shape) if pool is None else pool.effects[:, : len(wanted)]
    costs = np.zeros(0) if pool is None else pool.costs
    order = np.argsort(costs, kind="stable")[: 6 * MOST_PAIRED]
    _, first = np.unique(
        effects[order].reshape(len(order), -1).round(12), axis=0, return_index=True
    )
    likeliest = order[np.sort(first)[:MOST_PAIRED]].tolist()
    rows = np.concatenate(
        [
            effects[likeliest],
            np.array([e.effect[: len(wanted)] for e in more]).reshape(-1, *wanted.shape),
        ]
    )
    rows = np.where(np.isfinite(rows), rows, np.inf)
    at = np.unravel_index(np.abs(wanted).argmax(), wanted.shape)
    along = rows[:, at[0], at[1]]
    sorting = np.argsort(along)
    margin = target.tolerance[at]
    low = np.searchsorted(along[sorting], wanted[at] - along - margin, "left")
    high = np.searchsorted(along[sorting], wanted[at] - along + margin, "right")
    found = []

    def pick(number: int) -> TermChange:
        if number >= len(likeliest) or pool is None:
            return more[number - len(likeliest)]
        return pool.pick(likeliest[number])

    for number in np.flatnonzero(high > low).tolist():
        for other in sorting[low[number] : high[number]].tolist():
            if (
                other > number
                and (np.abs(rows[number] + rows[other] - wanted) <= target.tolerance).all()
            ):
                found.append((pick(number), pick(other)))
    return found


def _list_extra_terms(target: Target) -> list[TermChange]:
    """Terms too many, of any entry of the part or of none, that make what is off before a wave."""
    (place,), table = target.table.places, target.table
    entries = table.terms.entries.items()
    foreign = [
        (group, at)
        for at, entry in entries
        if at.part == place.part
        for group in _group_by_wave(entry)
    ]
    weighing = place.part in ("force", "gravity")
    beyond = [(group, None) for group in _generate_products(table.values, weighing=weighing)]
    arms = len(target.difference)
    found = []
    for key, part in target.parts.items():
        column = table.column(place, key)
        with np.errstate(divide="ignore", invalid="ignore"):
            wanted = (part * column[:arms]).sum(axis=1) / (column[:arms] ** 2).sum(axis=1)
        allowed = (target.tolerance / np.abs(column[:arms]).max(axis=1, keepdims=True)).max(axis=1)
        seen = set[object]()
        for group, _at in (*foreign, *beyond):
            monomials = tuple(product.monomial for product in group)
            if monomials in seen:
                continue
            seen.add(monomials)
            size = sum(each.value(table.values) for each in monomials) + np.zeros(arms + 1)
            for by, more in TIMES:
                if (np.abs(by * size[:arms] - wanted) <= allowed + FITS * np.abs(wanted)).all():
                    length = max(len(each.powers) for each in monomials)
                    far = 2.0 + more + 0.1 * length
                    effect = by * size[:, None] * column
                    terms = tuple(
                        (place, Product(key, Monomial(_times(n, by), p))) for n, p in monomials
                    )
                    found.append(TermChange("extra", terms, effect, far))
            found += _find_reactions(target, key, group, size, wanted, allowed)
    return found


def _times(number: float, by: float) -> float:
    whole = number * by
    return int(whole) if whole == round(whole) else whole


def _find_reactions(
    target: Target,
    key: TermKey,
    group: EntryTerms,
    size: np.ndarray,
    wanted: np.ndarray,
    allowed: np.ndarray,
) -> Iterable[TermChange]:
    """Terms that are there with both signs, so nowhere, if one has another lever.

    So a force between two links acts on both; the lever is a length that all of a group have.
    """
    table, arms = target.table, len(target.difference)
    shared = set.intersection(*({*product.monomial.powers} for product in group))
    for name in sorted(name for name, power in shared if power == 1):
        if parse_letter(name).stem not in ("L", "d"):
            continue
        for other in table.values:
            if other != name and parse_letter(other).stem in ("L", "d"):
                made = size * (table.values[other] / table.values[name] - 1)
                for by in (1, -1):
                    if (np.abs(by * made[:arms] - wanted) <= allowed + FITS * np.abs(wanted)).all():
                        terms = tuple(
                            (table.places[0], Product(key, Monomial(by * n, powers)))
                            for _, (n, powers) in group
                        )
                        effect = by * made[:, None] * table.column(table.places[0], key)
                        yield TermChange("swapped", terms, effect, 2.3, other, name)


def _group_by_wave(entry: EntryTerms) -> Iterator[EntryTerms]:
    """Each term of an entry, and all that stand before one wave."""
    yield from ((product,) for product in entry)
    for key in {product.key: None for product in entry}:
        yield tuple(product for product in entry if product.key == key)


def _generate_products(values: Values, *, weighing: bool) -> Iterator[EntryTerms]:
    """Products of a mass and up to two lengths, and inertias; of weights, gravity and a lever."""
    stems = {name: parse_letter(name).stem for name in values}
    lengths = [(name,) for name, stem in stems.items() if stem in LEVERS]
    masses = [name for name, stem in stems.items() if stem in STEMS_BY_QUANTITY["mass"]]
    inertias = [(name,) for name, stem in stems.items() if stem in STEMS_BY_QUANTITY["inertia"]]
    if weighing:
        pulls = [name for name in STEMS_BY_QUANTITY["gravity"] if name in values]
        levers = [(pull, *length) for pull in pulls for length in lengths]
    else:
        pairs = combinations_with_replacement([name for (name,) in lengths], 2)
        levers = [(), *lengths, *pairs]
    for names in (
        *(() if weighing else inertias),
        *((m, *lever) for m in masses for lever in levers),
    ):
        powers = tuple(sorted((name, names.count(name)) for name in set(names)))
        yield (Product(TermKey(()), Monomial(1, powers)),)
