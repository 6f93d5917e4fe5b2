"""A user's coordinates x of a robot, q = phi(x)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from crosscheck.checks.robot_states import RandomStates
from crosscheck.models.arm.layout import make_layout
from crosscheck.models.errors import InputError
from crosscheck.models.robot.robot import Robot
from crosscheck.trial.coordinates.curved import (
    build_callable_frame,
    build_velocity_frame,
    is_sympy_matrix,
)
from crosscheck.trial.coordinates.frame import Frame, build_linear_frame, require_invertible
from crosscheck.trial.coordinates.readings import list_readings
from crosscheck.trial.coordinates.states import find_coordinates
from crosscheck.trial.input.arrays import NotNumbers, convert_to_numbers
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.robots.readings import describe_coordinates


def build_robot_frame(coordinates: Coordinates, robot: Robot, where: str = "coordinates") -> Frame:
    """The map of a user's coordinates, of the joints' own the identity. Raises InputError."""
    size, joint_names = len(robot.coordinates), robot.coordinate_names
    usual = Coordinates()
    if (coordinates.gearing, coordinates.gears) != (usual.gearing, usual.gears):
        allowed = "of a robot's may have matrix, function, order, or links = absolute, velocities"
        raise InputError(where, "coordinates", None, allowed)
    if coordinates.order and sorted(coordinates.order) != sorted(joint_names):
        reason = f"must be all of {', '.join(joint_names)}, each once"
        raise InputError(where, "coordinates.order", list(coordinates.order), reason)
    layout = make_layout([False] * size)
    names = tuple(f"x_{number + 1}" for number in range(size))
    if coordinates.velocities is not None:
        if coordinates != replace(usual, velocities=coordinates.velocities):
            raise InputError(where, "coordinates.velocities", None, "must stand alone")
        return build_velocity_frame(coordinates.velocities, layout, names)
    if coordinates.function is not None:
        if is_sympy_matrix(coordinates.function):
            import sympy as sp

            entries = sp.lambdify([coordinates.symbols], list(coordinates.function), "numpy")
            coordinates = replace(coordinates, function=lambda x: np.array(entries(x)), symbols=())
        return build_callable_frame(coordinates, layout, f"the {size} joints of {robot.name}")
    if coordinates.matrix is not None:
        try:
            matrix = convert_to_numbers(coordinates.matrix, (size, size))
        except NotNumbers as error:
            raise InputError(where, "coordinates.matrix", None, str(error)) from None
        require_invertible(matrix, "matrix")
        return build_linear_frame(layout, names, matrix)
    if coordinates.order:
        places = [[float(name == each) for each in coordinates.order] for name in joint_names]
        return build_linear_frame(layout, names, np.array(places))
    if coordinates.links == "relative":
        return build_linear_frame(layout, tuple(joint_names), np.eye(size))
    readings = list_readings(describe_coordinates(robot))
    absolute = (each.position for each in readings if each.kind == "absolute")
    matrix = next(absolute, np.eye(size))
    return build_linear_frame(layout, names, matrix)


def place_states(states: RandomStates, frame: Frame) -> RandomStates:
    """The states, those that no x gives shifted towards one that some x gives."""
    if frame.matrix is not None:
        return states
    positions = [frame.position(x) for x in find_coordinates(frame, states.q)]
    return states._replace(q=np.array(positions))
