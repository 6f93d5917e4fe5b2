"""The damping that the paper leaves out: which settings explain the numbers that it prints?

A start explains a number if its claim is true of it; one that lacks what the claim is about does
not. A setting belongs to the set if the numbers that its starts explain cannot be distinguished
from those of the best setting.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from crosscheck.audit.claims import catalogue
from crosscheck.audit.claims.study_plan import ResultsByCondition
from crosscheck.audit.experiments.paper_conditions import Condition
from crosscheck.audit.judging import quantities, rule
from crosscheck.audit.measures.undefined import JsonObject

# The numbers that Section 3 prints of meshes and fluctuations, and Section 4.1's frequency.
NUMBERS = ("3.1-09", "3.1-14", "3.2-16", "3.2-20", "3.2-27", "3.2-28", "3.2-29", "4.1-19")
ALPHA = 0.05  # that one setting or more is left out although it explains as much as the best


@dataclass(frozen=True)
class DampingFit:
    """What a setting explains: by claim, (starts,), whether each start explains its number.

    Of starts that were run in one of its experiments at least.
    """

    cell: Condition
    explained: Mapping[str, np.ndarray]

    @cached_property
    def counts(self) -> np.ndarray:
        """How many numbers each start explains, (starts,)."""
        return np.sum(list(self.explained.values()), axis=0)

    @property
    def mean(self) -> float:
        """The mean count of printed numbers that a start explains."""
        return float(self.counts.mean())


def fit_condition(
    cell: Condition, results: quantities.ConditionResults, claims: Sequence[rule.Claim]
) -> DampingFit:
    """The fit of a setting to claims about one quantity each, from the setting's experiments."""
    explained = {}
    tracker = quantities.ResultsTracker(results)
    for claim in claims:
        (quantity,) = claim.choices.values()
        explained[claim.id] = claim.limits.contains(quantity(tracker))
    return DampingFit(cell, {name: yes[: tracker.run] for name, yes in explained.items()})


def select_best_fits(fits: Sequence[DampingFit]) -> list[DampingFit]:
    """The best fit, and every one that cannot be distinguished from it (Holm's procedure)."""
    best = max(fits, key=lambda fit: fit.mean)
    others = [fit for fit in fits if fit is not best]
    chances = {id(fit): chance(best.counts, fit.counts) for fit in others}
    worse = sorted(others, key=lambda fit: chances[id(fit)])
    for place, fit in enumerate(worse):
        if chances[id(fit)] > ALPHA / (len(worse) - place):
            return [best, *sorted(worse[place:], key=lambda fit: -fit.mean)]
    return [best]


def chance(best: np.ndarray, other: np.ndarray) -> float:
    """Probability that counts (starts,) of one origin are split with as large a sum in the first.

    Fisher and Pitman's exact test, one-sided: over all ways to choose as many of all starts.
    """
    pooled = np.concatenate([best, other]).astype(int)
    ways = np.zeros((best.size + 1, int(pooled.sum()) + 1))
    ways[0, 0] = 1.0
    for count in pooled:
        ways[1:, count:] += ways[:-1, : ways.shape[1] - count].copy()
    return float(ways[best.size, int(best.sum()) :].sum() / ways[best.size].sum())


@dataclass(frozen=True)
class SettingsSummary:
    """What the settings of a set have in common. most: numbers that the best of them explains."""

    laws: tuple[str, ...]
    readings: tuple[str, ...]
    planets: tuple[str, ...]
    zetas: tuple[float, float]
    settings: int
    most: float

    def to_dict(self) -> JsonObject:
        """The summary as a JSON object."""
        names = {
            name: list(getattr(self, name)) for name in ("laws", "readings", "planets", "zetas")
        }
        return {"id": "finding/damping", **names, "settings": self.settings, "most": self.most}


def summarize_best_fits(settings: ResultsByCondition) -> SettingsSummary:
    """The span of the settings that explain the printed numbers equally well."""
    claims = [catalogue.BY_ID[name] for name in NUMBERS]
    fits = [fit_condition(condition, results, claims) for condition, results in settings]
    chosen = select_best_fits(fits)
    cells = [fit.cell for fit in chosen]
    zetas = [cell.zeta for cell in cells]
    return SettingsSummary(
        laws=tuple(dict.fromkeys(cell.law.id for cell in cells)),
        readings=tuple(dict.fromkeys(cell.reading for cell in cells)),
        planets=tuple(dict.fromkeys(cell.planets for cell in cells)),
        zetas=(min(zetas), max(zetas)),
        settings=len(cells),
        most=max(fit.mean for fit in chosen),
    )
