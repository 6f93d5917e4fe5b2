"""Why entries are wrong: their differences on the arm, and on others, made by changes of terms.

The others, of the arm's structure, show what its equal numbers and zeros hide.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.trial.arms.questions import VerificationProblem
from crosscheck.trial.changes.arms.arm_numbers import draw_probe_arms
from crosscheck.trial.changes.arms.comparison import EntryComparison, Perform, ask_and_compare
from crosscheck.trial.changes.arms.dependence import Dependence, IgnoredNumber
from crosscheck.trial.changes.arms.mesh_forces import compute_signals, list_mesh_laws
from crosscheck.trial.changes.arms.polynomial import as_polynomial
from crosscheck.trial.changes.arms.segments import (
    ReferenceTerms,
    build_reference_terms,
    evaluate_entry,
)
from crosscheck.trial.changes.arms.steps import find_steps
from crosscheck.trial.changes.arms.term_changes import WEIGHT, Target, TermChange
from crosscheck.trial.changes.arms.term_search import ChangeSet, make_entry_target, search_changes
from crosscheck.trial.changes.arms.term_words import (
    error_signature,
    make_difference_terms,
    make_term_error,
)
from crosscheck.trial.judge import entries
from crosscheck.trial.judge.entries import EntryMismatch, EntryPlace, Explanation, TermError

SAME = 1e-12  # tolerance between two readings of a map, relative to its row
FOLLOWS = "follows from the wrong M"
PROBES = 2


def explain_entries(arm: EntryComparison, probes: Sequence[EntryComparison]) -> list[EntryMismatch]:
    """The wrong entries with their reasons; then those that only another arm shows.

    probes: the same on arms of the same structure and other numbers.
    """
    if probes and probes[0].columns is not None and _is_same_map(probes[0].columns, arm):
        arm = replace(arm, letters=probes[0].columns)  # equal numbers are no letter's own
    return _explain_parts((arm, *probes), list(_explain_arms(arm, probes)))


def _is_same_map(columns: np.ndarray, arm: EntryComparison) -> bool:
    """Whether a map in letters has the same numbers as the user's map of an arm."""
    matrix = arm.frame.matrix
    if matrix is None:
        return False
    numbers = [as_polynomial(entry).value(arm.values) for entry in columns.ravel()]
    off = np.abs(np.reshape(numbers, matrix.shape) - matrix)
    return bool((off <= SAME * np.abs(matrix).max(axis=1, keepdims=True)).all())


def _collect_errors(wrong_entries: Sequence[EntryMismatch]) -> dict[object, TermError]:
    explanations = [wrong.explanation for wrong in wrong_entries if wrong.explanation]
    return {error_signature(error): error for each in explanations for error in each.errors}


def _explain_arms(
    arm: EntryComparison, probes: Sequence[EntryComparison]
) -> Iterator[EntryMismatch]:
    """The wrong entries of an arm, then of others, each with what explains it alone."""
    seen = set()
    for number, each in enumerate((arm, *probes)):
        for wrong in each.wrong_entries:
            if wrong.place not in seen:
                seen.add(wrong.place)
                explained = _explain_entry(wrong, (each, *probes[number:]))
                name = each.problem.case.arm.name if number else ""
                yield replace(explained, shown_on=name)


def _explain_entry(wrong: EntryMismatch, arms: Sequence[EntryComparison]) -> EntryMismatch:
    arm, place = arms[0], wrong.place
    if arm.terms is None or place.part == "acceleration" or wrong.notes:
        return wrong
    if place.rates is not None and arm.is_caused_by_mass(place):
        return replace(wrong, notes=(FOLLOWS,))
    if place.rates is not None and (rates := arm.find_exchanged_rates(place)):
        right, yours = (entries.format_rates(each, arm.problem.names) for each in rates)
        return replace(wrong, notes=(f"yours has {yours} where {right} belongs",))
    waves = arm.fit_waves(place)
    arms = [each for each in arms if place.quantity in each.user_values]
    target = make_entry_target(arms, place)
    sets = search_changes(target, _list_whole_weights(arms, place, target))
    if len(arms) == 1:  # whose numbers are met by many pairs
        sets = [changes for changes in sets if len(changes) == 1]
    if not sets and place.part == "force" and waves is None:
        target = make_entry_target(arms[:1], place)
        sets = search_changes(target, _list_law_changes(arm, place, target))
    if sets:
        return replace(wrong, explanation=_make_explanation(target, sets))
    return replace(wrong, difference=make_difference_terms(waves or {}, arm.terms))


def _make_explanation(target: Target, sets: Sequence[ChangeSet]) -> Explanation:
    """The first of changes that make the same, and the others beside it."""
    terms, arms = target.terms, len(target.difference)
    first, *others = (tuple(make_term_error(each, terms) for each in changes) for changes in sets)
    made = sum(change.effect[:arms] for change in sets[0])
    size = float(np.linalg.norm(target.difference))
    left = float(np.linalg.norm(target.difference - made)) / size
    return Explanation(first, left, tuple(others))


