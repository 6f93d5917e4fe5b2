"""What a comparison with a record says, sentence by sentence: every view begins with the same."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import floor, log10

import numpy as np

from crosscheck.recordings.compare import EngineDisagreement, Explanation, RecordComparison, Repair
from crosscheck.recordings.engines import describe_disagreement
from crosscheck.recordings.friction import FrictionFit, JointFriction
from crosscheck.recordings.gravity import GravityFit
from crosscheck.recordings.parameters import Estimate
from crosscheck.registry import RIGID_ARM
from crosscheck.report.formatting import format_count

LEVEL_PHRASES = {
    "links": "links alone (links)",
    "carriers": "links with the gears' masses (carriers)",
    "armature": "gears' inertia on the diagonal (armature)",
    "coupled": "rigid gears (coupled)",
}
NONE_FITS = "No model fits the recording with the file's numbers"
LARGEST_RATIO = 1e12  # that is written out
MOST_DIGITS = 15


def describe_answers(comparison: RecordComparison | EngineDisagreement) -> list[str]:
    """The sentences that answer, the most important one first."""
    if isinstance(comparison, EngineDisagreement):
        return list(describe_disagreement(comparison.engines, "arm"))
    return [*_describe_verdict(comparison), *_describe_runs(comparison)]


def _describe_verdict(comparison: RecordComparison) -> Iterator[str]:
    """What explains the record, and by how much it is the best."""
    best, others = comparison.best, comparison.levels[1:]
    per_freedom = comparison.residual_chi2 / comparison.residual_freedom
    left = f"chi squared is {format_number(per_freedom)} per degree of freedom"
    explanations = comparison.explanations
    if comparison.decided:
        yield f"The recording fits {describe_level(comparison, best.name)} with the file's numbers."
        beside = [
            f"{each.name}, the next best, is {likelihood(each.ratio)} times less likely"
            for each in sorted(others, key=lambda level: level.ratio)[:1]
        ]
        yield f"It leaves noise alone ({left}){''.join(f'; {each}' for each in beside)}."
    elif comparison.explained:
        names = " and ".join(comparison.candidates)
        yield f"The recording fits {names} with the file's numbers and does not distinguish them."
        yield f"All of these leave noise alone ({left} of {best.name})."
    elif explanations:
        yield _describe_explanation(comparison, explanations[0], "The recording fits")
        if explanations[1:]:
            yield "The recording cannot tell these apart from it:"
            yield from (
                _describe_explanation(comparison, each, "it fits") for each in explanations[1:]
            )
        yield f"{NONE_FITS}; nearest is {name_level(comparison, best.name)} ({left})."
    else:
        yield f"{NONE_FITS}."
        name = name_level(comparison, best.name)
        yield (
            f"Nearest is {name} ({left}); no one number, no friction and no gravity explains"
            " the rest."
        )
        nearest = next((each for each in comparison.single if each.is_possible), None)
        if nearest is not None:
            yield f"The change that explains most: {format_estimate(nearest)}."
    for repair in comparison.repairs:
        if repair.arm is None:
            parameter = repair.estimate.parameter
            value = _format_estimate_value(repair.estimate)
            level = describe_level(comparison, repair.level)
            yield (
                f"{level} would need {parameter.phrase} to be {value}"
                f" {parameter.unit}, which is impossible."
            )


def name_level(comparison: RecordComparison, level: str) -> str:
    """A level's name, or that of the only one that the arm has."""
    return level if comparison.levels[1:] else f"the {RIGID_ARM}"


def describe_level(comparison: RecordComparison, level: str) -> str:
    """A level in a phrase."""
    return LEVEL_PHRASES[level] if comparison.levels[1:] else name_level(comparison, level)


def _describe_explanation(comparison: RecordComparison, change: Explanation, begin: str) -> str:
    """The sentence that a person would say of an explanation."""
    fits = f"{begin} {describe_level(comparison, change.level)}"
    if isinstance(change, Repair):
        parameter = change.estimate.parameter
        return (
            f"{fits} if {parameter.phrase} is {_format_estimate_value(change.estimate)}"
            f" {parameter.unit};"
            f" the file says {format_exact(parameter.value)}."
        )
    if isinstance(change, GravityFit):
        return f"{fits} if {change.gravity.describe()}"
    return f"{fits} with friction: {'; '.join(map(_describe_friction, change.joints))}."


