"""Every change that terms of one entry allow, and what it does at the states."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from crosscheck.trial.changes.arms.letters import (
    STEMS_BY_QUANTITY,
    Alternative,
    Values,
    format_power,
    generate_alternatives,
    generate_forms,
    generate_spins,
    parse_letter,
)
from crosscheck.trial.changes.arms.segments import Product, ReferenceTerms, TermKey, evaluate_wave
from crosscheck.trial.judge.entries import EntryPlace, ErrorKind
from crosscheck.trial.judge.unit_mistakes import DEGREES

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


class TermSample(NamedTuple):
    """Where terms are evaluated on one arm, whose quantities by name are values.

    angles (R, joints): joint angles; signals (R,) by name; columns (R,) by entry: what the values
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

    The entries are one of a part, or those of a row of all equations.
    """

    terms: ReferenceTerms
    places: tuple[EntryPlace, ...]
    samples: Sequence[TermSample]

    @cached_property
    def rows(self) -> list[tuple[EntryPlace, Product]]:
        """The terms with their entries."""
        rows = [(place, each) for place in self.places for each in self.terms.entry(place)]
        # A row times any number has the same accelerations: its torque is taken as right.
        is_row = len(self.places) > 1
        return [row for row in rows if not (is_row and row[1].key.signal.startswith("T_"))]

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
                columns.append(sample.columns[place] * wave if place in sample.columns else wave)
            self._kept_columns[at] = np.array(columns)
        return self._kept_columns[at]

    def build_pool(self, keys: Sequence[TermKey]) -> ChangePool | None:
        """All changes; keys: waves and signals that may stand where others belong."""
        if not self.rows:
            return None
        groups = self._list_groups()
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
            if name[0] == "m" and f"I_l{name[1:]}" in letters:
                length = self.values[f"L{name[1:]}"][None, :, None]  # of density and cross-section
                link = mask | letters[f"I_l{name[1:]}"]
                made, yours = (1 / length - 1) * whole, f"m{name[1:]}/L{name[1:]}"
                yield Modifier("swapped", made, link, 1.3, yours, name)
            if self.values[name].all():  # before a bracket
                by = self.values[name][None, :, None]
                yield Modifier("factor", (by - 1) * whole, every, 1.45, name)
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


def _find_place(place: EntryPlace, product: Product) -> tuple[EntryPlace]:
    return (place,)


def _find_weight(place: EntryPlace, product: Product) -> Iterator[str]:
    if any(parse_letter(name).stem in STEMS_BY_QUANTITY["gravity"] for name in product.letters):
        yield WEIGHT


def _find_letters(place: EntryPlace, product: Product) -> tuple[str, ...]:
    return product.letters


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
