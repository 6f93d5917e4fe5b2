"""The answers of a comparison with records, sentence by sentence; every view begins with them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import floor, log10

import numpy as np

from crosscheck.identification.compare import EXCITED, RecordComparison, Side, SideResult
from crosscheck.identification.engines import describe_disagreement
from crosscheck.identification.excitation import DRAWN, Excitation
from crosscheck.identification.mechanism import ComparedMechanism
from crosscheck.identification.refinement import PossibleBodies, Refinement
from crosscheck.identification.restrictions import (
    LIKELIHOOD_RATIO,
    FileJudgement,
    Restriction,
    flag_friction,
)
from crosscheck.identification.terms import ROTOR_KINDS, TermEstimate
from crosscheck.models.robot.robot import Level
from crosscheck.report.formatting import format_count, format_rounded

SIDE_PHRASES: dict[Side, str] = {
    "motor": "torques of the motors",
    "joint": "torques at the joints",
    "between": "torques of the motors less those at the joints",
}
FITS: dict[Side, tuple[str, str]] = {
    "motor": ("The recording fits", "No level fits the recording"),
    "joint": (
        "Judged by the torques at the joints, the recording fits",
        "Judged by the torques at the joints, no level fits",
    ),
}
LARGE_REST_PERCENT = 20.0  # unexplained share of torques at which links and friction explain little
LARGE_FACTOR = 10.0  # on the torques of the file's links, from which on units are suspected
# Time between rows [s] of no controller, but of one whose times are in another unit.
UNUSUAL_STEPS = {"seconds": (0.0, 1e-5), "milliseconds": (0.2, np.inf)}
LARGEST_RATIO = 1e6  # largest likelihood ratio that is written out
MOST_DIGITS = 15
MOST_NAMES = 6
UNDETERMINED = "the record does not determine it"
EXCITATION_FILE = "excitation.csv"


def describe_answers(comparison: RecordComparison) -> list[str]:
    """The sentences that answer, the most important one first."""
    if not comparison.engines_agree:
        return list(describe_disagreement(comparison.engines, comparison.mechanism.noun))
    doubt = suspect_units(comparison)
    if doubt:
        return [doubt]
    sentences: list[str] = []
    if comparison.tilt is not None:
        sentences += [comparison.tilt.describe(), "What follows holds with that gravity."]
    if comparison.is_fitting and not comparison.is_clear:
        return [*sentences, *_describe_doubt(comparison)]
    judged = [(side, side.judgement) for side in comparison.sides if side.judgement is not None]
    for side, judgement in judged:
        sentences += _describe_judgement(comparison.mechanism, side, judgement)
    if comparison.has_explanation:
        for side, _ in judged:
            sentences += _describe_delay(side)
        return [*sentences, *_describe_runs(comparison)]
    return [*sentences, *_describe_terms(comparison)]


def _describe_doubt(comparison: RecordComparison) -> Iterator[str]:
    """That a level fits by its residuals alone, why that says nothing, and a better motion."""
    noun, judgements = comparison.mechanism.noun, comparison.judgements
    most = max(_find_most(each.best) for each in judgements if each.explained)
    reason = f"its residual is {format_number(most)} times that of freely fitted links"
    if comparison.leaves_at_once:
        reason += ", and simulated runs leave the record at once"
    share = 100 * max(float(side.unexplained.max()) for side in comparison.judged_sides)
    cause = "It is too short or too noisy, or a unit is wrong."
    if share >= LARGE_REST_PERCENT:
        rest = f"{format_rounded(share)} % of the torques unexplained"
        cause = f"Even these leave {rest}: are columns exchanged, or of another sense?"
    yield f"The recording cannot tell whether the {noun} is right: {reason}. {cause}"
    yield from _describe_runs(comparison)
    for side in comparison.judged_sides:
        if not side.is_excited:
            yield from _describe_side(side, _has_gears(comparison.mechanism))


def suspect_units(comparison: RecordComparison) -> str:
    """A line that asks for the units, of which what follows would be no more than a consequence.

    Empty where a level fits the record, links need no factor that no wrong link has, and rows
    are as far apart as those of a controller.
    """
    if not comparison.engines_agree or comparison.is_fitting:
        return ""
    head, asked = "The units may be wrong:", "Check the units of time, angles and torques."
    for record in comparison.records:
        for unit, (least, most) in UNUSUAL_STEPS.items():
            if least < record.step < most:
                return f"{head} rows are {record.step:.3g} s apart. Is the time in {unit}? {asked}"
    factors = [abs(each.value) for side in comparison.sides for each in side.wrong_factors]
    if any(not 1 / LARGE_FACTOR < value < LARGE_FACTOR for value in factors):
        return f"{head} the torques are far from those of the file's links. {asked}"
    return ""


def _describe_judgement(
    mechanism: ComparedMechanism, side: SideResult, judgement: FileJudgement
) -> Iterator[str]:
    """Whether the files' numbers explain the torques of a side, or a change of one does."""
    fits, none = FITS[side.side]
    none += " with the file's numbers"
    best, explanations = judgement.best, judgement.explanations
    least = judgement.levels[0]
    left = f"{_format_most(least)} times that of freely fitted links"
    name = mechanism.describe_level
    if judgement.explained and len(explanations) == 1:
        yield f"{fits} {name(best.level)} with the file's numbers{_add_friction(mechanism, side)}."
        others = sorted(judgement.levels[1:], key=lambda each: each.surprise)[:1]
        beside = ""
        for each in others:
            by = format_ratio(judgement.compare(each, best), " times less likely")
            beside = f"; {each.level}, the next best, is {by}"
        yield f"Its residual is {left}{beside}."
    elif judgement.explained:
        names = " and ".join(each.level for each in explanations)
        friction = _add_friction(mechanism, side)
        yield f"{fits} {names} with the file's numbers{friction} and cannot distinguish them."
    elif explanations:
        yield f"{fits} {_describe_change(mechanism, best)}{_add_friction(mechanism, side)}."
        if explanations[1:]:
            yield "The recording cannot distinguish these from it:"
            yield from (
                f"it fits {_describe_change(mechanism, each)}."
                for each in explanations[1:MOST_NAMES]
            )
        nearest = f" of the nearest, {name(least.level)}," if judgement.levels[1:] else ""
        yield f"With the file's numbers the residual{nearest} is {left}."
    else:
        yield f"{none}, and no single number explains the rest."
        yield f"The residual of the nearest, {name(least.level)}, is {left}."
        for change in judgement.changes:
            is_likelier = judgement.compare(least, change) > LIKELIHOOD_RATIO
            if change.mechanism is not None and is_likelier:
                yield (
                    f"The best change of a number: {_describe_change(mechanism, change)}. Its"
                    f" residual is {_format_most(change)} times that."
                )
    for change in judgement.changes:
        if change.mechanism is None and change.parameter and change.estimate:
            value = _format_interval(change.estimate, change.estimate.term.unit)
            yield (
                f"For {name(change.level)} {change.parameter.phrase} would have to be {value},"
                " which is impossible."
            )


