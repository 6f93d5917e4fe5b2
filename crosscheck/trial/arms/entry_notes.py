"""Sentences of an arm's trial on wrong entries, units, and numbers that are not followed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from dataclasses import replace

from crosscheck.report.formatting import join_words
from crosscheck.trial.changes.arms.dependence import IgnoredNumber
from crosscheck.trial.changes.arms.term_words import group_by_errors, guess
from crosscheck.trial.judge.entries import (
    EntryMismatch,
    describe_entry_notes,
    format_entry,
)


def name_entry(wrong: EntryMismatch, names: Sequence[str], causes: Sequence[str]) -> EntryMismatch:
    """The entry with its name, and the first cause of all or a guess at its error.

    causes: in words, what explains all entries.
    """
    words = causes[0] if causes else guess(wrong)
    return replace(wrong, name=format_entry(wrong.place, names), guess=words)


def describe_entries(wrong: Sequence[EntryMismatch]) -> Iterator[str]:
    """Errors, one line each, however many entries they appear in; those explained first."""
    yield from _describe_groups(wrong, explained=True)
    yield from describe_entry_notes(wrong)


def describe_unexplained(wrong: Sequence[EntryMismatch]) -> Iterator[str]:
    """Entries that no change of their terms explains, one line for those that are alike."""
    yield from _describe_groups(wrong, explained=False)


def _describe_groups(wrong: Sequence[EntryMismatch], *, explained: bool) -> Iterator[str]:
    """Entries with the same error: what is wrong in the first one, and where else it is."""
    for first, *others in group_by_errors([each for each in wrong if not each.notes]):
        if bool(first.explanation) == explained:
            also = f"; also in {', '.join(each.name for each in others)}" if others else ""
            yield f"{first.name}: {first.cause}{also}"


def describe_point_masses(points: Sequence[str]) -> str:
    """The note on inertias of links that are judged as 0."""
    return (
        f"Your equations have no {', '.join(points)}, and the file's are less than"
        " 1e-6 of mass x com^2: judged as point masses, with 0 in their place."
    )


def describe_unfollowed(
    unfollowed: Sequence[IgnoredNumber],
    wrong_parts: Set[str] = frozenset(),
    written: Set[str] = frozenset(),
) -> str:
    """One note on all numbers of the arm's file that the equations do not follow; or ''.

    Of a number that is 0 in the file and in the equations there is nothing to say. wrong_parts: of
    the equations, whose values may be the error; written: names of numbers whose values stand in
    the user's file, so that they are not missing.
    """
    literal = [each for each in unfollowed if each.value and not each.goes_with]
    tied = [each for each in unfollowed if each.goes_with]
    sentences, is_wrong = [], False
    if literal:
        parts = list(dict.fromkeys(part for each in literal for part in each.parts))
        verb = "does" if len(parts) == 1 else "do"
        listed_numbers = ", ".join(f"{each.name} = {each.value:.6g}" for each in literal)
        is_wrong = not wrong_parts.isdisjoint(parts)
        is_missing = is_wrong and not {each.name for each in literal} <= written
        it, missing = "is it" if len(literal) == 1 else "are they", "missing or " * is_missing
        which = join_words(["M" if part == "mass_matrix" else part for part in parts])
        sentences.append(
            f"Your {which} {verb} not change with the file's {listed_numbers}:"
            f" {it} {missing}hard-coded?"
        )
    if tied:
        listed_ties = ", ".join(f"{t.name} from {' and '.join(t.goes_with)}" for t in tied)
        sentences.append(f"Your equations take {listed_ties}, which is right on this arm.")
    if sentences and not is_wrong:
        sentences.append("The trial went ahead with your values.")
    return " ".join(sentences)
