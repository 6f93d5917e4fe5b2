"""Differences of values of SymPy: of numbers, expressions, matrices and vectors in frames."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

Element = tuple[Any, ...]  # of a value: nothing, a row and a column, or a frame's name and an axis
Difference = Mapping[tuple[int, Element], Any]  # by evaluation and element, those that are not 0


class NotVariable(Exception):
    """An error for a difference that nothing stands for in a derivation."""


def list_variables(expressions: Iterable[Any]) -> set[Any]:
    """Symbols, functions of time and their rates that expressions depend on."""
    import sympy as sp
    from sympy.core.function import AppliedUndef

    variables, waiting = set[Any](), list(expressions)
    while waiting:
        expression = waiting.pop()
        if isinstance(expression, sp.Derivative | AppliedUndef | sp.Symbol):
            variables.add(expression)
        else:
            waiting += getattr(expression, "args", ())
    return variables


def is_vector(value: Any) -> bool:
    from sympy.physics.vector import Vector

    return isinstance(value, Vector)


def list_elements(value: Any) -> dict[Element, Any]:
    """The elements of a number, an expression, a matrix or a vector of SymPy. Raises TypeError."""
    import sympy as sp
    from sympy.physics.vector import Vector

    if isinstance(value, Vector):
        return {
            (frame.name, axis): sp.sympify(matrix[axis])
            for matrix, frame in value.args
            for axis in range(len(matrix))
        }
    if isinstance(value, sp.MatrixBase):
        rows, columns = value.shape
        return {(i, j): value[i, j] for i in range(rows) for j in range(columns)}
    if isinstance(value, bool) or not isinstance(value, int | float | sp.Expr):
        raise TypeError
    return {(): sp.sympify(value)}


def are_equal(value: Any, other: Any) -> bool:
    try:
        return bool(value == other)
    except Exception:  # whatever an object of the code raises
        return False


def subtract(value: Any, other: Any) -> dict[Element, Any]:
    """The elements of a difference that are not 0.

    Raises TypeError for values of another kind, and NotVariable for a vector 0, which has no frame.
    """
    elements, others = list_elements(value), list_elements(other)
    if not {*map(len, elements)} <= {*map(len, others)}:
        raise TypeError if others else NotVariable
    differences = {
        each: elements.get(each, 0) - others.get(each, 0) for each in {**elements, **others}
    }
    return {each: difference for each, difference in differences.items() if difference != 0}


def add(value: Any, variations: Mapping[Element, Any]) -> Any:
    """A value with a variation of each element."""
    import sympy as sp
    from sympy.physics.vector import Vector

    if not variations:
        return value
    if isinstance(value, Vector):
        frames = {each.name: (each.x, each.y, each.z) for each in _list_frames(value)}
        return sum((v * frames[name][axis] for (name, axis), v in variations.items()), value)
    if isinstance(value, sp.MatrixBase):
        changed = value.as_mutable()
        for place, variation in variations.items():
            changed[place] += variation
        return type(value)(changed)
    return value + variations[()]


def _list_frames(vector: Any) -> Iterator[Any]:
    """The frames of a vector, and all that are turned against them."""
    waiting, listed = [frame for _, frame in vector.args], set[Any]()
    while waiting:
        frame = waiting.pop()
        if frame not in listed:
            listed.add(frame)
            yield frame
            waiting += frame._dcm_dict
