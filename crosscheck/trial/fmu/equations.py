"""Equations out of an FMU's accelerations: of a rigid arm also M, bias and force."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field

from crosscheck.trial.coordinates.frame import frame_of
from crosscheck.trial.fmu.archive import library_of, unpacked
from crosscheck.trial.fmu.description import FmuDescription, described
from crosscheck.trial.fmu.unit import MappedUnit
from crosscheck.trial.input.equations import Coordinates, Equations, Level
from crosscheck.trial.tables.coordinates_file import MOST, CoordinatesFile
from models.arm.arm import Arm
from models.errors import InputError
from models.files import read_toml
from models.loading import validated

Variables = Annotated[tuple[str, ...], Field(min_length=1, max_length=MOST)]
PUSH_N_M = 1e3  # by which torques are told from weight


class MappingFile(CoordinatesFile):
    """Names of an FMU's variables: coordinates, their rates, the drive's torques."""

    q: Variables
    v: Variables
    torque: Variables


def fmu_equations(path: Path, mapping: Path, arm: Arm, folder: Path) -> Equations:
    """The equations of a unit; it is unpacked into an empty folder, and runs in workers alone.

    Raises InputError.
    """
    said = validated(MappingFile, read_toml(mapping), str(mapping))
    unpacked(path, folder)
    description = described(str(path), folder)
    own = Coordinates(**said.model_dump(exclude={"level", "q", "v", "torque"}))
    frame = frame_of(own, arm)
    wanted = {"q": len(frame.names), "v": len(frame.names), "torque": len(arm.joints)}
    for name, count in wanted.items():
        given = getattr(said, name)
        if len(given) != count or len(set(given)) < count:
            reason = f"must be {count} names unlike each other"
            raise InputError(str(mapping), name, list(given), reason)
    places = (
        _states(description, said.q, mapping, "q"),
        _states(description, said.v, mapping, "v"),
        _inputs(description, said.torque, mapping),
    )
    library = library_of(str(path), folder, description.identifier)
    unit = MappedUnit(folder, library, description, *places)
    theta = frame.jacobian(np.zeros(len(frame.names)))[frame.layout.theta]
    return _equations(unit, theta, own, said.level)


def _states(
    description: FmuDescription, names: tuple[str, ...], mapping: Path, field: str
) -> tuple[int, ...]:
    for name in names:
        if name not in description.states:
            allowed = f"is no continuous state; there are {', '.join(description.states)}"
            raise InputError(str(mapping), field, name, allowed)
    return tuple(map(description.states.index, names))


def _inputs(description: FmuDescription, names: tuple[str, ...], mapping: Path) -> tuple[int, ...]:
    references = {v.name: v.reference for v in description.variables if v.is_input}
    for name in names:
        if name not in references:
            allowed = f"is no real input; there are {', '.join(references) or 'none'}"
            raise InputError(str(mapping), "torque", name, allowed)
    return tuple(references[name] for name in names)


def _equations(
    unit: MappedUnit, theta: np.ndarray, coordinates: Coordinates, level: Level
) -> Equations:
    """theta (joints, n): d theta / dx. With a torque on each coordinate M is what resists them;
    else there is the acceleration alone."""
    joints, size = theta.shape
    if joints != size:
        return Equations(
            acceleration=lambda t, x, v, torque: unit.acceleration(t, x, v, torque),
            coordinates=coordinates,
        )

    def mass_matrix(x: np.ndarray) -> np.ndarray:
        still, gained = np.zeros(size), np.zeros((size, joints))
        for joint, push in enumerate(PUSH_N_M * np.eye(joints)):
            ahead, back = (unit.acceleration(0.0, x, still, sign * push) for sign in (1, -1))
            gained[:, joint] = (ahead - back) / (2 * PUSH_N_M)
        return theta.T @ np.linalg.inv(gained)

    def bias(x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """What is even in the rates and vanishes with them: weight and friction do not."""
        idle = np.zeros(joints)
        ahead, back, still = (unit.acceleration(0.0, x, s * v, idle) for s in (1, -1, 0))
        return mass_matrix(x) @ (still - (ahead + back) / 2)

    def force(t: float, x: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        return mass_matrix(x) @ unit.acceleration(t, x, v, torque) + bias(x, v)

    return Equations(
        mass_matrix=mass_matrix, bias=bias, force=force, coordinates=coordinates, level=level
    )
