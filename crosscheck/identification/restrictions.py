"""The numbers of a mechanism's files as restrictions of the fit of all terms.

A rigid level with the numbers of its file makes torques of its own; friction and a delay are
estimated beside them, and one number of the file, if it alone may be wrong. Such a restriction
explains a record if it leaves no more at any joint than any links do (Fisher's test); of several
the likeliest is named.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import exp

import numpy as np
from scipy.special import chdtrc, fdtrc, fdtri

from crosscheck.identification.estimation import LinearFit, fit_linear
from crosscheck.identification.mechanism import (
    ComparedMechanism,
    Parameter,
    RigidLevel,
    list_body_parameters,
)
from crosscheck.identification.sampling import BandSample
from crosscheck.identification.structure import find_basis
from crosscheck.identification.terms import (
    FRICTION_KINDS,
    Regressor,
    TermEstimate,
    TorqueTerm,
    build_columns,
    filter_columns,
)
from crosscheck.models.errors import InputError
from crosscheck.models.pinocchio.regressor import LinkRegressor
from crosscheck.models.robot.robot import Robot, remove_friction
from crosscheck.registry import build_robot_model, reference_engine

# Chance that links of any kind leave less at a joint while a restriction of them is right.
SIGNIFICANT = 1e-4
PLAUSIBLE = 0.01  # the same of a number's change, which is the best of many
LEFT_MORE = 1.1  # ratio of residuals at a joint below which the links are not wrong
CLEAR = 2.0  # ratio of residuals up to which they are alike
LIKELIHOOD_RATIO = 100.0  # likelihood ratio from which on one of two is named alone
POSITIONS = 20  # of a record, at which inertias are computed
MOST_NUMBERS = 8  # numbers of a level with the least residual, fitted with intervals
PASSES, SETTLED = 5, 0.01  # of standard errors: a last step of a number
NO_COLUMN = 1e-6  # share of the largest column of the same unit: less is rounding
# Share of a joint's rms torque that filters and interpolation leave in a record without noise.
ROUNDED = 1e-6


@dataclass(frozen=True)
class Restriction:
    """A level with its file's numbers, or all but one.

    parameter: the number that is estimated, None if none is; estimates: of friction and of it;
    ratios (joints,): rms of each joint's residual over that of any links; chance: that a right one
    leaves so much more; surprise: twice the logarithm of how much less likely it is than any links;
    mechanism: with the number estimated; None where no file may hold it.
    """

    level: str
    parameter: Parameter | None
    estimates: tuple[TermEstimate, ...]
    ratios: np.ndarray
    chance: float
    surprise: float
    mechanism: ComparedMechanism | None

    @property
    def explains(self) -> bool:
        """Whether it is possible, and fits no worse than any links do."""
        return self.is_fitting and self.mechanism is not None

    @property
    def is_fitting(self) -> bool:
        """Whether it fits no worse than any links do."""
        return self.chance >= (SIGNIFICANT if self.parameter is None else PLAUSIBLE)

    @property
    def is_clear(self) -> bool:
        """Whether any links leave as much, so that it fits not for want of quiet rows alone."""
        return bool(self.ratios.max() <= CLEAR)

    @property
    def friction(self) -> tuple[TermEstimate, ...]:
        """Estimates of friction and a delay."""
        return tuple(each for each in self.estimates if each.term.kind != "number")

    @property
    def estimate(self) -> TermEstimate | None:
        """The estimate of the number; None where none is estimated."""
        return next((each for each in self.estimates if each.term.kind == "number"), None)

    def compute_friction(self, rates: np.ndarray) -> np.ndarray:
        """Torques (rows, n) of joints' own friction as estimated, at rates (rows, n)."""
        by_name = {each.term.name: each.value for each in self.friction}
        joints = self.mechanism.robot.coordinate_names if self.mechanism else []
        signals = {"offset": np.ones_like(rates), "viscous": rates, "coulomb": np.sign(rates)}
        torques = np.zeros_like(rates)
        for kind, signal in signals.items():
            torques += signal * [by_name.get(f"{kind} of {name}", 0.0) for name in joints]
        return torques


