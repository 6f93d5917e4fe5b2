"""Every change that terms of one entry, or of many, allow, and what it does at the states."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from crosscheck.trial.arms.unit_mistakes import DEGREES
from crosscheck.trial.changes.arms.letters import (
    STEMS_BY_QUANTITY,
    Alternative,
    Values,
    format_power,
    generate_alternatives,
    generate_forms,
    generate_spins,
    parse_letter,
    sort_powers,
)
from crosscheck.trial.changes.arms.polynomial import Monomial
from crosscheck.trial.changes.arms.segments import Product, ReferenceTerms, TermKey, evaluate_wave
from crosscheck.trial.judge.entries import EntryPlace, ErrorKind, format_rates

FACTORS = (2, 1 / 2, 3, 1 / 3, 4, 1 / 4, -2, -1 / 2, 3 / 2, 2 / 3, 6, 1 / 6, 12, 1 / 12)
PLAIN: tuple[tuple[ErrorKind, float, float], ...] = (
    ("dropped", 0.0, 1.0),
    ("sign", -1.0, 1.0),
    ("factor", FACTORS[0], 1.02),
    # A half is more often a centre of mass where a length belongs.
    *(("factor", by, 1.2 + 0.05 * place) for place, by in enumerate(FACTORS[1:])),
)
UNITS = {DEGREES: "{}, its angle in degrees,", 1 / DEGREES: "{}, its angle times pi/180,"}
LEVERS = ("L", "d", "r_s", "r_p", "r_c", "r_cp")
HUGE = 1e200  # an effect that fits nothing
WEIGHT = "the weight of every body"
MULTIPLES = 3  # number of multiples of a letter, the last of its forms
MOST_TERMS = 4  # terms that are written out
MOST_EACH = 200  # terms of many entries that are changed one by one, too


class TermSample(NamedTuple):
    """Where terms are evaluated on one arm, whose quantities by name are values.

    angles (K, joints): joint angles; signals (K,) by name; columns (R, K) by entry: what the values
    of an entry at the states are multiplied by, nothing where they are taken as they are.
    """

    values: Mapping[str, float]
    angles: np.ndarray
    signals: Mapping[str, np.ndarray]
    columns: Mapping[EntryPlace, np.ndarray]


class TermChange(NamedTuple):
    """A change of terms.

    effect (A, R): on each arm; cost: how far-fetched it is; yours, right: texts of what is swapped;
    key: where the terms of an angle stand instead; group: words for the terms of many entries.
    """

    kind: ErrorKind
    terms: tuple[tuple[EntryPlace, Product], ...]
    effect: np.ndarray
    cost: float
    yours: str = ""
    right: str = ""
    by: float | None = None
    key: TermKey | None = None
    group: str = ""

    @property
    def products(self) -> tuple[Product, ...]:
        """The terms without their places."""
        return tuple(product for _, product in self.terms)


class Modifier(NamedTuple):
    """A change of each term: effects (P, A, R) of terms of which it is one, ``allowed`` (P,)."""

    kind: ErrorKind
    effects: np.ndarray
    allowed: np.ndarray
    cost: float
    yours: str = ""
    right: str = ""
    by: float | None = None
    key: TermKey | None = None


class TermGroup(NamedTuple):
    """Terms that one change may concern together (P,), how far-fetched that is, and in words."""

    mask: np.ndarray
    cost: float
    words: str = ""


@dataclass(frozen=True, eq=False)
class ChangePool:
    """Changes as rows: effects (C, A, R), costs (C,), and by which modifier of which terms."""

    table: TermTable
    effects: np.ndarray
    costs: np.ndarray
    origins: Sequence[tuple[Modifier, np.ndarray, str]]

    def pick(self, number: int) -> TermChange:
        """One of the changes."""
        modifier, mask, words = self.origins[number]
        terms = tuple(self.table.rows[place] for place in np.flatnonzero(mask))
        kind, _, _, _, yours, right, by, key = modifier
        if words != WEIGHT and len({place for place, _ in terms}) == 1:
            words = "every term" if len(terms) > MOST_TERMS and kind != "dropped" else ""
            words *= len(terms) == len(self.table.terms.entry(terms[0][0]))
        cost = float(self.costs[number])
        return TermChange(kind, terms, self.effects[number], cost, yours, right, by, key, words)


@dataclass(frozen=True, eq=False)
class TermTable:
    """The terms of some entries as columns on several arms, the last with unrelated numbers.

    swaps: pairs of entries, of which terms of the first may stand in the second. has_rows: whether
    the entries are those of a row of all equations, and not of one part.
    """

    terms: ReferenceTerms
    places: tuple[EntryPlace, ...]
    samples: Sequence[TermSample]
    swaps: tuple[tuple[EntryPlace, EntryPlace], ...] = ()
    has_rows: bool = False

    @cached_property
    def rows(self) -> list[tuple[EntryPlace, Product]]:
        """The terms with their entries."""
        rows = [(place, each) for place in self.places for each in self.terms.entry(place)]
        # A row times any number has the same accelerations: its torque is taken as right.
        return [row for row in rows if not (self.has_rows and row[1].key.signal.startswith("T_"))]

    @cached_property
    def is_shared(self) -> bool:
        """Whether the entries are of many rows, or of all of a part."""
        rows = {place.row for place in self.places}
        return len(self.places) > 1 and not (self.has_rows and len(rows) == 1)

    @cached_property
    def values(self) -> Values:
        """The quantities' numbers, (A,) each."""
        names = self.samples[0].values
        return {name: np.array([each.values[name] for each in self.samples]) for name in names}

    @cached_property
    def coefficients(self) -> np.ndarray:
        """The number before the wave of each term, (P, A)."""
        arms = len(self.samples)
        numbers = [product.monomial.value(self.values) + np.zeros(arms) for _, product in self.rows]
        return np.array(numbers).reshape(len(self.rows), arms)

    @cached_property
    def waves(self) -> np.ndarray:
        """What is behind the number of each term, (P, A, R)."""
        return np.array([self.column(place, product.key) for place, product in self.rows])

    @cached_property
    def _kept_columns(self) -> dict[tuple[EntryPlace, TermKey, float], np.ndarray]:
        return {}

    def column(self, place: EntryPlace, key: TermKey, unit: float = 1.0) -> np.ndarray:
        """A wave or signal of an entry (A, R), its angle multiplied by a unit."""
        at = place, key, unit
        if at not in self._kept_columns:
            columns = []
            for sample in self.samples:
                wave = evaluate_wave(key, sample.angles, unit)
                wave = wave * sample.signals[key.signal] if key.signal else wave
                columns.append(sample.columns[place] @ wave if place in sample.columns else wave)
            self._kept_columns[at] = np.array(columns)
        return self._kept_columns[at]

    def build_pool(self, keys: Sequence[TermKey]) -> ChangePool | None:
        """All changes; keys: waves and signals that may stand where others belong."""
        if not self.rows:
            return None
        groups = self._list_shared_groups() if self.is_shared else self._list_groups()
        masks = np.array([group.mask for group in groups])
        extra = np.array([group.cost for group in groups])
        effects, costs = list[np.ndarray](), list[np.ndarray]()
        origins = list[tuple[Modifier, np.ndarray, str]]()
        for modifier in self._generate_modifiers(keys):
            chosen = masks & modifier.allowed
            there = chosen.any(axis=1)
            if modifier.key is not None:
                there &= self._has_single_key(chosen)
            flat = np.nan_to_num(modifier.effects, nan=HUGE, posinf=HUGE, neginf=HUGE)
            flat = flat.reshape(len(self.rows), -1)
            made = chosen[there].astype(float) @ flat
            effects.append(made.reshape(-1, *modifier.effects.shape[1:]))
            costs.append(modifier.cost + extra[there])
            numbers = np.flatnonzero(there).tolist()
            origins += [(modifier, chosen[each], groups[each].words) for each in numbers]
        return ChangePool(self, np.concatenate(effects), np.concatenate(costs), origins)

    def _has_single_key(self, masks: np.ndarray) -> np.ndarray:
        """Which groups have terms before one wave or signal alone."""
        keys = [product.key for _, product in self.rows]
        numbers = np.array([keys.index(key) for key in keys])
        low = np.where(masks, numbers, len(keys)).min(axis=1)
        single: np.ndarray = low == np.where(masks, numbers, -1).max(axis=1)
        return single

    def _collect(self, name: Any) -> dict[Any, np.ndarray]:
        """Masks of the terms with each of their names."""
        masks: defaultdict[Any, np.ndarray] = defaultdict(lambda: np.zeros(len(self.rows), bool))
        for number, (place, product) in enumerate(self.rows):
            for each in name(place, product):
                masks[each][number] = True
        return dict(masks)

    def _list_groups(self) -> list[TermGroup]:
        """Terms of an entry: each; all; of one wave or letter; of a joint's masses."""
        by_key = self._collect(lambda place, product: ((place, product.key),))
        by_letter = self._collect(_find_letters)
        groups = [TermGroup(mask, 0.0) for mask in np.eye(len(self.rows), dtype=bool)]
        weights = [mask for mask in self._collect(_find_weight).values() if mask.sum() > 1]
        groups += [TermGroup(mask, 0.01, WEIGHT) for mask in weights]
        groups += [TermGroup(mask, 0.02) for mask in self._collect(_find_place).values()]
        groups += [TermGroup(mask, 0.04) for mask in by_key.values()]
        groups += [TermGroup(mask, 0.06) for mask in by_letter.values()]
        shared = [a & b for a in by_letter.values() for b in by_key.values()]
        shared += self._collect(_find_assemblies).values()
        groups += [TermGroup(mask, 0.12) for mask in shared if mask.sum() > 1]
        return list({group.mask.tobytes(): group for group in reversed(groups)}.values())

    def _list_shared_groups(self) -> list[TermGroup]:
        """Terms of many entries: all; of a part or row, of products of rates, of some letters."""
        names = self.terms.names
        groups = [TermGroup(mask, 0.1) for mask in np.eye(len(self.rows), dtype=bool)]
        groups = groups if len(groups) <= MOST_EACH else []
        named = [(_find_weight, 0.0), (_find_part, 0.0), (_find_rates, 0.05)]
        if not self.has_rows:
            named += [(lambda place, product: (f"every term of row {names[place.row]}",), 0.04)]
        for name, cost in named:
            groups += [TermGroup(mask, cost, words) for words, mask in self._collect(name).items()]
        masks = [(mask, 0.06) for mask in self._collect(_find_letters).values()]
        masks += [(mask, 0.07) for mask in self._collect(_find_pairs).values()]
        masks += [(mask, 0.08) for mask in self._collect(_find_segment).values()]
        groups += [TermGroup(mask, cost, self._name_group(mask)) for mask, cost in masks]
        return list({group.mask.tobytes(): group for group in reversed(groups)}.values())

    def _name_group(self, mask: np.ndarray) -> str:
        """Terms by the letters that all of them have, with their least powers."""
        powers = [dict(self.rows[n][1].monomial.powers) for n in np.flatnonzero(mask).tolist()]
        shared = {name: min(each.get(name, 0) for each in powers) for name in powers[0]}
        kept = sort_powers((name, power) for name, power in shared.items() if power > 0)
        if not kept:
            return ""
        words = f"every term with {' '.join(format_power(*each) for each in kept)}"
        (stem, joint, _), *others = (parse_letter(name) for name, _ in kept)
        if [each.stem in STEMS_BY_QUANTITY["gravity"] for each in others] == [True]:
            owner = {"m": f"link {joint}", "m_payload": "the payload"}.get(stem)
            words += f", the weight of {owner}" if owner else ""
        return words

    def _generate_modifiers(self, keys: Sequence[TermKey]) -> Iterator[Modifier]:
        """Factors; letters by others; waves and signals by others; units of angles."""
        whole = self.coefficients[..., None] * self.waves
        every = np.ones(len(self.rows), dtype=bool)
        for kind, by, cost in PLAIN:
            yield Modifier(kind, (by - 1) * whole, every, cost, by=by)
        concerned = self._collect(_find_joints)
        for name, value in self.values.items():
            stem, joint, _ = parse_letter(name)
            if stem in ("N", "n") and joint in concerned:
                powers = {name: 1.0, f"1/{name}": -1.0, f"{name}^2": 2.0, f"1/{name}^2": -2.0}
                powers |= {f"sqrt({name})": 0.5, f"1/sqrt({name})": -0.5} if stem == "N" else {}
                for text, power in powers.items():
                    by = (value**power)[None, :, None]
                    cost = 1.25 if abs(power) == 1 else 1.3
                    yield Modifier("factor", (by - 1) * whole, every, cost, text)
        letters = self._collect(_find_letters)
        for name, mask in letters.items():
            yield from self._generate_swaps(name, mask, whole)
            if self.is_shared and name[0] == "m" and f"I_l{name[1:]}" in letters:
                length = self.values[f"L{name[1:]}"][None, :, None]  # of density and cross-section
                link = mask | letters[f"I_l{name[1:]}"]
                made, yours = (1 / length - 1) * whole, f"m{name[1:]}/L{name[1:]}"
                yield Modifier("swapped", made, link, 1.3, yours, name)
            if not self.is_shared and self.values[name].all():  # before a bracket
                by = self.values[name][None, :, None]
                yield Modifier("factor", (by - 1) * whole, every, 1.45, name)
        if self.is_shared:
            yield from self._generate_exchanges(letters, whole)
            yield from self._generate_other_gears(whole)
            yield from self._generate_moves()
        for key in keys:
            other = np.array([self.column(place, key) for place, _ in self.rows])
            signals = np.array([product.key.signal != key.signal for _, product in self.rows])
            for sign, cost in ((1.0, 1.0), (-1.0, 1.2)):
                made = self.coefficients[..., None] * (sign * other - self.waves)
                for kind, allowed, more in (("angle", ~signals, 0.0), ("swapped", signals, 0.4)):
                    if allowed.any():  # rather a term is missing than a signal another
                        yield Modifier(kind, made, allowed, cost + more, by=sign, key=key)
        turned = np.array([any(product.key.wave) for _, product in self.rows])
        for unit, words in UNITS.items() if turned.any() else ():
            other = np.array(
                [self.column(place, product.key, unit) for place, product in self.rows]
            )
            made = self.coefficients[..., None] * (other - self.waves)
            yield Modifier("angle", made, turned, 1.4, words)

    def _generate_swaps(self, name: str, mask: np.ndarray, whole: np.ndarray) -> Iterator[Modifier]:
        """A letter by another in all its terms; of more than one power also by one of them."""
        value = self.values[name]
        powers = np.array([dict(product.monomial.powers).get(name, 0) for _, product in self.rows])
        sizes = set(powers[mask].tolist())
        alternatives = [
            *generate_alternatives(name, self.values),
            *generate_forms(name, self.values),
        ]
        # Of one power throughout, a multiple of the letter is but a factor of the terms.
        for other in alternatives if len(sizes) > 1 else alternatives[:-MULTIPLES]:
            yield self._swap(other, name, mask, whole, powers)
        for belongs, other in generate_spins(name, self.values):
            radius = f"r_cp{parse_letter(name).joint}"
            spins = [dict(product.monomial.powers).get(radius, 0) for _, product in self.rows]
            there = mask & (np.array(spins) != 0)
            if there.any():
                ratio = (1 + 0 * value) * other.value
                yield self._swap(
                    other._replace(value=ratio), belongs, there, whole, np.array(spins), 1.0
                )
        if len(sizes) == 1 and abs(power := sizes.pop()) >= 2:
            step = int(np.sign(power))
            named = [each for each in alternatives if each.text in self.values]
            lower = Alternative("", np.ones_like(value), 0.1)
            fewer, right = (format_power(name, each) for each in (power - step, power))
            for other in (lower, *named):
                text = f"{other.text} {fewer}".strip()
                alone = other._replace(text=text, cost=other.cost + 0.15)
                yield self._swap(alone, right, mask, whole, step * (powers != 0), value)

    def _swap(
        self,
        other: Alternative,
        right: str,
        mask: np.ndarray,
        whole: np.ndarray,
        powers: np.ndarray,
        value: Any = None,
    ) -> Modifier:
        """One quantity by another, to these powers, in the terms of a mask."""
        value = self.values[right] if value is None else value
        with np.errstate(divide="ignore", invalid="ignore"):
            effects = self._raise(np.asarray(other.value) / value, powers)[..., None] * whole
        effects[~mask] = 0.0
        return Modifier("swapped", effects, mask, 1.0 + other.cost, other.text, right)

    def _raise(self, ratio: np.ndarray, powers: np.ndarray) -> np.ndarray:
        """Powers (P,) of a ratio (A,), less 1 (P, A); a power of 0 is one that fits nothing."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            raised = ratio[None, :] ** powers[:, None].astype(float) - 1
        return np.nan_to_num(raised, nan=HUGE, posinf=HUGE, neginf=HUGE)

    def _generate_exchanges(
        self, letters: Mapping[str, np.ndarray], whole: np.ndarray
    ) -> Iterator[Modifier]:
        """Two letters of a kind, each in the place of the other."""
        powers = [dict(product.monomial.powers) for _, product in self.rows]
        for first, second in combinations(letters, 2):
            if _are_exchangeable(first, second):
                with np.errstate(divide="ignore", invalid="ignore"):
                    ratio = self.values[second] / self.values[first]
                net = np.array([each.get(first, 0) - each.get(second, 0) for each in powers])
                effects = self._raise(ratio, net)[..., None] * whole
                mask = letters[first] | letters[second]
                yield Modifier("exchanged", effects, mask, 1.4, first, second)

    def _generate_moves(self) -> Iterator[Modifier]:
        """Terms of the bias before other rates or in another row."""
        names, bias = self.terms.names, [place for place, _ in self.rows]
        for here, there in self.swaps:
            allowed = np.array([place == here for place in bias])
            in_row = here.row == there.row
            if allowed.any() and (in_row or here.rates == there.rates):
                yours, right = (
                    format_rates(each.rates or (0, 0), names)
                    if in_row
                    else f"row {names[each.row]}"
                    for each in (there, here)
                )
                made = self._move(dict.fromkeys([here], there))
                yield Modifier("swapped", made, allowed, 1.1, yours, right)

    def _move(self, places: Mapping[EntryPlace, EntryPlace]) -> np.ndarray:
        """Effects (P, A, R) of terms that stand in other entries instead."""
        waves = [
            self.column(places[place], product.key) - wave if place in places else 0 * wave
            for (place, product), wave in zip(self.rows, self.waves, strict=True)
        ]
        return self.coefficients[..., None] * np.array(waves)

    def _generate_other_gears(self, whole: np.ndarray) -> Iterator[Modifier]:
        """What the gears of a joint reflect by the numbers of another joint; both exchanged."""
        reflecting = self._collect(
            lambda place, product: filter(None, [find_reflecting_joint(product)])
        )
        words = "the reflected inertia of joint {}"
        for here, there in combinations(reflecting, 2):
            effects = {}
            for joint, other in ((here, there), (there, here)):
                effects[joint] = 0 * whole
                for number in np.flatnonzero(reflecting[joint]).tolist():
                    product = self.rows[number][1]
                    powers = tuple(
                        (f"{parse_letter(n).stem}{other}", p) for n, p in product.monomial.powers
                    )
                    value = Monomial(product.monomial.number, powers).value(self.values)
                    change = (value - self.coefficients[number])[:, None]
                    effects[joint][number] = change * self.waves[number]
                yours, right = words.format(other), words.format(joint)
                yield Modifier("swapped", effects[joint], reflecting[joint], 1.5, yours, right)
            mask, both = reflecting[here] | reflecting[there], effects[here] + effects[there]
            yield Modifier("exchanged", both, mask, 1.5, words.format(here), words.format(there))


def _find_place(place: EntryPlace, product: Product) -> tuple[EntryPlace]:
    return (place,)


def _find_part(place: EntryPlace, product: Product) -> tuple[str]:
    return (f"the whole {place.part.replace('mass_matrix', 'M')}",)


def _find_rates(place: EntryPlace, product: Product) -> Iterator[str]:
    if place.rates is not None:
        j, k = place.rates
        words = "the squares of rates" if j == k else "the products of two rates"
        yield f"all of {words} in the bias"


def _find_weight(place: EntryPlace, product: Product) -> Iterator[str]:
    if any(parse_letter(name).stem in STEMS_BY_QUANTITY["gravity"] for name in product.letters):
        yield WEIGHT


def _find_letters(place: EntryPlace, product: Product) -> tuple[str, ...]:
    return product.letters


def _find_pairs(place: EntryPlace, product: Product) -> Iterator[tuple[str, ...]]:
    """A body's mass and one of its levers."""
    stems = {name: parse_letter(name).stem for name in product.letters}
    masses = [name for name, stem in stems.items() if stem in STEMS_BY_QUANTITY["mass"]]
    yield from ((mass, name) for mass in masses for name in stems if name != mass)