def _list_whole_weights(
    arms: Sequence[EntryComparison], place: EntryPlace, target: Target
) -> list[TermChange]:
    """The weights in a force, which are a part of their own."""
    if place.part != "force" or any("gravity" not in arm.user_values for arm in arms):
        return []
    weights = [-arm.user_values["gravity"][target.states, place.row] for arm in (*arms, arms[0])]
    return [TermChange("extra", (), np.array(weights), 1.0, right="gravity", group=WEIGHT)]


def _list_law_changes(arm: EntryComparison, place: EntryPlace, target: Target) -> list[TermChange]:
    """Other laws of meshes that change an entry of the force."""
    frame, problem = arm.frame, arm.problem

    def evaluate(terms: ReferenceTerms, signals: Mapping[str, np.ndarray]) -> np.ndarray:
        return evaluate_entry(
            terms.entry(place), arm.values, arm.angles, {**arm.signals, **signals}
        )

    assert arm.terms is not None  # else nobody asks
    right, changes = evaluate(arm.terms, {}), list[TermChange]()
    laws = list_mesh_laws(problem.case.arm, frame.layout, problem.case.switches)
    for number, law in enumerate(laws, start=2):
        terms = arm.terms
        if law.switches != problem.case.switches:
            parts: dict[str, Any] = {"has_gravity": problem.has_gravity, "columns": arm.columns}
            terms = build_reference_terms(frame, law.arm, law.switches, **parts)
        made_of = law.arm, frame.layout, law.switches, arm.states
        signals = compute_signals(*made_of, law.is_absolute, law.rate_factor)
        effect = (evaluate(terms, signals) - right)[target.states]
        if effect.any():  # laws that do the same here are others elsewhere
            effects, texts = np.array([effect, number * effect]), (law.yours, law.right)
            changes.append(TermChange("swapped", (), effects, 1.0, *texts, group=law.words))
    return changes


def _explain_parts(
    arms: Sequence[EntryComparison], wrong_entries: Sequence[EntryMismatch]
) -> list[EntryMismatch]:
    """The wrong entries, those of a part that no single error makes by one change of many."""
    explanations = dict[EntryPlace, Explanation]()
    open_entries = [w for w in wrong_entries if not (w.notes or w.shown_on)]
    for part in dict.fromkeys(wrong.place.part for wrong in open_entries):
        group = [wrong for wrong in open_entries if wrong.place.part == part]
        quantity = group[0].place.quantity
        if any(each.terms is None or quantity not in each.user_values for each in arms):
            continue
        group = _prefer_shared_errors(group, arms[0].values)
        explanations |= {w.place: w.explanation for w in group if w.explanation}
        group = [replace(each, explanation=explanations.get(each.place)) for each in group]
        if len(_collect_errors(group)) != 1 or not all(wrong.explanation for wrong in group):
            explanations |= _explain_part(arms, [wrong.place for wrong in group])
    pairs = ((each, explanations.get(each.place, each.explanation)) for each in wrong_entries)
    return [replace(each, explanation=explanation) for each, explanation in pairs]


def _prefer_shared_errors(
    group: Sequence[EntryMismatch], values: Mapping[str, float]
) -> list[EntryMismatch]:
    """The wrong entries, of equally likely errors first those that most of them may have.

    If a factor is a root of a count, one that is a number is named as such a root too.
    """

    def key(errors: Sequence[TermError]) -> tuple[object, ...]:
        return tuple(map(error_signature, errors))

    ways = {w.place: [w.explanation.errors, *w.explanation.others] for w in group if w.explanation}
    if any("sqrt" in error.yours for error in _collect_errors(group).values()):
        for sets in ways.values():
            sets[:] = [tuple(_name_root(error, values) for error in errors) for errors in sets]
    counts = Counter(each for sets in ways.values() for each in {*map(key, sets)})
    shared = []
    for wrong in group:
        explanation = wrong.explanation
        if explanation is not None:
            first, *others = sorted(ways[wrong.place], key=lambda errors: -counts[key(errors)])
            explanation = replace(explanation, errors=first, others=tuple(others))
        shared.append(replace(wrong, explanation=explanation))
    return shared


def _name_root(error: TermError, values: Mapping[str, float]) -> TermError:
    letters = error.term.coefficient.strip("-").split()
    counts = [name for name in letters if name in values and name[0] == "N"]
    equal = [name for name in counts if error.by == values[name] ** -0.5]
    return replace(error, yours=f"1/sqrt({equal[0]})", by=None) if equal else error


def _explain_part(
    arms: Sequence[EntryComparison], wrong: Sequence[EntryPlace]
) -> dict[EntryPlace, Explanation]:
    """Explanations of wrong entries of a part by one change of all of them."""
    part = wrong[0].part
    if arms[0].problem.has_gravity and part == "force":
        return {}  # without weights there is nothing to derive
    sets = [(error,) for error in find_steps(arms, part)]
    return dict.fromkeys(wrong, Explanation(sets[0], 0.0, tuple(sets[1:]))) if sets else {}


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
        return Diagnosis(explain_entries(here, there), [], [])
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
    return explain_entries(here, there)


def _count_unexplained(wrong_entries: Sequence[EntryMismatch]) -> int:
    """Number of entries that are wrong on the user's arm without a reported reason."""
    return sum(
        each.explanation is None and not each.notes for each in wrong_entries if not each.shown_on
    )
