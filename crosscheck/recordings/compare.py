"""A record and the rigid levels of its arm: which explains it, and what it asks for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import exp

import numpy as np

from crosscheck.findings import Finding
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.drive import drive_data, torques_along
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.recordings.engines import build_rigid_model, compare_arm_engines
from crosscheck.recordings.forward import Window, run_windows
from crosscheck.recordings.friction import FrictionFit, fit_friction
from crosscheck.recordings.gravity import GravityFit, find_gravity, fit_gravity
from crosscheck.recordings.parameters import (
    Estimate,
    Parameter,
    apply_estimate,
    estimate_separately,
    find_parameters,
    increase_parameter,
)
from crosscheck.recordings.parameters import estimate_together as base_of
from crosscheck.recordings.record import Record, require_same_units, require_slow
from crosscheck.recordings.residual import (
    Fit,
    NormalEquations,
    build_normal_equations,
    fit_models,
    whitening,
)
from crosscheck.recordings.smoothing import Block, select_evenly, select_spacing, smooth_record
from crosscheck.registry import find_distinct_levels
from crosscheck.runner.progress_update import CountCallback

# A level is named if every other one is less likely by such a factor.
LIKELIHOOD_RATIO = 100.0
MOST_BLOCKS = 50  # by which parameters are estimated
# Of chi squared over its degrees of freedom: more than noise, in standard deviations of it.
BEYOND_NOISE = 4.0
SAMPLES = 400  # of the residual that a picture shows, a block


@dataclass(frozen=True)
class LevelResult:
    """A rigid level's fit; ratio: how much less likely it is than the best one, up to 1e300."""

    name: str
    fit: Fit
    ratio: float


@dataclass(frozen=True)
class Repair:
    """A level that leaves nothing but noise once a single parameter is changed.

    arm: with the parameter so changed; None where no arm can have it.
    """

    level: str
    estimate: Estimate
    arm: Arm | None


Explanation = Repair | FrictionFit | GravityFit


@dataclass(frozen=True)
class ResidualCurve:
    """The smoothed residual of a level and its standard deviation by the record's noise.

    change: what of the arm is changed; None for the file's numbers. time (rows,) [s]; both others
    (rows, joints) [N m].
    """

    level: str
    change: Explanation | None
    time: np.ndarray
    residual: np.ndarray
    deviation: np.ndarray


@dataclass(frozen=True)
class ComparisonBasis:
    """What is known of a record and its arm before anything is judged.

    spacing_s: time between knots of the smoothing, in the mean; engines: how far each is from the
    analytic models on the record.
    """

    record: Record
    arm: Arm
    torques_from: str
    spacing_s: float
    engines: tuple[Finding, ...]


@dataclass(frozen=True)
class EngineDisagreement(ComparisonBasis):
    """A comparison that says nothing of the record, for the engines disagree on the arm."""


@dataclass(frozen=True)
class RecordComparison(ComparisonBasis):
    """What a record says of an arm on which the engines agree.

    angle_noise [rad] and torque_noise [N m] (joints,): of one sample; levels: the likeliest first;
    own_chi2 over own_freedom: of the best level under its own noise; single: its parameters as if
    each alone were wrong; base: those that the record distinguishes, at once, with their condition
    number; repairs, frictions and gravities: where it leaves more than noise, what would not;
    curves: of the best explanation, without its change and with it.
    """

    angle_noise: np.ndarray
    torque_noise: np.ndarray
    levels: tuple[LevelResult, ...]
    residual_chi2: float
    residual_freedom: int
    single: tuple[Estimate, ...]
    base: tuple[Estimate, ...]
    condition: float
    repairs: tuple[Repair, ...]
    frictions: tuple[FrictionFit, ...]
    gravities: tuple[GravityFit, ...]
    tolerances: Mapping[str, float]
    windows: tuple[Window, ...]
    curves: tuple[ResidualCurve, ...]

    @property
    def best(self) -> LevelResult:
        """The likeliest level."""
        return self.levels[0]

    @property
    def decided(self) -> bool:
        """Whether the best level leaves nothing but noise and the others are too unlikely."""
        return self.explained and len(self.candidates) == 1

    @property
    def candidates(self) -> tuple[str, ...]:
        """Names of the levels that the record does not tell from the best."""
        return tuple(level.name for level in self.levels if level.ratio < LIKELIHOOD_RATIO)

    @property
    def explained(self) -> bool:
        """Whether the best level leaves no more than the record's noise."""
        return _is_noise(self.residual_chi2, self.residual_freedom)

    @property
    def explanations(self) -> list[Explanation]:
        """The changes that an arm can have: friction, gravity, then numbers that leave least."""
        return _select_possible(self.repairs, self.frictions, self.gravities)


