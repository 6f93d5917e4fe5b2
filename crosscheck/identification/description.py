"""A record's description: the columns and files of motion and torque, and their meaning."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from crosscheck.identification.mechanism import list_body_parameters
from crosscheck.identification.refinement import Knowledge, Unknown
from crosscheck.models.arm import quantities
from crosscheck.models.arm.quantities import Data
from crosscheck.models.errors import InputError
from crosscheck.models.files import read_toml
from crosscheck.models.inputs import doubt_degrees
from crosscheck.models.loading import validate_record
from crosscheck.models.pinocchio.regressor import LinkRegressor
from crosscheck.models.robot.robot import BASE, Robot, RobotBody
from crosscheck.recordings.csv_table import CsvTable, open_table
from crosscheck.recordings.record import Record, describe_gaps

Column = Annotated[str, quantities.PrintableText(200)]
FileName = Annotated[str, quantities.PrintableText(400)]
Columns = Annotated[
    tuple[Annotated[str, quantities.PrintableText(200, may_be_empty=True)], ...],
    Field(strict=False, min_length=1, max_length=64),
]
Factor = Annotated[float, quantities.NumberRange(-1e9, 1e9)]
Factors = Annotated[tuple[Factor, ...], Field(strict=False, min_length=1, max_length=64)]
Matrix = Annotated[tuple[Factors, ...], Field(strict=False, min_length=1, max_length=64)]
Side = Literal["motor", "joint"]


class PositionColumns(Data):
    """Columns that hold the joints' or the motors' positions."""

    columns: Columns
    """Names of the columns, in the order of the robot's joints."""
    unit: Literal["rad", "deg", "m"] = "rad"
    """Unit of the numbers."""
    shaft: Side = "joint"
    """Shaft of the positions; the transmission converts motors' positions to joints'."""
    zero: Factors | None = None
    """Added to the joints' positions [rad or m]; 0 if left out."""


class TorqueColumns(Data):
    """Columns that hold torques, or the currents that make them."""

    columns: Columns
    """Names of the columns, in the order of the robot's joints."""
    gain: Factors | None = None
    """Torque [N m or N] for each unit of the numbers, such as N m/A; 1 if left out."""
    shaft: Side = "joint"
    """Shaft of the torques; motors' torques are converted to joints'."""


class Payload(Data):
    """A known body that a link holds, small beside its way from the joints: a point mass."""

    link: Column
    """Link of the URDF."""
    mass_kg: Annotated[float, quantities.NumberRange(1e-9, 1e9, "kg")]
    """Mass of the payload."""
    place_m: Annotated[tuple[Factor, Factor, Factor], Field(strict=False)]
    """Its centre of mass in the link's frame [m]."""


class RecordingFiles(Data):
    """The files of one recording; a single one if all columns are there."""

    position: FileName
    """CSV file with times and positions, from this file's folder."""
    torque: FileName | None = None
    """CSV file with the torques, row by row with the first; the same if left out."""
    payload: Payload | None = None
    """Load that the URDF does not have."""


class LinkPrior(Data):
    """Knowledge of the robot from before it is measured."""

    links: Annotated[float, quantities.NumberRange(1e-6, 10)]
    """Relative standard deviation of each link's mass and moments in the robot's file."""
    bodies: Literal["any", "possible"] = "any"
    """Whether links must be possible bodies, without negative mass anywhere."""


class RecordDescription(Data):
    """Recordings of a robot: which columns are what, and how motors turn joints."""

    schema_version: quantities.SchemaVersion
    """Version of the file: 1."""
    recordings: Annotated[tuple[RecordingFiles, ...], Field(strict=False, min_length=1)]
    """Recordings of one robot, estimated together."""
    time: Column | None = None
    """Column of the times [s]; step_s if left out."""
    step_s: Annotated[float, quantities.NumberRange(1e-7, 10, "s")] | None = None
    """Time between rows, if no column has times."""
    position: PositionColumns
    """Positions of the joints."""
    motor_torque: TorqueColumns | None = None
    """Torques of the motors: rotors and gears are between them and the links."""
    joint_torque: TorqueColumns | None = None
    """Torques that sensors behind the gears measure: there is no rotor."""
    transmission: Matrix | None = None
    """Rate of each motor (rows) for the rate of each joint; direct or unknown if left out."""

    prior: LinkPrior | None = None
    """Accuracy of the file's links; unknown if left out."""
    estimate: Annotated[tuple[Unknown, ...], Field(strict=False, max_length=2)] = ()
    """Further unknowns: gains of all drives, zeros of all encoders."""


def load_description(path: Path) -> RecordDescription:
    """The description in a TOML file. Raises InputError."""
    return validate_record(RecordDescription, read_toml(path), str(path))


def find_knowledge(description: RecordDescription, robot: Robot, where: Path) -> Knowledge:
    """The knowledge of links and payloads in a description, and its further questions.

    Raises InputError for a payload on no link that moves.
    """
    prior, unknown = description.prior, frozenset(description.estimate)
    held = [files.payload for files in description.recordings]
    payloads = tuple(_compute_payload(each, robot, where) for each in held) if any(held) else ()
    links, are_possible = (prior.links, prior.bodies == "possible") if prior else (None, False)
    return Knowledge(links, unknown, are_possible, payloads)


