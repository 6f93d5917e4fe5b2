"""Compares records with a mechanism: whether its files explain them, and which terms they need."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Literal

import numpy as np

from crosscheck.findings import Finding
from crosscheck.identification.bandwidth import (
    BandResult,
    choose_bandwidth,
    combine_bands,
    measure_error,
)
from crosscheck.identification.engines import compare_engines
from crosscheck.identification.estimation import (
    ALIKE,
    LinearFit,
    PartFit,
    fit_linear,
    fit_part,
)
from crosscheck.identification.excitation import Excitation, suggest_excitation
from crosscheck.identification.forward import Window, run_windows
from crosscheck.identification.gravity import GravityEstimate
from crosscheck.identification.mechanism import ComparedMechanism
from crosscheck.identification.refinement import Knowledge, RecordedTorque, Refinement, refine
from crosscheck.identification.restrictions import (
    SIGNIFICANT,
    FileFits,
    FileJudgement,
    Restriction,
    find_worse_joints,
    flag_friction,
)
from crosscheck.identification.sampling import (
    BandSample,
    highest_bandwidth,
    lowest_bandwidth,
    sample,
    space_signals,
)
from crosscheck.identification.structure import (
    LevelRanks,
    TermBasis,
    compare_levels,
    draw_samples,
    find_alike,
    find_basis,
)
from crosscheck.identification.terms import (
    ROTOR_KINDS,
    Regressor,
    TermEstimate,
    TermKind,
    TorqueTerm,
    build_columns,
    filter_columns,
    shared_motors,
)
from crosscheck.models.errors import InputError
from crosscheck.models.pinocchio.regressor import LinkRegressor
from crosscheck.models.robot.robot import Robot, remove_friction
from crosscheck.recordings.record import Record
from crosscheck.runner.progress_update import ProgressCallback

Side = Literal["motor", "joint", "between"]
LinkTreatment = Literal["identified", "scaled", "fixed", "none"]
LINK_KINDS: dict[LinkTreatment, tuple[TermKind, ...]] = {
    "identified": ("links",),
    "scaled": ("scale",),
    "fixed": ("gravity",),
    "none": (),
}
# Terms added step by step, friction before rotors: a rotor must explain the residual of friction.
STEPS: tuple[tuple[str, tuple[TermKind, ...]], ...] = (
    ("viscous friction", ("offset", "viscous")),
    ("Coulomb friction", ("coulomb",)),
    ("friction of shared motors", ("shared viscous", "shared coulomb")),
    ("delay", ("delay",)),
    ("armature", ("armature",)),
    ("armature of shared motors", ("shared armature",)),
)
MOST_BANDS = 4  # whose samples are kept: fits ask for those of the last ones again
FEWEST_ROWS = 8  # rows of torques per parameter, half of them independent
NOTHING_ELSE = Knowledge()
NAMED_KINDS: tuple[TermKind, ...] = (*ROTOR_KINDS, "scale", "gravity", "delay")
# Condition number of scaled columns beyond which estimates depend on terms that the motion hardly
# shows (Gautier and Khalil, 1992, require 100).
EXCITED = 1000.0
SOON, INSIDE = 0.05, 0.5  # share of a run's time, and of its rows within 2 standard uncertainties
CONCERNED = 0.1  # a parameter's part in the direction that motion shows least, to be named


@dataclass(frozen=True)
class SideResult:
    """The results of torques measured on one side of the gears.

    side: motor, joint, or the motors' less the joints'; names, measured: of all joints, and those
    whose torque is measured; estimates: of all terms but links; contained: terms that links make
    up; alike: pairs of terms that this motion makes one; concerned: terms that the motion hardly
    shows, where it does so; threshold: how many errors a rotor or a delay is above 0, a factor from
    1, to be named; bands: at half and twice the bandwidth; samples, fit: rows, and the fit of the
    full model, by those rows of a joint in which it moves; excitation: a motion that shows more,
    where this one does not show every parameter of identified links; refinement: with what else is
    known of these.
    """

    side: Side
    links: LinkTreatment
    names: tuple[str, ...]
    measured: tuple[str, ...]
    bandwidth: float
    steps: tuple[PartFit, ...]
    estimates: tuple[TermEstimate, ...]
    contained: tuple[TorqueTerm, ...]
    alike: tuple[tuple[TorqueTerm, TorqueTerm], ...]
    concerned: tuple[str, ...]
    threshold: float
    bands: tuple[BandResult, ...]
    samples: BandSample
    fit: LinearFit
    excitation: Excitation | None = None
    refinement: Refinement | None = None
    judgement: FileJudgement | None = None

    @property
    def rotors(self) -> tuple[TermEstimate, ...]:
        """Estimates of armature."""
        return self.select(*ROTOR_KINDS)

    def select(self, *kinds: TermKind) -> tuple[TermEstimate, ...]:
        """Estimates of terms of these kinds."""
        return tuple(each for each in self.estimates if each.term.kind in kinds)

    @property
    def unexplained(self) -> np.ndarray:
        """Residuals (measured,) of the full model over the torques' variation, both rms."""
        torque = self.samples.torque[:, [self.names.index(name) for name in self.measured]]
        return self.fit.sigma / np.std(torque, axis=0, where=self.fit.shown)

    @property
    def is_excited(self) -> bool:
        """Whether the motion shows every parameter."""
        return not self.concerned

    @property
    def has_other_gravity(self) -> bool:
        """Whether a component of gravity is not the file's."""
        sure = [each for each in self.select("gravity") if abs(each.t) > self.threshold]
        return self.is_excited and bool(sure)

    @property
    def seen(self) -> tuple[TermEstimate, ...]:
        """Rotors that the record needs, of a motion that shows every parameter."""
        return tuple(
            each
            for each in self.rotors
            if (abs(each.t) if each.term.kind == "shared armature" else each.t) > self.threshold
        )

    @property
    def delay(self) -> TermEstimate | None:
        """A delay of the torques that the record needs."""
        delays = (each for each in self.select("delay") if abs(each.t) > self.threshold)
        return next(delays, None)

    @property
    def wrong_factors(self) -> tuple[TermEstimate, ...]:
        """Factors on the torques of the file's links that are not 1."""
        return tuple(
            each
            for each in self.select("scale")
            if abs(each.value - 1) > self.threshold * each.error
        )

    def find_worse_joints(self, other: SideResult) -> dict[str, float]:
        """Joints whose residual exceeds that of another treatment of links, with the ratio."""
        ratios = self.steps[-1].rms / other.steps[-1].rms
        return find_worse_joints(
            self.measured, ratios, other.fit.taken - self.fit.taken, other.fit.left
        )

    @property
    def impossible(self) -> tuple[TermEstimate, ...]:
        """Armatures that are negative beyond doubt: something else is missing."""
        return tuple(each for each in self.select("armature") if each.t < -self.threshold)