def compare(
    record: Record,
    arm: Arm,
    scenario: Scenario | None,
    tolerances: Mapping[str, float],
    progress: CountCallback,
) -> RecordComparison | EngineDisagreement:
    """Compare a record with the rigid levels of its arm, if the engines agree on these.

    Args:
        scenario: Whose drive gives the torques of a record that has none.
        tolerances: Relative standard uncertainties of the arm's parameters, by path.

    Raises:
        InputError: For a path that is no parameter's, and for a record without torques, with too
            few rows or with rows that no spline can follow.
    """
    _require_parameters(arm, tolerances)
    try:
        return _compare_levels(record, arm, scenario, tolerances, progress)
    except np.linalg.LinAlgError:  # of a spline, or of its noise
        reason = "rows stand too unevenly in time to be smoothed; cut the record where it has gaps"
        raise InputError(record.where, "t", None, reason) from None


def _compare_levels(
    record: Record,
    arm: Arm,
    scenario: Scenario | None,
    tolerances: Mapping[str, float],
    progress: CountCallback,
) -> RecordComparison | EngineDisagreement:
    """The comparison of a record that can be smoothed."""
    spacing = select_spacing(record)
    torques, source = _torques(record, scenario, spacing)
    rows = record.time.size
    pieces = list(smooth_record(record, torques, spacing))
    angles, rates, accelerations = (
        np.concatenate(parts) for parts in zip(*(block.motion for block in pieces), strict=True)
    )
    require_slow(record, rates)
    require_same_units(record, rates)
    progress("asking the engines", 0, rows)
    basis = ComparisonBasis(
        record=record,
        arm=arm,
        torques_from=source,
        spacing_s=spacing * float(record.time[-1] - record.time[0]) / (rows - 1),
        engines=tuple(compare_arm_engines((angles, rates, accelerations), arm)),
    )
    if any(engine.verdict != "agree" for engine in basis.engines):
        return EngineDisagreement(**vars(basis))
    return _judge_levels(basis, pieces, tolerances, progress)


def _judge_levels(
    basis: ComparisonBasis,
    every: Sequence[Block],
    tolerances: Mapping[str, float],
    progress: CountCallback,
) -> RecordComparison:
    """The comparison of the levels, and what the record asks of the arm's numbers."""
    arm, rows = basis.arm, basis.record.time.size
    names = find_distinct_levels(arm)
    models = [build_rigid_model(level, arm) for level in names]
    level_fits = fit_models(
        every, models, lambda done: progress("comparing the levels", done, rows)
    )
    levels = _rank_levels(dict(zip(names, level_fits, strict=True)))
    best, among = levels[0].name, find_parameters(arm)
    pieces = select_evenly(every, MOST_BLOCKS)
    normal = _build_equations(pieces, arm, best, among, progress)
    equations = normal.leading(len(among))
    base, condition = base_of(equations, among)
    repairs: list[Repair] = []
    frictions: list[FrictionFit] = []
    gravities: list[GravityFit] = []
    if not _is_noise(equations.chi2, equations.freedom):
        for level in names:
            each = (
                normal if level == best else _build_equations(pieces, arm, level, among, progress)
            )
            repairs += _find_repairs(each, level, arm, among)
            frictions += _find_frictions(each, level, arm, among)
            gravities += _find_gravities(each, level, arm, len(among))
    explanations = _select_possible(repairs, frictions, gravities)
    progress("running the model forward", rows, rows)
    return RecordComparison(
        **vars(basis),
        angle_noise=_mean_noise(pieces, "angle_noise"),
        torque_noise=_mean_noise(pieces, "torque_noise"),
        levels=levels,
        residual_chi2=equations.chi2,
        residual_freedom=equations.freedom,
        single=tuple(estimate_separately(equations, among)),
        base=tuple(base),
        condition=condition,
        repairs=tuple(repairs),
        frictions=tuple(frictions),
        gravities=tuple(gravities),
        tolerances=tolerances,
        windows=tuple(run_windows(pieces, arm, best, tolerances)),
        curves=tuple(_compute_curves(pieces, arm, best, explanations)),
    )


def _require_parameters(arm: Arm, tolerances: Mapping[str, float]) -> None:
    """Raise InputError for a path that is no parameter's."""
    available_paths = {parameter.path for parameter in find_parameters(arm)}
    for path in tolerances:
        if path not in available_paths:
            allowed = f"must be one of {', '.join(sorted(available_paths))}"
            raise InputError("--tolerance", path, None, allowed)


def _build_equations(
    pieces: Sequence[Block],
    arm: Arm,
    level: str,
    among: Sequence[Parameter],
    progress: CountCallback,
) -> NormalEquations:
    """Normal equations of a level: the parameters, gravity, then Coulomb friction of joints."""
    more = [increase_parameter(arm, parameter) for parameter in (*among, *find_gravity(arm))]
    changes = [(build_rigid_model(level, other), by) for other, by in more]
    total = sum(len(block.time) for block in pieces)
    doing = f"estimating parameters of {level}"
    return build_normal_equations(
        pieces,
        build_rigid_model(level, arm),
        changes,
        lambda done: progress(doing, done, total),
        coulomb=True,
    )


