"""Estimates that go beyond a record: links known by their file, gains of drives, encoders' zeros.

Torques y of joints are modelled as s (A(q + z) x) + d y', with x of links, friction and rotors, s
and z of each joint's drive and encoder, d a delay. Rows of correlated errors weigh less, by the
number for which these agree; what a file says of links is more rows, one for each parameter.
Links may be asked to be possible bodies (bodies.py).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np
from scipy.linalg import qr, solve_triangular
from scipy.special import chdtri

from crosscheck.identification.bodies import (
    BODY,
    BORDER,
    Solution,
    find_scale,
    find_thickness,
    solve_bodies,
)
from crosscheck.identification.estimation import LinearFit, count_alike_rows
from crosscheck.identification.sampling import BandSample
from crosscheck.identification.structure import draw_samples, find_basis
from crosscheck.identification.terms import (
    FRICTION_KINDS,
    ROTOR_KINDS,
    Regressor,
    RotorRegressor,
    TermEstimate,
    TermKind,
    TorqueTerm,
    build_columns,
    filter_columns,
)
from crosscheck.models.pinocchio.regressor import LinkRegressor
from crosscheck.models.robot.robot import Level, Robot

Unknown = Literal["gains", "zeros"]
LESS_LIKELY = 2 * np.log(100.0)  # excess of chi squared at which a level is rejected
SURPRISE = 0.001  # chance of links so far from their file, where its uncertainty is right
NO_SLOPE = 1e-7  # share of the largest slope below which one is rounding
ANGLE = 1e-5  # [rad or m] by which slopes in positions are taken: an error of 1e-10 of them
PASSES, SETTLED = 20, 1e-7  # of standard errors: a last step of estimates


class Knowledge(NamedTuple):
    """Knowledge beyond a record, and questions beyond the file's numbers.

    links: relative standard deviation of what the file says of each link, None where it is not
    believed; unknown: whether gains of drives and zeros of encoders are estimated; are_possible:
    whether links have to be possible bodies; payloads: ten parameters of each body that a payload
    adds, of each recording, nothing if there are none.
    """

    links: float | None = None
    unknown: frozenset[Unknown] = frozenset()
    are_possible: bool = False
    payloads: tuple[np.ndarray, ...] = ()

    @property
    def lacks_size(self) -> bool:
        """Whether gains are unknown and nothing has a known size, so any gain has its links."""
        differ = any((each != self.payloads[0]).any() for each in self.payloads)
        return "gains" in self.unknown and self.links is None and not differ

    @property
    def has_questions(self) -> bool:
        """Whether links are known to a share, or there are questions beyond the files' numbers."""
        return self.links is not None or bool(self.unknown)


@dataclass(frozen=True)
class RecordedTorque:
    """Torques of a side, and how their rows are weighed.

    samples: all joints, without payload_torque (rows, measured); measured (n,): joints whose
    torque is known; chosen: numbers of the columns that are independent over all motions; fit: by
    these.
    """

    robot: Robot
    shared: np.ndarray
    samples: BandSample
    payload_torque: np.ndarray
    measured: np.ndarray
    chosen: np.ndarray
    fit: LinearFit

    @property
    def deviations(self) -> np.ndarray:
        """Standard deviations (measured,) that divide a row's weight by its number of like rows."""
        alike = [
            max(
                count_alike_rows(self.fit.residual[first:last], joint)
                for first, last in pairwise(self.samples.starts)
            )
            for joint in range(len(self.fit.sigma))
        ]
        return self.fit.sigma * np.sqrt(alike)


@dataclass(frozen=True)
class PossibleBodies:
    """The cost of restricting links to possible bodies.

    excess: of chi squared over links without this condition; impossible: joints that move bodies
    which these would be no longer; border: joints whose bodies are at the border now.
    """

    excess: float
    impossible: tuple[str, ...]
    border: tuple[str, ...]

    @property
    def explain(self) -> bool:
        """Whether possible bodies are not a hundred times less likely than any."""
        return self.excess < LESS_LIKELY


@dataclass(frozen=True)
class LevelFit:
    """Estimates at a level.

    chi_squared: of rows and of links against their file; surprise: the latter's part; links: ten
    parameters of each body, the file's where torques do not depend on them, empty where base
    parameters alone are estimated; shown: on how many of them torques depend; contained: joints
    whose encoder's zero links or nothing make up; settled: whether the estimates came to rest;
    bodies: where links have to be possible.
    """

    level: Level
    chi_squared: float
    surprise: float
    estimates: tuple[TermEstimate, ...]
    links: np.ndarray
    shown: int
    contained: tuple[str, ...]
    settled: bool
    bodies: PossibleBodies | None = None