@dataclass(frozen=True)
class RecordComparison:
    """The results of comparing records with a mechanism.

    ranks: of its levels over all motions; sides: nothing where the engines disagree; knowledge:
    what was known of links, and what was asked beside them; gravities: of each side, with the
    file's links, another gravity; tilt: that one if it alone explains the torques, and all sides
    are judged with it; tolerances: of the files' numbers, relative standard uncertainties by path;
    windows: runs of the best explanation.
    """

    mechanism: ComparedMechanism
    records: tuple[Record, ...]
    engines: tuple[Finding, ...]
    ranks: LevelRanks
    sides: tuple[SideResult, ...]
    knowledge: Knowledge = NOTHING_ELSE
    gravities: tuple[SideResult, ...] = ()
    tilt: GravityEstimate | None = None
    tolerances: Mapping[str, float] = field(default_factory=dict)
    windows: tuple[Window, ...] = ()

    @property
    def excitation(self) -> Excitation | None:
        """A motion that shows more than the record's, of the first side that lacks one."""
        return next((side.excitation for side in self.sides if side.excitation), None)

    @property
    def engines_agree(self) -> bool:
        """Whether all engines agree on the record."""
        return all(engine.verdict == "agree" for engine in self.engines)

    @property
    def judged_sides(self) -> tuple[SideResult, ...]:
        """Sides whose torques are compared with the files' numbers."""
        return tuple(side for side in self.sides if side.judgement is not None)

    @property
    def judgements(self) -> tuple[FileJudgement, ...]:
        """The judgements of the files' numbers by these sides."""
        return tuple(side.judgement for side in self.sides if side.judgement is not None)

    @property
    def is_explained(self) -> bool:
        """Whether the files' numbers explain all torques, friction aside."""
        explained = all(each.explained for each in self.judgements)
        return self.tilt is None and self.has_explanation and explained

    @property
    def has_explanation(self) -> bool:
        """Whether the files explain all torques, or do if single numbers are changed."""
        return self.is_fitting and self.is_clear

    @property
    def is_fitting(self) -> bool:
        """Whether a level fits all torques by its residuals, perhaps with a number changed."""
        return bool(self.judgements) and all(each.explanations for each in self.judgements)

    @property
    def is_clear(self) -> bool:
        """Whether levels with the files' numbers that fit leave no more than any links, as do runs.

        Runs do not have the uncertainty of a number that is estimated.
        """
        right = [each for each in self.judgements if each.explained]
        return all(each.best.is_clear and not self.leaves_at_once for each in right)

    @property
    def leaves_at_once(self) -> bool:
        """Whether runs are outside their uncertainty soon, and stay there."""
        if not self.windows:
            return False
        shares = [each.stays_s / (each.time[-1] - each.time[0]) for each in self.windows]
        inside = np.mean([each.within for each in self.windows])
        return bool(np.median(shares) < SOON and inside < INSIDE)

    @property
    def is_decided(self) -> bool:
        """Whether the files explain the torques; with more questions, whether all are decided."""
        if not self.knowledge.has_questions:
            return self.is_explained
        return (
            bool(self.sides)
            and not self.knowledge.lacks_size
            and all(side.refinement.is_decided for side in self.sides if side.refinement)
            and all(
                side.is_excited and not side.impossible
                for side in self.sides
                if side.links != "scaled"
            )
        )


