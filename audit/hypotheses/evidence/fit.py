"""Which damping explains the numbers that the paper prints: a set of settings, from many starts.

A start explains a number if its claim is true of it; one that lacks what the claim is about does
not. A setting belongs to the set if the numbers that its starts explain are not told apart from
those of the best setting.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from crosscheck.audit.claims.quantities import Known
from crosscheck.audit.claims.rule import Answer, Claim, State, answers
from crosscheck.audit.claims.settings import plan_of
from crosscheck.audit.experiments.cells import LAWS, MODELS, Cell
from crosscheck.audit.experiments.experiments import CONSTANT, NO_ERROR, PD
from crosscheck.audit.experiments.variant import Planets
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.said import Said

# The numbers that Section 3 prints of meshes and fluctuations, and Section 4.1's frequency.
NUMBERS = (
    "3.1-09",
    "3.1-14",
    "3.2-16",
    "3.2-20",
    "3.2-27",
    "3.2-28",
    "3.2-29",
    "4.1-19",
)
SOURCES = (PD, NO_ERROR, CONSTANT)  # the experiments that they are about
PLANETS: tuple[Planets, ...] = ("free", "lumped")
ALPHA = 0.05  # that one setting or more is left out although it explains as much as the best


@dataclass(frozen=True)
class DampingFit:
    """A setting. explained: by claim, (starts,), whether each start explains its number."""

    cell: Cell
    explained: Mapping[str, np.ndarray]
    answers: Mapping[str, Answer]

    @cached_property
    def counts(self) -> np.ndarray:
        """How many numbers each start explains (starts,)."""
        return np.sum(list(self.explained.values()), axis=0)

    @property
    def mean(self) -> float:
        """Numbers that a start explains."""
        return float(self.counts.mean())

    def without(self, claim: str) -> DampingFit:
        """With one number left out."""
        left = {name: yes for name, yes in self.explained.items() if name != claim}
        return DampingFit(self.cell, left, self.answers)


def fits(material: Material, claims: Sequence[Claim]) -> list[DampingFit]:
    """Every setting; quick: of the claims' own quick ones."""
    plan = plan_of(material.scale)
    cells = [
        Cell(law, zeta, arm, planets)
        for planets, law, arm, zeta in product(PLANETS, LAWS, plan.readings, plan.zetas)
    ]
    wanted = [(cell, source) for cell in cells for source in SOURCES]
    found = material.samples(wanted, "damping fit")
    return [fit_of(c, Known({s: found[c, s] for s in SOURCES}), claims) for c in cells]


def fit_of(cell: Cell, known: Known, claims: Sequence[Claim]) -> DampingFit:
    """From the setting's experiments, each claim about one quantity."""
    explained, given = {}, {}
    for claim in claims:
        (quantity,) = claim.choices.values()
        explained[claim.id] = claim.limits.yes(quantity(known))
        (given[claim.id],) = answers(claim, [(cell, known)])
    return DampingFit(cell, explained, given)


def equally_good(found: Sequence[DampingFit]) -> list[DampingFit]:
    """The best, and every setting that is not told apart from it (Holm's procedure)."""
    best = max(found, key=lambda fit: fit.mean)
    others = [fit for fit in found if fit is not best]
    chances = {id(fit): chance(best.counts, fit.counts) for fit in others}
    worse = sorted(others, key=lambda fit: chances[id(fit)])
    for place, fit in enumerate(worse):
        if chances[id(fit)] > ALPHA / (len(worse) - place):
            return [best, *sorted(worse[place:], key=lambda fit: -fit.mean)]
    return [best]


def chance(best: np.ndarray, other: np.ndarray) -> float:
    """That counts (starts,) of equal origin are shared out with as large a sum in the first.

    Fisher and Pitman's exact test, one-sided: over all ways to choose as many of all starts.
    """
    pooled = np.concatenate([best, other]).astype(int)
    ways = np.zeros((best.size + 1, int(pooled.sum()) + 1))
    ways[0, 0] = 1.0
    for count in pooled:
        ways[1:, count:] += ways[:-1, : ways.shape[1] - count].copy()
    return float(ways[best.size, int(best.sum()) :].sum() / ways[best.size].sum())


@dataclass(frozen=True)
class Span:
    """What the settings of a set have in common; left_out: the claim that it does without."""

    left_out: str | None
    laws: tuple[str, ...]
    readings: tuple[str, ...]
    planets: tuple[str, ...]
    zetas: tuple[float, float]
    settings: int
    mean: float


def span(chosen: Sequence[DampingFit], left_out: str | None = None) -> Span:
    """Of a set."""
    cells = [fit.cell for fit in chosen]
    zetas = [cell.zeta for cell in cells]
    return Span(
        left_out,
        _unlike(cell.law.id for cell in cells),
        _unlike(cell.reading for cell in cells),
        _unlike(cell.planets for cell in cells),
        (min(zetas), max(zetas)),
        len(cells),
        max(fit.mean for fit in chosen),
    )


def _unlike(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(names))


def each_left_out(found: Sequence[DampingFit]) -> list[Span]:
    """The set that is found when one of the numbers is not asked for, by turns."""
    return [
        span(equally_good([fit.without(claim) for fit in found]), claim)
        for claim in found[0].explained
    ]


def tells_nothing(found: Sequence[DampingFit]) -> dict[State, list[str]]:
    """Claims on which all settings agree, by what they say: these choose no damping."""
    silent: dict[State, list[str]] = {State.YES: [], State.NO: []}
    for claim in found[0].explained:
        states = {fit.answers[claim].state for fit in found}
        if len(states) == 1 and (state := states.pop()) in silent:
            silent[state].append(claim)
    return silent


def said(found: Iterable[DampingFit], claims: Sequence[Claim]) -> list[Said]:
    """What the fit says of the claims' quantities, in settings of theirs."""
    quantities = {claim.id: quantity.id for claim in claims for quantity in claim.choices.values()}
    return [
        Said("damping fit", quantities[name], answer.limits, answer.place, answer.state)
        for fit in found
        if fit.cell.model in MODELS
        for name, answer in fit.answers.items()
    ]
