"""An entry's difference at many states as cosines and sines of joint angle sums, and signals."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product as combinations

import numpy as np

from crosscheck.trial.diagnose.terms.polynomial import AngleSum, EntryTerms, TermKey
from crosscheck.trial.diagnose.terms.reference_terms import ReferenceTerms

EPS = float(np.finfo(float).eps)
ROUNDINGS = 16  # least error of a value, in roundings of its natural size
SIGNIFICANT = 16  # standard errors: a coefficient below is none
FULL = 3  # joints up to which every sum of few angles is tried
SPARE_STATES, STATES_PER_NUMBER = 50, 2  # a fit with noise wants more states than numbers


@dataclass(frozen=True)
class HarmonicFit:
    """The difference of one entry, yours minus right, on one arm: its coefficients by key.

    values: the arm's quantities (``collect_arm_values``); noise: standard error of each
    coefficient; left_over: what no key explains, beyond rounding, relative to the difference.
    """

    values: Mapping[str, float]
    coefficients: Mapping[TermKey, float]
    noise: Mapping[TermKey, float]
    left_over: float = 0.0

    @property
    def significant_coefficients(self) -> dict[TermKey, float]:
        """The coefficients that are not 0."""
        sure = {key: SIGNIFICANT * noise for key, noise in self.noise.items()}
        return {key: v for key, v in self.coefficients.items() if abs(v) > sure.get(key, 0.0)}


def list_angle_sums(terms: ReferenceTerms) -> tuple[AngleSum, ...]:
    """Waves for M and bias: 0, the reference's, sums and differences of two joint or link angles.

    Of few joints also every sum of joint angles, each up to twice.
    """
    single = _angles(terms.joints)
    pairs = [a + sign * b for a in single for b in single for sign in (1, -1)]
    return _add_all_sums(terms, [*single, *pairs], range(-2, 3))


def list_weight_angle_sums(terms: ReferenceTerms) -> tuple[AngleSum, ...]:
    """Waves that weight may be thought to depend on: 0, joint and link angles, once and twice.

    Of few joints also every sum of joint angles, each once or not at all.
    """
    single = _angles(terms.joints)
    return _add_all_sums(terms, [*single, *(2 * single)], (-1, 0, 1))


def _add_all_sums(
    terms: ReferenceTerms, waves: Iterable[np.ndarray], times: Iterable[int]
) -> tuple[AngleSum, ...]:
    """The reference's waves and the given ones; of few joints all sums too, by these multiples."""
    angle_sums: list[Iterable[int]] = [*terms.angle_sums, *waves]
    if terms.joints <= FULL:
        angle_sums += combinations(times, repeat=terms.joints)
    return tuple(dict.fromkeys(map(_normalize_sign, angle_sums)))


def _angles(joints: int) -> np.ndarray:
    """Waves (2 joints, joints) of the joint angles, then of the links' absolute angles."""
    return np.vstack([np.eye(joints), np.tril(np.ones((joints, joints)))]).astype(int)


def _normalize_sign(wave: Iterable[int]) -> AngleSum:
    whole = tuple(int(entry) for entry in wave)
    first = next((entry for entry in whole if entry), 1)
    return whole if first > 0 else tuple(-entry for entry in whole)


def minimum_state_count(terms: ReferenceTerms) -> int:
    """Number of states needed to see a residual that no wave or signal explains."""
    still = 2 * len(list_weight_angle_sums(terms)) + len(terms.signals) + len(terms.names)
    return SPARE_STATES + STATES_PER_NUMBER * max(2 * len(list_angle_sums(terms)), still)


def make_term_keys(waves: Iterable[AngleSum]) -> list[TermKey]:
    """The keys of the cosine and sine of each wave, of wave 0 the cosine alone."""
    both = [(wave, function) for wave in waves for function in ("cos", "sin")]
    return [TermKey(wave, function) for wave, function in both if any(wave) or function == "cos"]