def compare(
    mechanism: ComparedMechanism,
    records: Sequence[Record],
    transmission: np.ndarray,
    progress: ProgressCallback,
    knowledge: Knowledge = NOTHING_ELSE,
    tolerances: Mapping[str, float] | None = None,
) -> RecordComparison:
    """Judge a mechanism's files by records, and estimate links, friction and rotors.

    The friction of the files is left out, since friction is estimated.

    Args:
        transmission: Rates of motors for rates of joints (n, n).
        knowledge: What is known of links, and what is asked beside them.
        tolerances: Relative standard uncertainties of the files' numbers, by path.

    Raises:
        InputError: Records are too short for what is asked.
    """
    given, robot, shared = mechanism, remove_friction(mechanism.robot), shared_motors(transmission)
    stated = tolerances or {}
    mechanism.require_parameters(stated)
    chosen = _select_torques(records)
    progress("asking what can be distinguished", 0, len(chosen) + 1)
    ranks = compare_levels(robot, shared)
    sides: list[SideResult] = []
    gravities: list[SideResult] = []
    engines: list[Finding] = []
    tilt: GravityEstimate | None = None
    widest = np.inf
    for number, (side, torques) in enumerate(chosen, 1):
        progress(f"estimating by torques of side {side}", number, len(chosen) + 1)
        # Payloads are on both sides of the gears: what lies between these has none.
        payloads = () if side == "between" else knowledge.payloads
        problem = _Problem(robot, _BandSamples(robot, records, torques, shared, payloads), side)
        bandwidth = problem.choose_bandwidth(widest)
        if side == "between":
            # Where its few terms say nothing more accelerations are noise: links would take it up.
            widest = bandwidth
        if not engines:
            engines = compare_engines(mechanism, problem.samples.at(bandwidth).states)
            if any(engine.verdict != "agree" for engine in engines):
                break
        judged = _judge_side(problem, bandwidth, knowledge)
        if side == "between":
            sides.append(judged)
            continue
        if not any(each.any() for each in payloads):
            weighed, gravity = _judge_gravity(problem, torques, bandwidth)
            gravities.append(weighed)
            if gravity is not None and tilt is None:
                tilt, mechanism = gravity, mechanism.turn(gravity.value)
                robot = replace(robot, gravity=gravity.value)
                samples = _BandSamples(robot, records, torques, shared, payloads)
                problem = _Problem(robot, samples, side)
                bandwidth = problem.choose_bandwidth(widest)
                judged = _judge_side(problem, bandwidth, knowledge)
        if not knowledge.has_questions:
            progress("judging the file's numbers", number, len(chosen) + 1)
            judged = replace(judged, judgement=_judge_file(problem, mechanism, judged))
        scaled = _Problem(robot, problem.samples, side, "scaled")
        sides += [judged, _judge_side(scaled, bandwidth, NOTHING_ELSE)]
    comparison = RecordComparison(
        given,
        tuple(records),
        tuple(engines),
        ranks,
        tuple(sides),
        knowledge,
        tuple(gravities),
        tilt,
        stated,
    )
    progress("running the model forward", len(chosen) + 1, len(chosen) + 1)
    return replace(comparison, windows=tuple(_run_best(comparison)))


