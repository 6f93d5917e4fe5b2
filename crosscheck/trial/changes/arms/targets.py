"""What changes must make: of an entry, of the balance behind accelerations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from crosscheck.trial.changes.arms.comparison import EntryComparison
from crosscheck.trial.changes.arms.letters import draw_unrelated_values
from crosscheck.trial.changes.arms.term_changes import Target, TermSample
from crosscheck.trial.changes.arms.term_search import FITS
from crosscheck.trial.changes.arms.waves import list_keys
from crosscheck.trial.judge.entries import LOOSEST, EntryPlace

FEW_STATES = 12  # states at which changes are tried; of forces, which may have branches, more
MOST_STATES = 60


class TargetRow(NamedTuple):
    """A difference (K,) at the states of an arm, its rounding, and the entries behind it.

    factors: by what each entry is multiplied there, (K,).
    """

    difference: np.ndarray
    noise: float
    factors: Mapping[EntryPlace, np.ndarray]


def make_entry_target(arms: Sequence[EntryComparison], place: EntryPlace) -> Target:
    """What changes must make of one entry on every arm, at some states."""
    rows = [
        TargetRow(arm.difference(place)[0], arm.noise(place), {place: np.ones(len(arm.states))})
        for arm in arms
    ]
    target = make_target(arms, rows, place.part)
    fits = [arm.fit_waves(place) or {} for arm in arms]
    keys = dict.fromkeys(key for fit in fits for key in fit) if fits[0] else {}
    numbers = {key: np.array([[fit.get(key, 0.0)] for fit in fits]) for key in keys}
    columns = {key: target.column(place, key)[: len(arms)] for key in keys}
    return replace(target, parts={key: numbers[key] * columns[key] for key in keys})


def make_balance_target(
    arms: Sequence[EntryComparison], balances: Sequence[np.ndarray], row: int
) -> Target:
    """What changes must make of a row of M a + h - f."""
    assert arms[0].terms is not None  # else nobody asks
    places, rows = [each for each in arms[0].terms.entries if each.row == row], []
    for arm, balance in zip(arms, balances, strict=True):
        a, u = arm.user_values["acceleration"], arm.rates
        noise = (arm.sizes.tolerance("acceleration") - LOOSEST) * float(arm.sizes.force[row])
        factors = {place: np.ones(len(u)) for place in places}
        for place in places:
            if place.column is not None:
                factors[place] = -a[:, place.column]
            elif place.rates is not None:
                factors[place] = -u[:, place.rates[0]] * u[:, place.rates[1]]
        rows.append(TargetRow(balance[:, row], noise, factors))
    return make_target(arms, rows, "acceleration")


def make_target(arms: Sequence[EntryComparison], rows: Sequence[TargetRow], part: str) -> Target:
    """What changes must make of a row of each arm at some states.

    These are the first, corners at the end, and the worst.
    """
    terms, count = arms[0].terms, min(len(arm.states) for arm in arms)
    assert terms is not None  # else nobody asks
    half = (MOST_STATES if part in ("force", "acceleration") else FEW_STATES) // 2
    worst = int(np.abs(rows[0].difference[:count]).argmax())
    few = np.unique([*range(min(count, half)), *range(max(count - half, 0), count), worst])
    present = [n for n in arms[0].values if any(each.values[n] for each in arms)]
    samples = [
        TermSample(
            {name: arm.values[name] for name in present},
            arm.angles[few],
            {name: signal[few] for name, signal in arm.signals.items()},
            {place: factor[few] for place, factor in row.factors.items()},
        )
        for arm, row in zip(arms, rows, strict=True)
    ]
    samples.append(samples[0]._replace(values=draw_unrelated_values(present)))
    terms = terms.drop_letters({*arms[0].values} - {*present})
    goals = np.array([row.difference[few] for row in rows])
    allowed = FITS * np.abs(goals).max(axis=1) + [row.noise for row in rows]
    keys = list_keys(terms, arms[0].signals, "force" if part == "acceleration" else part)
    places, tolerance = tuple(samples[0].columns), allowed[:, None] + 0 * goals
    return Target(terms, places, samples, goals, tolerance, keys, states=few)
