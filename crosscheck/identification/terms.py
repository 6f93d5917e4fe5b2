"""Terms of a robot's torques that are linear in something unknown: links, gravity, friction."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from crosscheck.identification.sampling import BandSample
from crosscheck.models.pinocchio.regressor import LinkRegressor
from crosscheck.models.robot.robot import Robot, Rotor
from crosscheck.registry import build_robot_model, reference_engine

FRICTION = {"viscous": "viscous friction", "coulomb": "Coulomb friction"}
TermKind = Literal[
    "links",
    "scale",
    "gravity",
    "offset",
    "viscous",
    "coulomb",
    "shared viscous",
    "shared coulomb",
    "armature",
    "shared armature",
    "delay",
    "rotors",
    "gain",
    "zero",
    "number",
]
FRICTION_KINDS: tuple[TermKind, ...] = (
    *("offset", "viscous", "coulomb"),
    *("shared viscous", "shared coulomb", "delay"),
)
ROTOR_KINDS: tuple[TermKind, ...] = ("armature", "shared armature")


@dataclass(frozen=True)
class TorqueTerm:
    """Something unknown of a kind, on which torques depend linearly.

    name: what people call it; unit: of the unknown number; value: what the robot's files say of
    it, None where they say nothing.
    """

    kind: TermKind
    name: str
    unit: str
    value: float | None = None

    @property
    def words(self) -> str:
        """The name as sentences have it, in which friction is that at a joint."""
        law = FRICTION.get(self.kind.removeprefix("shared "))
        whose = self.name.partition(" ")[2]
        if law is None:
            return self.name
        return f"{law} {whose if self.kind.startswith('shared') else whose.replace('of', 'at', 1)}"


@dataclass(frozen=True)
class TermEstimate:
    """An estimated term: value with its standard error and half of its 95 % interval.

    systematic: the part of the standard error that blocks do not show, by other bands; doubled: the
    value in a band twice as wide where that is further off than either interval: this one is then
    of the band and not of the robot.
    """

    term: TorqueTerm
    value: float
    error: float
    half_width: float
    systematic: float = 0.0
    doubled: float | None = None

    @property
    def t(self) -> float:
        """The value over its standard error."""
        return self.value / self.error if self.error else 0.0

    @property
    def is_determined(self) -> bool:
        """Whether its interval is narrower than the number is large; True where no file has one."""
        in_file = self.term.value
        return not in_file or self.half_width < max(abs(self.value), abs(in_file))


@dataclass(frozen=True)
class Regressor:
    """Terms, and the torques (rows, n, terms) that one unit of each makes.

    alike: pairs of terms of one column, of which the second is left out.
    """

    terms: tuple[TorqueTerm, ...]
    values: np.ndarray
    alike: tuple[tuple[TorqueTerm, TorqueTerm], ...] = ()

    def select(self, chosen: np.ndarray) -> Regressor:
        """The columns of these numbers, in this order."""
        return Regressor(tuple(self.terms[index] for index in chosen), self.values[:, :, chosen])

    def measure(self, measured: np.ndarray) -> Regressor:
        """The columns at joints whose torque is measured (n,) alone."""
        return Regressor(self.terms, self.values[:, measured])

    def numbers(self, *kinds: TermKind) -> np.ndarray:
        """Numbers of the columns of these kinds."""
        return np.array([n for n, term in enumerate(self.terms) if term.kind in kinds], dtype=int)


def shared_motors(transmission: np.ndarray) -> np.ndarray:
    """Rows of motors that several joints turn, over the rate for their own joint; (shared, n)."""
    rows = [
        row / row[number]
        for number, row in enumerate(transmission)
        if np.count_nonzero(row) > 1 and row[number]
    ]
    return np.array(rows).reshape(len(rows), transmission.shape[1])


def build_columns(robot: Robot, shared: np.ndarray, samples: BandSample) -> Regressor:
    """Columns of all terms of a robot at samples; shared: rows of motors that joints share."""
    regressor = LinkRegressor(robot)
    links = regressor.compute(*samples.states)
    terms = [
        TorqueTerm("links", name, "SI", float(value))
        for name, value in zip(regressor.names, regressor.values, strict=True)
    ]
    parts = [links]
    given = links @ regressor.values
    for joint, name in enumerate(robot.coordinate_names):
        terms.append(TorqueTerm("scale", f"the file's links at {name}", "", 1.0))
        parts.append(_keep_joint(given, joint)[:, :, None])
    # Linear beside the file's links alone: of other links it would be multiplied by these.
    terms += [
        TorqueTerm("gravity", f"gravity along {axis} beyond the file's", "m/s^2", 0.0)
        for axis in "xyz"
    ]
    parts.append(regressor.gravity_torques(samples.q))
    for term, column in _joint_columns(robot, shared, samples):
        terms.append(term)
        parts.append(column[:, :, None])
    return Regressor(tuple(terms), np.concatenate(parts, axis=2))


def filter_columns(samples: BandSample, compute: Callable[[BandSample], Regressor]) -> Regressor:
    """Columns of motions, filtered as torques are: a few rows at a time, for they are many.

    Args:
        compute: The columns at rows of motion.
    """
    values: list[np.ndarray] = []
    terms: tuple[TorqueTerm, ...] = ()
    for _, piece in samples.pieces():
        columns = compute(piece.motion)
        terms = columns.terms
        values.append(piece.filter(columns.values))
    return Regressor(terms, np.concatenate(values))


class RotorRegressor:
    """Columns of each rotor as a body, by the project's own model less its links.

    Args:
        robot: Its links alone count.
        rotors: Each of a reflected inertia of 1 kg m^2, whatever its own is.
    """

    def __init__(self, robot: Robot, rotors: Sequence[Rotor]) -> None:
        joints = tuple(replace(joint, armature=0.0) for joint in robot.joints)
        bare = replace(robot, joints=joints, rotors=(), stages=())
        self._links = build_robot_model(reference_engine(), bare, "links")
        self._turning = [
            build_robot_model(reference_engine(), replace(bare, rotors=(each,)), "coupled")
            for each in (replace(rotor, inertia=rotor.ratio**-2, mesh=None) for rotor in rotors)
        ]
        self.terms = tuple(
            TorqueTerm(
                "rotors",
                f"rotor of {robot.joints[rotor.joint].name}",
                "kg m^2",
                rotor.ratio**2 * rotor.inertia,
            )
            for rotor in rotors
        )

    def compute(self, samples: BandSample) -> Regressor:
        """The columns at samples."""
        alone = self._links.inverse_dynamics(*samples.states)
        parts = [model.inverse_dynamics(*samples.states) - alone for model in self._turning]
        shape = (*samples.q.shape, len(parts))
        return Regressor(self.terms, np.stack(parts, axis=2) if parts else np.zeros(shape))


def _joint_columns(
    robot: Robot, shared: np.ndarray, samples: BandSample
) -> Iterator[tuple[TorqueTerm, np.ndarray]]:
    """Terms of joints and of motors that they share, each with its column (rows, n)."""
    names = robot.coordinate_names
    turns = [robot.joints[number].kind == "revolute" for number in robot.coordinates]
    kinds: tuple[tuple[TermKind, np.ndarray, str, str], ...] = (
        ("offset", np.ones(samples.q.shape), "N m", "N"),
        ("viscous", samples.v, "N m s/rad", "N s/m"),
        ("coulomb", samples.direction, "N m", "N"),
        ("armature", samples.a, "kg m^2", "kg"),
    )
    values = _armatures(robot)
    for kind, signal, turning, sliding in kinds:
        for joint, name in enumerate(names):
            value = values[joint] if kind == "armature" else None
            unit = turning if turns[joint] else sliding
            yield TorqueTerm(kind, f"{kind} of {name}", unit, value), _keep_joint(signal, joint)
    for motor, row in enumerate(shared):
        together = " and ".join(names[joint] for joint in np.flatnonzero(row))
        column = samples.shared_direction[:, motor, None] * row
        yield TorqueTerm("shared coulomb", f"coulomb of the motor of {together}", "N m"), column
        mixed: tuple[tuple[TermKind, np.ndarray, str], ...] = (
            ("shared viscous", samples.v, "N m s/rad"),
            ("shared armature", samples.a, "kg m^2"),
        )
        between = np.outer(row, row) * (1 - np.eye(len(row)))  # of each joint by the others
        for kind, signal, unit in mixed:
            noun = kind.removeprefix("shared ")
            yield TorqueTerm(kind, f"{noun} that {together} share", unit), signal @ between
    yield TorqueTerm("delay", "delay of all torques", "s"), -samples.torque_rate


def _keep_joint(signal: np.ndarray, joint: int) -> np.ndarray:
    """The signal (rows, n) of a joint, 0 at all others."""
    return np.where(np.arange(signal.shape[1]) == joint, signal, 0.0)


def _armatures(robot: Robot) -> list[float | None]:
    """The armature of each free joint in the robot's file [kg m^2 or kg]."""
    values: list[float | None] = [value or None for value in robot.armature.tolist()]
    for rotor in robot.rotors:
        if rotor.joint in robot.coordinates:
            at = robot.coordinates.index(rotor.joint)
            values[at] = (values[at] or 0.0) + rotor.ratio**2 * rotor.inertia
    return values