def _judge_file(
    problem: _Problem, mechanism: ComparedMechanism, judged: SideResult
) -> FileJudgement:
    """The judgement of the files' numbers by a side; behind the gears there are links alone."""
    behind = [each for each in mechanism.levels if each.level == "links"]
    levels = mechanism.levels if judged.side == "motor" else behind
    judgement = problem.fit_file(mechanism, judged.bandwidth).judge(levels)
    others = [(each, problem.fit_file(mechanism, each.bandwidth)) for each in judged.bands]

    def combine(restriction: Restriction) -> Restriction:
        again = [
            replace(band, estimates=fits.repeat(restriction).estimates) for band, fits in others
        ]
        estimates = combine_bands(restriction.estimates, judged.bandwidth, again)
        return replace(restriction, estimates=estimates)

    return FileJudgement(
        tuple(map(combine, judgement.levels)), tuple(map(combine, judgement.changes))
    )


def _run_best(comparison: RecordComparison) -> Iterator[Window]:
    """Runs of the first side's best explanation, where every joint's torque is measured.

    None of a record with a payload, which the files do not have.
    """
    is_loaded = any(payload.any() for payload in comparison.knowledge.payloads)
    for side in () if is_loaded else comparison.judged_sides[:1]:
        best = next(iter(side.judgement.explanations), None) if side.judgement else None
        pairs = [
            (each, torque)
            for each in comparison.records
            for torque in [each.motor_torque if side.side == "motor" else each.joint_torque]
            if torque is not None and np.isfinite(torque).all()
        ]
        if best is None or best.mechanism is None or len(pairs) < len(comparison.records):
            continue
        rubs = flag_friction(best, comparison.mechanism.robot, side.threshold)
        friction = best.compute_friction if rubs else None
        yield from run_windows(pairs, best.mechanism, best.level, comparison.tolerances, friction)


def _judge_gravity(
    problem: _Problem, torques: Sequence[np.ndarray], bandwidth: float
) -> tuple[SideResult, GravityEstimate | None]:
    """The fit with the file's links and another gravity, and whether that is a tilt.

    Args:
        problem: With any links and the file's gravity.
        bandwidth: Of that problem; with another gravity it is chosen anew.
    """
    robot, records = problem.robot, problem.records
    links = [LinkRegressor(robot).values] * len(records)
    left = _BandSamples(robot, records, torques, problem.shared, links)
    fixed = _Problem(robot, left, problem.side, "fixed")
    weighed = _judge_side(fixed, bandwidth, NOTHING_ELSE)
    if weighed.has_other_gravity:
        bandwidth = fixed.choose_bandwidth()
        weighed = _judge_side(fixed, bandwidth, NOTHING_ELSE)
    if not weighed.has_other_gravity:
        return weighed, None
    free = _judge_side(problem, bandwidth, NOTHING_ELSE)
    return weighed, _find_tilt(robot, weighed, free)