class HarmonicBasis:
    """A least-squares fit of waves and signals to entries, at the same states for many entries.

    angles (K, joints): joint angles of q at the states; signals: their values (K,) by name.
    """

    def __init__(
        self,
        keys: Sequence[TermKey],
        angles: np.ndarray,
        signals: Mapping[str, np.ndarray] | None = None,
    ) -> None:
        columns = [_column(key, angles, signals or {}) for key in keys]
        sizes = [float(np.sqrt(np.mean(column**2))) for column in columns]
        there = [place for place, size in enumerate(sizes) if size > 0]
        self.keys = [keys[place] for place in there]
        self.sizes = np.array([sizes[place] for place in there])
        table = np.array([columns[place] for place in there]).reshape(len(there), len(angles))
        self.table = (table / self.sizes[:, None]).T

    @classmethod
    def from_angle_sums(cls, terms: ReferenceTerms, angles: np.ndarray) -> HarmonicBasis:
        """The fitting for entries of M, and of the bias."""
        return cls(make_term_keys(list_angle_sums(terms)), angles)

    @classmethod
    def from_forces(
        cls, terms: ReferenceTerms, angles: np.ndarray, signals: Mapping[str, np.ndarray]
    ) -> HarmonicBasis:
        """The fitting for entries of the force: each signal, and weight."""
        still = (0,) * terms.joints
        driven = [TermKey(still, signal=name) for name in signals]
        return cls([*driven, *make_term_keys(list_weight_angle_sums(terms))], angles, signals)

    @cached_property
    def _inverse(self) -> np.ndarray:
        return np.linalg.pinv(self.table, rcond=1e-10)

    def residual(self, values: np.ndarray) -> np.ndarray:
        """The part of values (K,) that no column makes."""
        return values - self.table @ (self._inverse @ values)

    def fit(self, values: np.ndarray, scale: float, arm: Mapping[str, float]) -> HarmonicFit:
        """The coefficients that make values (K,), the differences of an entry.

        scale: the size of the numbers whose rounding the values have; arm: the arm's quantities.
        Where a value or its square is beyond what floats hold, nothing explains anything.
        """
        with np.errstate(over="ignore"):
            squared = values @ values
        if not np.isfinite(squared):
            return HarmonicFit(arm, {}, {}, float("inf"))
        solved = self._inverse @ values
        solved = solved + self._inverse @ (values - self.table @ solved)
        rest = float(np.linalg.norm(values - self.table @ solved))
        free = max(len(values) - len(self.keys), 1)
        error = max(rest / np.sqrt(free), ROUNDINGS * EPS * scale)
        spread = np.maximum(np.linalg.norm(self._inverse, axis=1), EPS)
        floor = ROUNDINGS * EPS * scale  # rounding of what hangs on no state is no noise
        noise = np.maximum(error * spread, floor / 4) / self.sizes
        size = float(np.linalg.norm(values))
        beyond = max(rest - ROUNDINGS * EPS * scale * np.sqrt(len(values)), 0.0)
        return HarmonicFit(
            arm,
            dict(zip(self.keys, (solved / self.sizes).tolist(), strict=True)),
            dict(zip(self.keys, noise.tolist(), strict=True)),
            beyond / size if size else 0.0,
        )


def _column(
    key: TermKey, angles: np.ndarray, signals: Mapping[str, np.ndarray], unit: float = 1.0
) -> np.ndarray:
    angle = unit * (angles @ np.array(key.wave, dtype=float))
    wave = np.sin(angle) if key.function == "sin" else np.cos(angle)
    return wave * signals[key.signal] if key.signal else wave


def evaluate_entry(
    entry: EntryTerms,
    values: Mapping[str, float],
    angles: np.ndarray,
    signals: Mapping[str, np.ndarray] | None = None,
    unit: float = 1.0,
) -> np.ndarray:
    """An entry's values (K,) at joint angles (K, joints), by an arm's quantities and signals.

    unit: by which the angle of every wave is multiplied, as 180/pi where it is read in degrees.
    """
    total = np.zeros(len(angles))
    for product in entry:
        column = _column(product.key, angles, signals or {}, unit)
        total += product.monomial.value(values) * column
    return total
