"""Quantities that claims are about: what one start of every experiment of a setting gives.

Each has an id that says how it is made, so two claims about one quantity have the same.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from scipy.stats import rankdata

from crosscheck.audit.judging.sample import Sample

FEWEST_MEMBERS = 3  # of a family of experiments that a trend is seen along


class MeasuredExperiment(Protocol):
    """An experiment by which a paper's claims are judged; as text, its id; hashable.

    kind: what it shares with its family; size: of a family, what makes this member; static: whether
    the arm's data alone decide it.
    """

    @property
    def kind(self) -> str: ...
    @property
    def size(self) -> float | None: ...
    @property
    def static(self) -> bool: ...


class Series(Protocol):
    """Experiments of one kind that differ in one size."""

    @property
    def kind(self) -> str: ...


class Number(NamedTuple):
    """A number that experiments measure. words: a noun phrase; window: the part of the run."""

    words: str
    unit: str
    window: str = ""


class NotSimulatedError(LookupError):
    """Raised where a setting lacks the experiment that a quantity is about."""


class ConditionResults(dict[MeasuredExperiment, Sample]):
    """The experiments of a setting. Raises NotSimulatedError for one that it does not have."""

    def __missing__(self, experiment: MeasuredExperiment) -> Sample:
        raise NotSimulatedError(experiment)

    def members(self, series: Series) -> list[MeasuredExperiment]:
        """The experiments of a family, ascending. Raises NotSimulatedError with too few of them."""
        members = [experiment for experiment in self if experiment.kind == series.kind]
        if len(members) < FEWEST_MEMBERS:
            raise NotSimulatedError(series)
        return sorted(members, key=lambda source: source.size or 0.0)


class ResultsTracker(ConditionResults):
    """The experiments of a setting that have been asked for by now."""

    def __init__(self, results: ConditionResults) -> None:
        super().__init__()
        self.results = results

    def __missing__(self, experiment: MeasuredExperiment) -> Sample:
        self[experiment] = sample = self.results[experiment]
        return sample

    def members(self, series: Series) -> list[MeasuredExperiment]:
        return self.results.members(series)

    @property
    def run(self) -> int:
        """Starts from which one of these experiments at least was run: the first of all."""
        return max(sample.run for sample in self.values())


Formula = Callable[[ConditionResults], np.ndarray]  # (starts,), nan where undefined


@dataclass(frozen=True)
class Quantity:
    """What a claim is about; its id says which numbers of which experiments make it."""

    id: str
    unit: str
    formula: Formula
    static: bool = False

    def __call__(self, results: ConditionResults) -> np.ndarray:
        """The value for every start, (starts,); one number where the arm's data alone decide it."""
        with np.errstate(all="ignore"):
            return np.asarray(self.formula(results), dtype=float)


def _combine_quantities(
    symbol: str, unit: str, parts: Sequence[Quantity], formula: Formula
) -> Quantity:
    """A quantity that is made of others."""
    name = f"{symbol}({', '.join(part.id for part in parts)})"
    return Quantity(name, unit, formula, all(part.static for part in parts))


def difference(first: Quantity, second: Quantity) -> Quantity:
    """One quantity less another."""
    return _combine_quantities("less", first.unit, (first, second), lambda n: first(n) - second(n))


def magnitude(quantity: Quantity) -> Quantity:
    """The magnitude of a quantity."""
    return _combine_quantities("size", quantity.unit, (quantity,), lambda n: np.abs(quantity(n)))


def scaled_quantity(quantity: Quantity, factor: float, unit: str) -> Quantity:
    """A quantity times a constant factor, in another unit."""
    return _combine_quantities(
        f"{factor:g} times", unit, (quantity,), lambda n: factor * quantity(n)
    )


def ratio(numerator: Quantity, denominator: Quantity) -> Quantity:
    """One quantity over another."""
    unit = "1" if numerator.unit == denominator.unit else f"{numerator.unit}/({denominator.unit})"
    return _combine_quantities(
        "over", unit, (numerator, denominator), lambda n: numerator(n) / denominator(n)
    )


def minimum(*parts: Quantity) -> Quantity:
    """The smallest of several quantities; undefined if one of them is."""
    return _combine_quantities(
        "min", parts[0].unit, parts, lambda n: np.min([p(n) for p in parts], 0)
    )


def maximum(*parts: Quantity) -> Quantity:
    """The largest of several quantities; undefined if one of them is."""
    return _combine_quantities(
        "max", parts[0].unit, parts, lambda n: np.max([p(n) for p in parts], 0)
    )


def maximum_over_starts(quantity: Quantity) -> Quantity:
    """The largest value of a quantity in any start, given for every start."""

    def formula(results: ConditionResults) -> np.ndarray:
        values = quantity(results)
        return np.full(values.shape, np.fmax.reduce(values))  # nan where nothing is defined

    return _combine_quantities("any start's", quantity.unit, (quantity,), formula)


