"""Finds errors of terms that explain the difference of a wrong entry, and nothing else.

An error is believed if it makes every coefficient of the difference, on every arm that was tried,
to the rounding of the data. Of several the likeliest comes first; the others that the arms cannot
distinguish from it are reported too.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import product as combinations
from typing import NamedTuple

import numpy as np

from crosscheck.trial.diagnose.terms.candidates import (
    Candidate,
    CandidateSet,
    generate_extras,
    generate_products,
    generate_reactions,
    group_by_wave,
)
from crosscheck.trial.diagnose.terms.harmonic_fit import HarmonicFit
from crosscheck.trial.diagnose.terms.messages import make_term_error
from crosscheck.trial.diagnose.terms.polynomial import TermKey
from crosscheck.trial.diagnose.terms.reference_terms import ReferenceTerms
from crosscheck.trial.diagnose.terms.values import (
    GEAR_PARTS,
    RADII,
    Values,
    draw_unrelated_values,
    parse_symbol,
)
from crosscheck.trial.judge.entries import EntryMismatch, EntryPlace, Explanation, TermError

ROUNDING = 1e-11  # rounding of a coefficient's difference, in addition to the noise of its fit
NOISES = 8  # standard errors that a coefficient may be off
UNEXPLAINED = 1e-6  # largest share of a difference outside all waves that terms may explain
MOST_PAIRED = 1000
MOST_OTHERS = 6
UNLIKELY = 1.6  # a cost from which a term too many may be as likely
FAR_FETCHED = 0.5  # largest cost above the likeliest explanation's that is reported
MOST_PER_KEY = 8
MOST_WRONG = 4  # waves and signals that are off, for terms of other entries to be tried
TOO_NOISY = 1e-7  # relative: with more, two errors at once fit almost anything
USUAL_FACTOR = re.compile(r"(?:1/)?[Nn](\d+)(?:\^2)?")  # a number of planets, a ratio
GEARS = GEAR_PARTS | RADII  # stems of symbols
FOLLOWS = 1e-9  # tolerance of a bias entry's difference, in addition to its noise
Entries = Mapping[tuple[int, int], Mapping[TermKey, float]]


class Target(NamedTuple):
    """The difference of an entry that errors must explain, over keys and arms.

    difference, tolerance (keys, arms): the difference and what it may be off; wrong (keys,): where
    it is not 0.
    """

    keys: tuple[TermKey, ...]
    difference: np.ndarray
    tolerance: np.ndarray
    wrong: np.ndarray

    def select_keys(self, keys: np.ndarray) -> Target:
        """The target at some of its keys, the rest being made by other errors."""
        chosen = tuple(key for key, there in zip(self.keys, keys, strict=True) if there)
        return Target(chosen, self.difference[keys], self.tolerance[keys], self.wrong[keys])


ErrorSet = tuple[Candidate, ...]


def explain(
    place: EntryPlace, observed: Sequence[HarmonicFit], terms: ReferenceTerms
) -> Explanation | None:
    """An explanation by errors that make the difference on all arms; None if no few do."""
    target = build_target(observed)
    if not target.wrong.any() or max(each.left_over for each in observed) > UNEXPLAINED:
        return None
    # What every arm has none of can neither be missing nor stand where something else belongs.
    present = [name for name in observed[0].values if any(each.values[name] for each in observed)]
    arms = [*(each.values for each in observed), draw_unrelated_values(observed[0].values)]
    values = {name: np.array([arm[name] for arm in arms]) for name in present}
    terms = terms.drop_symbols(set(observed[0].values) - set(present))
    unique: dict[object, ErrorSet] = {}  # what does the same on all arms is the same
    for errors in sorted(search_errors(target, place, terms, values), key=_cost):
        unique.setdefault(_fingerprint(errors), errors)
    likely = list(unique.values())
    if not likely:
        return None
    likely = _merge_equal_factors(likely)
    explanations = [errors for errors in likely if _cost(errors) <= _cost(likely[0]) + FAR_FETCHED]
    first, *others = (
        tuple(make_term_error(each, terms) for each in errors) for errors in explanations
    )
    made = build_change_table(target, explanations[0]).sum(axis=0)
    size = float(np.linalg.norm(target.difference))
    left = float(np.linalg.norm(target.difference - made)) / size
    left = max(left, *(each.left_over for each in observed))
    return Explanation(first, left, tuple(others[:MOST_OTHERS]))


def _merge_equal_factors(explanations: Sequence[ErrorSet]) -> list[ErrorSet]:
    """The explanations, of factors that are the same number on the arm one alone.

    It is the count or ratio of gears where these are usual, in terms of the same joint's gears, and
    the plain number elsewhere.
    """
    kept: dict[object, ErrorSet] = {}
    for number, errors in enumerate(explanations):
        key: object = number
        if len(errors) == 1 and errors[0].kind == "factor":
            (error,) = errors
            made = {wave: f"{change[0]:.9e}" for wave, change in error.change.items()}
            key = error.products, tuple(made.items())
        other = kept.get(key)
        if other is None or _factor_rank(errors[0]) < _factor_rank(other[0]):
            kept[key] = errors
    return list(kept.values())


def _factor_rank(error: Candidate) -> int:
    """Rank of a factor by how usual it is in its terms, 0 the most usual."""
    if not error.user_text:
        return 1
    match = USUAL_FACTOR.fullmatch(error.user_text)
    of_gears = [
        {
            parse_symbol(symbol).joint
            for symbol in (product.key.signal, *product.symbols)
            if symbol == product.key.signal or parse_symbol(symbol).stem in GEARS
        }
        for product in error.products
    ]
    return 0 if match and all(int(match[1]) in joints for joints in of_gears) else 2


def _fingerprint(errors: ErrorSet) -> frozenset[tuple[TermKey, str]]:
    """Total change by several errors on the last arm, whose numbers are unrelated."""
    total = defaultdict[TermKey, float](float)
    for error in errors:
        for key, change in error.change.items():
            total[key] += change[-1]
    nothing = ROUNDING * max(map(abs, total.values()))
    return frozenset((key, f"{value:.9e}") for key, value in total.items() if abs(value) > nothing)


def build_target(observed: Sequence[HarmonicFit]) -> Target:
    """The target of one entry, observed on several arms."""
    keys = tuple(dict.fromkeys(key for each in observed for key in each.coefficients))
    table = [[each.coefficients.get(key, 0.0) for each in observed] for key in keys]
    noise = [[each.noise.get(key, 0.0) for each in observed] for key in keys]
    shape = len(keys), len(observed)
    difference = np.array(table).reshape(shape)
    tolerance = NOISES * np.array(noise).reshape(shape) + ROUNDING * np.abs(difference)
    wrong = (np.abs(difference) > 2 * tolerance).any(axis=1)
    return Target(keys, difference, tolerance, wrong)


def search_errors(
    target: Target, place: EntryPlace, terms: ReferenceTerms, values: Values
) -> list[ErrorSet]:
    """The errors that make a target: one; else one for each part of it; else two together.

    An error is one in the entry's own terms, or a term that does not belong there.
    """
    of_entry = CandidateSet(terms.entry(place), values)
    wrong_keys = [key for key, wrong in zip(target.keys, target.wrong, strict=True) if wrong]
    candidates = [*of_entry.list_term_candidates(), *of_entry.generate_angle_candidates(wrong_keys)]
    changes = build_change_table(target, candidates)
    single = _find_singles(target, candidates, changes)
    if min(map(_cost, single), default=UNLIKELY) >= UNLIKELY and len(wrong_keys) <= MOST_WRONG:
        same_part = (entry for other, entry in terms.entries.items() if other.part == place.part)
        foreign = [group for entry in same_part for group in group_by_wave(entry)]
        beyond = generate_products(values, weighing=place.part in ("force", "gravity"))
        fits_by_key = {
            key: partial(_fitting_changes, target, row)
            for row, key in enumerate(target.keys)
            if target.wrong[row]
        }
        candidates += generate_extras([*foreign, *beyond], fits_by_key, values)
        candidates += generate_reactions(foreign, fits_by_key, values)
        changes = build_change_table(target, candidates)
        single = _find_singles(target, candidates, changes)
    return (
        single
        or find_covers(target, candidates, changes)
        or find_pairs(target, candidates, changes)
    )


def _find_singles(
    target: Target, candidates: Sequence[Candidate], changes: np.ndarray
) -> list[ErrorSet]:
    fits = (np.abs(changes - target.difference) <= target.tolerance).all(axis=(1, 2))
    return [(candidates[number],) for number in np.flatnonzero(fits).tolist()]


def _fitting_changes(target: Target, row: int, changes: np.ndarray) -> np.ndarray:
    """Mask of the changes (terms, arms) that explain the difference at one key."""
    arms = target.difference.shape[1]
    off = np.abs(changes[:, :arms] - target.difference[row])
    return (off <= target.tolerance[row]).all(axis=1)


def build_change_table(target: Target, candidates: Sequence[Candidate]) -> np.ndarray:
    """Changes by candidates (candidates, keys, arms); infinite for one that changes other keys."""
    numbers = {key: number for number, key in enumerate(target.keys)}
    arms = target.difference.shape[1]
    table = np.zeros((len(candidates), len(target.keys), arms))
    for row, candidate in zip(table, candidates, strict=True):
        for key, change in candidate.change.items():
            if key in numbers:
                row[numbers[key]] = change[:arms]
            elif change[:arms].any():
                row[:] = np.inf
    return table


def find_covers(
    target: Target, candidates: Sequence[Candidate], changes: np.ndarray
) -> list[ErrorSet]:
    """Sets of errors of which each makes some coefficients alone, and all together make all.

    Or, where some are made so, two more errors that make the rest together.
    """
    active = (np.abs(changes) > target.tolerance).any(axis=2)
    close = (np.abs(changes - target.difference) <= target.tolerance).all(axis=2)
    partial = np.flatnonzero(active.any(axis=1) & (close | ~active).all(axis=1)).tolist()
    parts = sorted(partial, key=lambda s: (-active[s].sum(), candidates[s].cost))
    open_keys, chosen = target.wrong.copy(), list[list[Candidate]]()
    while open_keys.any():
        fitting = [s for s in parts if not (active[s] & ~open_keys).any()]
        if not fitting and not chosen:
            return []
        if not fitting:  # what is left may be made by two errors together
            inside = ~active[:, ~open_keys].any(axis=1)
            left = [each for each, there in zip(candidates, inside, strict=True) if there]
            two = find_pairs(target.select_keys(open_keys), left, changes[inside][:, open_keys])
            return [(*(each[0] for each in chosen), *pair) for pair in two]
        best = active[fitting[0]]
        same = [s for s in fitting if (active[s] == best).all()]
        chosen.append([candidates[s] for s in same[:MOST_PER_KEY]])
        open_keys &= ~best
    return list(combinations(*chosen)) if len(chosen) <= 3 else [tuple(c[0] for c in chosen)]


def find_pairs(
    target: Target, candidates: Sequence[Candidate], changes: np.ndarray
) -> list[ErrorSet]:
    """Pairs of errors that make the difference together, found by sorting one side."""
    size = np.abs(target.difference)
    if not size.any() or (target.tolerance.max() > TOO_NOISY * size.max()):
        return []
    finite = np.flatnonzero(np.isfinite(changes).all(axis=(1, 2))).tolist()
    likeliest = sorted(finite, key=lambda s: candidates[s].cost)[:MOST_PAIRED]
    key, arm = np.unravel_index(size.argmax(), size.shape)
    order = np.array(sorted(likeliest, key=lambda s: changes[s, key, arm]), dtype=np.int64)
    along = changes[order, key, arm]
    complement, margin = target.difference[key, arm] - along, target.tolerance[key, arm]
    first = np.searchsorted(along, complement - margin, "left")
    after = np.searchsorted(along, complement + margin, "right")
    error_pairs: list[ErrorSet] = []
    for left in np.flatnonzero(after > first).tolist():
        for right in range(max(first[left], left + 1), after[left]):
            a, b = int(order[left]), int(order[right])
            both = changes[a] + changes[b]
            if (np.abs(both - target.difference) <= target.tolerance).all():
                error_pairs.append((candidates[a], candidates[b]))
    return error_pairs


def _cost(errors: ErrorSet) -> float:
    return sum(candidate.cost for candidate in errors)


def group_by_errors(wrong: Sequence[EntryMismatch]) -> list[list[EntryMismatch]]:
    """The wrong entries, grouped by the errors that explain them, in order of first entries."""
    groups: defaultdict[object, list[EntryMismatch]] = defaultdict(list)
    for number, each in enumerate(wrong):
        errors = each.explanation.errors if each.explanation else ()
        groups[tuple(map(error_signature, errors)) or number].append(each)
    return list(groups.values())


def error_signature(error: TermError) -> object:
    """Key that equal errors in different entries share: the swap, or else the term as well."""
    if error.kind == "swapped":
        return error.kind, error.yours, error.right
    term = error.term.coefficient.removeprefix("-")
    where = term, error.term.angle, error.term.signal
    return error.kind, error.yours, error.right, error.by, where


def compute_bias_differences(
    mass: Entries, turns: np.ndarray
) -> dict[EntryPlace, dict[TermKey, float]]:
    """Change of a bias that follows from M, by differences of M: cosines and sines alone.

    turns (joints, n): d theta / d x. In row i dM_ij/dx_k counts once, and half of dM_jk/dx_i with
    the opposite sign.
    """
    total: defaultdict[EntryPlace, defaultdict[TermKey, float]] = defaultdict(
        lambda: defaultdict(float)
    )
    for (i, j), waves in mass.items():
        for key, coefficient in waves.items():
            other = TermKey(key.wave, "sin" if key.function == "cos" else "cos")
            sign = -1 if key.function == "cos" else 1
            slopes = sign * coefficient * (np.array(key.wave) @ turns)
            for k in map(int, np.flatnonzero(slopes)):
                total[EntryPlace("bias", i, rates=_pair(j, k))][other] += slopes[k]
                total[EntryPlace("bias", k, rates=_pair(i, j))][other] -= slopes[k] / 2
    return {place: dict(waves) for place, waves in total.items()}


def _pair(j: int, k: int) -> tuple[int, int]:
    return min(j, k), max(j, k)


def is_caused_by_mass(observed: HarmonicFit, expected: Mapping[TermKey, float]) -> bool:
    """Whether a bias entry's difference is what the differences of M make it."""
    keys = {*observed.coefficients, *expected}
    return all(
        abs(observed.coefficients.get(key, 0.0) - expected.get(key, 0.0))
        <= NOISES * observed.noise.get(key, 0.0) + FOLLOWS * abs(expected.get(key, 0.0))
        for key in keys
    )