@dataclass(frozen=True)
class FileJudgement:
    """The judgement of a mechanism's files by a record.

    levels: with the files' numbers; changes: where none of these explains the record, with one
    number estimated, those that explain it or the one that comes next; the likeliest first.
    """

    levels: tuple[Restriction, ...]
    changes: tuple[Restriction, ...]

    @property
    def explained(self) -> bool:
        """Whether a level with the files' numbers explains the record."""
        return self.levels[0].explains

    @property
    def explanations(self) -> tuple[Restriction, ...]:
        """Restrictions that explain the record, nearly as likely as the best, which is first."""
        able = [each for each in (*self.levels, *self.changes) if each.explains]
        return tuple(each for each in able if self.compare(each, able[0]) < LIKELIHOOD_RATIO)

    @property
    def best(self) -> Restriction:
        """The likeliest explanation; the likeliest level where there is none."""
        return next(iter(self.explanations), self.levels[0])

    @property
    def likeliest(self) -> Restriction:
        """The likeliest of all, which may be impossible or explain the record no better."""
        return min((*self.levels, *self.changes), key=lambda each: each.surprise)

    def compare(self, restriction: Restriction, other: Restriction) -> float:
        """The likelihood of one over that of another, up to 1e300."""
        return exp(min((restriction.surprise - other.surprise) / 2, 690.0))


def find_worse_joints(
    names: Sequence[str],
    ratios: np.ndarray,
    further: np.ndarray,
    left: np.ndarray,
) -> dict[str, float]:
    """Ratios of residuals at joints where a fit with further parameters is significantly better.

    By Fisher's test of what these take up there, of all joints together at the level SIGNIFICANT.

    Args:
        ratios: Of both fits' rms of residuals (joints,).
        further: Independent values that the further parameters take up at each joint.
        left: Those that are left then.
    """
    further = np.maximum(further, 1.0)
    chance = fdtri(further, left, 1 - SIGNIFICANT / len(ratios))
    least = np.sqrt(1 + chance * further / left)
    rows = zip(names, ratios.tolist(), least.tolist(), strict=True)
    return {name: ratio for name, ratio, needed in rows if ratio > max(LEFT_MORE, needed)}


def compute_chance(ratios: np.ndarray, further: np.ndarray, left: np.ndarray) -> float:
    """The chance that parameters without effect reduce the residual so much at all joints together.

    Fisher's test at each joint, whose chances are combined as he does it (1932): many joints that
    leave a little more say as much as one that leaves much more. As for ``find_worse_joints``.
    """
    further = np.maximum(further, 1.0)
    chances = fdtrc(further, left, np.maximum(ratios**2 - 1, 0.0) * left / further)
    least = np.finfo(float).tiny
    return float(chdtrc(2 * len(ratios), -2 * np.log(np.maximum(chances, least)).sum()))