def _describe_change(mechanism: ComparedMechanism, change: Restriction) -> str:
    """A level with one number of the file changed."""
    parameter, estimate = change.parameter, change.estimate
    assert parameter is not None  # as of every change
    assert estimate is not None
    in_file = f"{format_exact(parameter.value)} {estimate.term.unit}".rstrip()
    return (
        f"{mechanism.describe_level(change.level)} if {parameter.phrase} (file: {in_file}) is"
        f" {_format_interval(estimate, estimate.term.unit)}"
    )


def _add_friction(mechanism: ComparedMechanism, side: SideResult) -> str:
    """Friction that is not the file's, as the end of a sentence; nothing where it is."""
    assert side.judgement is not None  # as was asked
    flagged = flag_friction(side.judgement.best, mechanism.robot, side.threshold)
    if not flagged:
        return ""
    listed = (
        f"{format_estimate(each)} (file: {each.term.value:g})"
        if each.term.kind == "viscous"  # no file has another one
        else format_estimate(each)
        for each in flagged
    )
    return f", with {'; '.join(listed)}"


def _format_most(restriction: Restriction) -> str:
    """The residual of a restriction over that of any links, at the joint where it is largest."""
    return format_number(_find_most(restriction))


def _find_most(restriction: Restriction) -> float:
    return float(restriction.ratios.max())


