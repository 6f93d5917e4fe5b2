"""A difference at many states as cosines and sines of joint angle sums, and signals."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from itertools import product as combinations

import numpy as np

from crosscheck.trial.changes.arms.segments import AngleSum, ReferenceTerms, TermKey, evaluate_wave

EPS = float(np.finfo(float).eps)
ROUNDINGS = 16  # least error of a value, in roundings of its natural size
SIGNIFICANT = 16  # standard errors: a coefficient below is none
FULL = 3  # joints up to which every sum of few angles is tried
SPARE_STATES, STATES_PER_NUMBER = 50, 2  # a fit with noise wants more states than numbers
UNEXPLAINED = 1e-6  # largest share of a difference outside all waves that terms may explain
FOLLOWS = 1e-9  # largest residual of a bias that follows from M, relative to the difference


def list_angle_sums(terms: ReferenceTerms, *, weighing: bool = False) -> tuple[AngleSum, ...]:
    """Waves of M and bias, or of weights: 0, the reference's, sums and differences of two angles.

    Of few joints also every sum of joint angles, each up to twice; in weights once or not at all.
    """
    joints = terms.joints
    single = np.vstack([np.eye(joints), np.tril(np.ones((joints, joints)))]).astype(int)
    pairs = [a + sign * b for a in single for b in single for sign in (1, -1)]
    sums: list[Iterable[int]] = [*terms.angle_sums, *single]
    sums += [*(2 * single)] if weighing else pairs
    if joints <= FULL:
        sums += combinations((-1, 0, 1) if weighing else range(-2, 3), repeat=joints)
    return tuple(dict.fromkeys(map(_normalize_sign, sums)))


def _normalize_sign(wave: Iterable[int]) -> AngleSum:
    whole = tuple(int(entry) for entry in wave)
    first = next((entry for entry in whole if entry), 1)
    return whole if first > 0 else tuple(-entry for entry in whole)


def list_keys(terms: ReferenceTerms, signals: Iterable[str], part: str) -> list[TermKey]:
    """What the entries of a part may depend on: signals, and each wave's cosine and sine."""
    still = (0,) * terms.joints
    weighing = part in ("force", "gravity")
    keys = [TermKey(still, signal=name) for name in signals] if weighing else []
    for wave in list_angle_sums(terms, weighing=weighing):
        keys += [TermKey(wave), TermKey(wave, "sin")] if any(wave) else [TermKey(wave)]
    return keys


def minimum_state_count(terms: ReferenceTerms) -> int:
    """Number of states needed to see a residual that no wave or signal explains."""
    signals = {p.key.signal for entry in terms.entries.values() for p in entry}
    keys = (list_keys(terms, ["", *signals], part) for part in ("mass_matrix", "force"))
    return SPARE_STATES + STATES_PER_NUMBER * (max(map(len, keys)) + len(terms.names))


class WaveBasis:
    """A least-squares fit of waves and signals, at the same states for many entries.

    angles (K, joints): joint angles of q at the states; signals: their values (K,) by name.
    """

    def __init__(
        self, keys: Sequence[TermKey], angles: np.ndarray, signals: Mapping[str, np.ndarray]
    ) -> None:
        columns = [
            evaluate_wave(key, angles) * (signals[key.signal] if key.signal else 1.0)
            for key in keys
        ]
        sizes = np.sqrt(np.mean(np.square(columns), axis=1))
        there = np.flatnonzero(sizes > 0)
        self.keys, self.sizes = [keys[place] for place in there.tolist()], sizes[there]
        self.table = (np.array(columns)[there] / self.sizes[:, None]).T

    @cached_property
    def _inverse(self) -> np.ndarray:
        return np.linalg.pinv(self.table, rcond=1e-10)

    def fit(self, values: np.ndarray, scale: float) -> dict[TermKey, float] | None:
        """Fit values (K,) by waves: the coefficients that are not 0, or None if nothing fits.

        scale: the size of the numbers from whose rounding the values suffer.
        """
        size = float(np.linalg.norm(values))
        if not np.isfinite(size) or not size:
            return None
        solved = self._inverse @ values
        solved = solved + self._inverse @ (values - self.table @ solved)
        rest = float(np.linalg.norm(values - self.table @ solved))
        floor = ROUNDINGS * EPS * scale
        if rest - floor * np.sqrt(len(values)) > UNEXPLAINED * size:
            return None
        error = max(rest / np.sqrt(max(len(values) - len(self.keys), 1)), floor)
        spread = np.maximum(np.linalg.norm(self._inverse, axis=1), EPS)
        noise = np.maximum(error * spread, floor / 4)  # constant values are not noise
        return {
            key: float(number / unit)
            for key, number, unit, least in zip(
                self.keys, solved, self.sizes, SIGNIFICANT * noise, strict=True
            )
            if abs(number) > least
        }