def _find_repairs(
    normal: NormalEquations, level: str, arm: Arm, among: Sequence[Parameter]
) -> list[Repair]:
    equations = normal.leading(len(among))
    return [
        Repair(level, each, apply_estimate(arm, each))
        for each in estimate_separately(equations, among)
        if _is_noise(equations.chi2 - each.better, equations.freedom)
    ]


def _find_frictions(
    normal: NormalEquations, level: str, arm: Arm, among: Sequence[Parameter]
) -> list[FrictionFit]:
    fit = fit_friction(normal, level, arm, among)
    return [fit] if _is_noise(normal.chi2 - fit.better, normal.freedom) else []


def _find_gravities(normal: NormalEquations, level: str, arm: Arm, before: int) -> list[GravityFit]:
    fit = fit_gravity(normal, level, arm, range(before, before + len(arm.gravity_m_per_s2)))
    return [fit] if _is_noise(normal.chi2 - fit.better, normal.freedom) else []


def _select_possible(
    repairs: Sequence[Repair],
    frictions: Sequence[FrictionFit],
    gravities: Sequence[GravityFit],
) -> list[Explanation]:
    """Those that an arm can have: friction, gravity, numbers; each kind by what it leaves."""
    able = [each for each in repairs if each.arm is not None]
    return [
        *sorted((each for each in frictions if each.arm is not None), key=lambda each: each.left),
        *sorted((each for each in gravities if each.arm is not None), key=lambda each: each.left),
        *sorted(able, key=lambda each: each.estimate.left),
    ]


def _is_noise(chi2: float, freedom: int) -> bool:
    return bool(chi2 / freedom <= 1 + BEYOND_NOISE * np.sqrt(2 / freedom))


def _torques(record: Record, scenario: Scenario | None, spacing: int) -> tuple[np.ndarray, str]:
    """Torques (rows, joints) [N m], and where they are from. Raises InputError without any."""
    if record.torques is not None and scenario is None:
        return record.torques, "the record"
    if scenario is None:
        reason = "has no torques; columns must be torque_1_N_m, ..., or --scenario tells the drive"
        raise InputError(record.where, "", None, reason)
    drive = drive_data(scenario, record.angles.shape[1])
    pieces = smooth_record(record, np.zeros_like(record.angles), spacing)
    parts = [torques_along(drive, each.time, each.angles, each.rates) for each in pieces]
    return np.concatenate(parts), f"the drive of {scenario.name}"


def _rank_levels(level_fits: Mapping[str, Fit]) -> tuple[LevelResult, ...]:
    """The levels, likeliest first; what the best leaves beyond noise counts as noise for all."""
    least = min(level_fits.values(), key=lambda fit: fit.chi2)
    scale = max(least.chi2 / least.freedom, 1.0)
    twice = {name: fit.chi2 / scale + fit.spread for name, fit in level_fits.items()}
    best = min(twice.values())
    levels = [
        LevelResult(name, fit, exp(min((twice[name] - best) / 2, 690.0)))
        for name, fit in level_fits.items()
    ]
    return tuple(sorted(levels, key=lambda level: twice[level.name]))


def _mean_noise(pieces: Sequence[Block], name: str) -> np.ndarray:
    """Root of the blocks' mean variance of the noise of this name, shape (joints,)."""
    return np.sqrt(np.mean([getattr(block, name) ** 2 for block in pieces], axis=0))


def _compute_curves(
    pieces: Sequence[Block], arm: Arm, best: str, explanations: Sequence[Explanation]
) -> list[ResidualCurve]:
    """Of the best explanation before and after its change; of the best level where none is."""
    if not explanations:
        return [_compute_curve(pieces, arm, best, None)]
    change = explanations[0]
    return [
        _compute_curve(pieces, arm, change.level, None),
        _compute_curve(pieces, arm, change.level, change),
    ]


def _compute_curve(
    pieces: Sequence[Block], arm: Arm, level: str, change: Explanation | None
) -> ResidualCurve:
    times, rows, deviations = [], [], []
    model = build_rigid_model(level, arm if change is None or change.arm is None else change.arm)
    for block in pieces:
        shown = slice(None, None, max(len(block.time) // SAMPLES, 1))
        residual = block.torques - model.inverse_dynamics(*block.motion)
        if isinstance(change, FrictionFit):
            residual -= change.coulomb * np.sign(block.rates)
        smoothing = block.bases[0][shown] @ np.linalg.inv(block.gram)
        _, covariance = whitening(block, model)
        size = len(block.gram)
        joint_slices = [
            slice(joint * size, (joint + 1) * size) for joint in range(residual.shape[1])
        ]
        times.append(block.time[shown])
        rows.append(smoothing @ block.summed(residual))
        variances = [
            np.einsum("rk,kl,rl->r", smoothing, covariance[part, part], smoothing)
            for part in joint_slices
        ]
        deviations.append(np.sqrt(variances).T)
    parts = np.concatenate(times), np.concatenate(rows), np.concatenate(deviations)
    return ResidualCurve(level, change, *parts)
