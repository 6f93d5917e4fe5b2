"""A user's coordinates x of a robot, q = phi(x): their functions as those of the joints' q."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

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
from crosscheck.trial.input.calls import MATRICES, Arguments
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.robots.readings import describe_coordinates

Call = Callable[[Arguments], Any]
RATED = ("bias", "coriolis")  # parts that stand beside M, of whose x'' the map's bend is a part
KEPT_STATES = 1024  # states whose map is kept: several parts are asked at each


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


def map_calls(calls: Mapping[str, Call], frame: Frame, where: str) -> dict[str, Call]:
    """The functions of x as functions of q: what they get and what they answer is carried over.

    Torques are those of the joints in both. A matrix of Coriolis of curved coordinates counts as
    the bias that it makes. Raises InputError where a bias has no M beside it.
    """
    if frame.is_identity:
        return dict(calls)
    mass_of, curved = calls.get("mass_matrix"), frame.matrix is None
    rated = [part for part in RATED if part in calls]
    if curved and rated and mass_of is None:
        reason = "needs mass_matrix beside it: the coordinates are curved, q'' = J x'' + J' x'"
        raise InputError(where, rated[0], None, reason)

    @lru_cache(maxsize=KEPT_STATES)
    def map_state(q: bytes, v: bytes) -> tuple[np.ndarray, ...]:
        """Of a state of the joints x (n,), J (n, n), x' (n,), and J' x' (n,)."""
        x = frame.place(np.frombuffer(q))
        jacobian, v_q = frame.jacobian(x), np.frombuffer(v)
        u = np.linalg.solve(jacobian, v_q)
        bend = frame.drift(x, u) if v_q.any() else np.zeros_like(u)  # a square of the rates
        return x, jacobian, u, bend

    def carry(part: str, call: Call, arguments: Arguments) -> Any:
        """The answer in the joints' coordinates, or as it is where it is no answer."""
        q = arguments["x"]
        v = arguments.get("v", np.zeros_like(q))
        x, jacobian, u, bend = map_state(q.tobytes(), v.tobytes())
        moved = {**arguments, "x": x.copy(), "v": u.copy()}
        if "a" in arguments:
            moved["a"] = np.linalg.solve(jacobian, arguments["a"] - bend)
        raw, shape = call(moved), (len(x), len(x))
        try:
            answer = convert_to_numbers(raw, shape if part in MATRICES else shape[:1])
        except NotNumbers:  # the caller reports it with the state
            return raw
        if part == "acceleration":
            return jacobian @ answer + bend
        if part == "coriolis" and curved:
            answer = answer @ u
        if answer.ndim == 2:
            return np.linalg.solve(jacobian.T, answer) @ np.linalg.inv(jacobian)
        if part in RATED and bend.any():
            assert mass_of is not None  # as was required
            mass = convert_to_numbers(mass_of({"x": x.copy()}), shape)
            answer = answer - mass @ np.linalg.solve(jacobian, bend)
        return np.linalg.solve(jacobian.T, answer)

    mapped = {part: partial(carry, part, call) for part, call in calls.items()}
    return {"bias" if curved and part == "coriolis" else part: c for part, c in mapped.items()}


def place_states(states: RandomStates, frame: Frame) -> RandomStates:
    """The states, those that no x gives shifted towards one that some x gives."""
    if frame.matrix is not None:
        return states
    positions = [frame.position(x) for x in find_coordinates(frame, states.q)]
    return states._replace(q=np.array(positions))
