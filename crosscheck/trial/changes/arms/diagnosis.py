"""Errors of equations and their reasons, on their arm and on other arms of its structure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from crosscheck.models.errors import InputError
from crosscheck.trial.arms.questions import VerificationProblem
from crosscheck.trial.changes.arms.causes import explain_entries
from crosscheck.trial.changes.arms.comparison import (
    EntryComparison,
    Perform,
    ask_and_compare,
)
from crosscheck.trial.changes.arms.dependence import Dependence, IgnoredNumber
from crosscheck.trial.changes.arms.probe import draw_probe_arms
from crosscheck.trial.judge.entries import EntryMismatch

PROBES = 2


def build_probe_problems(
    problem: VerificationProblem, unfollowed: Sequence[IgnoredNumber] = ()
) -> list[VerificationProblem]:
    """Benches of the same equations on arms that show what equal numbers and zeros hide, if any.

    unfollowed: numbers that these arms keep.
    """
    if not problem.equations.any_arm:
        return []
    try:
        kept = {each.name: each.goes_with for each in unfollowed}
        arms = draw_probe_arms(problem.case.arm, PROBES, kept)
        return [problem.adapt_to_arm(arm) for arm in arms]
    except InputError:  # equations of some arms alone are right or wrong on this one
        return []


class Diagnosis(NamedTuple):
    """The wrong entries with their reasons, and the numbers that the equations do not follow.

    uncertain: further ones, which may be errors.
    """

    wrong_entries: list[EntryMismatch]
    ignored_numbers: list[IgnoredNumber]
    uncertain: list[IgnoredNumber]


def diagnose(
    here: EntryComparison, there: Sequence[EntryComparison], perform: Perform
) -> Diagnosis:
    """The wrong entries, here and on other arms, with their reasons.

    Where any differ, the numbers of the arm's file are changed one by one; those that the equations
    do not follow are kept on the other arms, which are then asked again.
    """
    problem = here.problem
    alone = not there or problem.equations.table is not None
    if alone or not any(any(each.wrong_entries) for each in (here, *there)):
        return Diagnosis(list(explain_entries(here, there)), [], [])
    unfollowed = Dependence(here, perform).find_ignored_numbers()
    certain = [each for each in unfollowed if each.certain]
    uncertain = [each for each in unfollowed if not each.certain]
    diagnosis = Diagnosis(_explain_with_probes(here, there, certain, perform), certain, uncertain)
    if uncertain and _count_unexplained(diagnosis.wrong_entries):
        other = Diagnosis(_explain_with_probes(here, there, unfollowed, perform), unfollowed, [])
        diagnosis = min(diagnosis, other, key=lambda each: _count_unexplained(each.wrong_entries))
    return diagnosis


def _explain_with_probes(
    here: EntryComparison,
    there: Sequence[EntryComparison],
    kept: Sequence[IgnoredNumber],
    perform: Perform,
) -> list[EntryMismatch]:
    """The wrong entries with their reasons, by other arms that keep these numbers."""
    if any(each.parts for each in kept):
        probes = build_probe_problems(here.problem, kept)
        there = ask_and_compare(probes, here.level, perform)
    return list(explain_entries(here, there))


def _count_unexplained(wrong_entries: Sequence[EntryMismatch]) -> int:
    """Number of entries that are wrong on the user's arm without a reported reason."""
    return sum(
        each.explanation is None and not each.notes for each in wrong_entries if not each.shown_on
    )
