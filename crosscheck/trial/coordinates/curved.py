"""Coordinates by a function q = phi(x): its Jacobian given, or found and checked."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import sympy as sp

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import Layout
from crosscheck.models.errors import InputError
from crosscheck.runner.interruption import was_stopped
from crosscheck.trial.coordinates import frame as frames
from crosscheck.trial.coordinates.differences import derivative
from crosscheck.trial.coordinates.frame import WHERE, Along, Frame, Vector
from crosscheck.trial.input.arrays import NotNumbers, numbers_of, shown
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.input.symbolic import in_arm_symbols, in_numbers, plain_symbols

COMPLEX_STEP = 1e-30
SAMPLES = 3
AGREED = 1e-6  # of a Jacobian held against differences, relative to its row
CERTAIN = 1e-9  # of what differences give where nothing better is to be had


def curved_frame(coordinates: Coordinates, layout: Layout, arm: Arm) -> Frame:
    """The frame of a user's function. Raises InputError."""
    n, function = len(layout), coordinates.function
    count = frames.counted(coordinates, n, arm)
    if isinstance(function, sp.MatrixBase):
        frame = _sympy_frame(coordinates, function, layout, arm, count)
    elif callable(function):
        frame = _callable_frame(coordinates, layout, count)
    else:
        reason = f"is a {type(function).__name__}; must be a function of x or a sympy Matrix"
        raise InputError(WHERE, "function", None, reason)
    if frame.matrix is None:
        _require_derivative(frame)
    return frame


def _sympy_frame(
    coordinates: Coordinates, function: Any, layout: Layout, arm: Arm, count: str
) -> Frame:
    """The frame of a sympy Matrix, its derivatives by sympy.

    A function that turns out linear is a matrix, with the arm's symbols in it.
    """
    n = len(layout)
    if len(coordinates.symbols) != n or len(function) != n:
        reason = (
            f"has {len(function)} entries over {len(coordinates.symbols)} symbols;"
            f" must be {n} over {n}, for {count}"
        )
        raise InputError(WHERE, "function", None, reason)
    plain = plain_symbols(coordinates.symbols)
    x = [plain[symbol] for symbol in coordinates.symbols]
    q = in_arm_symbols(sp.Matrix(list(function)).xreplace(plain), x, {}, arm, f"{WHERE}: function")
    names = frames.names_of(coordinates, [symbol.name for symbol in x])
    jacobian = q.jacobian(x)
    if not jacobian.free_symbols & set(x) and not any(
        map(sp.simplify, q.subs(dict.fromkeys(x, 0)))
    ):
        matrix = np.array(in_numbers(jacobian, arm), dtype=np.float64)
        frames.require_invertible(matrix, "function")
        return frames.linear_frame(layout, names, matrix, jacobian)
    u = [sp.Dummy(f"u{k}") for k in range(n)]
    drift = (jacobian * sp.Matrix(u)).jacobian(x) * sp.Matrix(u)
    value, slopes, along = (
        sp.lambdify([x, u], in_numbers(entries, arm), "numpy", cse=True)
        for entries in (q, jacobian, drift)
    )
    return Frame(
        layout,
        names,
        "sympy",
        position=lambda x: _answer(value(x, x), (n,), "function", x),
        slopes=lambda x: _answer(slopes(x, x), (n, n), "function's jacobian", x),
        drift=lambda x, u: _answer(along(x, u), (n,), "function's second derivative", x),
    )


def _callable_frame(coordinates: Coordinates, layout: Layout, count: str) -> Frame:
    """The frame of a Python function, its Jacobian as given, by complex steps or differences."""
    n, own, given = len(layout), coordinates.function, coordinates.jacobian
    names = frames.names_of(coordinates, [f"x_{k + 1}" for k in range(n)])

    def function(x: np.ndarray) -> np.ndarray:
        return _answer(_called(own, "function", x), (n,), f"function, for {count}", x)

    by_differences = Frame(
        layout,
        names,
        "differences",
        position=function,
        slopes=lambda x: _by_differences(function, x),
        drift=lambda x, u: _curvature(function, x, u),
    )
    if given is None:
        return _complex_frame(by_differences, own) or by_differences
    if not callable(given):
        reason = f"is a {type(given).__name__}; must be a function of x"
        raise InputError(WHERE, "jacobian", None, reason)

    def slopes(x: np.ndarray) -> np.ndarray:
        return _answer(_called(given, "jacobian", x), (n, n), f"jacobian, for {count}", x)

    return replace(
        by_differences,
        found_by="given",
        slopes=slopes,
        drift=lambda x, u: _turning(lambda y, w: slopes(y) @ w, x, u),
    )


