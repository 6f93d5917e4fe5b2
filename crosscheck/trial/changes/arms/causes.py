"""Why entries are wrong: their differences on the arm, and on others, made by changes of terms."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import permutations
from typing import Any

import numpy as np

from crosscheck.trial.changes.arms.comparison import QUANTITIES, EntryComparison
from crosscheck.trial.changes.arms.mesh_forces import compute_signals, list_mesh_laws
from crosscheck.trial.changes.arms.polynomial import as_polynomial
from crosscheck.trial.changes.arms.segments import (
    ReferenceTerms,
    build_reference_terms,
    evaluate_entry,
    rate_name,
)
from crosscheck.trial.changes.arms.steps import find_steps
from crosscheck.trial.changes.arms.targets import (
    TargetRow,
    make_balance_target,
    make_entry_target,
    make_target,
)
from crosscheck.trial.changes.arms.term_changes import Target, TermChange
from crosscheck.trial.changes.arms.term_search import FITS, ChangeSet, find_singles, search_changes
from crosscheck.trial.changes.arms.term_words import (
    error_signature,
    join_terms,
    make_difference_terms,
    make_term,
    make_term_error,
)
from crosscheck.trial.changes.forms import exchange_rows, scale_part
from crosscheck.trial.judge import entries
from crosscheck.trial.judge.entries import (
    EntryMismatch,
    EntryPlace,
    Explanation,
    TermError,
)

SAME = 1e-12  # tolerance between two readings of a map, relative to its row
FOLLOWS = "follows from the wrong M"


def explain_entries(arm: EntryComparison, probes: Sequence[EntryComparison]) -> list[EntryMismatch]:
    """The wrong entries with their reasons; then those that only another arm shows.

    probes: the same on arms of the same structure and other numbers.
    """
    if probes and probes[0].columns is not None and _is_same_map(probes[0].columns, arm):
        arm = replace(arm, letters=probes[0].columns)  # equal numbers are no letter's own
    if set(arm.user_values) == {"acceleration"} and arm.terms is not None:
        return list(_explain_accelerations(arm, probes))
    return _explain_parts((arm, *probes), list(_explain_arms(arm, probes)))


def _is_same_map(columns: np.ndarray, arm: EntryComparison) -> bool:
    """Whether a map in letters has the same numbers as the user's map of an arm."""
    matrix = arm.frame.matrix
    if matrix is None:
        return False
    numbers = [as_polynomial(entry).value(arm.values) for entry in columns.ravel()]
    off = np.abs(np.reshape(numbers, matrix.shape) - matrix)
    return bool((off <= SAME * np.abs(matrix).max(axis=1, keepdims=True)).all())


def _collect_errors(wrong_entries: Sequence[EntryMismatch]) -> dict[object, entries.TermError]:
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
    if arm.terms is None or place.part == "acceleration":
        return wrong
    if place.rates is not None and arm.is_caused_by_mass(place):
        return replace(wrong, notes=(FOLLOWS,))
    waves = arm.fit_waves(place)
    arms = [each for each in arms if QUANTITIES[place.part] in each.user_values]
    target = make_entry_target(arms, place)
    sets = search_changes(target, _list_whole_weights(arms, place, target))
    if not sets and place.part == "force" and waves is None:
        target = make_entry_target(arms[:1], place)
        sets = search_changes(target, _list_law_changes(arm, place, target))
    if sets:
        return replace(wrong, explanation=_make_explanation(target, sets))
    difference = make_difference_terms(waves or {}, arm.terms)
    latex = join_terms(term.latex for term in difference)
    return replace(wrong, difference=difference, latex=latex)


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
    words = "the weight of every body"
    return [TermChange("extra", (), np.array(weights), 1.0, right="gravity", group=words)]


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
        states, convention = arm.force_states, law.convention
        signals = compute_signals(law.arm, frame.layout, law.switches, states, convention)
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
        quantity = QUANTITIES[part]
        if any(each.terms is None or quantity not in each.user_values for each in arms):
            continue
        group = _prefer_shared_errors(group, arms[0].values)
        explanations |= {w.place: w.explanation for w in group if w.explanation}
        explanations |= _find_moved_terms(arms, group)
        group = [replace(each, explanation=explanations.get(each.place)) for each in group]
        if len(_collect_errors(group)) != 1 or not all(wrong.explanation for wrong in group):
            explanations |= _explain_part(arms, [wrong.place for wrong in group])
    return [
        wrong
        if wrong.shown_on
        else replace(wrong, explanation=explanations.get(wrong.place, wrong.explanation))
        for wrong in wrong_entries
    ]


