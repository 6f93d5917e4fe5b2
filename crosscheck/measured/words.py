"""What a comparison with a record says, sentence by sentence: every view begins with the same."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from crosscheck.measured.compare import EngineDisagreement, Explanation, RecordComparison, Repair
from crosscheck.measured.engines import REFERENCE, EngineDeviation
from crosscheck.measured.friction import FrictionFit, JointFriction
from crosscheck.measured.parameters import Estimate

LEVEL_WORDS = {
    "links": "links alone (links)",
    "carriers": "links with the gears' masses (carriers)",
    "armature": "gears' inertia on the diagonal (armature)",
    "coupled": "rigid gears (coupled)",
}
NONE_FITS = "No model fits the recording with the file's numbers"
LARGEST_RATIO = 1e12  # that is written out
MOST_DIGITS = 15


def answers(found: RecordComparison | EngineDisagreement) -> list[str]:
    """The sentences that answer, the most important one first."""
    if isinstance(found, EngineDisagreement):
        return list(_disagreement(found))
    return [*_verdict(found), *_runs(found)]


def _disagreement(found: EngineDisagreement) -> Iterator[str]:
    """Who disagrees, who stands alone, and that nothing is said of the record."""
    apart = [engine for engine in found.engines if not engine.agrees]
    worst = max(apart, key=lambda engine: engine.measured)
    reference = f"{REFERENCE}:{worst.level}"
    if worst.failure:
        said = f"The engines do not agree on the arm: {worst.name} failed ({worst.failure})"
    else:
        said = (
            f"The engines disagree on the arm: torques of {reference} and {worst.name} are"
            f" {number(worst.measured)} of their terms apart, at most"
            f" {number(worst.tolerance)} is rounding"
        )
    yield f"{said}. Nothing is said about the recording."
    for engine in apart:
        if not engine.failure:
            yield _outsider(engine)


def _outsider(engine: EngineDeviation) -> str:
    pair = {f"{REFERENCE}:{engine.level}", engine.name}
    if len(engine.alone) == 1:
        (right,) = pair - set(engine.alone)
        return f"{engine.alone[0]} stands alone: {right} agrees with first principles."
    said = "both differ from first principles" if engine.alone else "neither stands alone"
    return f"{' and '.join(sorted(pair))}: {said}."


def _verdict(found: RecordComparison) -> Iterator[str]:
    """What explains the record, and by how much it is the best."""
    best, others = found.best, found.levels[1:]
    left = f"chi squared is {number(found.own_chi2 / found.own_freedom)} per degree of freedom"
    explanations = found.explanations
    if found.decided:
        next_best = min(others, key=lambda level: level.ratio)
        yield f"The recording fits {LEVEL_WORDS[best.name]} with the file's numbers."
        yield (
            f"It leaves noise alone ({left}); {next_best.name}, the next best, is"
            f" {likelihood(next_best.ratio)} times less likely."
        )
    elif found.explained:
        names = " and ".join(found.candidates)
        yield f"The recording fits {names} with the file's numbers and does not distinguish them."
        yield f"All of these leave noise alone ({left} of {best.name})."
    elif explanations:
        yield _explained_by(explanations[0], "The recording fits")
        if explanations[1:]:
            yield "Other changes explain it too, and the recording does not distinguish them:"
            yield from (_explained_by(each, "it fits") for each in explanations[1:])
        yield f"{NONE_FITS}; nearest is {best.name} ({left})."
    else:
        yield f"{NONE_FITS}."
        yield f"Nearest is {best.name} ({left}); no one number and no friction explains the rest."
        nearest = next((each for each in found.single if each.is_possible), None)
        if nearest is not None:
            yield f"The change that explains most: {estimate(nearest)}."
    for repair in found.repairs:
        if repair.arm is None:
            parameter = repair.estimate.parameter
            value = _value(repair.estimate)
            yield (
                f"{LEVEL_WORDS[repair.level]} would need {parameter.phrase} to be {value}"
                f" {parameter.unit}, which is impossible."
            )


def _explained_by(change: Explanation, begin: str) -> str:
    """The sentence that a person would say of an explanation."""
    fits = f"{begin} {LEVEL_WORDS[change.level]}"
    if isinstance(change, Repair):
        parameter = change.estimate.parameter
        return (
            f"{fits} if {parameter.phrase} is {_value(change.estimate)} {parameter.unit};"
            f" the file says {parameter.value:.6g}."
        )
    return f"{fits} with friction: {'; '.join(map(_friction, change.joints))}."


def _friction(each: JointFriction) -> str:
    coulomb = written(each.coulomb, each.coulomb_half_width, 0.0)
    viscous = written(each.viscous, each.viscous_half_width, each.in_file)
    return (
        f"joint {each.joint}: Coulomb {coulomb} N m (the file has none) and viscous {viscous}"
        f" N m s/rad (the file says {each.in_file:.6g})"
    )


def _runs(found: RecordComparison) -> Iterator[str]:
    """How long runs stay with the record."""
    if not found.windows:
        return
    stays = np.median([window.stays_s for window in found.windows])
    long = np.median([window.time[-1] - window.time[0] for window in found.windows])
    inside = np.mean([window.within for window in found.windows])
    yield (
        f"{len(found.windows)} runs of {found.best.name} from the record's states stay within"
        f" 3 u_val for {stays:.3g} s of {long:.3g} s (median); |E| is at most 2 u_val at"
        f" {100 * inside:.0f} % of the rows."
    )


def change_words(change: Explanation | None) -> str:
    """What a figure of a residual says of the arm's numbers."""
    if change is None:
        return "with the file's numbers"
    if isinstance(change, FrictionFit):
        return "with Coulomb and viscous friction as estimated"
    parameter = change.estimate.parameter
    return f"with {parameter.name} {_value(change.estimate)} {parameter.unit}"


def _value(each: Estimate) -> str:
    return written(each.value, each.half_width, each.parameter.value)


def estimate(each: Estimate) -> str:
    """An estimate with its interval, the file's number and what it leaves."""
    parameter = each.parameter
    impossible = "" if each.is_possible else ", which is impossible"
    return (
        f"{parameter.name} {each.value:.6g} +- {each.half_width:.2g} {parameter.unit} (95 %)"
        f"{impossible}; the file says {parameter.value:.6g}; leaves a chi squared of"
        f" {number(each.left)} per degree of freedom"
    )


def written(value: float, half_width: float, in_file: float) -> str:
    """A value in three digits, or as many as state it within its interval or its change to 1 %."""
    enough = max(half_width, abs(value - in_file) / 100)
    for digits in range(3, MOST_DIGITS):
        text = f"{value:.{digits}g}"
        if abs(float(text) - value) <= enough:
            return text
    return repr(value)


def likelihood(ratio: float) -> str:
    """How much less likely a level is."""
    return f"{ratio:.2g}" if ratio < LARGEST_RATIO else f"over {LARGEST_RATIO:g}"


def number(value: float) -> str:
    """A number with three digits; with separators where it has more before its point."""
    return f"{value:,.0f}" if 1e3 <= value < 1e7 else f"{value:.3g}"


def values(row: Sequence[float] | np.ndarray, digits: int = 3) -> str:
    """The numbers of several joints."""
    return ", ".join(f"{value:.{digits}g}" for value in row)
