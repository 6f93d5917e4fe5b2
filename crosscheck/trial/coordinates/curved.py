"""Coordinates by a function q = phi(x): its Jacobian given, or found and checked."""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import Layout
from crosscheck.models.errors import InputError, describe_type
from crosscheck.runner.interruption import was_stopped
from crosscheck.trial.coordinates import frame as frames
from crosscheck.trial.coordinates.differences import derivative
from crosscheck.trial.coordinates.frame import WHERE, Along, Frame, Vector
from crosscheck.trial.input.arrays import NotNumbers, convert_to_numbers, format_vector
from crosscheck.trial.input.equations import Coordinates

COMPLEX_STEP = 1e-30
SAMPLES = 3
AGREED = 1e-6  # tolerance between a Jacobian and differences, relative to its row
CERTAIN = 1e-9  # of what differences give where nothing better is to be had


def build_curved_frame(coordinates: Coordinates, layout: Layout, arm: Arm) -> Frame:
    """The frame of a user's function. Raises InputError."""
    count = frames.describe_coordinate_count(coordinates, len(layout), arm)
    if not is_sympy_matrix(coordinates.function):
        return build_callable_frame(coordinates, layout, count)
    frame = _build_sympy_frame(coordinates, coordinates.function, layout, arm, count)
    if frame.matrix is None:
        _require_derivative(frame)
    return frame


def is_sympy_matrix(function: Any) -> bool:
    """Whether it is a Matrix of sympy, which whoever has one has imported; it takes a while."""
    return "sympy" in sys.modules and isinstance(function, sys.modules["sympy"].MatrixBase)


def _build_sympy_frame(
    coordinates: Coordinates, function: Any, layout: Layout, arm: Arm, count: str
) -> Frame:
    """The frame of a sympy Matrix, its derivatives by sympy.

    A function that turns out linear is a matrix, with the arm's symbols in it.
    """
    import sympy as sp

    from crosscheck.trial.input.symbolic import (
        express_in_arm_symbols,
        express_in_numbers,
        make_plain_symbols,
    )

    n = len(layout)
    if len(coordinates.symbols) != n or len(function) != n:
        reason = (
            f"has {len(function)} entries over {len(coordinates.symbols)} symbols;"
            f" must be {n} over {n}, for {count}"
        )
        raise InputError(WHERE, "function", None, reason)
    plain = make_plain_symbols(coordinates.symbols)
    x = [plain[symbol] for symbol in coordinates.symbols]
    q = express_in_arm_symbols(
        sp.Matrix(list(function)).xreplace(plain), x, {}, arm, f"{WHERE}: function"
    )
    names = frames.select_coordinate_names(coordinates, [symbol.name for symbol in x])
    jacobian = q.jacobian(x)
    if not jacobian.free_symbols & set(x) and not any(
        map(sp.simplify, q.subs(dict.fromkeys(x, 0)))
    ):
        matrix = np.array(express_in_numbers(jacobian, arm), dtype=np.float64)
        frames.require_invertible(matrix, "function")
        return frames.build_linear_frame(layout, names, matrix)
    u = [sp.Dummy(f"u{k}") for k in range(n)]
    drift = (jacobian * sp.Matrix(u)).jacobian(x) * sp.Matrix(u)
    value, slopes, along = (
        sp.lambdify([x, u], express_in_numbers(entries, arm), "numpy", cse=True)
        for entries in (q, jacobian, drift)
    )
    return Frame(
        layout,
        names,
        position=lambda x: _convert_answer(value(x, x), (n,), "function", x),
        slopes=lambda x: _convert_answer(slopes(x, x), (n, n), "function's jacobian", x),
        drift=lambda x, u: _convert_answer(along(x, u), (n,), "function's second derivative", x),
    )


def build_callable_frame(coordinates: Coordinates, layout: Layout, count: str) -> Frame:
    """The frame of a Python function, its Jacobian as given, by complex steps or differences.

    count: how many coordinates there are, in words. Raises InputError.
    """
    n, user_function, given = len(layout), coordinates.function, coordinates.jacobian
    if not callable(user_function):
        what = describe_type(user_function)
        reason = f"is {what}; must be a function of x or a sympy Matrix"
        raise InputError(WHERE, "function", None, reason)
    names = frames.select_coordinate_names(coordinates, [f"x_{k + 1}" for k in range(n)])

    def function(x: np.ndarray) -> np.ndarray:
        return _call_user_function(user_function, "function", x, (n,), f", for {count}")

    jacobian = partial(_difference_jacobian, function)
    frame = Frame(layout, names, function, jacobian, partial(_certain_derivative, 2, function))
    if given is None:
        frame = _build_complex_frame(frame, user_function) or frame
    elif not callable(given):
        reason = f"is {describe_type(given)}; must be a function of x"
        raise InputError(WHERE, "jacobian", None, reason)
    else:

        def slopes(x: np.ndarray) -> np.ndarray:
            return _call_user_function(given, "jacobian", x, (n, n), f", for {count}")

        drift = partial(_jacobian_drift, lambda x, u: slopes(x) @ u)
        frame = replace(frame, slopes=slopes, drift=drift)
    _require_derivative(frame)
    return frame