def _compute_payload(payload: Payload | None, robot: Robot, where: Path) -> np.ndarray:
    """The change of links' parameters by a payload, in the regressor's order. Raises InputError."""
    nothing = RobotBody(0.0, np.zeros(3), np.zeros((3, 3)))
    bodies = [nothing] * len(robot.bodies)
    if payload is not None:
        frame = robot.frames.get(payload.link)
        if frame is None or frame.body == BASE:
            moving = ", ".join(name for name, each in robot.frames.items() if each.body != BASE)
            allowed = f"must be one of {moving}"
            raise InputError(str(where), "recordings.payload.link", payload.link, allowed)
        place = frame.placement.rotation @ np.array(payload.place_m) + frame.placement.position
        bodies[frame.body] = replace(nothing, mass=payload.mass_kg, com=place)
    return list_body_parameters(replace(robot, bodies=tuple(bodies)), LinkRegressor(robot).names)


def read_recordings(
    description: RecordDescription, robot: Robot, where: Path
) -> tuple[Record, ...]:
    """Read the recordings that a description names, in SI units at the joints.

    Raises InputError naming file, row, column and what is allowed.
    """
    count = len(robot.coordinates)
    _require_lengths(description, count, str(where))
    turns = transmission_matrix(description, count)
    if np.linalg.matrix_rank(turns) < count:
        raise InputError(str(where), "transmission", None, "must be a matrix that has an inverse")
    return tuple(
        _read_recording(description, files, turns, where) for files in description.recordings
    )


def transmission_matrix(description: RecordDescription, count: int) -> np.ndarray:
    """Rates of motors for rates of joints, (count, count)."""
    given = description.transmission
    return np.eye(count) if given is None else np.array(given)


def _require_lengths(description: RecordDescription, count: int, where: str) -> None:
    """Raise InputError where a list has not an entry for each joint, or nothing is measured."""
    lists = {
        f"{name}.{field}": values
        for name in ("position", "motor_torque", "joint_torque")
        for field, values in getattr(description, name) or ()
    }
    lists["transmission"] = description.transmission
    for number, row in enumerate(description.transmission or ()):
        lists[f"transmission.{number}"] = row
    for name, values in lists.items():
        if isinstance(values, tuple) and len(values) != count:
            reason = f"has {len(values)} entries; must have {count}, one for each free joint"
            raise InputError(where, name, None, reason)
    if description.motor_torque is None and description.joint_torque is None:
        raise InputError(where, "", None, "needs a table motor_torque or joint_torque")
    if (description.time is None) == (description.step_s is None):
        raise InputError(where, "", None, "needs time, the name of a column, or step_s")


def _read_recording(
    description: RecordDescription, files: RecordingFiles, turns: np.ndarray, where: Path
) -> Record:
    """One recording. Raises InputError."""
    moving = open_table(where.parent / files.position)
    given, torques = description.position, (description.motor_torque, description.joint_torque)
    pulled = tuple(name for each in torques if each is not None for name in each.columns)
    if files.torque is None:
        time = _read_times(description, moving)
        pieces = moving.select_pieces((*given.columns, *pulled))
    else:
        pulling = open_table(where.parent / files.torque)
        time, rows = _read_times(description, moving), pulling.count_rows()
        if rows != len(time):
            reason = f"has {rows} rows, {moving.where} has {len(time)}"
            raise InputError(pulling.where, "", None, reason)
        both = moving.select_pieces(given.columns), pulling.select_pieces(pulled)
        pieces = (np.hstack(pair) for pair in zip(*both, strict=True))
    count, done = len(given.columns), 0
    signals = np.empty((len(time), count + len(pulled)))
    for piece in pieces:
        signals[done : done + len(piece)] = piece
        done += len(piece)
    positions, *tables = np.split(signals, len(signals[0]) // count, axis=1)
    # In place: signals of a long recording are most of the memory.
    if given.unit == "deg":
        positions *= np.pi / 180
    elif given.unit == "rad" and given.shaft == "joint":
        for name, angles in zip(given.columns, positions.T, strict=True):
            doubt_degrees(moving.where, name, angles, 'state unit = "deg" in [position]')
    if given.shaft == "motor":
        positions[:] = np.linalg.solve(turns, positions.T).T
    if given.zero is not None:
        positions += np.array(given.zero)
    for stated, values in zip(filter(None, torques), tables, strict=True):
        values *= np.array(stated.gain or 1.0)
        if stated.shaft == "motor":
            values[:] = values @ turns
    left = iter(tables)
    before, behind = (None if each is None else next(left) for each in torques)
    gaps = tuple(describe_gaps(time))
    return Record(moving.where, time, positions, before, behind, notes=gaps)


def _read_times(description: RecordDescription, table: CsvTable) -> np.ndarray:
    """Times [s] of all rows. Raises InputError."""
    if description.time is None:
        return (description.step_s or 1.0) * np.arange(table.count_rows())
    return np.concatenate(list(table.select_pieces((description.time,))))[:, 0]