class FileFits:
    """Fits of a record's torques in a band by levels of a mechanism.

    Args:
        mechanism: With the gravity that holds.
        samples: Of the record, torques without those of payloads.
        shared: Rates of motors that several joints turn, for rates of joints (shared, n).
        measured: Whether a joint's torque is measured (n,).
        full: The fit of all terms.
    """

    def __init__(
        self,
        mechanism: ComparedMechanism,
        samples: BandSample,
        shared: np.ndarray,
        measured: np.ndarray,
        full: LinearFit,
    ) -> None:
        self._mechanism, self._samples, self._measured = mechanism, samples, measured
        self._full = full
        # Of levels, which are kept, so that no other robot has the place of one in memory.
        self._torques: dict[tuple[str, int], tuple[RigidLevel, np.ndarray]] = {}
        self._torque = samples.torque[:, measured]
        self._least = ROUNDED * np.sqrt((self._torque**2).mean(axis=0))
        self._noise: dict[str, np.ndarray] = {}
        robot = remove_friction(mechanism.robot)
        self._body_names = LinkRegressor(robot).names

        def compute(piece: BandSample) -> Regressor:
            columns = build_columns(robot, shared, piece).measure(measured)
            return columns.select(columns.numbers("links", *FRICTION_KINDS))

        columns = filter_columns(samples, compute)
        self._links = columns.values[:, :, columns.numbers("links")]
        friction = columns.select(columns.numbers(*FRICTION_KINDS))
        shown = Regressor(friction.terms, friction.values * full.shown[:, :, None])
        self._friction = friction.select(find_basis(shown, FRICTION_KINDS).chosen)

    def judge(self, levels: Sequence[RigidLevel]) -> FileJudgement:
        """The levels with the files' numbers; single changes where none of these explains."""
        fits = [self._fit(level) for level in levels]
        changes: list[Restriction] = []
        if not any(fit.explains for fit in fits):
            for level in levels:
                changes += self._fit_changes(level)
        explaining = [each for each in changes if each.is_fitting]
        nearest = sorted(changes, key=lambda each: each.surprise)[:1]
        return FileJudgement(_sort(fits), _sort(explaining or nearest))

    def _fit_changes(self, level: RigidLevel) -> Iterator[Restriction]:
        """The fits of changed numbers with the smallest residual."""
        numbers, columns = [], []
        for parameter in self._mechanism.parameters:
            column = None if parameter.is_friction else self._compute_column(level, parameter)
            if column is not None and (column * self._full.shown).any():
                numbers.append(parameter)
                columns.append(column)
        if not numbers:
            return
        table = np.stack(columns, axis=2)
        weights = (self._full.shown / self._full.sigma)[:, :, None]
        friction = (self._friction.values * weights).reshape(-1, len(self._friction.terms))
        flat = (table * weights).reshape(len(friction), -1)
        right = ((self._torque - self._compute_torques(level)) * weights[:, :, 0]).ravel()
        basis = np.linalg.qr(friction / np.linalg.norm(friction, axis=0))[0]
        flat, right = (each - basis @ (basis.T @ each) for each in (flat, right))
        sizes = np.linalg.norm(flat, axis=0)
        units = [parameter.unit for parameter in numbers]
        most = [max(sizes[[each == unit for each in units]]) for unit in units]
        sizes = np.where(sizes > NO_COLUMN * np.array(most), sizes, 0.0)
        falls = (flat.T @ right) ** 2 / np.where(sizes > 0, sizes, np.inf) ** 2
        for place in np.argsort(-falls)[:MOST_NUMBERS].tolist():
            yield self._settle(level, numbers[place], columns[place])

    def repeat(self, restriction: Restriction) -> Restriction:
        """A restriction of another band in this one."""
        level, parameter = self._mechanism.find_level(restriction.level), restriction.parameter
        if parameter is None:
            return self._fit(level)
        column = self._compute_column(level, parameter)
        assert column is not None  # as in the other band
        return self._settle(level, parameter, column)

    def _settle(self, level: RigidLevel, parameter: Parameter, column: np.ndarray) -> Restriction:
        """Fit with one number free; a place takes several steps: moments have its square."""
        fit, value = self._fit(level, parameter, column), np.inf
        number = fit.estimates[-1]
        for _ in range(PASSES if parameter.unit == "m" else 0):
            if fit.mechanism is None or abs(number.value - value) < SETTLED * number.error:
                break
            value = number.value
            moved, there = fit.mechanism.find_level(level.name), parameter._replace(value=value)
            new = self._compute_column(moved, there)
            if new is None:
                break
            fit = self._fit(moved, there, new)
            number = fit.estimates[-1]
        number = replace(number, term=replace(number.term, value=parameter.value))
        return replace(fit, parameter=parameter, estimates=(*fit.friction, number))

    def _fit(
        self,
        level: RigidLevel,
        parameter: Parameter | None = None,
        column: np.ndarray | None = None,
    ) -> Restriction:
        """The fit of a level, with a number if it is given with its column (rows, joints)."""
        terms, columns = list(self._friction.terms), self._friction.values
        if parameter is not None and column is not None:
            term = TorqueTerm("number", parameter.phrase, parameter.unit, parameter.value)
            terms.append(term)
            columns = np.concatenate([columns, column[:, :, None]], axis=2)
        full, torque = self._full, self._torque - self._compute_torques(level)
        fit = fit_linear(columns, torque, full.shown, self._samples.starts)
        # A column is of what is more than the file's number; friction has none.
        given = np.array([(term.kind == "number" and term.value) or 0.0 for term in terms])
        numbers = ((fit.values + given).tolist(), fit.errors.tolist(), fit.half_widths.tolist())
        estimates = [TermEstimate(*each) for each in zip(terms, *numbers, strict=True)]
        most = np.maximum(full.sigma, self._least)
        ratios = np.maximum(fit.sigma, self._least) / most
        # Any links may be too small, so that they leave less than the noise of the accelerations.
        noise = np.maximum(most, self._compute_noise(level))
        beyond = np.maximum(fit.sigma, noise) / noise
        independent = full.taken + full.left
        return Restriction(
            level=level.name,
            parameter=parameter,
            estimates=tuple(estimates),
            ratios=ratios,
            chance=compute_chance(beyond, full.taken - fit.taken, full.left),
            surprise=float(independent @ np.log(beyond**2)),
            mechanism=_apply(self._mechanism, parameter, estimates),
        )

    def _compute_noise(self, level: RigidLevel) -> np.ndarray:
        """Torques (measured,) that the noise of positions makes by a level's inertias, rms."""
        noise = self._samples.acceleration_noise
        if noise is None:
            return np.zeros(self._torque.shape[1])
        if level.name not in self._noise:
            model = build_robot_model(reference_engine(), remove_friction(level.robot), level.level)
            chosen = np.linspace(0, len(self._samples.q) - 1, POSITIONS).round().astype(int)
            inertias = model.mass_matrix(self._samples.q[chosen])
            power = (inertias**2 @ noise**2).mean(axis=0)
            self._noise[level.name] = np.sqrt(power)[self._measured]
        return self._noise[level.name]

    def _compute_torques(self, level: RigidLevel) -> np.ndarray:
        """Torques (rows, measured) of a level in the band, without friction."""
        key = level.level, id(level.robot)
        if key not in self._torques:
            bodies = list_body_parameters(level.robot, self._body_names)
            self._torques[key] = level, self._links @ bodies + self._compute_rotors(level)
        return self._torques[key][1]

    def _compute_rotors(self, level: RigidLevel) -> np.ndarray:
        """The torques of a level's rotors (rows, measured), in the band."""
        if level.level == "links":
            return np.zeros_like(self._torque)
        robot = remove_friction(level.robot)
        models = [
            build_robot_model(reference_engine(), robot, each) for each in (level.level, "links")
        ]
        parts = []
        for _, piece in self._samples.pieces():
            whole, links = (model.inverse_dynamics(*piece.motion.states) for model in models)
            parts.append(piece.filter(whole - links))
        return np.concatenate(parts)[:, self._measured]

    def _compute_column(self, level: RigidLevel, parameter: Parameter) -> np.ndarray | None:
        """The torques (rows, measured) of one unit more of a number; None without any."""
        step = parameter.step
        changed = self._mechanism.change({parameter.path: parameter.value + step})
        other = next((each for each in changed.levels if each.name == level.name), None)
        if other is None:
            return None
        robots = other.robot, level.robot
        bodies = [list_body_parameters(robot, self._body_names) for robot in robots]
        column: np.ndarray = self._links @ (bodies[0] - bodies[1])
        if level.level != "links" and _list_rotors(robots[0]) != _list_rotors(robots[1]):
            column = column + self._compute_rotors(other) - self._compute_rotors(level)
        elif not np.any(bodies[0] - bodies[1]):
            return None
        return column / step


