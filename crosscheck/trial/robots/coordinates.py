"""A user's coordinates x of a robot, q = matrix @ x: their functions as those of the joints' q."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.models.robot.robot import Robot
from crosscheck.trial.coordinates.frame import require_invertible
from crosscheck.trial.coordinates.readings import list_readings
from crosscheck.trial.input.arrays import NotNumbers, convert_to_numbers
from crosscheck.trial.input.calls import MATRICES, Arguments
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.robots.readings import describe_coordinates

MOVED = ("x", "v", "a")  # arguments that are of coordinates


@dataclass(frozen=True)
class MappedCall:
    """A function of x as one of q: what it gets and what it answers are carried over.

    inverse: of the matrix. Torques are those of the joints in both.
    """

    call: Callable[[Arguments], Any]
    part: str
    matrix: np.ndarray
    inverse: np.ndarray

    def __call__(self, arguments: Arguments) -> Any:
        """The answer in the joints' coordinates, or as it is where it is no answer."""
        moved = {
            name: self.inverse @ value if name in MOVED else value
            for name, value in arguments.items()
        }
        raw, size = self.call(moved), len(self.matrix)
        shape = (size, size) if self.part in MATRICES else (size,)
        try:
            answer = convert_to_numbers(raw, shape)
        except NotNumbers:  # which whoever called tells with the state
            return raw
        if self.part in MATRICES:
            return self.inverse.T @ answer @ self.inverse
        return self.matrix @ answer if self.part == "acceleration" else self.inverse.T @ answer


def read_matrix(coordinates: Coordinates, robot: Robot, where: str) -> np.ndarray | None:
    """The matrix of a user's coordinates; None for the joints' own. Raises InputError."""
    usual = Coordinates()
    plain = replace(coordinates, links="relative", matrix=None, names=())
    if plain != usual:
        allowed = "of a robot's may have matrix, or links = absolute"
        raise InputError(where, "coordinates", None, allowed)
    if coordinates.matrix is not None:
        size = len(robot.coordinates)
        try:
            matrix = convert_to_numbers(coordinates.matrix, (size, size))
        except NotNumbers as error:
            raise InputError(where, "coordinates.matrix", None, str(error)) from None
        require_invertible(matrix, "matrix")
        return matrix
    if coordinates.links == "relative":
        return None
    readings = list_readings(describe_coordinates(robot))
    absolute = (each.position for each in readings if each.kind == "absolute")
    return next(absolute, None)