def build_velocity_frame(
    velocities: Callable[[np.ndarray], Any], layout: Layout, names: tuple[str, ...]
) -> Frame:
    """The frame of the coordinates themselves, with velocities S(q) q' in place of their rates.

    So J is the inverse of S, and none of a function's. Raises InputError.
    """
    n = len(layout)
    if not callable(velocities):
        reason = f"is {describe_type(velocities)}; must be a function of q"
        raise InputError(WHERE, "velocities", None, reason)

    def slopes(q: np.ndarray) -> np.ndarray:
        matrix = _call_user_function(velocities, "velocities", q, (n, n))
        frames.require_invertible(matrix, "velocities", q)
        return np.linalg.inv(matrix)

    def drift(q: np.ndarray, u: np.ndarray) -> np.ndarray:
        return _certain_derivative(1, lambda at: slopes(at) @ u, q, slopes(q) @ u)

    slopes(np.zeros(n))
    return Frame(layout, names, position=np.copy, slopes=slopes, drift=drift)


def _build_complex_frame(frame: Frame, user_function: Any) -> Frame | None:
    """The frame with a Jacobian by complex steps; None if the function does not take them."""

    def forward(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        answer = np.asarray(user_function(x + 1j * COMPLEX_STEP * u), dtype=np.complex128)
        return answer.reshape(len(x)).imag / COMPLEX_STEP

    def slopes(x: np.ndarray) -> np.ndarray:
        columns = [forward(x, unit) for unit in np.eye(len(x))]
        return _convert_answer(
            np.stack(columns, axis=1), (len(x), len(x)), "function's jacobian", x
        )

    candidate = replace(frame, slopes=slopes, drift=partial(_jacobian_drift, forward))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # numpy's, for an imaginary part that is lost
            fits = all(_misfit(candidate, x) is None for x in _sample_states(frame))
            return candidate if fits else None
    except InputError:
        raise
    except BaseException:  # whatever a function that means floats does with complex ones
        if was_stopped():
            raise
        return None


def _difference_jacobian(function: Vector, x: np.ndarray) -> np.ndarray:
    columns = [_certain_derivative(1, function, x, unit) for unit in np.eye(len(x))]
    return np.stack(columns, axis=1)


def _jacobian_drift(forward: Along, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Derivative (n,) of J u along u, at fixed u; forward(x, u): J u."""
    return _certain_derivative(1, lambda y: forward(y, u), x, u, "second derivative")


def _certain_derivative(
    order: int, function: Vector, x: np.ndarray, along: np.ndarray, what: str = ""
) -> np.ndarray:
    """A derivative (n,) of the function along a vector. Raises InputError unless it is certain."""
    size = float(np.abs(along).max()) or 1.0
    unit = along / size

    def curve(s: float) -> np.ndarray:
        try:
            with np.errstate(all="ignore"):
                return function(x + s * unit)
        except (ArithmeticError, ValueError):
            return np.full(len(x), math.nan)

    derivatives, uncertainties = derivative(curve, order)
    if not (uncertainties < CERTAIN).all():
        what = what or ("derivative" if order == 1 else "second derivative")
        reason = (
            f"its {what} is not to be found at x = {format_vector(x)}; give a sympy Matrix of it"
        )
        raise InputError(WHERE, "function", None, reason)
    return size**order * derivatives


def _call_user_function(
    user_function: Callable[[np.ndarray], Any],
    what: str,
    x: np.ndarray,
    shape: tuple[int, ...],
    more: str = "",
) -> np.ndarray:
    """The numbers of a user's answer; more: words on those that are expected. Raises InputError."""
    try:
        raw = user_function(x.copy())
    except BaseException as error:  # the user's own code
        if was_stopped():
            raise
        reason = f"raises {type(error).__name__}: {error}, at x = {format_vector(x)}"
        raise InputError(WHERE, what, None, reason) from error
    return _convert_answer(raw, shape, what + more, x)


def _convert_answer(raw: Any, shape: tuple[int, ...], what: str, x: np.ndarray) -> np.ndarray:
    try:
        return convert_to_numbers(raw, shape)
    except NotNumbers as error:
        raise InputError(WHERE, what, None, f"{error}, at x = {format_vector(x)}") from None


def _sample_states(frame: Frame) -> list[np.ndarray]:
    """A few states at which the function has values. Raises what it raises where it has none."""
    samples: list[np.ndarray] = []
    states = np.random.default_rng(1).uniform(-1.0, 1.0, (frames.TRIES, len(frame.names)))
    for number, x in enumerate(states):
        try:
            with np.errstate(all="ignore"):
                frame.position(x)
            samples.append(x)
        except (ArithmeticError, ValueError):
            if number + 1 == frames.TRIES and not samples:
                raise
        if len(samples) == SAMPLES:
            break
    return samples


def _require_derivative(frame: Frame) -> None:
    """Raise InputError unless J equals its finite differences and is invertible somewhere."""
    states = _sample_states(frame)
    for x in states:
        misfit = _misfit(frame, x)
        if misfit is not None:
            raise InputError(WHERE, "jacobian", None, f"{misfit}, at x = {format_vector(x)}")
    singular = None
    for x in states:
        try:
            frame.jacobian(x)
            return
        except InputError as error:
            singular = error
    assert singular is not None
    raise singular


def _misfit(frame: Frame, x: np.ndarray) -> str | None:
    """Which entry of J differs from differences, and both values; None if all agree."""
    given, expected = frame.slopes(x), _difference_jacobian(frame.position, x)
    size = np.abs(expected).max(axis=1, keepdims=True).clip(1e-12)
    relative_errors = np.abs(given - expected) / size
    row, column = np.unravel_index(int(relative_errors.argmax()), relative_errors.shape)
    if relative_errors[row, column] <= AGREED:
        return None
    return (
        f"[{row}, {column}], of {frame.layout.names[row]} by {frame.names[column]}, is"
        f" {given[row, column]:.8g}; differences of function give {expected[row, column]:.8g}"
    )