def _describe_friction(each: JointFriction) -> str:
    coulomb = format_value(each.coulomb, each.coulomb_half_width, 0.0)
    viscous = format_value(each.viscous, each.viscous_half_width, each.in_file)
    return (
        f"joint {each.joint}: Coulomb {coulomb} N m (the file has none) and viscous {viscous}"
        f" N m s/rad (the file says {format_exact(each.in_file)})"
    )


def _describe_runs(comparison: RecordComparison) -> Iterator[str]:
    """How long runs stay with the record."""
    if not comparison.windows:
        return
    stays = np.median([window.stays_s for window in comparison.windows])
    long = np.median([window.time[-1] - window.time[0] for window in comparison.windows])
    inside = np.mean([window.within for window in comparison.windows])
    name = name_level(comparison, comparison.best.name)
    start = f"Simulated from {format_count(len(comparison.windows), 'recorded state')}"
    leaves = (
        "leaves its uncertainty band (3 sigma) after"
        if stays < long
        else "stays in its uncertainty band (3 sigma) for"
    )
    median = " (median)" if len(comparison.windows) > 1 else ""
    yield (
        f"{start}, {name} {leaves} {stays:.3g} s of {long:.3g} s{median};"
        f" {100 * inside:.0f} % of the rows are within 2 sigma."
    )


def change_words(change: Explanation | None) -> str:
    """What a figure of a residual says of the arm's numbers."""
    if change is None:
        return "with the file's numbers"
    if isinstance(change, FrictionFit):
        return "with Coulomb and viscous friction as estimated"
    if isinstance(change, GravityFit):
        return "with gravity as estimated"
    parameter = change.estimate.parameter
    return f"with {parameter.name} {_format_estimate_value(change.estimate)} {parameter.unit}"


def _format_estimate_value(each: Estimate) -> str:
    return format_value(each.value, each.half_width, each.parameter.value)


def format_estimate(each: Estimate) -> str:
    """An estimate with its interval, the file's number and what it leaves."""
    parameter = each.parameter
    impossible = "" if each.is_possible else ", which is impossible"
    return (
        f"{parameter.name} {_format_to_interval(each)} +- {each.half_width:.2g} {parameter.unit}"
        f" (95 %){impossible}; the file says {format_exact(parameter.value)}; leaves a chi squared"
        f" of {format_number(each.left)} per degree of freedom"
    )


def format_value(value: float, half_width: float, in_file: float) -> str:
    """A value in three digits, or as many as state it within its interval or its change to 1 %."""
    enough = max(half_width, abs(value - in_file) / 100)
    for digits in range(3, MOST_DIGITS):
        text = f"{value:.{digits}g}"
        if abs(float(text) - value) <= enough:
            return text
    return repr(value)


def _format_to_interval(each: Estimate) -> str:
    """An estimate in six digits, or as many as show the second one of its interval."""
    digits = 6
    if each.value and each.half_width:
        digits = max(digits, 2 + floor(log10(abs(each.value))) - floor(log10(each.half_width)))
    return f"{each.value:.{min(digits, MOST_DIGITS)}g}"


def format_exact(value: float) -> str:
    """A number of a file in six digits, or as many as give it back."""
    texts = (f"{value:.{digits}g}" for digits in range(6, 18))
    return next(text for text in texts if float(text) == value)


def format_distinct(values: Sequence[float], digits: int = 3) -> list[str]:
    """Numbers in so many digits, or as many as make different ones read differently."""
    for more in range(digits, 18):
        texts = [f"{value:.{more}g}" for value in values]
        if len(set(texts)) == len(set(values)):
            break
    return texts


def likelihood(ratio: float) -> str:
    """How much less likely a level is."""
    return f"{ratio:.2g}" if ratio < LARGEST_RATIO else f"over {LARGEST_RATIO:g}"


def format_number(value: float) -> str:
    """A number with three digits; with separators where it has more before its point."""
    return f"{value:,.0f}" if 1e3 <= value < 1e7 else f"{value:.3g}"


def format_values(row: Sequence[float] | np.ndarray, digits: int = 3) -> str:
    """The numbers of several joints."""
    return ", ".join(f"{value:.{digits}g}" for value in row)