def _complex_frame(frame: Frame, own: Any) -> Frame | None:
    """The frame with a Jacobian by complex steps; None if the function does not take them."""

    def forward(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        answer = np.asarray(own(x + 1j * COMPLEX_STEP * u), dtype=np.complex128)
        return answer.reshape(len(x)).imag / COMPLEX_STEP

    def slopes(x: np.ndarray) -> np.ndarray:
        columns = [forward(x, unit) for unit in np.eye(len(x))]
        return _answer(np.stack(columns, axis=1), (len(x), len(x)), "function's jacobian", x)

    found = replace(
        frame, found_by="complex step", slopes=slopes, drift=lambda x, u: _turning(forward, x, u)
    )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # numpy's, for an imaginary part that is lost
            return found if all(_misfit(found, x) is None for x in _samples(frame)) else None
    except InputError:
        raise
    except BaseException:  # whatever a function that means floats does with complex ones
        if was_stopped():
            raise
        return None


def _by_differences(function: Vector, x: np.ndarray) -> np.ndarray:
    columns = [_certain(1, function, x, unit) for unit in np.eye(len(x))]
    return np.stack(columns, axis=1)


def _curvature(function: Vector, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """The second derivative (n,) of the function along u."""
    size = float(np.abs(u).max()) or 1.0
    return size**2 * _certain(2, function, x, u / size)


def _turning(forward: Along, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Derivative (n,) of J u along u, at fixed u; forward(x, u): J u."""
    size = float(np.abs(u).max()) or 1.0
    return size**2 * _certain(1, lambda y: forward(y, u / size), x, u / size, "second derivative")


def _certain(
    order: int, function: Vector, x: np.ndarray, unit: np.ndarray, what: str = ""
) -> np.ndarray:
    """A derivative (n,) of the function along a line. Raises InputError where it is not certain."""

    def curve(s: float) -> np.ndarray:
        try:
            with np.errstate(all="ignore"):
                return function(x + s * unit)
        except (ArithmeticError, ValueError):
            return np.full(len(x), math.nan)

    found, apart = derivative(curve, order)
    if not (apart < CERTAIN).all():
        what = what or ("derivative" if order == 1 else "second derivative")
        reason = f"its {what} is not to be found at x = {shown(x)}; give a sympy Matrix of it"
        raise InputError(WHERE, "function", None, reason)
    return found


def _called(own: Callable[[np.ndarray], Any], what: str, x: np.ndarray) -> Any:
    try:
        return own(x.copy())
    except BaseException as error:  # the user's own code
        if was_stopped():
            raise
        reason = f"raises {type(error).__name__}: {error}, at x = {shown(x)}"
        raise InputError(WHERE, what, None, reason) from error


def _answer(raw: Any, shape: tuple[int, ...], what: str, x: np.ndarray) -> np.ndarray:
    try:
        return numbers_of(raw, shape)
    except NotNumbers as error:
        raise InputError(WHERE, what, None, f"{error}, at x = {shown(x)}") from None


def _samples(frame: Frame) -> list[np.ndarray]:
    """A few states at which the function has values. Raises what it raises where it has none."""
    found: list[np.ndarray] = []
    states = np.random.default_rng(1).uniform(-1.0, 1.0, (frames.TRIES, len(frame.names)))
    for number, x in enumerate(states):
        try:
            with np.errstate(all="ignore"):
                frame.position(x)
            found.append(x)
        except (ArithmeticError, ValueError):
            if number + 1 == frames.TRIES and not found:
                raise
        if len(found) == SAMPLES:
            break
    return found


def _require_derivative(frame: Frame) -> None:
    """Raise InputError unless J is what differences say, and invertible somewhere."""
    states = _samples(frame)
    for x in states:
        misfit = _misfit(frame, x)
        if misfit is not None:
            raise InputError(WHERE, "jacobian", None, f"{misfit}, at x = {shown(x)}")
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
    given, expected = frame.slopes(x), _by_differences(frame.position, x)
    apart = np.abs(given - expected) / np.abs(expected).max(axis=1, keepdims=True).clip(1e-12)
    row, column = np.unravel_index(int(apart.argmax()), apart.shape)
    if apart[row, column] <= AGREED:
        return None
    return (
        f"[{row}, {column}], of {frame.layout.names[row]} by {frame.names[column]}, is"
        f" {given[row, column]:.8g}; differences of function give {expected[row, column]:.8g}"
    )
