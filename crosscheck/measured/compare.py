"""A record and the rigid levels of its arm: which explains it, and what it asks for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import exp

import numpy as np

from crosscheck.measured.forward import Window, windows
from crosscheck.measured.parameters import Estimate, alone, increased, parameters
from crosscheck.measured.parameters import together as base_of
from crosscheck.measured.record import Record, require_same_units, require_slow
from crosscheck.measured.residual import Fit, Normal, fits, normal_equations, whitening
from crosscheck.measured.smoothing import Block, blocks, chosen_spacing, evenly
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.drive import drive_data, torques_along
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.interface import Model
from crosscheck.planning.sizing import at_rest
from crosscheck.registry import RIGID_LEVELS, build, covering, of_level

# A level is named if every other one is less likely by such a factor.
LIKELIHOOD_RATIO = 100.0
DRAWN = 1000  # states at which all engines of a level are compared
MOST_BLOCKS = 50  # by which parameters are estimated
# Of chi squared over its degrees of freedom: more than noise, in standard deviations of it.
BEYOND_NOISE = 4.0
SAMPLES = 400  # of the residual that a picture shows, a block
Told = Callable[[str, int, int], None]


@dataclass(frozen=True)
class LevelResult:
    """A rigid level's fit; ratio: how much less likely it is than the best one, up to 1e300."""

    name: str
    fit: Fit
    ratio: float


@dataclass(frozen=True)
class Repair:
    """A level that leaves nothing but noise once a single parameter is changed."""

    level: str
    estimate: Estimate


@dataclass(frozen=True)
class EngineAgreement:
    """Largest difference of an engine's torques from the analytic ones, over the largest of these.

    rows: how many rows of the record it was asked at.
    """

    name: str
    apart: float
    rows: int


@dataclass(frozen=True)
class Shown:
    """The smoothed residual of the best level and its standard deviation by the record's noise.

    time [s]; both (rows, joints) [N m].
    """

    time: np.ndarray
    residual: np.ndarray
    deviation: np.ndarray


@dataclass(frozen=True)
class RecordComparison:
    """What a record says of an arm.

    spacing_s: time between knots of the smoothing, in the mean; angle_noise [rad] and torque_noise
    [N m] (joints,): of one sample; levels: the likeliest first; own_chi2 over own_freedom: of the
    best level under its own noise; single: its parameters as if each alone were wrong; base: those
    that can be told apart, at once, with their condition number; repairs: where it leaves more than
    noise, what would not.
    """

    record: Record
    arm: Arm
    torques_from: str
    spacing_s: float
    angle_noise: np.ndarray
    torque_noise: np.ndarray
    levels: tuple[LevelResult, ...]
    own_chi2: float
    own_freedom: int
    engines: tuple[EngineAgreement, ...]
    single: tuple[Estimate, ...]
    base: tuple[Estimate, ...]
    condition: float
    repairs: tuple[Repair, ...]
    tolerances: Mapping[str, float]
    windows: tuple[Window, ...]
    shown: Shown

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
        return _is_noise(self.own_chi2, self.own_freedom)


