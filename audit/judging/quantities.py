"""Quantities that claims are about: what one start of every experiment of a setting gives.

Each has an id that says how it is made, so two claims about one quantity have the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

FEWEST_MEMBERS = 3  # of a family of experiments that a trend is seen along


@dataclass(frozen=True)
class MeasuredExperiment:
    """An experiment by which a paper's claims are judged; as text, its id.

    kind: what it shares with its family; size: of a family, what makes this member; static: whether
    the arm's data alone decide it.
    """

    kind: str
    size: float | None = None
    static: bool = False

    def __str__(self) -> str:
        return self.kind


class Number(NamedTuple):
    """A number that experiments measure. words: a noun phrase; window: the part of the run."""

    words: str
    unit: str
    window: str = ""


@dataclass(frozen=True)
class Sample:
    """What the starts of an experiment measured.

    numbers: name -> (starts,), nan where undefined; diverged (starts,): whether the run did;
    not_run: of the last starts, those that others stand for, so that start i of one experiment has
    a start i of another beside it; they are no evidence, and never counted.
    """

    numbers: Mapping[str, np.ndarray]
    diverged: np.ndarray
    not_run: int = 0

    @property
    def run(self) -> int:
        """How many starts were run."""
        return self.diverged.size - self.not_run

    def __getitem__(self, name: str) -> np.ndarray:
        """A number of every start, (starts,). Raises KeyError for one that is not measured."""
        if self.diverged.all():
            return np.full(self.diverged.shape, math.nan)
        return self.numbers[name]


class NotSimulatedError(LookupError):
    """Raised where a setting lacks the experiment that a quantity is about."""


class ConditionResults(dict[MeasuredExperiment, Sample]):
    """The experiments of a setting. Raises NotSimulatedError for one that it does not have."""

    def __missing__(self, experiment: MeasuredExperiment) -> Sample:
        raise NotSimulatedError(experiment)

    def members(self, kind: str) -> list[MeasuredExperiment]:
        """The experiments of a family, ascending. Raises NotSimulatedError with too few of them."""
        members = [experiment for experiment in self if experiment.kind == kind]
        if len(members) < FEWEST_MEMBERS:
            raise NotSimulatedError(kind)
        return sorted(members, key=lambda source: source.size or 0.0)


class ResultsTracker(ConditionResults):
    """The experiments of a setting that have been asked for by now."""

    def __init__(self, results: ConditionResults) -> None:
        super().__init__()
        self.results = results

    def __missing__(self, experiment: MeasuredExperiment) -> Sample:
        self[experiment] = sample = self.results[experiment]
        return sample

    def members(self, kind: str) -> list[MeasuredExperiment]:
        return self.results.members(kind)

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


# What quantities are made of others by: of values (starts,), undefined where one of them is.
OPERATIONS: dict[str, Callable[..., np.ndarray]] = {
    "less": np.subtract,
    "over": np.divide,
    "size": np.abs,
    "min": lambda *values: np.min(values, axis=0),
    "max": lambda *values: np.max(values, axis=0),
    # The largest in any start, given for every start; nan where nothing is defined.
    "any start's": lambda values: np.full(values.shape, np.fmax.reduce(values)),
}
RESTRICTIONS = {"where above": np.greater, "where below": np.less}
# What a family's numbers (members, starts) become, (starts,).
FOLDS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "least": lambda values: values.min(axis=0),
    "greatest": lambda values: values.max(axis=0),
    "least of those with": np.fmin.reduce,
}


def combine_quantities(operation: str, *parts: Quantity) -> Quantity:
    """The quantity that one of OPERATIONS makes of others."""
    unit = parts[0].unit
    if operation == "over":
        unit = "1" if unit == parts[1].unit else f"{unit}/({parts[1].unit})"
    return _make_quantity(operation, unit, parts, OPERATIONS[operation])


def scale_quantity(factor: float, unit: str, quantity: Quantity) -> Quantity:
    """A quantity times a constant factor, in another unit."""
    return _make_quantity(f"{factor:g} times", unit, (quantity,), lambda values: factor * values)


def restrict_quantity(side: str, limit: float, condition: Quantity, quantity: Quantity) -> Quantity:
    """The quantity where a condition is on the side of a limit that one of RESTRICTIONS names."""
    return _make_quantity(
        f"{side} {limit:g}",
        quantity.unit,
        (condition, quantity),
        lambda decisive, values: np.where(RESTRICTIONS[side](decisive, limit), values, np.nan),
    )


def _make_quantity(
    symbol: str, unit: str, parts: Sequence[Quantity], formula: Callable[..., np.ndarray]
) -> Quantity:
    """A quantity made of others, whose id says so."""
    return Quantity(
        f"{symbol}({', '.join(part.id for part in parts)})",
        unit,
        lambda results: formula(*(part(results) for part in parts)),
        all(part.static for part in parts),
    )


def divergence(experiment: MeasuredExperiment) -> Quantity:
    """A quantity that is 1 where the experiment's run diverged, else 0."""
    return Quantity(f"{experiment}: diverged", "1", lambda n: n[experiment].diverged.astype(float))


def series_values(kind: str, name: str, results: ConditionResults) -> tuple[np.ndarray, np.ndarray]:
    """A family's sizes (members,), ascending, and its numbers (members, starts)."""
    members = results.members(kind)
    sizes = np.array([experiment.size for experiment in members], dtype=float)
    return sizes, np.array([results[experiment][name] for experiment in members])


def rank_members(values: np.ndarray) -> np.ndarray:
    """Ranks (members, starts) among the members of a start, from 1; of equal values their mean."""
    below, equal = (compare(values, values[:, None]).sum(axis=1) for compare in (np.less, np.equal))
    ranks: np.ndarray = below + (equal + 1) / 2
    return ranks


def rank_correlation(sizes: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Spearman's rank correlation: sizes (members,), values (members, starts) -> (starts,)."""
    rank_deviations, size_deviations = (
        ranks - ranks.mean(axis=0) for ranks in map(rank_members, (values, sizes[:, None]))
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

    def fold_series(self, fold: str, kind: str, name: str) -> Quantity:
        """A number folded over a family's experiments by one of FOLDS."""
        return Quantity(
            f"{fold}({kind}: {name})",
            self.numbers[name].unit,
            lambda results: FOLDS[fold](series_values(kind, name, results)[1]),
        )

    def rank(self, kind: str, name: str) -> Quantity:
        """Spearman's rank correlation of a number with size, over a family's experiments.

        Undefined where one of them has no such number, or all have the same.
        """
        return Quantity(
            f"rank({kind}: {name})",
            "1",
            lambda results: rank_correlation(*series_values(kind, name, results)),
        )

    def rank_among(self, kind: str, name: str, condition: str, above: float) -> Quantity:
        """Rank correlation of a number with size where another number is large enough.

        Undefined with fewer than FEWEST_MEMBERS of them; none of them lacks the number.
        """

        def formula(results: ConditionResults) -> np.ndarray:
            sizes, values = series_values(kind, name, results)
            chosen = np.isfinite(values) & (series_values(kind, condition, results)[1] > above)
            correlations = np.full(len(chosen.T), np.nan)
            for start, is_chosen in enumerate(chosen.T):
                if is_chosen.sum() >= FEWEST_MEMBERS:
                    (correlations[start],) = rank_correlation(
                        sizes[is_chosen], values[is_chosen, start, None]
                    )
            return correlations

        return Quantity(f"rank where above {above:g}({kind}: {condition}, {name})", "1", formula)


Choices = Mapping[str, Quantity]
