"""Terms that can be distinguished: independent over all motions, and over a record's own."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.linalg import qr

from crosscheck.identification.sampling import SLOW, BandSample
from crosscheck.identification.terms import (
    Regressor,
    RotorRegressor,
    TermKind,
    TorqueTerm,
    build_columns,
)
from crosscheck.models.robot.robot import Robot, Rotor

# Share of a column that earlier ones must not explain: less is the rounding of printed angles, such
# as 1.5708 between parallel axes, and no motion shows it.
INDEPENDENT = 1e-4
ROUNDED = 1e-12  # share of the largest column below which one is rounding
MOTIONS = 200  # random ones: rows of torques are many times the parameters
SEED = 0
LEAST_RATE = 1e-14  # [rad/s or m/s]
ASSUMED_RATIO = 50.0  # ratio where files state no rotor; ranks are the same for any but 0 and 1


@dataclass(frozen=True)
class TermBasis:
    """Terms that are independent, and those that others contain.

    chosen: numbers of the independent columns; contained: terms beside links that links and
    earlier terms make up.
    """

    chosen: np.ndarray
    contained: tuple[TorqueTerm, ...]


@dataclass(frozen=True)
class LevelRanks:
    """Ranks of the levels' columns: equal ones are the same model where links are free.

    links, armature, coupled: of each level's; both: of all columns of armature and coupled;
    assumed: whether the rotors are assumed, on the links before the joints and along their axes.
    """

    links: int
    armature: int
    coupled: int
    both: int
    assumed: bool

    @property
    def are_equal(self) -> bool:
        """Whether armature and coupled make the same torques, with other links."""
        return self.armature == self.coupled == self.both


def draw_samples(robot: Robot, shared: np.ndarray) -> BandSample:
    """Random motions, without regard to limits: what holds of them holds of all."""
    rng = np.random.default_rng(SEED)
    shape = (MOTIONS, len(robot.coordinates))
    q, v, a = rng.uniform(-2, 2, shape), rng.uniform(-2, 2, shape), rng.uniform(-5, 5, shape)
    return make_sample((q, v, a), np.zeros(shape), rng.uniform(-5, 5, shape), shared, step=1.0)


def make_sample(
    motion: tuple[np.ndarray, np.ndarray, np.ndarray],
    torque: np.ndarray,
    torque_rate: np.ndarray,
    shared: np.ndarray,
    step: float,
) -> BandSample:
    """Rows of a motion that is known without a filter; all (rows, n), step [s] between them."""
    q, v, a = motion
    rates = np.hstack([v, v @ shared.T])
    # Of joints that cannot move the sign is 0.
    slow = np.maximum(SLOW * np.abs(rates).max(axis=0), LEAST_RATE)
    direction = np.clip(rates / slow, -1.0, 1.0)
    return BandSample(
        bandwidth=0.0,
        q=q,
        v=v,
        a=a,
        moving=np.ones(q.shape, dtype=bool),
        direction=direction[:, : q.shape[1]],
        shared_direction=direction[:, q.shape[1] :],
        torque=torque,
        torque_rate=torque_rate,
        starts=(0, len(q)),
        step=step,
    )


def find_basis(columns: Regressor, kinds: tuple[TermKind, ...]) -> TermBasis:
    """Independent columns of these kinds, links first, then the others in their order."""
    rows = columns.values.reshape(-1, columns.values.shape[2])
    size = _sizes(rows)
    rows = rows / np.where(size > 0, size, 1.0)
    links = columns.numbers("links") if "links" in kinds else np.array([], dtype=int)
    links = links[size[links] > 0]
    chosen: list[int] = []
    basis = np.zeros((len(rows), 0))
    if links.size:
        _, triangle, order = qr(rows[:, links], mode="economic", pivoting=True)
        pivots = np.abs(np.diag(triangle))
        rank = int((pivots > INDEPENDENT * pivots[0]).sum())
        chosen = sorted(links[order[:rank]].tolist())
        basis = np.linalg.qr(rows[:, chosen])[0]
    contained = []
    for number in columns.numbers(*(kind for kind in kinds if kind != "links")):
        left = rows[:, number]  # of length 1, or 0 where nothing depends on it
        for _ in range(2):  # once more, against rounding
            left = left - basis @ (basis.T @ left)
        length = float(np.linalg.norm(left))
        if length > INDEPENDENT:
            chosen.append(int(number))
            basis = np.column_stack([basis, left / length])
        else:
            contained.append(columns.terms[number])
    return TermBasis(np.array(chosen, dtype=int), tuple(contained))


def find_alike(columns: Regressor, shown: np.ndarray) -> tuple[tuple[TorqueTerm, TorqueTerm], ...]:
    """Pairs of friction's terms that are one column where a record shows them (rows, n).

    Such are offset and Coulomb friction of a joint that turns in one direction only.
    """
    numbers = columns.numbers("offset", "viscous", "coulomb")
    rows = columns.values[:, :, numbers][shown]
    rows = rows / np.maximum(np.linalg.norm(rows, axis=0), np.finfo(float).tiny)
    pairs = []
    for first, second in combinations(range(len(numbers)), 2):
        product = rows[:, first] @ rows[:, second]
        left = rows[:, second] - product * rows[:, first]
        if product and np.linalg.norm(left) < INDEPENDENT:
            pairs.append((columns.terms[numbers[first]], columns.terms[numbers[second]]))
    return tuple(pairs)


def compare_levels(robot: Robot, shared: np.ndarray) -> LevelRanks:
    """Ranks of the levels of a robot with free links, over random motions."""
    samples = draw_samples(robot, shared)
    every = build_columns(robot, shared, samples)
    links = every.select(every.numbers("links"))
    armature = every.select(every.numbers("links", "armature"))
    rotors = RotorRegressor(robot, robot.rotors or assume_rotors(robot)).compute(samples)
    coupled = np.concatenate([links.values, rotors.values], axis=2)
    both = np.concatenate([armature.values, rotors.values], axis=2)
    return LevelRanks(
        links=_rank(links.values),
        armature=_rank(armature.values),
        coupled=_rank(coupled),
        both=_rank(both),
        assumed=not robot.rotors,
    )


def assume_rotors(robot: Robot) -> list[Rotor]:
    """A rotor for each free joint, on the link before it and along its axis."""
    rotors = []
    for number in robot.coordinates:
        joint = robot.joints[number]
        # The first link of a body is that which its joint moves: its frame is the body's.
        stator = next(name for name, frame in robot.frames.items() if frame.body == joint.parent)
        axis = joint.placement.rotation @ joint.axis
        rotors.append(Rotor(number, ASSUMED_RATIO, 1.0, stator, axis))
    return rotors


def _sizes(rows: np.ndarray) -> np.ndarray:
    """Lengths of columns; 0 for one of nothing but rounding."""
    size = np.sqrt((rows**2).sum(axis=0))
    return np.where(size > ROUNDED * size.max(), size, 0.0)


def _rank(values: np.ndarray) -> int:
    rows = values.reshape(-1, values.shape[2])
    size = _sizes(rows)
    pivots = np.abs(np.diag(qr(rows[:, size > 0] / size[size > 0], mode="r", pivoting=True)[0]))
    return int((pivots > INDEPENDENT * pivots[0]).sum())
