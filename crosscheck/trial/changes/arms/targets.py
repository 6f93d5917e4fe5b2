"""What changes must make of an entry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from crosscheck.trial.changes.arms.comparison import EntryComparison
from crosscheck.trial.changes.arms.letters import draw_unrelated_values
from crosscheck.trial.changes.arms.term_changes import Target, TermSample
from crosscheck.trial.changes.arms.term_search import FITS
from crosscheck.trial.changes.arms.waves import list_keys
from crosscheck.trial.judge.entries import EntryPlace

FEW_STATES = 12  # states at which changes are tried; of forces, which may have branches, more
MOST_STATES = 60


def make_entry_target(arms: Sequence[EntryComparison], place: EntryPlace) -> Target:
    """What changes must make of one entry on every arm, at some states."""
    target = _make_target(arms, place)
    fits = [arm.fit_waves(place) or {} for arm in arms]
    keys = dict.fromkeys(key for fit in fits for key in fit) if fits[0] else {}
    numbers = {key: np.array([[fit.get(key, 0.0)] for fit in fits]) for key in keys}
    columns = {key: target.column(key)[: len(arms)] for key in keys}
    return replace(target, parts={key: numbers[key] * columns[key] for key in keys})


def _make_target(arms: Sequence[EntryComparison], place: EntryPlace) -> Target:
    """What changes must make of an entry of each arm at some states.

    These are the first, corners at the end, and the worst.
    """
    terms, differences = arms[0].terms, [arm.difference(place)[0] for arm in arms]
    assert terms is not None  # else nobody asks
    count = min(map(len, differences))
    half = (MOST_STATES if place.part == "force" else FEW_STATES) // 2
    worst = int(np.abs(differences[0][:count]).argmax())
    few = np.unique([*range(min(count, half)), *range(max(count - half, 0), count), worst])
    present = [n for n in arms[0].values if any(each.values[n] for each in arms)]
    samples = [
        TermSample(
            {name: arm.values[name] for name in present},
            arm.angles[few],
            {name: signal[few] for name, signal in arm.signals.items()},
        )
        for arm in arms
    ]
    samples.append(samples[0]._replace(values=draw_unrelated_values(present)))
    terms = terms.drop_letters({*arms[0].values} - {*present})
    goals = np.array([difference[few] for difference in differences])
    allowed = FITS * np.abs(goals).max(axis=1) + [arm.noise(place) for arm in arms]
    keys, tolerance = list_keys(terms, arms[0].signals, place.part), allowed[:, None] + 0 * goals
    return Target(terms, place, samples, goals, tolerance, keys, states=few)