def _find_tilt(robot: Robot, weighed: SideResult, free: SideResult) -> GravityEstimate | None:
    """The gravity that alone explains torques, if it is one of a tilted base.

    Args:
        weighed: Of the file's links with another gravity.
        free: Of any links with the file's gravity.
    """
    components = weighed.select("gravity")
    axes = ["xyz".index(each.term.name.split()[2]) for each in components]
    value, half_width = robot.gravity.astype(float), np.zeros(3)
    value[axes] += [each.value for each in components]
    half_width[axes] = [each.half_width for each in components]
    gravity = GravityEstimate(value, half_width, robot.gravity, tuple(axes))
    is_sure = all(each.doubled is None for each in components)
    alone = is_sure and not weighed.find_worse_joints(free)
    return gravity if alone and gravity.is_tilted else None


def _select_torques(records: Sequence[Record]) -> list[tuple[Side, list[np.ndarray]]]:
    """Sides that all recordings have, and their torques."""
    chosen: list[tuple[Side, list[np.ndarray]]] = []
    before = [each.motor_torque for each in records if each.motor_torque is not None]
    behind = [each.joint_torque for each in records if each.joint_torque is not None]
    if before and behind:
        between = [motor - joint for motor, joint in zip(before, behind, strict=True)]
        chosen.append(("between", between))
    if before:
        chosen.append(("motor", before))
    if behind:
        chosen.append(("joint", behind))
    return chosen


class _BandSamples:
    """Recordings and their torques on one side of the gears, sampled once for each bandwidth.

    Args:
        torques: Of each recording (rows, n); of no number where a joint's is not measured.
        shared: Rates of motors that several joints turn, for rates of joints (shared, n).
        payloads: What each recording's adds to links' parameters; nothing if there are none.
    """

    def __init__(
        self,
        robot: Robot,
        records: Sequence[Record],
        torques: Sequence[np.ndarray],
        shared: np.ndarray,
        payloads: Sequence[np.ndarray] = (),
    ) -> None:
        self.records, self.shared = records, shared
        self._regressor, self._payloads = LinkRegressor(robot), payloads
        self.measured = np.isfinite(torques[0]).all(axis=0)
        pairs = zip(records, torques, strict=True)
        self._signals = [
            space_signals(each, torque if self.measured.all() else np.nan_to_num(torque))
            for each, torque in pairs
        ]
        self._samples: dict[float, BandSample] = {}

    def at(self, bandwidth: float) -> BandSample:
        """Rows of the recordings in a band [Hz], all joints; torques without payloads'."""
        if bandwidth not in self._samples:
            for other in list(self._samples)[: 1 - MOST_BANDS]:
                del self._samples[other]
            samples = sample(self._signals, self.shared, bandwidth)
            torque = samples.torque - self.compute_payload_torques(samples)
            self._samples[bandwidth] = replace(samples, torque=torque)
        return self._samples[bandwidth]

    def compute_payload_torques(self, samples: BandSample) -> np.ndarray:
        """Torques (rows, n) of the recordings' payloads."""
        torques = np.zeros(samples.q.shape)
        for (first, last), added in zip(pairwise(samples.starts), self._payloads, strict=False):
            if added.any():
                for rows, piece in samples.select(slice(first, last)).pieces():
                    loaded = self._regressor.compute(*piece.motion.states) @ added
                    torques[first:last][rows] = piece.filter(loaded)
        return torques