@dataclass(frozen=True)
class Refinement:
    """Fits of a side's torques with further knowledge; fits: of the levels that differ."""

    knowledge: Knowledge
    fits: tuple[LevelFit, ...]

    @property
    def best(self) -> LevelFit:
        """The likeliest level's fit."""
        return min(self.fits, key=lambda fit: fit.chi_squared)

    @property
    def is_decided(self) -> bool:
        """Whether the fits converge and, if there are two, one level can be named."""
        settled = all(fit.settled for fit in self.fits)
        is_refuted = self.is_surprising or self.is_impossible
        return settled and not is_refuted and (len(self.fits) == 1 or bool(self.level))

    @property
    def is_surprising(self) -> bool:
        """Whether links are further from their file than its uncertainty allows."""
        return self.best.surprise > float(chdtri(self.best.shown, SURPRISE))

    @property
    def is_impossible(self) -> bool:
        """Whether links have to be possible bodies, and such explain the torques at no level."""
        return self.best.bodies is not None and not self.best.bodies.explain

    @property
    def level(self) -> Level | None:
        """The level that is a hundred times likelier than any other; None if there is none."""
        others = [fit.chi_squared for fit in self.fits if fit is not self.best]
        lead = min(others, default=self.best.chi_squared) - self.best.chi_squared
        is_refuted = self.is_surprising or self.is_impossible
        return self.best.level if lead > LESS_LIKELY and not is_refuted else None


def refine(record: RecordedTorque, knowledge: Knowledge) -> Refinement:
    """Estimate with what is known: at armature, and at coupled where the file has rotors."""
    levels: list[Level] = ["armature"]
    if knowledge.links is not None and record.robot.rotors and not record.robot.stages:
        levels.append("coupled")
    return Refinement(knowledge, tuple(_judge_level(record, knowledge, each) for each in levels))


class _LinearTerms:
    """Columns of links, friction and rotors at a level, at any positions of the joints."""

    def __init__(self, record: RecordedTorque, knowledge: Knowledge, level: Level) -> None:
        self.record, robot = record, record.robot
        self._rotors = RotorRegressor(robot, robot.rotors) if level == "coupled" else None
        self._chosen = record.chosen
        if knowledge.links is not None:
            every = build_columns(robot, record.shared, draw_samples(robot, record.shared))
            kinds: tuple[TermKind, ...] = ("links", *FRICTION_KINDS)
            if level == "armature":
                kinds += ROTOR_KINDS
            geared = {f"armature of {robot.joints[rotor.joint].name}" for rotor in robot.rotors}
            is_bare = [
                bool(geared) and each.kind in ROTOR_KINDS and each.name not in geared
                for each in every.terms
            ]
            self._chosen = np.setdiff1d(every.numbers(*kinds), np.flatnonzero(is_bare))
        first = filter_columns(record.samples, self._compute)
        shown = (first.values * record.fit.shown[:, :, None]).any(axis=(0, 1))
        is_link = np.array([term.kind == "links" for term in first.terms])
        # A possible body has all its parameters, those that the motion does not show among them.
        self._shown = np.flatnonzero(shown | is_link if knowledge.are_possible else shown)
        self.is_shown = shown[self._shown]
        self.terms = first.select(self._shown).terms
        self.is_late = np.array([term.kind == "delay" for term in self.terms])
        self.is_link = np.array([term.kind == "links" for term in self.terms])

    def _compute(self, samples: BandSample) -> Regressor:
        """The columns at samples that are not filtered."""
        record = self.record
        columns = build_columns(record.robot, record.shared, samples).select(self._chosen)
        if self._rotors is not None:
            rotors = self._rotors.compute(samples)
            values = np.concatenate([columns.values, rotors.values], axis=2)
            columns = Regressor(columns.terms + rotors.terms, values)
        return columns.measure(record.measured)

    def compute(self, samples: BandSample, zeros: np.ndarray) -> np.ndarray:
        """Columns (rows, measured, terms) where encoders read too little by zeros (n,)."""
        return filter_columns(samples.turn(zeros), self._compute).values[:, :, self._shown]

    def differentiate(
        self, samples: BandSample, zeros: np.ndarray, values: np.ndarray, is_free: np.ndarray
    ) -> np.ndarray:
        """Derivatives (rows, measured, free) of torques by free zeros; rounding counts as 0."""
        slopes = []
        for way in ANGLE * np.eye(len(zeros))[is_free]:
            ahead, back = (self.compute(samples, zeros + turn) for turn in (way, -way))
            slopes.append((ahead - back) @ values / (2 * ANGLE))
        found = np.stack(slopes, axis=2)
        size = np.abs(found).max(axis=(0, 1))
        return np.where(size > NO_SLOPE * size.max(), found, 0.0)


