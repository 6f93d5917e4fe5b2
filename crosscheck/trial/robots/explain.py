"""Errors of a user's equations of a robot, in words; each explanation holds at every state."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robot_states import TOLERANCE, WITH_WEIGHTS
from crosscheck.models.robot.robot import Level
from crosscheck.report.formatting import join_words, list_first
from crosscheck.trial.changes.kane import FACTORS
from crosscheck.trial.changes.numbers import ALIKE
from crosscheck.trial.changes.search import (
    CauseSearch,
    describe_causes,
    find_explanations,
    find_rarer_explanations,
    name_causes,
)
from crosscheck.trial.changes.table import ChangeTable
from crosscheck.trial.judge.entries import (
    LONE,
    PART_TITLES,
    EntryMismatch,
    EntryPlace,
    LevelDistance,
    describe_entry_notes,
    format_rates,
    interleave,
    list_entries,
    select_counted,
)
from crosscheck.trial.result import TrialDiagnosis
from crosscheck.trial.robots.consistency import BiasTerms, sample_bias_terms, term_sizes
from crosscheck.trial.robots.forms import (
    describe_accelerations,
    describe_angle_sum,
    describe_asymmetry,
    describe_friction,
    describe_pieces,
    format_factor,
)
from crosscheck.trial.robots.judge import SINGLE, RobotProblem, select_entry
from crosscheck.trial.robots.readings import find_readings, is_nearer_absolute

SHOWN = 1e-5  # least deviation of a ratio from 1 that is shown: ratios have six digits
MISSING, EXTRA = "missing", "the right value is 0"
ROUNDED = 1e-5  # largest difference, relative to an entry's size, that rounded numbers may cause
USUAL = (MISSING, *map(format_factor, FACTORS))  # factors that need no other cause
NO_CAUSE = "no single number, frame or place explains it"
Rates = Callable[[], BiasTerms | None]  # the terms of the user's bias, asked only if it is wrong


def diagnose(
    problem: RobotProblem, distances: Sequence[LevelDistance], rates: Rates
) -> TrialDiagnosis:
    """Find what makes the difference; distances: of the levels, the nearest first."""
    nearest = distances[0]
    if not nearest.entries:
        return TrialDiagnosis(nearest.level)
    parts = _wrong_parts(problem.entries(nearest.level))
    if parts != ["gravity"] or len(problem.parts) == 1:
        by_coordinates = _diagnose_reading(problem)
        if by_coordinates is not None:
            return by_coordinates
    allowed = _select_levels(problem, distances)
    table = ChangeTable(problem.compare(nearest.level))
    compared = {each.level: problem.compare(each.level) for each in allowed}
    searches = {level: CauseSearch(each, table) for level, each in compared.items()}
    level, explanations = find_explanations(searches, allowed)
    if not explanations and _are_several_wrong(problem, level):
        level, explanations = find_rarer_explanations(searches, allowed)
    entries = [_add_remark(problem, level, entry) for entry in problem.entries(level)]
    is_open = not explanations and problem.equations.has_open_angles
    wrong = _wrong_parts(entries)
    right = [part for part in problem.parts if part in SINGLE or len(wrong) == 1]
    right = [part for part in right if all(entry.part != part for entry in entries)]
    notes = list(_self_notes(problem, level, entries))
    agreeing = [each.level for each in distances if not each.entries]
    notes += [f"all parts agree with {each}, not with {problem.stated}" for each in agreeing]
    notes += _lone_part_notes(entries, wrong, right)
    if not explanations and (largest := entries[0].share) < ROUNDED:
        digits = int(-np.log10(largest)) + 1
        notes.append(f"agrees to {largest:.1g}: numbers rounded to {digits} digits?")
    search, is_explained = searches[level], bool(explanations)
    pieces, causes = dict[str, list[str]](), {part: list[str]() for part in wrong}
    if not is_explained:
        pieces = _describe_lone_product(problem, level, entries, rates) or {
            part: list(describe_pieces(search, part)) for part in wrong if part in SINGLE
        }
        for part in (each for each in wrong if not pieces.get(each)):
            alone = len(wrong) == 1
            causes[part] = list(_describe_causes_within(search, part, entries, alone))
    has_cause = is_explained or pieces.get("bias") or causes.get("bias")
    if "bias" in wrong and not has_cause and (terms := rates()) is not None:
        pieces["bias"] = list(_bias_notes(problem, level, terms))
        if not pieces["bias"] or not all(words.endswith(USUAL) for words in pieces["bias"]):
            pieces["bias"] += describe_pieces(search, "bias", are_usual=False)
    if "acceleration" in wrong and not is_explained:
        pieces["acceleration"] = list(_describe_accelerations(problem, search, entries))
    if "force" in wrong:
        difference = _compute_difference(problem, level, "force")
        by_friction = describe_friction(problem, level, "force", difference)
        pieces["force"] = [words for words, _ in by_friction]
    for part, sentences in causes.items():
        sentences[:0] = pieces.get(part, [])
        if len(wrong) > 1 and not (sentences or is_explained):
            sentences += describe_entry_notes([each for each in entries if each.part == part])
            sentences += [f"{part}: {LONE}"] * (not sentences and part not in SINGLE)
    notes += interleave(causes.values())
    explanations.sort(key=lambda cause: not cause.usual)
    words = tuple(name_causes(explanations))
    if wrong == ["gravity"] and len(problem.parts) > 1:  # by another zero of a coordinate
        words += tuple(each.words for each in find_readings(problem)[1])
    if not (words or notes):
        notes = list(describe_entry_notes(entries))
    unexplained = () if words or notes else (NO_CAUSE,)
    return TrialDiagnosis(
        level,
        tuple(entries),
        tuple(notes),
        unexplained,
        explanations=words,
        is_unusual=any(not each.usual or each.is_compound for each in explanations[:1]),
        is_nearer_absolute=is_open and is_nearer_absolute(problem, level),
    )


def _describe_accelerations(
    problem: RobotProblem, search: CauseSearch, entries: Sequence[EntryMismatch]
) -> Iterator[str]:
    """Sentences on accelerations: the terms that are wrong, then what is wrong in single rows."""
    yield from describe_pieces(search, "acceleration")
    rows = [entry.place.row for entry in entries if entry.part == "acceleration"]
    yield from describe_accelerations(problem, search.level, rows)
    for row in rows:
        causes = list(search.find_acceleration_causes(row))
        yield from describe_causes(causes, problem.entry_name("acceleration", [row]))


def _describe_lone_product(
    problem: RobotProblem, level: Level, entries: Sequence[EntryMismatch], rates: Rates
) -> dict[str, list[str]]:
    """The sentence on the one product of rates that is wrong, or on all of one row.

    A search over terms of Kane's sum would find several equal explanations of so small an error.
    """
    lone = len({entry.name for entry in entries if entry.part in SINGLE}) == 1
    if not lone or "bias" not in _wrong_parts(entries) or (terms := rates()) is None:
        return {}
    rounding = TOLERANCE * problem.sizes[level].bias[: len(terms.rest)].max()
    if max(np.abs(terms.rest).max(), np.abs(terms.linear).max()) > rounding:
        return {}
    sentences, others = _describe_products(problem, level, terms)
    if len(sentences) != 1 or others:
        return {}
    return {"bias": sentences}


def _diagnose_reading(problem: RobotProblem) -> TrialDiagnosis | None:
    """Diagnosis if the coordinates alone are wrong."""
    level, readings = find_readings(problem)
    if level is None:
        return None
    entries = [_add_remark(problem, level, entry) for entry in problem.entries(level)]
    causes = []
    for each in readings:
        if len(each.joints) == 1:
            causes.append(f"joint {each.joints[0]}: its axis the other way")
        elif len(each.joints) == len(problem.names):
            causes.append("every joint: its axis the other way")
    words = tuple(dict.fromkeys(each.described for each in readings))
    explanations = tuple(causes)
    return TrialDiagnosis(level, tuple(entries), explanations=explanations, readings=words)


def _select_levels(
    problem: RobotProblem, distances: Sequence[LevelDistance]
) -> list[LevelDistance]:
    """The levels at which one change may explain all.

    Of equal levels the first is taken. At one where gravity, the bias or one entry alone is wrong
    nothing else of the level is, so that an explanation at a level of more wrong entries would be
    chance.
    """
    nearest = distances[0]
    if problem.stated:
        return [nearest]
    distances = [
        each
        for place, each in enumerate(distances)
        if not any(problem.are_alike(each.level, other.level) for other in distances[:place])
    ]
    wrong = {entry.part for entry in problem.entries(nearest.level)}
    alone = len(wrong) == 1 and len(problem.parts) > 1
    if not alone or ("mass_matrix" in wrong and nearest.entries > 1):
        return list(distances)
    return [each for each in distances if each.entries == nearest.entries]


def _are_several_wrong(problem: RobotProblem, level: Level) -> bool:
    """Whether a link may be wrong: in several parts, or in one that nothing stands beside.

    Where one part alone is wrong the others follow from the file's links.
    """
    entries = problem.entries(level)
    wrong = _wrong_parts(entries)
    return len(wrong) > 1 or not (set(problem.parts) & set(SINGLE)) - set(wrong)


def _wrong_parts(entries: Sequence[EntryMismatch]) -> list[str]:
    """The wrong parts, without those that others of them make."""
    return list(dict.fromkeys(entry.part for entry in select_counted(entries)))


def _add_remark(problem: RobotProblem, level: Level, entry: EntryMismatch) -> EntryMismatch:
    """The entry with words on what it is beside the right one, where a few are enough."""
    part, right = entry.part, problem.reference_values[level]
    arrays = problem.answers.values[part], right[part], problem.sizes[level].entry_sizes(part)
    yours, expected, size = (select_entry(each, entry.place.index) for each in arrays)
    may_wave = part not in ("bias", "acceleration")  # which have rates in them
    words = _compare_values(problem, yours, expected, size * TOLERANCE, may_wave=may_wave)
    return replace(entry, notes=(words,) if words else ())


def _compare_values(
    problem: RobotProblem,
    yours: np.ndarray,
    right: np.ndarray,
    rounding: np.ndarray,
    *,
    may_wave: bool = True,
) -> str:
    """Words on values (states,) beside the right ones: their ratio, and a wave between them."""
    q, robot = problem.states.q[: len(yours)], problem.robot
    wave = describe_angle_sum(yours - right, q, robot) if may_wave else ""
    words = describe_ratio(yours, right, rounding), f"yours minus right is {wave}" * bool(wave)
    return "; ".join(filter(None, words))


def describe_ratio(
    user_values: np.ndarray, reference_values: np.ndarray, rounding: np.ndarray
) -> str:
    """Constant ratio of yours to right (states,), in words; '' if it varies with the state."""
    if (np.abs(reference_values) <= rounding).all():
        return EXTRA
    if (np.abs(user_values) <= rounding).all():
        return MISSING
    ratio = float(user_values @ reference_values / (reference_values @ reference_values))
    if not (
        np.abs(user_values - ratio * reference_values)
        <= ALIKE * np.abs(ratio * reference_values) + rounding
    ).all():
        return ""
    if abs(ratio - 1) < SHOWN:
        return ""
    return format_factor(ratio)


def _compute_difference(problem: RobotProblem, level: Level, part: str) -> np.ndarray:
    """Yours less right (states, ...)."""
    return problem.answers.values[part] - problem.reference_values[level][part]


def _lone_part_notes(
    entries: Sequence[EntryMismatch], wrong: Sequence[str], right: Sequence[str]
) -> Iterator[str]:
    """The sentence that one part alone is wrong, or one entry of it, while others are right."""
    if len(wrong) != 1 or not right:
        return
    within = [entry for entry in entries if entry.part == wrong[0]]
    name = within[0].name if len(within) == 1 else PART_TITLES.get(wrong[0], wrong[0])
    verb = "is" if len(right) == 1 else "are"
    remark = f": {within[0].remark}" if len(within) == 1 and within[0].remark else ""
    others = join_words([PART_TITLES.get(part, part) for part in right])
    yield f"{name} alone is wrong{remark}; {others} {verb} right"


def _bias_notes(problem: RobotProblem, level: Level, terms: BiasTerms) -> Iterator[str]:
    """Sentences on a bias that is wrong: what is no product of two rates, then wrong terms."""
    sizes, few = problem.sizes[level], slice(len(terms.rest))
    size = sizes.entry_sizes("bias", problem.answers.sources["bias"])[few]
    rounding = TOLERANCE * (size + sizes.gravity[few])  # the terms are sums of a few answers each
    names, difference = problem.names, _compute_difference(problem, level, "bias")
    by_friction = list(describe_friction(problem, level, "bias", difference))
    wrong = (np.abs(difference[few]) > rounding).any(axis=0)
    if set(np.flatnonzero(wrong)) <= {row for _, rows in by_friction for row in rows}:
        yield from (words for words, _ in by_friction)
        return
    left = np.abs(problem.answers.values["bias"][few] - terms.evaluate(problem.states.v[few]))
    if (left > rounding).any():
        yield "bias is not a sum of a constant, rates and products of two rates, as it must be"
        return
    if (np.abs(terms.rest) > rounding).any():
        yield "bias at rest is not 0: beside gravity it is Coriolis and centrifugal torques alone"
    linear = np.einsum("sij,sj->si", terms.linear, problem.states.v[few])
    by_friction = list(describe_friction(problem, level, "bias", linear))
    yield from (words for words, _ in by_friction)
    yield from _linear_notes(terms, size, names, {row for _, rows in by_friction for row in rows})
    sentences, others = _describe_products(problem, level, terms)
    yield from sentences
    if others:
        yield f"wrong terms: {list_first(others)}"


def _self_notes(
    problem: RobotProblem, level: Level, entries: Sequence[EntryMismatch]
) -> Iterator[str]:
    """Sentences on what the equations owe to themselves and do not keep, or keep although wrong."""
    if words := describe_asymmetry(problem, level):
        yield words
    names, rows = problem.names, problem.find_self_places("bias", level)
    wrong_rows = {each.place.index for each in entries if each.part == "bias"}
    is_matrix_wrong = "mass_matrix" in _wrong_parts(entries)
    if "bias" in problem.self_differences and wrong_rows:
        # Of a wrong M the right rows of the bias do not follow either.
        places = [EntryPlace("bias", row) for (row,) in rows if (row,) in wrong_rows]
        if places:
            which = "" if is_matrix_wrong else ", which is right"
            do = "does" if len(places) == 1 else "do"
            yield f"{list_entries(places, names)} {do} not follow from M{which}"
        elif is_matrix_wrong and not rows:
            yield "bias follows from M: they are wrong together, by one cause"
    unlike = [(a, b) for a, b in problem.find_self_places("gravity", level) if a < b]
    for row, column in unlike[:1]:
        a, b = names[row], names[column]
        pairs = [f"{names[i]} and {names[j]}" for i, j in unlike[1:]]
        also = f"; so with {list_first(pairs)}" if pairs else ""
        yield (
            f"no potential energy gives this gravity vector: d gravity[{a}]/d {b} differs from"
            f" d gravity[{b}]/d {a}{also}"
        )


def _linear_notes(
    terms: BiasTerms, size: np.ndarray, names: Sequence[str], explained: Collection[int]
) -> Iterator[str]:
    """The sentence on a part of the bias that is linear in the rates, in rows not yet explained."""
    linear_terms, is_constant = [], True
    for row, column in np.ndindex(terms.linear.shape[1:]):
        values = terms.linear[:, row, column]
        if row not in explained and np.abs(values).max() > TOLERANCE * size[:, row].max():
            constant = np.ptp(values) <= ALIKE * np.abs(values).max()
            factor = f"{values.mean():.6g} " if constant else ""
            is_constant &= constant
            linear_terms.append(f"{factor}{names[column]}' in bias[{names[row]}]")
    if linear_terms:
        listed = list_first(linear_terms)
        friction = ": friction? State it as viscous_friction." if is_constant else ""
        yield f"bias has a part linear in v, {listed}{friction}"


def _describe_products(
    problem: RobotProblem, level: Level, user_terms: BiasTerms
) -> tuple[list[str], list[str]]:
    """Sentences on products of rates that are wrong, in the same way as one; those without."""
    states = problem.states.first(len(user_terms.rest))
    reference_terms = sample_bias_terms(AnalyticRobot(problem.robot, level).bias, states)
    with_weights = problem.answers.sources["bias"] in WITH_WEIGHTS
    sizes, names = term_sizes(problem.sizes[level], with_weights=with_weights), problem.names
    sizes = sizes[: len(user_terms.rest)]
    differences = np.abs(user_terms.products - reference_terms.products)
    terms_by_words: dict[str, list[str]] = {}
    others = list[str]()
    for row, name in enumerate(names):
        user_products, reference_products = (
            each.products[:, row] for each in (user_terms, reference_terms)
        )
        beyond = np.argwhere((differences[:, row] > TOLERANCE * sizes[:, row]).any(axis=0))
        if not beyond.size:
            continue
        small = TOLERANCE * sizes[:, row]
        whole = describe_ratio(user_products.ravel(), reference_products.ravel(), small.ravel())
        if whole and len(beyond) > 1:
            terms_by_words.setdefault(whole, []).append(f"bias[{name}], all products of rates")
            continue
        for j, k in beyond.tolist():
            terms = (each[:, j, k] for each in (user_products, reference_products, small))
            term = f"bias[{name}] of {format_rates((j, k), names)}"
            if words := _compare_values(problem, *terms):
                terms_by_words.setdefault(words, []).append(term)
            else:
                others.append(term)
    return [f"{list_first(terms)}: {words}" for words, terms in terms_by_words.items()], others


def _describe_causes_within(
    search: CauseSearch, part: str, entries: Sequence[EntryMismatch], alone: bool
) -> Iterator[str]:
    """Sentences on what makes the difference of a part in this part alone, or of its entries."""
    wrong = {each.name: each.place.index for each in entries if each.part == part}
    missing = {each.name for each in entries if each.remark.startswith(MISSING)}
    if not missing >= set(wrong):  # whatever makes an entry nothing explains one that is missing
        where, causes = search.find_within(part, wrong, alone=alone)
        unlike = {cause.words: cause for cause in causes}
        yield from describe_causes(list(unlike.values()), where)
