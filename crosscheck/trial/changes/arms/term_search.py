"""Finds changes of terms that make the difference of entries, and nothing else, on every arm."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations_with_replacement

import numpy as np

from crosscheck.trial.changes.arms.comparison import EntryComparison
from crosscheck.trial.changes.arms.letters import (
    STEMS_BY_QUANTITY,
    Values,
    draw_unrelated_values,
    parse_letter,
)
from crosscheck.trial.changes.arms.polynomial import Monomial, Number
from crosscheck.trial.changes.arms.segments import EntryTerms, Product, TermKey
from crosscheck.trial.changes.arms.term_changes import LEVERS, Target, TermChange
from crosscheck.trial.changes.arms.waves import list_keys
from crosscheck.trial.changes.pairs import rank_pairs
from crosscheck.trial.judge.entries import EntryPlace, ErrorKind

FITS = 1e-9  # largest residual of a change, relative to the difference
ROUNDING = 1e-11  # largest part of an effect that counts as 0
MOST_PAIRED = 1500
LARGEST = 1e3  # largest effect of a change in a pair, over the difference
MOST_OTHERS = 6
UNLIKELY = 1.6  # a cost from which a term too many may be as likely
FAR_FETCHED = 0.5  # largest cost above the likeliest explanation's that is reported
MOST_WRONG = 4  # waves and signals that are off, for terms of other entries to be tried
TIMES = ((1, 0.0), (-1, 0.0), (2, 0.2), (-2, 0.2), (0.5, 0.2), (-0.5, 0.2))
ChangeSet = tuple[TermChange, ...]
FEW_STATES = 12  # states at which changes are tried; of forces, which may have branches, more
MOST_STATES = 60


def search_changes(target: Target, others: Sequence[TermChange] = ()) -> list[ChangeSet]:
    """The changes that make a target, likeliest first: one, else two together.

    others: further changes, such as other laws of a mesh.
    """
    if not target.difference.any():
        return []
    changes = [*target.list_changes(), *others]
    single = find_singles(target, changes)
    is_open = min(map(cost, single), default=UNLIKELY) >= UNLIKELY
    if is_open and 0 < len(target.parts) <= MOST_WRONG:
        changes += list_extra_terms(target)
        single = find_singles(target, changes)
    return select_likely(single or _find_pairs(target, changes))


def find_singles(target: Target, changes: Sequence[TermChange]) -> list[ChangeSet]:
    """Changes of which each makes the difference."""
    off = np.abs(_stack(target, changes) - target.difference) <= target.tolerance
    return [(changes[number],) for number in np.flatnonzero(off.all(axis=(1, 2))).tolist()]


def _stack(target: Target, changes: Sequence[TermChange]) -> np.ndarray:
    """What changes make of a target (changes, arms, states)."""
    effects = [each.effect[: len(target.difference)] for each in changes]
    return np.array(effects).reshape(-1, *target.difference.shape)


def select_likely(sets: Iterable[ChangeSet]) -> list[ChangeSet]:
    """Those of the likeliest kinds, each once, for what does the same on all arms is the same.

    Of factors of the same terms that are one number on the first arm there is one: a count or ratio
    of gears, else the number.
    """
    unique: dict[object, ChangeSet] = {}
    for changes in sorted(sets, key=cost):
        unique.setdefault(_fingerprint(changes), changes)
    likely: dict[object, ChangeSet] = {}
    for changes in unique.values():
        first, *others = changes
        key: object = id(changes)
        if first.kind == "factor" and not others:
            key = first.terms, tuple(f"{entry:.8e}" for entry in first.effect[0])
        if key not in likely or _factor_rank(first) < _factor_rank(likely[key][0]):
            likely[key] = changes
    least = cost(next(iter(likely.values()))) if likely else 0.0
    close = [each for each in likely.values() if cost(each) <= least + FAR_FETCHED]
    return close[: MOST_OTHERS + 1]


def _factor_rank(change: TermChange) -> int:
    """Rank of a factor by how usual it is, 0 the most usual."""
    is_root = "sqrt" in change.yours
    return 1 + is_root if is_root or not change.yours else 0


def cost(changes: ChangeSet) -> float:
    """How far-fetched several changes are together."""
    return sum(change.cost for change in changes)


def _fingerprint(changes: ChangeSet) -> tuple[str, ...]:
    """Total effect on the last arm, whose numbers are unrelated."""
    total = np.sum([change.effect[-1] for change in changes], axis=0)
    size = np.abs(total).max()
    kept = np.where(np.abs(total) > ROUNDING * size, total, 0.0)
    return tuple(f"{number:.8e}" for number in kept)


def _find_pairs(target: Target, changes: Sequence[TermChange]) -> list[ChangeSet]:
    """Pairs of the likeliest changes that make the difference together."""
    likely = sorted(changes, key=lambda change: change.cost)
    effects, goal = _stack(target, likely), target.difference.ravel()
    rows = effects.reshape(len(likely), goal.size)
    is_part = np.abs(rows).max(axis=1, initial=0.0) <= LARGEST * np.abs(goal).max()
    unique = np.unique(rows[is_part].round(12), axis=0, return_index=True)[1]
    kept = np.flatnonzero(is_part)[np.sort(unique)][:MOST_PAIRED]
    pairs = rank_pairs(rows[kept], np.zeros(len(kept), bool), goal, kept)
    both = [(int(kept[first]), int(kept[second])) for first, second, _ in pairs]
    return [
        (likely[first], likely[second])
        for first, second in both
        if (np.abs(rows[first] + rows[second] - goal) <= target.tolerance.ravel()).all()
    ]


def list_extra_terms(target: Target) -> list[TermChange]:
    """Extra terms, of any entry of the part or of none, that explain a wave's coefficient."""
    place, arms = target.place, len(target.difference)
    weighing = place.part in ("force", "gravity")
    same_part = (entry for at, entry in target.terms.entries.items() if at.part == place.part)
    groups = [group for entry in same_part for group in _group_by_wave(entry)]
    groups += _generate_products(target.values, weighing=weighing)
    unique = {tuple(product.monomial for product in group): None for group in groups}
    extras = []
    for key, part in target.parts.items():
        column = target.column(key)
        strongest = np.abs(column[:arms]).argmax(axis=1)
        goal, unit = (each[np.arange(arms), strongest] for each in (part, column[:arms]))
        allowed = target.tolerance[:, 0] + FITS * np.abs(goal)
        for monomials in unique:
            size = sum(each.value(target.values) for each in monomials) + np.zeros(arms + 1)
            for kind, by, made, cost, yours, right in _list_forms(monomials, size, target.values):
                if (np.abs(made[:arms] * unit - goal) <= allowed).all():
                    terms = tuple(
                        Product(key, Monomial(_multiply(number, by), powers))
                        for number, powers in monomials
                    )
                    effect = made[:, None] * column
                    extras.append(TermChange(kind, terms, effect, cost, yours, right))
    return extras


