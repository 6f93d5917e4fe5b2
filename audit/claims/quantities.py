"""Quantities that claims are about: what one start of every experiment of a setting gives.

Each has an id that says how it is made, so two claims about one quantity have the same.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.stats import rankdata

from crosscheck.audit.claims.measured import MEASURED
from crosscheck.audit.experiments.experiments import CONSTANT, PD, PLANTED, STATIC, Family, Source
from crosscheck.audit.experiments.pool import Sample

FEWEST_MEMBERS = 3  # of a family of experiments that a trend is seen along


class NotSimulatedError(LookupError):
    """Raised where a setting lacks the experiment that a quantity is about."""


class Known(dict[Source, Sample]):
    """The experiments of a setting. Raises NotSimulatedError for one that it does not have."""

    def __missing__(self, source: Source) -> Sample:
        raise NotSimulatedError(source)

    def members(self, family: Family) -> list[Source]:
        """The experiments of a family, ascending. Raises NotSimulatedError with too few of them."""
        found = [source for source in self if source.kind == family.kind]
        if len(found) < FEWEST_MEMBERS:
            raise NotSimulatedError(family)
        return sorted(found, key=lambda source: source.size_um or 0.0)


class ReadExperiments(Known):
    """The experiments of a setting that have been asked for by now."""

    def __init__(self, known: Known) -> None:
        super().__init__()
        self.known = known

    def __missing__(self, source: Source) -> Sample:
        self[source] = sample = self.known[source]
        return sample

    def members(self, family: Family) -> list[Source]:
        return self.known.members(family)

    @property
    def not_run(self) -> int:
        """Starts from which none of these experiments was run."""
        return min(sample.not_run for sample in self.values())


Formula = Callable[[Known], np.ndarray]  # (starts,), nan where undefined


@dataclass(frozen=True)
class Quantity:
    """What a claim is about. words: for readers; window: the part of a run that it looks at."""

    id: str
    words: str
    unit: str
    formula: Formula
    window: str = ""
    static: bool = False

    def __call__(self, known: Known) -> np.ndarray:
        """The value for every start, (starts,); one number where the arm's data alone decide it."""
        with np.errstate(all="ignore"):
            return np.asarray(self.formula(known), dtype=float)


def of(source: Source, name: str) -> Quantity:
    """The quantity of an experiment's number. Raises KeyError for a name not in MEASURED."""
    number, words = MEASURED[name], f"{MEASURED[name].words} {source.words}".strip()
    formula, static = lambda known: known[source][name], source in (STATIC, PLANTED)
    return Quantity(f"{source}: {name}", words, number.unit, formula, number.window, static)


# Of the experiments that most statements are about, a number by its name.
pd, torque, static = (partial(of, source) for source in (PD, CONSTANT, STATIC))


def _made(
    symbol: str, words: str, unit: str, parts: Sequence[Quantity], formula: Formula
) -> Quantity:
    """A quantity that is made of others."""
    windows = "; ".join(dict.fromkeys(part.window for part in parts if part.window))
    name = f"{symbol}({', '.join(part.id for part in parts)})"
    return Quantity(name, words, unit, formula, windows, all(part.static for part in parts))


def difference(one: Quantity, other: Quantity) -> Quantity:
    """One quantity less another."""
    words = f"{one.words} less {other.words}"
    return _made("less", words, one.unit, (one, other), lambda n: one(n) - other(n))


def size(one: Quantity) -> Quantity:
    """The magnitude of a quantity."""
    return _made("size", f"magnitude of {one.words}", one.unit, (one,), lambda n: np.abs(one(n)))


def times(one: Quantity, factor: float, unit: str) -> Quantity:
    """A quantity times a constant factor, in another unit."""
    return _made(f"{factor:g} times", one.words, unit, (one,), lambda n: factor * one(n))


def over(one: Quantity, other: Quantity) -> Quantity:
    """One quantity over another."""
    unit = "1" if one.unit == other.unit else f"{one.unit}/({other.unit})"
    words = f"{one.words} over {other.words}"
    return _made("over", words, unit, (one, other), lambda n: one(n) / other(n))


def smallest(*parts: Quantity) -> Quantity:
    """The smallest of several quantities; undefined if one of them is."""
    words = f"smallest of: {'; '.join(part.words for part in parts)}"
    return _made("min", words, parts[0].unit, parts, lambda n: np.min([p(n) for p in parts], 0))


def largest(*parts: Quantity) -> Quantity:
    """The largest of several quantities; undefined if one of them is."""
    words = f"largest of: {'; '.join(part.words for part in parts)}"
    return _made("max", words, parts[0].unit, parts, lambda n: np.max([p(n) for p in parts], 0))