def _list_rotors(robot: Robot) -> tuple[object, ...]:
    """Parts of a robot beside its links."""
    inertias = tuple(rotor.inertia for rotor in robot.rotors)
    return inertias, tuple(stage.gears for stage in robot.stages), tuple(robot.armature.tolist())


def _apply(
    mechanism: ComparedMechanism, parameter: Parameter | None, estimates: Sequence[TermEstimate]
) -> ComparedMechanism | None:
    """The mechanism with an estimate in place of its file's number; None where it may not be."""
    if parameter is None:
        return mechanism
    value = estimates[-1].value
    if not parameter.is_signed:
        if value + estimates[-1].half_width < 0:
            return None
        value = max(value, 0.0)
    try:
        return mechanism.change({parameter.path: value})
    except InputError:
        return None


def _sort(restrictions: Sequence[Restriction]) -> tuple[Restriction, ...]:
    """The likeliest first of those that explain, then of the others."""
    return tuple(sorted(restrictions, key=lambda each: (not each.explains, each.surprise)))


def flag_friction(
    restriction: Restriction, robot: Robot, threshold: float
) -> tuple[TermEstimate, ...]:
    """Estimates of friction that are not the file's, which has no Coulomb friction.

    threshold: how many errors an estimate is off where it is another.
    """
    viscous = dict(zip(robot.coordinate_names, robot.friction.tolist(), strict=True))
    flagged = []
    for each in restriction.friction:
        _, _, joint = each.term.name.partition(" of ")
        given = viscous.get(joint, 0.0) if each.term.kind == "viscous" else 0.0
        if abs(each.value - given) > threshold * each.error and each.term.kind != "delay":
            flagged.append(replace(each, term=replace(each.term, value=given)))
    return tuple(flagged)