def _find_segment(place: EntryPlace, product: Product) -> Iterator[Any]:
    """A body's mass and levers, in whatever entry they stand."""
    if len(product.letters) > 1 and not product.key.signal:
        yield product.monomial.powers


def _find_joints(place: EntryPlace, product: Product) -> set[int]:
    """Joints whose gears may concern a term."""
    names = (*product.letters, *filter(None, [product.key.signal]))
    return {parse_letter(name).joint for name in names}


def _find_assemblies(place: EntryPlace, product: Product) -> Iterator[Any]:
    """Masses of one joint's bodies but links, before the same lever; all that its gears reflect."""
    masses = [parse_letter(s) for s in product.letters if s[0] == "m" and s != "m_payload"]
    if masses and masses[0].stem != "m":
        powers = product.monomial.powers
        lever = tuple(each for each in powers if parse_letter(each[0]).stem in LEVERS)
        yield masses[0].joint, lever, product.key
    if joint := find_reflecting_joint(product):
        yield joint, "reflected", product.key


def find_reflecting_joint(product: Product) -> int:
    """The joint whose sun or planets a term reflects; 0 of any other term."""
    letters = map(parse_letter, product.letters)
    return next((each.joint for each in letters if each.stem in ("M_s", "M_p")), 0)


def _are_exchangeable(first: str, second: str) -> bool:
    stems = {parse_letter(first).stem, parse_letter(second).stem}
    return len(stems) == 1 or stems <= {"L", "d"} or stems == {"m", "m_payload"}
