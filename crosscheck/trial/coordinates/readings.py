"""Misunderstandings of coordinates that are common: absolute angles, senses, orders, degrees, ...

A reading says what coordinates x may have meant: q = position @ x + offset, q' = rates @ x'. The
right answers at x then follow from a model's at q, such as M_x = rows^T M rates.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations, permutations, product

import numpy as np

FITS = 1e-8  # largest residual of a reading, relative to a part's largest number
DEGREE = np.pi / 180
QUARTERS = (np.pi / 2, np.pi, -np.pi / 2)
MOST_FOR_ALL = 4  # coordinates of which all orders and senses are tried
MOST_STATED = 3  # coordinates whose matrix is short enough to be shown


@dataclass(frozen=True)
class Reading:
    """A possible meaning of coordinates, in words that complete `right in ...`.

    position, rates, rows (n, n); offset (n,): see the module. kind: of misunderstanding. joints:
    those whose sense alone is another.
    """

    kind: str
    words: str
    position: np.ndarray
    rates: np.ndarray
    rows: np.ndarray
    offset: np.ndarray
    joints: tuple[str, ...] = ()

    @property
    def changed(self) -> int:
        """How many coordinates it takes for others."""
        is_other = (self.position != np.eye(len(self.position))).any(axis=1)
        return int(np.count_nonzero(is_other | (self.offset != 0)))

    @property
    def statement(self) -> str:
        """How equations state these coordinates, where a matrix does; else ''."""
        alike = (self.position == self.rates).all() and (self.position == self.rows).all()
        if not alike or self.offset.any():
            return ""
        if self.kind == "absolute":
            return 'coordinates=Coordinates(links="absolute")'
        rows = [[float(f"{value:.12g}") for value in row] for row in self.position.tolist()]
        return f"coordinates=Coordinates(matrix={rows})"

    @property
    def described(self) -> str:
        """The reading in words, and how equations state it, unless that is long."""
        how = self.statement if len(self.position) <= MOST_STATED else ""
        return f"{self.words} ({how})" if how else self.words


@dataclass(frozen=True)
class JointCoordinates:
    """Coordinates q of joints: names; turning: places of angles.

    before: by place, the places of angles that turn that joint's base; ratios: of motors' gears.
    """

    names: Sequence[str]
    turning: Sequence[int]
    before: Mapping[int, Sequence[int]]
    ratios: np.ndarray = field(default_factory=lambda: np.ones(0))

    @property
    def size(self) -> int:
        """How many there are."""
        return len(self.names)


def select_first_kind(readings: Sequence[Reading]) -> list[Reading]:
    """The readings of the first one's kind that change fewest coordinates: others mirror these."""
    alike = [each for each in readings if each.kind == readings[0].kind]
    fewest = min(each.changed for each in alike)
    return [each for each in alike if each.changed == fewest]


def list_readings(joints: JointCoordinates) -> list[Reading]:
    """Single misunderstandings of joints' coordinates."""
    kinds = (_absolute, _senses, _orders, _degrees, _motor_sides, _zeros)
    return [reading for kind in kinds for reading in kind(joints)]


def linear_reading(kind: str, words: str, matrix: np.ndarray) -> Reading:
    """The reading in which a matrix makes the joints' coordinates and rates of x."""
    return Reading(kind, words, matrix, matrix, matrix, np.zeros(len(matrix)))


def _absolute(joints: JointCoordinates) -> Iterator[Reading]:
    """Angles each of which is the sum of its own and of those of the joints before it."""
    sums = np.eye(joints.size)
    for place, before in joints.before.items():
        sums[place, list(before)] = 1.0
    if (sums != np.eye(joints.size)).any():
        yield linear_reading("absolute", "absolute angles", np.linalg.inv(sums))


def _senses(joints: JointCoordinates) -> Iterator[Reading]:
    names, size = joints.names, joints.size
    groups: list[tuple[int, ...]] = [(place,) for place in range(size)]
    if 1 < size <= MOST_FOR_ALL:
        groups = [g for count in range(1, size) for g in combinations(range(size), count)]
    for group in groups:
        listed = " and ".join(names[place] for place in group)
        signs = np.diag([-1.0 if place in group else 1.0 for place in range(size)])
        reading = linear_reading("sense", f"coordinates with {listed} reversed", signs)
        yield replace(reading, joints=tuple(names[place] for place in group))
    if size > 1:
        reading = linear_reading("sense", "coordinates with all senses reversed", -np.eye(size))
        yield replace(reading, joints=tuple(names))


def _orders(joints: JointCoordinates) -> Iterator[Reading]:
    names, size = joints.names, joints.size
    identity = tuple(range(size))
    orders = [identity[::-1]]
    if size <= MOST_FOR_ALL:
        orders = list(permutations(identity))
    for order in orders:
        if order != identity:
            # x_k is q of the joint order[k].
            matrix = np.array([[float(order[k] == joint) for k in identity] for joint in identity])
            listed = ", ".join(names[place] for place in order)
            yield linear_reading("order", f"coordinates in the order {listed}", matrix)


def _degrees(joints: JointCoordinates) -> Iterator[Reading]:
    turning, size = joints.turning, joints.size
    if not turning:
        return
    scale = np.eye(size)
    scale[turning, turning] = DEGREE
    still = np.eye(size)
    whole = linear_reading("degrees", "angles and rates in degrees", scale)
    yield replace(whole, words="angles in degrees", rates=still, rows=still)
    yield replace(whole, rows=still)
    yield whole


def _motor_sides(joints: JointCoordinates) -> Iterator[Reading]:
    ratios = joints.ratios
    if ratios.size and (ratios != 1).any():
        yield linear_reading(
            "motor side", "angles of the motors, before their gears", np.diag(1 / ratios)
        )


def _zeros(joints: JointCoordinates) -> Iterator[Reading]:
    names, size, turning = joints.names, joints.size, joints.turning
    still = linear_reading("zero", "", np.eye(size))
    most = 2 if len(turning) <= 2 else 1
    for count in range(1, most + 1):
        for group in combinations(turning, count):
            for angles in product(QUARTERS, repeat=count):
                offset = np.zeros(size)
                offset[list(group)] = angles
                pairs = zip(group, angles, strict=True)
                zeros = (f"{names[k]} measured from {round(a / DEGREE)} degrees" for k, a in pairs)
                words = f"coordinates with {' and '.join(zeros)}"
                yield replace(still, words=words, offset=offset)
