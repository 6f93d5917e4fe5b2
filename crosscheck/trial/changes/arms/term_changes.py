"""Every change that terms of one entry allow, and what it does at the states."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import compress
from typing import Any, NamedTuple

import numpy as np

from crosscheck.trial.changes.arms.letters import (
    GEAR_PARTS,
    RADII,
    STEMS_BY_QUANTITY,
    Alternative,
    Values,
    format_power,
    generate_alternatives,
    generate_forms,
    parse_letter,
)
from crosscheck.trial.changes.arms.segments import (
    EntryTerms,
    Product,
    ReferenceTerms,
    TermKey,
    evaluate_wave,
)
from crosscheck.trial.judge.entries import EntryPlace, ErrorKind

FACTORS = (2, 1 / 2, 3, 1 / 3, 4, 1 / 4, -2, -1 / 2, 3 / 2, 2 / 3, 6, 1 / 6, 12, 1 / 12)
PLAIN: tuple[tuple[ErrorKind, float, float], ...] = (
    ("dropped", 0.0, 1.0),
    ("sign", -1.0, 1.0),
    ("factor", FACTORS[0], 1.02),
    # A half is more often a centre of mass where a length belongs.
    *(("factor", by, 1.2 + 0.05 * place) for place, by in enumerate(FACTORS[1:])),
)
UNITS = {180 / np.pi: "{}, its angle in degrees,", np.pi / 180: "{}, its angle times pi/180,"}
LEVERS = ("L", "d", "r_s", "r_p", "r_c", "r_cp")
HUGE = 1e200  # an effect that fits nothing
WEIGHT = "the whole gravity term"
MULTIPLES = 3  # number of multiples of a letter, the last of its forms
MOST_TERMS = 4  # terms that are written out


class TermChange(NamedTuple):
    """A change of terms.

    effect (A, R): on each arm; cost: how far-fetched it is; yours, right: texts of what is swapped;
    key: where the terms of an angle stand instead; group: words for the terms of many entries.
    """

    kind: ErrorKind
    terms: tuple[Product, ...]
    effect: np.ndarray
    cost: float
    yours: str = ""
    right: str = ""
    by: float | None = None
    key: TermKey | None = None
    group: str = ""


@dataclass(frozen=True, eq=False)
class Target:
    """Differences that changes of the terms of an entry must make on several arms.

    Args:
        terms: The terms of all entries.
        place: The entry.
        values: The quantities' numbers by name, (A,) each; at the end those of one arm more, which
            are unrelated, at the states of the first.
        angles: Joint angles at the states (A, R, joints).
        signals: Torques, mesh forces and rates there by name, (A, R) each.
        difference: What changes must make on each arm but the last (A - 1, R).
        tolerance: What these may be off (A - 1, R).
        keys: Waves and signals that may stand where others belong.
        parts: The difference taken apart by waves.
        states: Numbers of the states (R,).
    """

    terms: ReferenceTerms
    place: EntryPlace
    values: Values
    angles: np.ndarray
    signals: Mapping[str, np.ndarray]
    difference: np.ndarray
    tolerance: np.ndarray
    keys: Sequence[TermKey]
    parts: Mapping[TermKey, np.ndarray] = field(default_factory=dict)
    states: Sequence[int] | np.ndarray = ()

    @cached_property
    def rows(self) -> EntryTerms:
        """The terms of the entry."""
        return self.terms.entry(self.place)

    @cached_property
    def coefficients(self) -> np.ndarray:
        """The number before the wave of each term, (P, A)."""
        arms = len(self.angles)
        numbers = [product.monomial.value(self.values) + np.zeros(arms) for product in self.rows]
        return np.array(numbers).reshape(len(self.rows), arms)

    @cached_property
    def waves(self) -> np.ndarray:
        """What is behind the number of each term, (P, A, R)."""
        return np.array([self.column(product.key) for product in self.rows])

    @cached_property
    def _kept_columns(self) -> dict[tuple[TermKey, float], np.ndarray]:
        return {}

    def column(self, key: TermKey, unit: float = 1.0) -> np.ndarray:
        """A wave or signal (A, R), its angle multiplied by a unit."""
        at = key, unit
        if at not in self._kept_columns:
            wave = evaluate_wave(key, self.angles, unit)
            self._kept_columns[at] = wave * self.signals[key.signal] if key.signal else wave
        return self._kept_columns[at]

    def list_changes(self) -> list[TermChange]:
        """All changes of the terms."""
        groups, changes = self._list_groups(), list[TermChange]()
        masks, kept = np.array([mask for mask, *_ in groups]), dict[bytes, Any]()
        for modifier, allowed in self._generate_modifiers() if self.rows else ():
            chosen = masks & allowed
            there = chosen.any(axis=1)
            if modifier.key is not None:
                there &= self._has_single_key(chosen)
            flat = np.nan_to_num(modifier.effect, nan=HUGE, posinf=HUGE, neginf=HUGE)
            made = chosen[there].astype(float) @ flat.reshape(len(self.rows), -1)
            effects = made.reshape(-1, *flat.shape[1:])
            for number, effect in zip(np.flatnonzero(there).tolist(), effects, strict=True):
                mask, (_, cost, words) = chosen[number], groups[number]
                terms = kept.setdefault(mask.tobytes(), tuple(compress(self.rows, mask)))
                if modifier.kind != "dropped" and len(terms) > MOST_TERMS:
                    is_entry = len(terms) == len(self.rows)
                    words = words or "every term" * is_entry
                cost += modifier.cost
                changes.append(
                    modifier._replace(terms=terms, effect=effect, cost=cost, group=words)
                )
        return changes

    def _has_single_key(self, masks: np.ndarray) -> np.ndarray:
        """Which groups have terms before one wave or signal alone."""
        keys = [product.key for product in self.rows]
        numbers = np.array([keys.index(key) for key in keys])
        low = np.where(masks, numbers, len(keys)).min(axis=1)
        return low == np.where(masks, numbers, -1).max(axis=1)

    def _collect(self, name: Any) -> dict[Any, np.ndarray]:
        """Masks of the terms with each of their names."""
        masks: defaultdict[Any, np.ndarray] = defaultdict(lambda: np.zeros(len(self.rows), bool))
        for number, product in enumerate(self.rows):
            for each in name(product):
                masks[each][number] = True
        return dict(masks)

    def _list_groups(self) -> list[tuple[np.ndarray, float, str]]:
        """Terms that one change may concern together: masks, what these cost, and words.

        Each; all; of one wave or letter; of a joint's masses.
        """
        by_key = self._collect(lambda product: (product.key,))
        by_letter = self._collect(lambda product: product.letters)
        shared = [a & b for a in by_letter.values() for b in by_key.values()]
        shared += self._collect(_find_assemblies).values()
        pulls = set(STEMS_BY_QUANTITY["gravity"])
        weights = np.array([not pulls.isdisjoint(product.letters) for product in self.rows])
        groups = [
            *((mask, 0.0, "") for mask in np.eye(len(self.rows), dtype=bool)),
            *([(weights, 0.01, WEIGHT)] if weights.sum() > 1 else []),
            (np.ones(len(self.rows), dtype=bool), 0.02, ""),
            *((mask, 0.04, "") for mask in by_key.values()),
            *((mask, 0.06, "") for mask in by_letter.values()),
            *((mask, 0.12, "") for mask in shared if mask.sum() > 1),
        ]
        return list({group[0].tobytes(): group for group in reversed(groups)}.values())

    def _generate_modifiers(self) -> Iterator[tuple[TermChange, np.ndarray]]:
        """Changes of each term, with effects (P, A, R), and the terms that may have them (P,).

        Factors; letters by others; waves and signals by others; units of angles.
        """
        whole = self.coefficients[..., None] * self.waves
        every, letters = np.ones(len(self.rows), bool), self._collect(lambda row: row.letters)

        def multiply(ratio: Any, powers: Any = 1.0) -> np.ndarray:
            """Effects of a ratio (A,) to powers (P,) or one."""
            raised = np.asarray(ratio) ** np.reshape(powers, (-1, 1)) - 1
            return raised[..., None] * whole

        for kind, by, cost in PLAIN:
            yield TermChange(kind, (), multiply(by), cost, by=by), every
        geared = self._collect(_find_geared_joints)
        for name, value in self.values.items():
            stem, joint, _ = parse_letter(name)
            if stem in ("N", "n") and joint in geared:
                powers = {name: 1.0, f"1/{name}": -1.0, f"{name}^2": 2.0, f"1/{name}^2": -2.0}
                powers |= {f"sqrt({name})": 0.5, f"1/sqrt({name})": -0.5} if stem == "N" else {}
                for text, power in powers.items():
                    cost = 1.25 if abs(power) == 1 else 1.3
                    made = multiply(value, power)
                    yield TermChange("factor", (), made, cost, text), geared[joint]
        for name, mask in letters.items():
            if not self.values[name].all():  # 0 has no ratio to another number
                continue
            for other, right, ratio, exponents in self._generate_swaps(name, mask):
                if ratio.all() or (exponents >= 0).all():  # else it divides by 0
                    made, cost = multiply(ratio, exponents), 1.0 + other.cost
                    yield TermChange("swapped", (), made, cost, other.text, right), exponents != 0
            # Before a bracket.
            yield TermChange("factor", (), multiply(self.values[name]), 1.45, name), every
        for key in self.keys:
            other_waves = self.column(key)
            signals = np.array([product.key.signal != key.signal for product in self.rows])
            for sign, cost in ((1.0, 1.0), (-1.0, 1.2)):
                made = self.coefficients[..., None] * (sign * other_waves - self.waves)
                yield TermChange("angle", (), made, cost, by=sign, key=key), ~signals
                # Rather a term is missing than a signal another.
                yield TermChange("swapped", (), made, cost + 0.4, by=sign, key=key), signals
        turned = np.array([any(product.key.wave) for product in self.rows])
        for unit, words in UNITS.items():
            columns = [self.column(product.key, unit) for product in self.rows]
            made = self.coefficients[..., None] * (np.array(columns) - self.waves)
            yield TermChange("angle", (), made, 1.4, words), turned

    def _generate_swaps(
        self, name: str, mask: np.ndarray
    ) -> Iterator[tuple[Alternative, str, np.ndarray, np.ndarray]]:
        """What may stand for a letter in all its terms, or for one of its powers.

        With each, what belongs there, the ratio (A,) of both, and its power (P,) in the terms.
        """
        value = self.values[name]
        powers = np.array([dict(product.monomial.powers).get(name, 0) for product in self.rows])
        sizes, given = set(powers[mask].tolist()), (name, self.values)
        alternatives = [*generate_alternatives(*given), *generate_forms(*given)]
        # Of one power throughout, a multiple of the letter is but a factor of the terms.
        for other in alternatives if len(sizes) > 1 else alternatives[:-MULTIPLES]:
            yield other, name, other.value / value, powers
        named = [each for each in alternatives if each.text in self.values]
        for power in (each for each in sizes if abs(each) >= 2):
            step = int(np.sign(power))
            fewer, right = (format_power(name, each) for each in (power - step, power))
            for other in (Alternative("", np.ones_like(value), 0.1), *named):
                text, cost = f"{other.text} {fewer}".strip(), other.cost + 0.15
                ratio = other.value / value
                yield Alternative(text, other.value, cost), right, ratio, step * (powers == power)


def _find_geared_joints(product: Product) -> Iterator[int]:
    """Joints whose gears a term has."""
    for name in filter(None, (product.key.signal, *product.letters)):
        stem, joint, _ = parse_letter(name)
        if name == product.key.signal or stem in GEAR_PARTS | RADII:
            yield joint


def _find_assemblies(product: Product) -> Iterator[Any]:
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
