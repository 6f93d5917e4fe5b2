"""Kinds of terms of Kane's sum that are wrong by one factor, in one part of the equations."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from crosscheck.report.formatting import join_words
from crosscheck.trial.changes.kane import FACTORS, KaneSum
from crosscheck.trial.changes.numbers import ALIKE
from crosscheck.trial.changes.problem import DynamicsTerms
from crosscheck.trial.changes.search import CauseSearch
from crosscheck.trial.judge.entries import PART_TITLES

SIZABLE = 1e-9  # smallest piece that can be recognized, relative to an entry's size


def describe_pieces(search: CauseSearch, part: str, *, are_usual: bool = True) -> Iterator[str]:
    """Sentences on kinds of terms of Kane's sum that are wrong by one factor in M, bias or gravity.

    Of an acceleration, in the bias that it comes from. All terms of a kind come first, then the
    kinds of which fewest are wrong. are_usual: whether by usual factors alone, since terms that do
    not depend on the rates are often equal by chance.
    """
    problem, table = search.problem, search.table
    term = "bias" if part == "acceleration" else part
    described: list[tuple[int, str]] = []
    for parts in table.part_lists:
        kinds = KaneSum(table.robot, *problem.states[:2], parts).list_pieces(term)
        for kind, pieces in kinds.items():
            stacked = np.array(list(pieces.values()))
            base = table.compute_base(search.level)._asdict()
            blank = {name: np.zeros((len(stacked), *each.shape)) for name, each in base.items()}
            rows = search.row(DynamicsTerms(**(blank | {term: stacked})))
            places = problem.select_part(part)
            chosen, by = search.choose_rows(rows[:, places], places, is_free=True)
            if not chosen or (are_usual and all(abs(1 + by - usual) > ALIKE for usual in FACTORS)):
                continue
            names, there = list(pieces), (np.abs(rows).max(axis=1) > SIZABLE).sum()
            whole = len(chosen) == there > 1
            of_links = f"{kind} of {join_words([names[n] for n in chosen])}"
            which = kind.replace("the", "every", 1) if whole else of_links
            words = f"{PART_TITLES.get(part, part)}: {which}: {format_factor(1 + by)}"
            described.append((0 if whole else len(chosen), words))
        if described:
            break
    fewest = min((count for count, _ in described), default=0)
    yield from (words for count, words in described if count == fewest)


def format_factor(factor: float) -> str:
    """How large what is wrong is beside what is right."""
    usual = (words for by, words in FACTORS.items() if abs(factor - by) < ALIKE)
    words = next(usual, f"{factor:.6g} times as large")
    return f"yours is {words}" if words.endswith("large") else words