def _describe_runs(comparison: RecordComparison) -> Iterator[str]:
    """The time that simulated runs stay with the record."""
    windows = comparison.windows
    if not windows:
        return
    durations = [window.time[-1] - window.time[0] for window in windows]
    shares = [each.stays_s / long for each, long in zip(windows, durations, strict=True)]
    share, long = sorted(shares)[len(shares) // 2], np.median(durations)
    inside = np.mean([window.within for window in windows])
    verb, until = ("stays in", "for") if share == 1 else ("leaves", "after")
    median = " (median)" if len(windows) > 1 else ""
    yield (
        f"Simulated from {format_count(len(windows), 'recorded state')}, the"
        f" {comparison.mechanism.noun} {verb} its uncertainty band (3 sigma) {until}"
        f" {share * long:.3g} s of {long:.3g} s{median}; {100 * inside:.0f} % of the rows are"
        " within 2 sigma."
    )


def _describe_terms(comparison: RecordComparison) -> Iterator[str]:
    """The terms that the torques need beside any links."""
    has_gears = _has_gears(comparison.mechanism)
    for place, side in enumerate(comparison.sides):
        if side.links == "scaled":  # after the same side with identified links
            yield from _describe_scaled(side, comparison.sides[place - 1], has_gears)
        else:
            yield from _describe_side(side, has_gears)
            for first, second in side.alike:
                yield f"This motion cannot distinguish {first.words} and {second.words}."
            if side.refinement is not None:
                yield from _describe_refinement(side.refinement, SIDE_PHRASES[side.side])
    if comparison.knowledge.lacks_size:
        yield (
            "The drives' gains cannot be determined: for any gains there are links that explain the"
            " torques. State how well the file's links are known ([prior] links), or record the"
            " motion again with a known payload (payload of recordings)."
        )
    if has_gears:
        yield from _describe_levels(comparison)


def _has_gears(mechanism: ComparedMechanism) -> bool:
    """Whether there may be gears: an arm's file states all of them, a robot's may lack some."""
    return mechanism.noun != "arm" or len(mechanism.levels) > 1


def _describe_side(side: SideResult, has_gears: bool = True) -> Iterator[str]:
    """The rotors that the torques of one side need, and those that they do not show.

    has_gears: of one without, rotors are none that a level leaves out.
    """
    where = SIDE_PHRASES[side.side]
    if not side.is_excited:
        names = ", ".join(side.concerned[:MOST_NAMES])
        condition, allowed = format_distinct([side.fit.condition, EXCITED], digits=4)
        what = f"The {where} cannot distinguish rotors from links: the" if has_gears else "The"
        yield (
            f"{what} motion hardly shows {names} (condition number {condition}, at most {allowed})."
        )
        if side.excitation is not None:
            yield _describe_excitation(side.excitation)
        return
    if side.impossible:
        listed = "; ".join(format_estimate(each) for each in side.impossible)
        yield (
            f"No level fits the {where}: {listed}, which no rotor can have. Something else is"
            " missing from the model."
        )
    elif side.seen:
        listed = "; ".join(format_estimate(each) for each in side.seen)
        yield f"Links and friction alone do not explain the {where}: {listed}."
        if side.side == "joint":
            yield "Behind gears there is no rotor: are these the motors' torques (motor_torque)?"
        if any(each.term.kind == "shared armature" for each in side.seen):
            yield "Armature of single joints does not explain them either: they share a motor."
    else:
        worst = int(side.unexplained.argmax())
        share, name = 100 * side.unexplained[worst], side.measured[worst]
        if share < LARGE_REST_PERCENT:
            rest = f"all but {share:.2g} % at {name} (rms)"
            yield f"Links and friction alone explain the {where}: {rest}."
        else:
            rest = f"leave {format_rounded(share)} % of the {where} unexplained at {name} (rms)"
            yield f"No rotor is missing, but links and friction {rest}."
    unseen = [each for each in side.rotors if each not in (*side.seen, *side.impossible)]
    if unseen:
        listed = "; ".join(format_estimate(each) for each in unseen)
        yield f"Too uncertain to be named: {listed}."
    yield from _describe_delay(side)
    contained = [each.name for each in side.contained if each.kind == "armature"]
    if contained and side.links == "identified":
        yield f"No motion can distinguish from the links: {', '.join(contained)}."


def _describe_delay(side: SideResult) -> Iterator[str]:
    if side.delay is not None:
        order = "lag behind" if side.delay.value > 0 else "come before"
        yield f"All of these torques {order} the motion: {format_estimate(side.delay)}."


def _describe_refinement(refinement: Refinement, where: str) -> Iterator[str]:
    """The decision by known links of the file, then gains and zeros."""
    links, best = refinement.knowledge.links, refinement.best
    if not all(fit.settled for fit in refinement.fits):
        yield f"No estimate by the {where} with these unknowns: the fit does not converge."
        return
    if links is not None:
        yield _describe_prior(refinement, links)
        for fit in refinement.fits:
            if fit.bodies is not None:
                yield _describe_bodies(fit.level, fit.bodies)
    beside = [each for each in best.estimates if each.term.kind in ("gain", "zero")]
    if beside:
        yield f"From the {where}: {'; '.join(format_estimate(each) for each in beside)}."
    if best.contained:
        reason = " beside the other unknowns" if links is None else ""
        yield f"The motion does not show the encoder zero of {', '.join(best.contained)}{reason}."


def _describe_bodies(level: Level, bodies: PossibleBodies) -> str:
    """Whether possible bodies explain the torques at a level, and which are at the border."""
    border = (
        f"; those moved by {', '.join(bodies.border)} are at the border" if bodies.border else ""
    )
    if bodies.explain:
        return f"At {level} possible bodies explain the torques as well as any{border}."
    return (
        f"At {level} no possible bodies explain the torques: those moved by"
        f" {', '.join(bodies.impossible)} would be impossible (possible ones have"
        f" {bodies.excess:.4g} more chi squared{border})."
    )


def _describe_prior(refinement: Refinement, links: float) -> str:
    """State which level is likelier if the file's links are known to this share."""
    best = refinement.best
    head = f"With the file's links known to {100 * links:.3g} %"
    if refinement.is_surprising:
        return (
            f"{head}, no level fits: the links would be further from the file than that (chi"
            f" squared {best.surprise:.4g} of {best.shown} parameters)."
        )
    if refinement.is_impossible:
        return f"{head}, no level has possible bodies that explain the torques."
    rotors = [each for each in best.estimates if each.term.kind in ("rotors", *ROTOR_KINDS)]
    listed = "; ".join(format_estimate(each) for each in rotors)
    if len(refinement.fits) == 1:
        return f"{head}: {listed}. The file has no rotors, so coupled is not compared."
    fits = refinement.fits
    values = format_distinct([fit.chi_squared for fit in fits], digits=5)
    sizes = " and ".join(f"{each} for {fit.level}" for each, fit in zip(values, fits, strict=True))
    if refinement.level is None:
        return (
            f"{head}, armature and coupled cannot be distinguished (chi squared {sizes}). Links"
            " must be known to less than the rotors' inertia times ratio."
        )
    return f"{head}, the torques are those of {best.level} (chi squared {sizes}): {listed}."


def _describe_excitation(excitation: Excitation) -> str:
    """A motion that would show the parameters, or the statement that none of those drawn does."""
    head = f"The best of {DRAWN} sums of sines within the joints' limits (seed"
    motion = excitation.motion
    tail = (
        f"{motion.seed}, period {motion.period:.3g} s) has a condition number of"
        f" {excitation.condition:.2g}"
    )
    if excitation.condition > EXCITED:
        return f"{head} {tail}: none of them shows enough."
    return f"{head} {tail}: record that one (--out FOLDER writes it as {EXCITATION_FILE})."


def _describe_scaled(
    side: SideResult, identified: SideResult, has_gears: bool = True
) -> Iterator[str]:
    """Factors on the file's links; rotors beside them where links cannot be identified."""
    wrong = side.wrong_factors
    if wrong:
        where, why = SIDE_PHRASES[side.side], "the links or gains are wrong"
        yield (
            f"The {where} cannot judge the rotors, because {why}."
            if has_gears
            else f"By the {where} {why}."
        )
        for each in wrong:
            yield f"They need a factor of {_format_interval(each)} for {each.term.name}."
    if identified.is_excited:
        worse = side.find_worse_joints(identified)
        if worse:
            listed = ", ".join(f"{ratio:.2f} at {name}" for name, ratio in worse.items())
            head = "The file's links are wrong: relative to identified links the residual is"
            yield f"{head} {listed}."
        return
    if has_gears:
        listed = "; ".join(format_estimate(each) for each in side.rotors)
        yield f"Estimates with these factors: {listed}."


def _describe_levels(comparison: RecordComparison) -> Iterator[str]:
    """Whether coupled and armature are one model."""
    ranks = comparison.ranks
    if ranks.are_equal:
        places = ", if stators are on the links before the joints" if ranks.assumed else ""
        yield (
            f"Coupled and armature are the same model with other links{places}. No recording can"
            " distinguish them unless the links are known otherwise, or those of one level are"
            " impossible bodies ([prior] bodies)."
        )
    else:
        slides = "a joint slides, " if comparison.mechanism.robot.slides else ""
        yield (
            f"Coupled and armature differ for any links (ranks {ranks.coupled}, {ranks.armature},"
            f" together {ranks.both}): {slides}a stator is not on the link before its joint, or its"
            " axis is another."
        )


def format_estimate(each: TermEstimate) -> str:
    """An estimate with its 95 % interval."""
    return f"{each.term.words} {_format_interval(each, each.term.unit)}"


def _format_interval(each: TermEstimate, unit: str = "") -> str:
    """A value to the second digit of its interval; without one where it depends on the band."""
    value, half_width, after = each.value, each.half_width, f" {unit}" if unit else ""
    is_small = 100 * half_width > abs(value) and half_width < 1e-5
    is_usual = 1e-9 < half_width < 1e6 and not is_small
    digits = f".{max(1 - floor(log10(half_width)), 0)}f" if is_usual else ".3g"
    shown = f"{value:{digits}}" if is_usual else format_value(value, half_width)
    if each.doubled is not None:
        beside = f"{each.doubled:{digits}}{after} in twice the band"
        return f"{shown}{after} (depends on the band: {beside})"
    interval = f"{shown} ± {half_width:{digits if is_usual else '.2g'}}{after}"
    return interval if each.is_determined else f"{interval} ({UNDETERMINED})"


def format_row(names: Sequence[str], values: Sequence[float] | np.ndarray) -> str:
    """The numbers of several joints."""
    return ", ".join(f"{value:.3g} at {name}" for name, value in zip(names, values, strict=True))


def format_value(value: float, half_width: float) -> str:
    """A value in three digits, or as many as state it within its interval."""
    for digits in range(3, MOST_DIGITS):
        text = f"{value:.{digits}g}"
        if abs(float(text) - value) <= half_width:
            return text
    return repr(value)


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


def format_ratio(ratio: float, unit: str = "") -> str:
    """How much less likely something is, as text; unit: what follows a number."""
    words = "far less likely" if unit else "over a million"
    return f"{ratio:.2g}{unit}" if ratio <= LARGEST_RATIO else words


def format_number(value: float) -> str:
    """A number with three digits; with separators where it has more before its point."""
    return f"{value:,.0f}" if 1e3 <= value < 1e7 else f"{value:.3g}"