def of_any_start(one: Quantity) -> Quantity:
    """The largest value of a quantity in any start, given for every start."""

    def formula(known: Known) -> np.ndarray:
        values = one(known)
        return np.full(values.shape, np.fmax.reduce(values))  # nan where nothing is defined

    return _made("any start's", f"the largest {one.words} of any start", one.unit, (one,), formula)


def diverged(source: Source) -> Quantity:
    """A quantity that is 1 where the experiment's run diverged, else 0."""
    words = f"runs {source.words} that diverge".replace("  ", " ")
    return Quantity(f"{source}: diverged", words, "1", lambda n: n[source].diverged.astype(float))


def where(condition: Quantity, above: float, quantity: Quantity) -> Quantity:
    """The quantity where the condition is above a limit; undefined elsewhere."""
    return _conditioned(quantity, condition, "above", "exceeds", above, np.greater)


def where_below(condition: Quantity, below: float, quantity: Quantity) -> Quantity:
    """The quantity where the condition is below a limit; undefined elsewhere."""
    return _conditioned(quantity, condition, "below", "is below", below, np.less)


def _conditioned(
    quantity: Quantity, condition: Quantity, side: str, verb: str, limit: float, holds: np.ufunc
) -> Quantity:
    return _made(
        f"where {side} {limit:g}",
        f"{quantity.words}, where {condition.words} {verb} {limit:g} {condition.unit}",
        quantity.unit,
        (condition, quantity),
        lambda n: np.where(holds(condition(n), limit), quantity(n), np.nan),
    )


def along(family: Family, name: str, known: Known) -> tuple[np.ndarray, np.ndarray]:
    """A family's sizes [um] (members,), ascending, and its numbers (members, starts)."""
    members = known.members(family)
    sizes = np.array([source.size_um for source in members], dtype=float)
    return sizes, np.array([known[source][name] for source in members])


def over_family(
    symbol: str, words: str, family: Family, name: str, fold: Callable[[np.ndarray], np.ndarray]
) -> Quantity:
    """A number folded over a family's experiments: fold is (members, starts) -> (starts,)."""
    number = MEASURED[name]
    return Quantity(
        f"{symbol}({family.kind}: {name})",
        f"{words} {number.words} over all {family.symbol}",
        number.unit,
        lambda known: fold(along(family, name, known)[1]),
        number.window,
    )


def least(family: Family, name: str) -> Quantity:
    """The smallest value of a number in a family of experiments; undefined if one is."""
    return over_family("least", "smallest", family, name, lambda values: values.min(axis=0))


def greatest(family: Family, name: str) -> Quantity:
    """The largest value of a number in a family of experiments; undefined if one is."""
    return over_family("greatest", "largest", family, name, lambda values: values.max(axis=0))


def spread(family: Family, name: str) -> Quantity:
    """The largest over the smallest value of a number in a family of experiments."""
    return over(greatest(family, name), least(family, name))


def rank(family: Family, name: str) -> Quantity:
    """Spearman's rank correlation of a number with size, over a family's experiments.

    Undefined where one of them has no such number, or all have the same.
    """
    number = MEASURED[name]
    return Quantity(
        f"rank({family.kind}: {name})",
        f"rank correlation with {family.symbol} of {number.words}",
        "1",
        lambda known: rank_correlation(*along(family, name, known)),
        number.window,
    )


def rank_among(family: Family, name: str, condition: str, above: float) -> Quantity:
    """Rank correlation of a number with size, among members whose ``condition`` is large enough.

    Undefined with fewer than FEWEST_MEMBERS of them; none of them lacks the number.
    """
    number, limit = MEASURED[name], MEASURED[condition]

    def formula(known: Known) -> np.ndarray:
        sizes, values = along(family, name, known)
        chosen = np.isfinite(values) & (along(family, condition, known)[1] > above)
        found = np.full(len(chosen.T), np.nan)
        for start, own in enumerate(chosen.T):
            if own.sum() >= FEWEST_MEMBERS:
                (found[start],) = rank_correlation(sizes[own], values[own, start, None])
        return found

    return Quantity(
        f"rank where above {above:g}({family.kind}: {condition}, {name})",
        f"rank correlation with {family.symbol} of {number.words}, among {family.symbol} where"
        f" {limit.words} exceeds {above:g} {limit.unit}",
        "1",
        formula,
        number.window,
    )


def rank_correlation(sizes: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Spearman's rank correlation: sizes (members,), values (members, starts) -> (starts,)."""
    ranks = rankdata(values, axis=0)
    own = rankdata(sizes)
    one, other = ranks - ranks.mean(axis=0), (own - own.mean())[:, None]
    with np.errstate(all="ignore"):
        found = (one * other).sum(axis=0) / np.sqrt((one**2).sum(axis=0) * (other**2).sum())
    return np.where(np.isfinite(values).all(axis=0), found, np.nan)


Choices = Mapping[str, Quantity]
