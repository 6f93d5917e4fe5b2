"""What is wrong with equations and why, on their arm and on other arms of its structure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from crosscheck.models.errors import InputError
from crosscheck.trial.diagnose.dependence import Dependence, Perform, Unfollowed, kept_numbers
from crosscheck.trial.diagnose.probe import NONE_KEPT, probe_arms
from crosscheck.trial.diagnose.reasons import Compared, compared, entry_questions, reasoned
from crosscheck.trial.judge.places import Wrong
from crosscheck.trial.judge.questions import VerificationProblem

PROBES = 2


def probes_of(
    problem: VerificationProblem, unfollowed: Sequence[Unfollowed] = ()
) -> list[VerificationProblem]:
    """Benches of the same equations on arms that show what equal numbers and zeros hide, if any.

    unfollowed: numbers that these arms keep.
    """
    if not problem.equations.any_arm:
        return []
    try:
        kept = kept_numbers(unfollowed) if unfollowed else NONE_KEPT
        return [problem.on(arm) for arm in probe_arms(problem.case.arm, PROBES, kept)]
    except InputError:  # equations of some arms alone are right or wrong on this one
        return []


class Diagnosis(NamedTuple):
    """The wrong entries with their reasons, and the numbers that the equations do not follow.

    uncertain: further ones, which may be errors.
    """

    wrong: list[Wrong]
    unfollowed: list[Unfollowed]
    uncertain: list[Unfollowed]


def diagnosed(here: Compared, there: Sequence[Compared], perform: Perform) -> Diagnosis:
    """The wrong entries, here and on other arms, with their reasons.

    Where any differ, the numbers of the arm's file are changed one by one; those that the equations
    do not follow are kept on the other arms, which are then asked again.
    """
    problem = here.problem
    alone = not there or problem.equations.table is not None
    if alone or not any(any(each.wrong) for each in (here, *there)):
        return Diagnosis(list(reasoned(here, there)), [], [])
    unfollowed = Dependence(here, perform).unfollowed()
    certain = [each for each in unfollowed if each.certain]
    uncertain = [each for each in unfollowed if not each.certain]
    found = Diagnosis(_reasons(here, there, certain, perform), certain, uncertain)
    if uncertain and _unexplained(found.wrong):
        other = Diagnosis(_reasons(here, there, unfollowed, perform), unfollowed, [])
        found = min(found, other, key=lambda each: _unexplained(each.wrong))
    return found


def _reasons(
    here: Compared, there: Sequence[Compared], kept: Sequence[Unfollowed], perform: Perform
) -> list[Wrong]:
    """The wrong entries with their reasons, by other arms that keep these numbers."""
    if any(each.parts for each in kept):
        probes = probes_of(here.problem, kept)
        questions = (entry_questions(each, [here.level], list(here.yours)) for each in probes)
        results = perform(list(dict.fromkeys(question for own in questions for question in own)))
        there = [compared(each, here.level, list(here.yours), results) for each in probes]
    return list(reasoned(here, there))


def _unexplained(found: Sequence[Wrong]) -> int:
    """How many entries are wrong on the arm on trial for a reason that is not told."""
    return sum(each.explanation is None and not each.notes for each in found if not each.shown_on)