class _Problem:
    """Torques of recordings on a side of the gears, and the terms that may explain them.

    links: how links enter; they are identified where there are any, unless stated.
    """

    def __init__(
        self,
        robot: Robot,
        samples: _BandSamples,
        side: Side,
        links: LinkTreatment | None = None,
    ) -> None:
        self.robot, self.samples, self.side = robot, samples, side
        self.links: LinkTreatment = links or ("none" if side == "between" else "identified")
        self.records, self.shared = samples.records, samples.shared
        self.measured = samples.measured
        self.kinds = (*LINK_KINDS[self.links], *(kind for _, added in STEPS for kind in added))
        anything = self._build_columns(draw_samples(robot, self.shared))
        self.basis: TermBasis = find_basis(anything, self.kinds)
        # In the order of the steps: the columns of each are the first so many of all.
        among = [anything.terms[number].kind for number in self.basis.chosen]
        order = sorted(range(len(among)), key=lambda place: self.kinds.index(among[place]))
        self.chosen = self.basis.chosen[order]
        self.terms = anything.select(self.chosen).terms
        self.every = anything.terms
        self._fits: dict[float, LinearFit] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the joints whose torques are measured."""
        return tuple(np.array(self.robot.coordinate_names)[self.measured].tolist())

    def fit(self, bandwidth: float) -> tuple[BandSample, Regressor, LinearFit]:
        """Sampled motion, columns of the measured joints, and the fit of all terms."""
        samples = self.samples.at(bandwidth)
        columns = filter_columns(
            samples, lambda motion: self._build_columns(motion).select(self.chosen)
        )
        shown = samples.moving[:, self.measured]
        reached = np.any([columns.values[on, at].any(axis=0) for at, on in enumerate(shown.T)], 0)
        alike = find_alike(columns, shown)
        again = [second for _, second in alike]
        reached &= np.array([term not in again for term in columns.terms])
        if not reached.all():
            columns = replace(columns.select(np.flatnonzero(reached)), alike=alike)
        if bandwidth not in self._fits:
            torque = samples.torque[:, self.measured]
            self._fits[bandwidth] = fit_linear(columns.values, torque, shown, samples.starts)
        return samples, columns, self._fits[bandwidth]

    def _build_columns(self, samples: BandSample) -> Regressor:
        """The columns of all terms at measured joints."""
        return build_columns(self.robot, self.shared, samples).measure(self.measured)

    def estimate_bands(self, bandwidth: float) -> tuple[BandResult, ...]:
        """Estimates at half and twice a bandwidth [Hz], if rows resolve them."""
        bands = []
        for band in (bandwidth / 2, bandwidth * 2):
            if band <= highest_bandwidth(self.records):
                _, columns, fit = self.fit(band)
                estimates = _select_estimates(self, columns, fit)
                bands.append(BandResult(band, estimates, band >= self.lowest_bandwidth))
        return tuple(bands)

    def fit_file(self, mechanism: ComparedMechanism, bandwidth: float) -> FileFits:
        """Fits by a mechanism's files in a band [Hz], beside that of independent terms."""
        samples, columns, full = self.fit(bandwidth)
        if full.condition > ALIKE:
            shown = replace(columns, values=columns.values * full.shown[:, :, None])
            independent = columns.select(find_basis(shown, self.kinds).chosen)
            torque = samples.torque[:, self.measured]
            full = fit_linear(independent.values, torque, full.shown, samples.starts)
        return FileFits(mechanism, samples, self.shared, self.measured, full)

    @property
    def lowest_bandwidth(self) -> float:
        """The least [Hz] that holds the motion, and rows enough for all parameters."""
        seconds = sum(float(each.time[-1] - each.time[0]) for each in self.records)
        rate = FEWEST_ROWS * len(self.terms) / (int(self.measured.sum()) * seconds)
        return max(lowest_bandwidth(self.records), rate / 4)

    def choose_bandwidth(self, widest: float = np.inf) -> float:
        """The bandwidth [Hz] of the fits, no wider one than that. Raises InputError."""
        lowest = self.lowest_bandwidth
        highest = highest_bandwidth(self.records)
        if lowest > highest:
            allowed = f"holds too few rows for {len(self.terms)} parameters; record more"
            raise InputError(self.records[0].where, "", None, allowed)
        return choose_bandwidth(self.measure, lowest, min(highest, widest))

    def measure(self, bandwidth: float) -> float:
        """The mean error in a band, without errors of terms that the motion hardly shows."""
        fit = self._fits[bandwidth] if bandwidth in self._fits else self.fit(bandwidth)[2]
        return measure_error(fit) if fit.condition <= EXCITED else np.inf