def compare(
    record: Record, arm: Arm, scenario: Scenario | None, tolerances: Mapping[str, float], told: Told
) -> RecordComparison:
    """Compare a record with the rigid levels of its arm.

    scenario: whose drive gives the torques of a record that has none. tolerances: relative
    standard uncertainties of the arm's parameters, by path. Raises InputError for a path that is no
    parameter's, and for a record without torques or with too few rows.
    """
    known = {parameter.path for parameter in parameters(arm)}
    for path in tolerances:
        if path not in known:
            allowed = f"must be one of {', '.join(sorted(known))}"
            raise InputError("--tolerance", path, None, allowed)
    spacing = chosen_spacing(record)
    torques, source = _torques(record, scenario, spacing)
    rows = record.time.size
    every = list(blocks(record, torques, spacing))
    parts = zip(*(block.motion for block in every), strict=True)
    motion = tuple(map(np.concatenate, parts))  # angles, rates, accelerations (rows, joints)
    require_slow(record, motion[1])
    require_same_units(record, motion[1])

    models = {level: _model(f"analytic:{level}", arm) for level in RIGID_LEVELS}
    found = fits(every, [*models.values()], lambda done: told("comparing the levels", done, rows))
    levels = _ranked(dict(zip(models, found, strict=True)))
    best = levels[0].name
    pieces = evenly(every, MOST_BLOCKS)
    among, asked = parameters(arm), sum(len(block.time) for block in pieces)

    def estimated(level: str) -> Normal:
        more = [increased(arm, parameter) for parameter in among]
        changed = [(_model(f"analytic:{level}", other), by) for other, by in more]
        doing = f"estimating parameters of {level}"
        return normal_equations(
            pieces, models[level], changed, lambda done: told(doing, done, asked)
        )

    normal = estimated(best)
    base, condition = base_of(normal, among)
    others = [] if _is_noise(normal.chi2, normal.freedom) else RIGID_LEVELS
    repairs = [
        Repair(level, each)
        for level in others
        for own in [normal if level == best else estimated(level)]
        for each in alone(own, among)
        if _is_noise(own.chi2 - each.better, own.freedom)
    ]
    told("running the model forward", rows, rows)
    runs = tuple(windows(pieces, arm, best, tolerances))
    return RecordComparison(
        record=record,
        arm=arm,
        torques_from=source,
        spacing_s=spacing * float(record.time[-1] - record.time[0]) / (rows - 1),
        angle_noise=_mean_noise(pieces, "angle_noise"),
        torque_noise=_mean_noise(pieces, "torque_noise"),
        levels=levels,
        own_chi2=normal.chi2,
        own_freedom=normal.freedom,
        engines=tuple(_engines(motion, arm, best, told)),
        single=tuple(alone(normal, among)),
        base=tuple(base),
        condition=condition,
        repairs=tuple(repairs),
        tolerances=tolerances,
        windows=runs,
        shown=_shown(pieces, models[best]),
    )


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
    pieces = blocks(record, np.zeros_like(record.angles), spacing)
    parts = [torques_along(drive, each.time, each.angles, each.rates) for each in pieces]
    return np.concatenate(parts), f"the drive of {scenario.name}"


def _model(name: str, arm: Arm) -> Model:
    """The model in an experiment without a drive: its inverse dynamics ask for motors' torques."""
    return build(name, arm, at_rest())


def _ranked(found: Mapping[str, Fit]) -> tuple[LevelResult, ...]:
    """The levels, likeliest first; what the best leaves beyond noise counts as noise for all."""
    least = min(found.values(), key=lambda fit: fit.chi2)
    scale = max(least.chi2 / least.freedom, 1.0)
    twice = {name: fit.chi2 / scale + fit.spread for name, fit in found.items()}
    best = min(twice.values())
    levels = [
        LevelResult(name, fit, exp(min((twice[name] - best) / 2, 690.0)))
        for name, fit in found.items()
    ]
    return tuple(sorted(levels, key=lambda level: twice[level.name]))


def _mean_noise(pieces: Sequence[Block], name: str) -> np.ndarray:
    """Root of the blocks' mean variance of the noise of this name, shape (joints,)."""
    return np.sqrt(np.mean([getattr(block, name) ** 2 for block in pieces], axis=0))


def _engines(
    motion: tuple[np.ndarray, ...], arm: Arm, best: str, told: Told
) -> Iterator[EngineAgreement]:
    """How far each other rigid model agrees: Pinocchio's best level at all rows, others at some."""
    able, rows = set(covering("rigid", arm, usual_switches(arm))), len(motion[0])
    drawn = np.linspace(0, rows - 1, min(rows, DRAWN)).round().astype(int)
    for level in RIGID_LEVELS:
        own = _model(f"analytic:{level}", arm)
        for name in of_level(level):
            if name == own.name or name not in able:
                continue
            every = level == best and name.startswith("pinocchio:")
            at = np.arange(rows) if every else drawn
            told(f"asking {name}", 0, at.size)
            states = [part[at] for part in motion]
            expected = own.inverse_dynamics(*states)
            apart = np.abs(_model(name, arm).inverse_dynamics(*states) - expected).max()
            yield EngineAgreement(name, float(apart / np.abs(expected).max()), at.size)


def _shown(pieces: Sequence[Block], model: Model) -> Shown:
    times, rows, deviations = [], [], []
    for block in pieces:
        shown = slice(None, None, max(len(block.time) // SAMPLES, 1))
        residual = block.torques - model.inverse_dynamics(*block.motion)
        smoothing = block.bases[0][shown] @ np.linalg.inv(block.gram)
        _, covariance = whitening(block, model)
        own = np.split(covariance, residual.shape[1])
        own = [np.split(part, len(own), axis=1)[joint] for joint, part in enumerate(own)]
        times.append(block.time[shown])
        rows.append(smoothing @ block.summed(residual))
        deviations.append(
            np.sqrt([np.einsum("rk,kl,rl->r", smoothing, part, smoothing) for part in own]).T
        )
    return Shown(np.concatenate(times), np.concatenate(rows), np.concatenate(deviations))