def _find_contained_zeros(terms: _LinearTerms) -> tuple[np.ndarray, np.ndarray]:
    """Whether links can make up each encoder's zero (n,), and the file's torques in base links.

    The latter are values (terms,) of the file's links alone, all others 0.
    """
    record = terms.record
    random = draw_samples(record.robot, record.shared)
    none = np.zeros(len(record.measured))
    columns = terms.compute(random, none)
    flat = columns.reshape(-1, columns.shape[2])
    links = LinkRegressor(record.robot)
    torque = (links.compute(*random.states) @ links.values)[:, record.measured].ravel()
    base = np.zeros(len(terms.terms))
    base[terms.is_link] = np.linalg.lstsq(flat[:, terms.is_link], torque, rcond=None)[0]
    slopes = terms.differentiate(random, none, base, none == 0)
    zeros = tuple(TorqueTerm("zero", str(number), "") for number in range(len(none)))
    every = Regressor(terms.terms + zeros, np.concatenate([columns, slopes], axis=2))
    kinds = tuple(dict.fromkeys(term.kind for term in every.terms))
    contained = [int(each.name) for each in find_basis(every, kinds).contained if each in zeros]
    return np.isin(np.arange(len(none)), contained), base


def _judge_level(record: RecordedTorque, knowledge: Knowledge, level: Level) -> LevelFit:
    """The estimates of a level; where links have to be possible, what this costs."""
    fit = _fit_level(record, knowledge, level)
    if not knowledge.are_possible:
        return fit
    free = _fit_level(record, knowledge._replace(are_possible=False), level)
    regressor = LinkRegressor(record.robot)
    scale = find_scale(regressor.values)
    joints = np.array([name.removesuffix(": m") for name in regressor.names[::BODY]])
    bodies = PossibleBodies(
        excess=fit.chi_squared - free.chi_squared,
        impossible=tuple(joints[find_thickness(free.links, scale) <= 0].tolist()),
        border=tuple(joints[find_thickness(fit.links, scale) < BORDER].tolist()),
    )
    return replace(fit, bodies=bodies)