def divergence(experiment: MeasuredExperiment) -> Quantity:
    """A quantity that is 1 where the experiment's run diverged, else 0."""
    return Quantity(f"{experiment}: diverged", "1", lambda n: n[experiment].diverged.astype(float))


def restrict_above(condition: Quantity, above: float, quantity: Quantity) -> Quantity:
    """The quantity where the condition is above a limit; undefined elsewhere."""
    return _restrict(quantity, condition, "above", above, np.greater)


def restrict_below(condition: Quantity, below: float, quantity: Quantity) -> Quantity:
    """The quantity where the condition is below a limit; undefined elsewhere."""
    return _restrict(quantity, condition, "below", below, np.less)


def _restrict(
    quantity: Quantity, condition: Quantity, side: str, limit: float, holds: np.ufunc
) -> Quantity:
    return _combine_quantities(
        f"where {side} {limit:g}",
        quantity.unit,
        (condition, quantity),
        lambda n: np.where(holds(condition(n), limit), quantity(n), np.nan),
    )


def series_values(
    series: Series, name: str, results: ConditionResults
) -> tuple[np.ndarray, np.ndarray]:
    """A family's sizes (members,), ascending, and its numbers (members, starts)."""
    members = results.members(series)
    sizes = np.array([experiment.size for experiment in members], dtype=float)
    return sizes, np.array([results[experiment][name] for experiment in members])


def rank_correlation(sizes: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Spearman's rank correlation: sizes (members,), values (members, starts) -> (starts,)."""
    ranks = rankdata(values, axis=0)
    size_ranks = rankdata(sizes)
    rank_deviations, size_deviations = (
        ranks - ranks.mean(axis=0),
        (size_ranks - size_ranks.mean())[:, None],
    )
    with np.errstate(all="ignore"):
        correlations = (rank_deviations * size_deviations).sum(axis=0) / np.sqrt(
            (rank_deviations**2).sum(axis=0) * (size_deviations**2).sum()
        )
    return np.where(np.isfinite(values).all(axis=0), correlations, np.nan)


@dataclass(frozen=True)
class Measures:
    """The numbers that a paper's experiments measure, by name, and the quantities made of them."""

    numbers: Mapping[str, Number]

    def quantity_of(self, experiment: MeasuredExperiment, name: str) -> Quantity:
        """The quantity of an experiment's number. Raises KeyError for a name that none has."""
        return Quantity(
            f"{experiment}: {name}",
            self.numbers[name].unit,
            lambda results: results[experiment][name],
            experiment.static,
        )

    def fold_series(
        self, symbol: str, series: Series, name: str, fold: Callable[[np.ndarray], np.ndarray]
    ) -> Quantity:
        """A number folded over a family's experiments: fold is (members, starts) -> (starts,)."""
        return Quantity(
            f"{symbol}({series.kind}: {name})",
            self.numbers[name].unit,
            lambda results: fold(series_values(series, name, results)[1]),
        )

    def series_minimum(self, series: Series, name: str) -> Quantity:
        """The smallest value of a number in a family of experiments; undefined if one is."""
        return self.fold_series("least", series, name, lambda values: values.min(axis=0))

    def series_maximum(self, series: Series, name: str) -> Quantity:
        """The largest value of a number in a family of experiments; undefined if one is."""
        return self.fold_series("greatest", series, name, lambda values: values.max(axis=0))

    def rank(self, series: Series, name: str) -> Quantity:
        """Spearman's rank correlation of a number with size, over a family's experiments.

        Undefined where one of them has no such number, or all have the same.
        """
        return Quantity(
            f"rank({series.kind}: {name})",
            "1",
            lambda results: rank_correlation(*series_values(series, name, results)),
        )

    def rank_among(self, series: Series, name: str, condition: str, above: float) -> Quantity:
        """Rank correlation of a number with size where another number is large enough.

        Undefined with fewer than FEWEST_MEMBERS of them; none of them lacks the number.
        """

        def formula(results: ConditionResults) -> np.ndarray:
            sizes, values = series_values(series, name, results)
            chosen = np.isfinite(values) & (series_values(series, condition, results)[1] > above)
            correlations = np.full(len(chosen.T), np.nan)
            for start, is_chosen in enumerate(chosen.T):
                if is_chosen.sum() >= FEWEST_MEMBERS:
                    (correlations[start],) = rank_correlation(
                        sizes[is_chosen], values[is_chosen, start, None]
                    )
            return correlations

        return Quantity(
            f"rank where above {above:g}({series.kind}: {condition}, {name})", "1", formula
        )


Choices = Mapping[str, Quantity]
