"""What changes must make: of an entry, of a part, of the balance behind accelerations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import permutations
from typing import NamedTuple

import numpy as np

from crosscheck.trial.changes.arms.comparison import EntryComparison
from crosscheck.trial.changes.arms.letters import draw_unrelated_values
from crosscheck.trial.changes.arms.term_changes import TermSample, TermTable
from crosscheck.trial.changes.arms.term_search import FITS, Target
from crosscheck.trial.changes.arms.waves import list_keys
from crosscheck.trial.judge.entries import LOOSEST, EntryPlace

FEW_STATES = 12  # states at which changes are tried; of forces, which may have branches, more
MOST_STATES = 60
PROJECTIONS = 16  # numbers by which all entries of a part are seen together


class TargetRow(NamedTuple):
    """A difference (K,) at the states of an arm, its size and rounding, and the entries behind it.

    factors: by what each entry is multiplied there, (K,) or a number.
    """

    difference: np.ndarray
    size: float
    noise: float
    factors: Mapping[EntryPlace, np.ndarray | float]


def _select_states(
    arms: Sequence[EntryComparison], rows: Sequence[TargetRow], part: str
) -> np.ndarray:
    """States at which changes are tried (few,): the first, corners at the end, and the worst."""
    count = min(len(arm.states) for arm in arms)
    few = MOST_STATES if part in ("force", "acceleration") else FEW_STATES
    worst = [int(np.abs(row.difference[:count]).argmax()) for row in rows]
    return np.unique(
        [*range(min(count, few // 2)), *range(max(count - few // 2, 0), count), *worst]
    )


def make_entry_target(arms: Sequence[EntryComparison], place: EntryPlace) -> Target:
    """What changes must make of one entry on every arm, at some states."""
    lines = [[TargetRow(*arm.difference(place), arm.noise(place), {place: 1.0})] for arm in arms]
    target = make_target(arms, lines, place.part)
    fits = [arm.fit_waves(place) or {} for arm in arms]
    keys = dict.fromkeys(key for fit in fits for key in fit) if fits[0] else {}
    numbers = {key: np.array([[fit.get(key, 0.0)] for fit in fits]) for key in keys}
    columns = {key: target.table.column(place, key)[: len(arms)] for key in keys}
    return replace(target, parts={key: numbers[key] * columns[key] for key in keys})


def make_part_target(arms: Sequence[EntryComparison], wrong: Sequence[EntryPlace]) -> Target:
    """What changes must make of all entries of a part."""
    assert arms[0].terms is not None  # else nobody asks
    part, lines = wrong[0].part, list[list[TargetRow]]()
    places = dict.fromkeys([*(p for p in arms[0].terms.entries if p.part == part), *wrong])
    for arm in arms:
        lines.append([])
        for place in places:
            difference, size = arm.difference(place)
            size = float(np.abs(difference).max()) if place in wrong else size
            lines[-1].append(TargetRow(difference, size or 1.0, arm.noise(place), {place: 1.0}))
    target = make_target(arms, lines, part)
    swaps = tuple(permutations(wrong, 2)) if part == "bias" else ()
    return replace(target, table=replace(target.table, swaps=swaps))


def make_balance_target(
    arms: Sequence[EntryComparison], balances: Sequence[np.ndarray], rows: Sequence[int]
) -> Target:
    """What changes must make of the rows of M a + h - f."""
    assert arms[0].terms is not None  # else nobody asks
    lines = list[list[TargetRow]]()
    for arm, balance in zip(arms, balances, strict=True):
        a, u, size = arm.user_values["acceleration"], arm.rates, arm.sizes.force
        noise = arm.sizes.tolerance("acceleration") - LOOSEST
        lines.append([])
        for row in rows:
            factors: dict[EntryPlace, np.ndarray | float] = {}
            for place in (each for each in arms[0].terms.entries if each.row == row):
                factors[place] = 1.0
                if place.column is not None:
                    factors[place] = -a[:, place.column]
                elif place.rates is not None:
                    factors[place] = -u[:, place.rates[0]] * u[:, place.rates[1]]
            lines[-1].append(TargetRow(balance[:, row], size[row], noise * size[row], factors))
    target = make_target(arms, lines, "acceleration")
    return replace(target, table=replace(target.table, has_rows=True))


def make_target(
    arms: Sequence[EntryComparison], lines: Sequence[Sequence[TargetRow]], part: str
) -> Target:
    """What changes must make of lines on every arm: of one at the states, of many random sums."""
    terms, generator = arms[0].terms, np.random.default_rng(0)
    few = _select_states(arms, lines[0], part)
    assert terms is not None  # else nobody asks
    present = [n for n in arms[0].values if any(each.values[n] for each in arms)]
    samples, goals, noises = list[TermSample](), list[np.ndarray](), list[float]()
    for arm, rows in zip(arms, lines, strict=True):
        columns, states = dict[EntryPlace, np.ndarray](), np.eye(len(arm.states))[few]
        goal, noise = np.zeros(len(few) if len(rows) == 1 else PROJECTIONS), 0.0
        for difference, size, rounding, factors in rows:
            mixing, unit = states, 1.0
            if len(rows) > 1:
                mixing, unit = generator.normal(size=(PROJECTIONS, len(few))) @ states, size
            columns |= {place: mixing * factor / unit for place, factor in factors.items()}
            goal += mixing @ difference / unit
            noise = max(noise, rounding / unit * (1.0 if len(rows) == 1 else len(few)))
        values = {name: arm.values[name] for name in present}
        samples.append(TermSample(values, arm.angles, arm.signals, columns))
        goals.append(goal)
        noises.append(noise)
    samples.append(samples[0]._replace(values=draw_unrelated_values(present)))
    terms = terms.drop_letters({*arms[0].values} - {*present})
    table = TermTable(terms, tuple(samples[0].columns), samples)
    allowed = FITS * np.abs(goals).max(axis=1) + np.array(noises)
    keys = list_keys(terms, arms[0].signals, "force" if part == "acceleration" else part)
    return Target(table, np.array(goals), np.repeat(allowed[:, None], len(goals[0]), 1), keys, {})