def _list_forms(
    monomials: Sequence[Monomial], size: np.ndarray, values: Values
) -> Iterator[tuple[ErrorKind, float, np.ndarray, float, str, str]]:
    """What terms make that are there by a usual factor; or with both signs, one's lever another.

    So a force between two links acts on both; the lever is a length that all of a group have.
    """
    length = max(len(each.powers) for each in monomials)
    for by, more in TIMES:
        yield "extra", by, by * size, 2.0 + more + 0.1 * length, "", ""
    for name, power in sorted(set.intersection(*({*each.powers} for each in monomials))):
        if power == 1 and parse_letter(name).stem in ("L", "d") and values[name].all():
            for other in values:
                if other != name and parse_letter(other).stem in ("L", "d"):
                    made = size * (values[other] / values[name] - 1)
                    yield "swapped", 1, made, 2.3, other, name
                    yield "swapped", -1, -made, 2.3, other, name


def _multiply(number: Number, by: float) -> Number:
    product = number * by
    return int(product) if product == round(product) else product


def _group_by_wave(entry: EntryTerms) -> Iterator[EntryTerms]:
    """Each term of an entry, and all that stand before one wave."""
    yield from ((product,) for product in entry)
    for key in {product.key: None for product in entry}:
        yield tuple(product for product in entry if product.key == key)


def _generate_products(values: Values, *, weighing: bool) -> Iterator[EntryTerms]:
    """Products of a mass and up to two lengths, and inertias; of weights, gravity and a lever."""
    stems = {name: parse_letter(name).stem for name in values}
    lengths: list[tuple[str, ...]] = [(name,) for name, stem in stems.items() if stem in LEVERS]
    masses = [name for name, stem in stems.items() if stem in STEMS_BY_QUANTITY["mass"]]
    inertias = [(name,) for name, stem in stems.items() if stem in STEMS_BY_QUANTITY["inertia"]]
    if weighing:
        pulls = [name for name in STEMS_BY_QUANTITY["gravity"] if name in values]
        levers = [(pull, *length) for pull in pulls for length in lengths]
    else:
        pairs = combinations_with_replacement([name for name, *_ in lengths], 2)
        levers = [(), *lengths, *pairs]
    for names in (
        *(() if weighing else inertias),
        *((m, *lever) for m in masses for lever in levers),
    ):
        powers = tuple(sorted((name, names.count(name)) for name in set(names)))
        yield (Product(TermKey(()), Monomial(1, powers)),)


def make_entry_target(arms: Sequence[EntryComparison], place: EntryPlace) -> Target:
    """What changes must make of one entry on every arm, at some states."""
    target = _make_target(arms, place)
    fits = [arm.fit_waves(place) or {} for arm in arms]
    keys = dict.fromkeys(key for fit in fits for key in fit) if fits[0] else {}
    numbers = {key: np.array([[fit.get(key, 0.0)] for fit in fits]) for key in keys}
    columns = {key: target.column(key)[: len(arms)] for key in keys}
    return replace(target, parts={key: numbers[key] * columns[key] for key in keys})


def _make_target(arms: Sequence[EntryComparison], place: EntryPlace) -> Target:
    """What changes must make of an entry of each arm at some states.

    These are the first, corners at the end, and the worst.
    """
    terms, differences = arms[0].terms, [arm.difference(place)[0] for arm in arms]
    assert terms is not None  # else nobody asks
    count = min(map(len, differences))
    half = (MOST_STATES if place.part == "force" else FEW_STATES) // 2
    worst = int(np.abs(differences[0][:count]).argmax())
    few = np.unique([*range(min(count, half)), *range(max(count - half, 0), count), worst])
    present = [n for n in arms[0].values if any(each.values[n] for each in arms)]
    unrelated, sides = draw_unrelated_values(present), [*arms, arms[0]]
    numbers = [*(arm.values for arm in arms), unrelated]
    values = {name: np.array([each[name] for each in numbers]) for name in present}
    angles = np.array([arm.angles[few] for arm in sides])
    names = arms[0].signals
    signals = {name: np.array([arm.signals[name][few] for arm in sides]) for name in names}
    terms = terms.drop_letters({*arms[0].values} - {*present})
    goals = np.array([difference[few] for difference in differences])
    allowed = FITS * np.abs(goals).max(axis=1) + [arm.noise(place) for arm in arms]
    keys, tolerance = list_keys(terms, names, place.part), allowed[:, None] + 0 * goals
    at = values, angles, signals
    return Target(terms, place, *at, goals, tolerance, keys, states=few)