def _judge_side(problem: _Problem, bandwidth: float, knowledge: Knowledge) -> SideResult:
    # Before all else: their columns are gone where those of the bandwidth itself are made.
    bands = problem.estimate_bands(bandwidth)
    samples, columns, full = problem.fit(bandwidth)
    torque = samples.torque[:, problem.measured]
    steps, kinds = [], list(LINK_KINDS[problem.links])
    for name, added in STEPS:
        if not columns.numbers(*added).size:
            continue
        kinds += added
        part = columns.values[:, :, : columns.numbers(*kinds).size]
        steps.append(fit_part(name, part, torque, full))
    estimates = combine_bands(_select_estimates(problem, columns, full), bandwidth, bands)
    concerned, excitation = _find_concerned(problem.terms, columns, full), None
    if concerned and problem.links in ("identified", "none"):
        excitation = suggest_excitation(
            problem.robot, samples.q, problem.shared, problem.chosen, problem.measured, full.sigma
        )
    return SideResult(
        side=problem.side,
        links=problem.links,
        names=tuple(problem.robot.coordinate_names),
        measured=problem.names,
        bandwidth=bandwidth,
        steps=tuple(steps),
        estimates=estimates,
        contained=problem.basis.contained,
        alike=columns.alike,
        concerned=concerned,
        threshold=find_threshold(estimates, full),
        bands=tuple(
            replace(band, estimates=tuple(e for e in band.estimates if e.term.kind in NAMED_KINDS))
            for band in bands
        ),
        samples=samples,
        fit=full,
        excitation=excitation,
        refinement=(
            refine(_record_torque(problem, samples, full), knowledge)
            if problem.links == "identified"
            and knowledge.has_questions
            and not knowledge.lacks_size
            else None
        ),
    )


def _record_torque(problem: _Problem, samples: BandSample, full: LinearFit) -> RecordedTorque:
    """The torques of a side as its fit of all terms weighs them."""
    return RecordedTorque(
        robot=problem.robot,
        shared=problem.shared,
        samples=samples,
        payload_torque=problem.samples.compute_payload_torques(samples)[:, problem.measured],
        measured=problem.measured,
        chosen=problem.chosen,
        fit=full,
    )


def _select_estimates(
    problem: _Problem, columns: Regressor, fit: LinearFit
) -> tuple[TermEstimate, ...]:
    """Estimates of all terms but links, which are base parameters without a name of their own."""
    numbers = (each.tolist() for each in (fit.values, fit.errors, fit.half_widths))
    estimates = [TermEstimate(*each) for each in zip(columns.terms, *numbers, strict=True)]
    alike = [first for first, _ in columns.alike]
    named = [each for each in estimates if each.term.kind != "links" and each.term not in alike]
    return tuple(sorted(named, key=lambda each: problem.every.index(each.term)))


def find_threshold(estimates: tuple[TermEstimate, ...], fit: LinearFit) -> float:
    """The number of standard errors beyond which a term is named.

    By Holm's steps (1979), the surest first: one that is there is none of those that may be there
    by chance.
    """
    away = [
        abs(each.value - (each.term.kind == "scale")) / each.error
        for each in estimates
        if each.term.kind in NAMED_KINDS and each.error
    ]
    threshold = fit.quantile(1 - SIGNIFICANT / 2)
    for others, surest in zip(range(len(away), 0, -1), sorted(away, reverse=True), strict=True):
        threshold = fit.quantile(1 - SIGNIFICANT / (2 * others))
        if surest <= threshold:
            break
    return threshold


def _find_concerned(
    terms: Sequence[TorqueTerm], columns: Regressor, fit: LinearFit
) -> tuple[str, ...]:
    """Names of the terms that the motion does not or hardly show; none where it shows all."""
    there = (*columns.terms, *(second for _, second in columns.alike))
    names = [term.name for term in terms if term not in there]
    if fit.condition > EXCITED:
        parts = np.abs(fit.weakest)
        order = np.argsort(-parts)
        names += [columns.terms[index].name for index in order if parts[index] > CONCERNED]
    return tuple(names)
