"""What a comparison of a robot with recordings says, sentence by sentence."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import floor, log10

import numpy as np

from crosscheck.identification.compare import (
    EXCITED,
    RobotComparison,
    Side,
    SideResult,
)
from crosscheck.identification.excitation import DRAWN, Excitation
from crosscheck.identification.refinement import PossibleBodies, Refinement
from crosscheck.identification.terms import ROTOR_KINDS, TermEstimate
from crosscheck.models.robot.robot import Level
from crosscheck.recordings.engines import describe_disagreement
from crosscheck.recordings.messages import format_distinct

SIDE_WORDS: dict[Side, str] = {
    "motor": "torques of the motors",
    "joint": "torques behind the gears",
    "between": "torques of the motors less those behind the gears",
}
MOST_NAMES = 6
EXCITATION_FILE = "excitation.csv"


def describe_answers(comparison: RobotComparison) -> list[str]:
    """The sentences that answer, the most important one first."""
    if not comparison.engines_agree:
        return list(describe_disagreement(comparison.engines, "robot"))
    sentences: list[str] = []
    if comparison.tilt is not None:
        sentences.append(
            "Another gravity alone explains the torques with the file's links:"
            f" {comparison.tilt.describe()}"
        )
        sentences.append("What follows holds with that gravity.")
    for side in comparison.sides:
        if side.links == "scaled":
            identified = next(
                each
                for each in comparison.sides
                if (each.side, each.links) == (side.side, "identified")
            )
            sentences += _describe_scaled(side, identified)
        else:
            sentences += _describe_side(side)
            pairs = ", ".join(f"{first.name} and {second.name}" for first, second in side.alike)
            if pairs:
                sentences.append(f"By this motion these cannot be distinguished: {pairs}.")
            if side.refinement is not None:
                sentences += _describe_refinement(side.refinement, SIDE_WORDS[side.side])
    if comparison.knowledge.lacks_size:
        sentences.append(
            "Gains of drives cannot be determined: any of them has links that explain the torques."
            " State how well the file's links are known ([prior] links), or record once more with a"
            " known payload (payload of recordings)."
        )
    return [*sentences, *_describe_levels(comparison)]


def _describe_side(side: SideResult) -> Iterator[str]:
    """What the torques of one side say."""
    where = SIDE_WORDS[side.side]
    if not side.is_excited:
        names = ", ".join(side.concerned[:MOST_NAMES])
        condition, allowed = format_distinct([side.condition, EXCITED], digits=4)
        yield (
            f"By the {where} rotors and links cannot be distinguished: the motion hardly shows"
            f" {names} (condition number {condition}, at most {allowed})."
        )
        if side.excitation is not None:
            yield _describe_excitation(side.excitation)
        return
    if side.impossible:
        listed = "; ".join(format_estimate(each) for each in side.impossible)
        yield (
            f"By the {where} no level fits: {listed}, which no rotor has. The model lacks"
            " something else."
        )
    elif side.seen:
        listed = "; ".join(format_estimate(each) for each in side.seen)
        yield f"By the {where} links and friction alone are rejected: {listed}."
        if side.side == "joint":
            yield "Behind gears there is no rotor: are these the motors' torques (motor_torque)?"
        if any(each.term.kind == "shared armature" for each in side.seen):
            yield "Armature of single joints is rejected, too: they share a motor."
    else:
        yield f"By the {where} links and friction alone are not rejected."
    unseen = [each for each in side.rotors if each not in (*side.seen, *side.impossible)]
    if unseen:
        listed = "; ".join(format_estimate(each) for each in unseen)
        yield f"Not distinguishable from zero: {listed}."
    if side.delay is not None:
        order = "lag behind" if side.delay.value > 0 else "come before"
        yield f"All of these torques {order} the motion: {format_estimate(side.delay)}."
    contained = [each.name for each in side.contained if each.kind == "armature"]
    if contained and side.links == "identified":
        yield f"No motion distinguishes from the links: {', '.join(contained)}."


def _describe_refinement(refinement: Refinement, where: str) -> Iterator[str]:
    """What the torques of a side say with links of the file, then gains and zeros."""
    links, best = refinement.knowledge.links, refinement.best
    if not all(fit.settled for fit in refinement.fits):
        yield f"With what else is asked the {where} have no estimate: its steps do not settle."
        return
    if links is not None:
        yield _describe_prior(refinement, links)
        for fit in refinement.fits:
            if fit.bodies is not None:
                yield _describe_bodies(fit.level, fit.bodies)
    beside = [each for each in best.estimates if each.term.kind in ("gain", "zero")]
    if beside:
        yield f"By the {where}: {'; '.join(format_estimate(each) for each in beside)}."
    if best.contained:
        reason = "what else is unknown" if links is None else "anything"
        names = ", ".join(best.contained)
        yield f"No zero of the encoder of {names} can be distinguished from {reason}."


def _describe_bodies(level: Level, bodies: PossibleBodies) -> str:
    """Whether possible bodies explain the torques at a level, and which are at the border."""
    border = f"; at the border: what {', '.join(bodies.border)} move" if bodies.border else ""
    if bodies.explain:
        return f"At {level} possible bodies explain the torques as well as any{border}."
    return (
        f"At {level} no possible bodies explain the torques: what"
        f" {', '.join(bodies.impossible)} move would be none (possible ones leave"
        f" {bodies.excess:.4g} more of chi squared{border})."
    )


def _describe_prior(refinement: Refinement, links: float) -> str:
    """Which level is likelier where the file's links are known to a share."""
    best = refinement.best
    head = f"With the file's links known to {100 * links:.3g} %"
    if refinement.is_surprising:
        return (
            f"{head} nothing fits: they would be further from the file (chi squared"
            f" {best.surprise:.4g} of {best.shown} parameters). No level is named."
        )
    if refinement.is_impossible:
        return f"{head} no level has possible bodies that explain the torques. None is named."
    rotors = [each for each in best.estimates if each.term.kind in ("rotors", *ROTOR_KINDS)]
    listed = "; ".join(format_estimate(each) for each in rotors)
    if len(refinement.fits) == 1:
        return f"{head}: {listed}. The file has no rotors, so coupled is not asked."
    fits = refinement.fits
    values = format_distinct([fit.chi_squared for fit in fits], digits=5)
    sizes = " and ".join(f"{each} for {fit.level}" for each, fit in zip(values, fits, strict=True))
    if refinement.level is None:
        return (
            f"{head} armature and coupled cannot be distinguished (chi squared {sizes}): links"
            " have to be known to less than inertia times ratio of the rotors."
        )
    return f"{head} the torques are those of {best.level} (chi squared {sizes}): {listed}."