def _find_moved_terms(
    arms: Sequence[EntryComparison], group: Sequence[EntryMismatch]
) -> dict[EntryPlace, Explanation]:
    """Terms of the bias that are missing in one entry and too many in another, by both entries.

    They stand before other rates, or in another row.
    """
    moved, names = dict[EntryPlace, Explanation](), arms[0].frame.names
    for wrong, other in permutations(group, 2):
        here, there, explanation = wrong.place, other.place, wrong.explanation
        if here.rates is None or there.rates is None or explanation is None:
            continue
        in_row, (error, *more) = here.row == there.row, explanation.errors
        if more or error.kind != "dropped" or not (in_row or here.rates == there.rates):
            continue
        sums = [np.abs(arm.difference(here)[0] + arm.difference(there)[0]).max() for arm in arms]
        least = [FITS * np.abs(arm.difference(here)[0]).max() + arm.noise(here) for arm in arms]
        if all(off <= allowed for off, allowed in zip(sums, least, strict=True)):
            yours, right = (
                entries.format_rates(each.rates or (0, 0), names)
                if in_row
                else f"row {names[each.row]}"
                for each in (there, here)
            )
            swapped = TermError("swapped", error.term, yours, right)
            moved |= dict.fromkeys((here, there), Explanation((swapped,), explanation.left_over))
    return moved


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
    if errors := find_steps(arms, part, [scale_part, exchange_rows]):
        return dict.fromkeys(wrong, _explain_by_any(errors))
    if arms[0].problem.has_gravity and part == "force":
        return {}  # without weights there is nothing to derive
    errors = find_steps(arms, part)
    return dict.fromkeys(wrong, _explain_by_any(errors)) if errors else {}


def _explain_by_any(errors: Sequence[TermError]) -> Explanation:
    """Explain a difference by the first of several errors that each make it alone."""
    return Explanation((errors[0],), 0.0, tuple((each,) for each in errors[1:]))


def _explain_accelerations(
    arm: EntryComparison, probes: Sequence[EntryComparison]
) -> Iterator[EntryMismatch]:
    """The wrong entries of accelerations alone, by changes of the equations behind them.

    With the right M, h and f, M a + h - f of a user's acceleration a is f' - f - (h' - h) -
    (M' - M) a of his own M', h' and f'. So a change shows in the rows that have it, and no other.
    """
    arms = [each for each in (arm, *probes) if "acceleration" in each.user_values]
    explanation = _explain_balances(arms, [_balance_accelerations(each) for each in arms])
    if explanation is None or len(explanation.errors) > 1:
        errors = find_steps(arms, "acceleration")
        explanation = _explain_by_any(errors) if errors else explanation
    for wrong in _explain_arms(arm, probes):
        yield wrong if wrong.shown_on else replace(wrong, explanation=explanation)


def _balance_accelerations(comparison: EntryComparison) -> np.ndarray:
    """The force (K, n) that M makes of the differences of accelerations."""
    mass, *_ = comparison.problem.list_trusted_answers(comparison.level)
    right = comparison.reference_values["acceleration"]
    wrong = comparison.user_values["acceleration"] - right
    force: np.ndarray = np.einsum("sij,sj->si", mass, wrong)
    return force


def _explain_balances(
    arms: Sequence[EntryComparison], balances: Sequence[np.ndarray]
) -> Explanation | None:
    """Explain the residual in the rows of M a + h - f."""
    terms = arms[0].terms
    assert terms is not None  # else nobody asks
    pairs = zip(arms, balances, strict=True)
    wrong = np.any([np.abs(b).max(axis=0) > FITS * arm.sizes.force for arm, b in pairs], axis=0)
    rows = dict[int, tuple[Target, list[ChangeSet]]]()
    for row in np.flatnonzero(wrong).tolist():
        target = make_balance_target(arms, balances, row)
        changes = search_changes(target)
        if not changes:
            break
        rows[row] = target, changes
    each = [_make_explanation(*given) for given in rows.values()]
    errors = {error_signature(e): e for explanation in each for e in explanation.errors}
    if not rows or len(rows) < wrong.sum():
        return None
    where = ", ".join(_name_places(changes[0], terms) for _, changes in rows.values())
    return Explanation(tuple(errors.values()), 0.0, (), f"{where}, which M x'' shows")


def _name_places(changes: ChangeSet, terms: ReferenceTerms) -> str:
    places = dict.fromkeys(place for change in changes for place, _ in change.terms)
    return ", ".join(entries.format_entry(place, terms.names) for place in places)


def explain_linear_rates(arm: EntryComparison) -> Iterator[EntryMismatch]:
    """Entries of the bias in which one rate stands where a product of two belongs.

    At rates of 1 nobody sees that; the bias at opposite rates has the opposite sign of it.
    """
    problem, terms = arm.problem, arm.terms
    bias = arm.results.get(problem.ask_equations("bias"))
    others = arm.results.get(problem.ask_equations("other_speeds"))
    if bias is None or others is None or terms is None:
        return
    odd = (bias - others[:, 0]) / 2
    for row, size in enumerate(arm.sizes.bias.tolist()):
        relative = float(np.abs(odd[:, row]).max() / size)
        if relative <= arm.sizes.tolerance("bias"):
            continue
        for place in terms.entries:
            for rate in dict.fromkeys(place.rates or ()) if place.row == row else ():
                line = TargetRow(odd[:, row], FITS * size, {place: arm.rates[:, rate]})
                target = make_target([arm], [line], "bias")
                singles = find_singles(target, target.list_changes())
                if extra := [change for (change,) in singles if change.by == 2]:
                    term, names = make_term(extra[0].products, terms), terms.names
                    right = entries.format_rates(place.rates or (0, 0), names)
                    error = TermError("swapped", term, rate_name(names[rate]), right)
                    yield EntryMismatch(place, relative, Explanation((error,), 0.0))