def _fit_level(record: RecordedTorque, knowledge: Knowledge, level: Level) -> LevelFit:
    """The estimates of a level, by Gauss and Newton's steps where gains or zeros are unknown."""
    terms = _LinearTerms(record, knowledge, level)
    robot, count = record.robot, len(terms.terms)
    names = np.array(robot.coordinate_names)
    is_free = np.full(len(names), "zeros" in knowledge.unknown)
    precision, mean = np.zeros((0, count)), np.zeros(count)
    if knowledge.links is not None:
        mean[terms.is_link] = [term.value or 0.0 for term in terms.terms if term.kind == "links"]
        precision = _weigh_links(terms, knowledge.links)
    elif is_free.any():
        contained, mean = _find_contained_zeros(terms)
        is_free &= ~contained
    if is_free.any():
        slopes = terms.differentiate(record.samples, 0.0 * is_free, mean, is_free)
        is_free[is_free] = (slopes * record.fit.shown[:, :, None]).any(axis=(0, 1))
    gains = int(record.measured.sum()) if "gains" in knowledge.unknown else 0
    state = np.concatenate([mean, np.ones(gains), np.zeros(int(is_free.sum()))])
    weights = record.fit.shown / record.deviations
    torque = record.samples.torque[:, record.measured]
    prior = np.hstack([precision, np.zeros((len(precision), len(state) - count))])
    expected = prior @ state
    fixed = terms.compute(record.samples, np.zeros(len(names)))

    def linearize(state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Weighted residual, the links' rows last, and its slopes with the sign changed."""
        values, zeros = state[:count], np.zeros(len(names))
        zeros[is_free] = state[count + gains :]
        scales = state[count : count + gains] if gains else np.ones(torque.shape[1])
        columns = terms.compute(record.samples, zeros) if is_free.any() else fixed
        drawn = np.where(terms.is_late, 0.0, values)
        parts = [columns * np.where(terms.is_late, 1.0, scales[:, None])]
        left = torque - parts[0] @ values - (scales - 1) * record.payload_torque
        if gains:
            parts.append((columns @ drawn + record.payload_torque)[:, :, None] * np.eye(gains))
        if is_free.any():
            slopes = terms.differentiate(record.samples, zeros, drawn, is_free)
            parts.append(slopes * scales[:, None])
        slopes = (np.concatenate(parts, axis=2) * weights[:, :, None]).reshape(-1, len(state))
        right = np.concatenate([(left * weights).ravel(), expected - prior @ state])
        return right, np.vstack([slopes, prior])

    is_link = np.append(terms.is_link, np.zeros(len(state) - count, dtype=bool))
    is_linear, settled = not (gains or is_free.any()), False
    for _ in range(1 if is_linear else PASSES):
        right, slopes = linearize(state)
        if knowledge.are_possible:
            solution = solve_bodies(right, slopes, state, is_link)
        else:
            solution = _solve(right, slopes, state)
        step, state = solution.state - state, solution.state
        at_rest = is_linear or (np.abs(step) < SETTLED * solution.errors).all()
        settled = solution.settled and bool(at_rest)
        if settled:
            break
    right, _ = linearize(state)
    surprise = float((right[len(right) - len(prior) :] ** 2).sum())
    every = list(terms.terms)
    every += [
        TorqueTerm("gain", f"drive gain of {name}", "", 1.0)
        for name in (names[record.measured] if gains else ())
    ]
    every += [
        TorqueTerm("zero", f"encoder zero of {names[place]}", robot.joint_units[names[place]], 0.0)
        for place in np.flatnonzero(is_free).tolist()
    ]
    estimates = []
    for term, value, error in zip(every, state.tolist(), solution.errors.tolist(), strict=True):
        if term.kind == "gain":  # the inverse of the factor on the stated torques
            value, error = 1 / value, error / value**2
        if term.kind != "links":
            estimates.append(TermEstimate(term, value, error, record.fit.interval * error))
    return LevelFit(
        level=level,
        chi_squared=float((right**2).sum()),
        surprise=surprise,
        estimates=tuple(estimates),
        links=_complete_links(terms, state) if len(precision) else np.zeros(0),
        shown=int((terms.is_link & terms.is_shown).sum()) if len(precision) else 0,
        contained=tuple(names[~is_free].tolist()) if "zeros" in knowledge.unknown else (),
        settled=settled,
    )


def _solve(right: np.ndarray, slopes: np.ndarray, state: np.ndarray) -> Solution:
    """Solve linear least squares: the residual at a state, and its slopes by the unknowns."""
    size = np.sqrt((slopes**2).sum(axis=0))
    basis, triangle = qr(slopes / size, mode="economic", check_finite=False)
    step = solve_triangular(triangle, basis.T @ right) / size
    inverse = solve_triangular(triangle, np.eye(len(state))) / size[:, None]
    return Solution(state + step, np.sqrt((inverse**2).sum(axis=1)), settled=True)


def _complete_links(terms: _LinearTerms, state: np.ndarray) -> np.ndarray:
    """Ten parameters of each body: the estimates, the file's of those that are none."""
    regressor = LinkRegressor(terms.record.robot)
    by_name = dict(zip(regressor.names, regressor.values.tolist(), strict=True))
    values = zip(terms.terms, state.tolist(), strict=False)
    by_name |= {term.name: value for term, value in values if term.kind == "links"}
    return np.array(list(by_name.values()))


def _weigh_links(terms: _LinearTerms, share: float) -> np.ndarray:
    """Rows (links' parameters, terms) with one over each parameter's standard deviation.

    The share is relative to a mass m, to the mean I of the moments of inertia about the joint's
    frame, and to the root of m I for first moments: products may be zero and still uncertain.
    """
    regressor = LinkRegressor(terms.record.robot)
    bodies = regressor.values.reshape(-1, BODY)
    mass, inertia = bodies[:, 0], (bodies[:, 4] + bodies[:, 6] + bodies[:, 9]) / 3
    first = np.sqrt(np.maximum(mass * inertia, 0.0))
    spread = share * np.column_stack([mass, *[first] * 3, *[inertia] * 6]).ravel()
    by_name = dict(zip(regressor.names, spread.tolist(), strict=True))
    deviations = np.array([by_name.get(term.name, 0.0) for term in terms.terms])
    weights = np.divide(1.0, deviations, out=np.zeros(len(deviations)), where=deviations > 0)
    return np.diag(weights)[terms.is_link]