def _describe_excitation(excitation: Excitation) -> str:
    """Which motion would show the parameters, or that none drawn does."""
    head = f"Of {DRAWN} sums of sines within the joints' limits the best (seed"
    motion = excitation.motion
    tail = (
        f"{motion.seed}, period {motion.period:.3g} s) has a condition number of"
        f" {excitation.condition:.2g}"
    )
    if excitation.condition > EXCITED:
        return f"{head} {tail}: none shows them within these limits."
    return f"{head} {tail}: record that one (--out FOLDER writes it as {EXCITATION_FILE})."


def _describe_scaled(side: SideResult, identified: SideResult) -> Iterator[str]:
    """How far off the file's links are; rotors beside them where links cannot be identified."""
    wrong = side.wrong_factors
    if wrong:
        listed = ", ".join(f"{_format_interval(each)} for {each.term.name}" for each in wrong)
        yield (
            f"The {SIDE_WORDS[side.side]} ask for factors on the torques of {listed}: the file's"
            " links or the gains are wrong, and rotors are not judged by these."
        )
    if identified.is_excited:
        worse = side.find_worse_joints(identified)
        if worse:
            listed = ", ".join(f"{ratio:.2f} times at {name}" for name, ratio in worse.items())
            yield f"Links of the file leave more than identified ones, so they are wrong: {listed}."
        return
    listed = "; ".join(format_estimate(each) for each in side.rotors)
    yield f"With such factors it would be: {listed}."


def _describe_levels(comparison: RobotComparison) -> Iterator[str]:
    """Which levels are one and the same model."""
    ranks = comparison.ranks
    if ranks.are_equal:
        places = ", where stators are on the links before the joints" if ranks.assumed else ""
        yield (
            "Coupled and armature are the same model with other links"
            f"{places}: no recording distinguishes them unless the links are known otherwise, or"
            " those of one are no possible bodies ([prior] bodies)."
        )
    else:
        yield (
            f"Coupled and armature differ for any links (ranks {ranks.coupled}, {ranks.armature},"
            f" together {ranks.both}): a stator is not on the link before its joint, or its axis"
            " is another."
        )


def format_estimate(each: TermEstimate) -> str:
    """An estimate with its 95 % interval."""
    return f"{each.term.name} {_format_interval(each, each.term.unit)}"


def _format_interval(each: TermEstimate, unit: str = "") -> str:
    """A value to the second digit of its interval; without one where it depends on the band."""
    value, half_width, after = each.value, each.half_width, f" {unit}" if unit else ""
    is_usual = 1e-9 < half_width < 1e6
    digits = f".{max(1 - floor(log10(half_width)), 0)}f" if is_usual else ".3g"
    if each.doubled is not None:
        beside = f"{each.doubled:{digits}}{after} in twice the band"
        return f"{value:{digits}}{after} (depends on the band: {beside})"
    return f"{value:{digits}} +- {half_width:{digits if is_usual else '.2g'}}{after}"


def format_row(values: Sequence[float] | np.ndarray) -> str:
    """The numbers of several joints."""
    return ", ".join(f"{value:.3g}" for value in values)
