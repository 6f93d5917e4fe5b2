"""Values of SymPy's expressions without code that is written for them.

Idea: `lambdify` writes a function, which takes a hundred times as long as to call it; edited
equations are asked at a few states, and most of their parts not at all. So an expression is walked
where its value is wanted. Difficulty: SymPy knows hundreds of functions. Remedy: what equations of
motion are made of is walked; for all else, and for what is asked often, SymPy writes its function.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from crosscheck.trial.input.calls import MEANT

MATRIX_DIMENSIONS = 2
FUNCTIONS: dict[str, Any] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "exp": np.exp, "log": np.log, "tanh": np.tanh,
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2,
    "sign": np.sign, "Abs": np.abs,
}  # fmt: skip
MOST_WALKS = 50  # calls of one function that take less time than to write it


class Unwalkable(Exception):
    """An error for an expression that is made of more than is walked."""


class LambdifiedExpression:
    """What ``lambdify`` returns: the value of an expression as a function of its arguments.

    Args:
        write: What lets SymPy write the function.
        arguments: Symbols, functions of time, or lists or matrices of these.
        expression: An expression, a matrix, or a list of these.
        values: Those of symbols that are no arguments.
    """

    def __init__(
        self,
        write: Callable[[], Callable[..., Any]],
        arguments: Sequence[Any],
        expression: Any,
        values: Mapping[Any, float],
    ) -> None:
        self.write, self.arguments, self.expression = write, arguments, expression
        self.values = values
        self.walks = 0
        self.written: Callable[..., Any] | None = None
        self.__signature__ = inspect.Signature(_list_parameters(arguments))

    def __call__(self, *values: Any, **named: Any) -> Any:
        """The value for numbers, or arrays of them. Raises what SymPy's function raises."""
        self.walks += 1
        if self.written is None and self.walks <= MOST_WALKS and not named:
            try:
                every = {**self.values, **dict(_list_pairs(self.arguments, values))}
                return evaluate(self.expression, every)
            except (Unwalkable, TypeError, ValueError):  # SymPy's function may know better
                pass
        self.written = self.written or self.write()
        return self.written(*values, **named)


def _list_parameters(arguments: Sequence[Any]) -> list[inspect.Parameter]:
    """The parameters as those of SymPy's function: with names where all of these mean something."""
    names = list(map(str, arguments))
    if set(names) <= set(MEANT):
        return [inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD) for name in names]
    numbered = (f"_{number}" for number in range(len(names)))
    return [inspect.Parameter(name, inspect.Parameter.POSITIONAL_ONLY) for name in numbered]


def _list_pairs(arguments: Sequence[Any], values: Iterable[Any]) -> Iterator[tuple[Any, Any]]:
    """The symbols among arguments, each with its value. Raises ValueError for another number."""
    for argument, value in zip(arguments, values, strict=True):
        if isinstance(argument, list | tuple):
            yield from _list_pairs(argument, value)
        elif hasattr(argument, "tolist"):  # a matrix of symbols
            yield from _list_pairs(list(argument), np.ravel(value))
        else:
            yield argument, value


def evaluate(expression: Any, values: dict[Any, Any]) -> Any:
    """The value of an expression for those of its symbols, with which it keeps those of its parts.

    A number, an array of them, or a list as the expression is one. Raises Unwalkable.
    """
    if isinstance(expression, list | tuple):
        return type(expression)(evaluate(each, values) for each in expression)
    if (
        hasattr(expression, "tolist") and len(getattr(expression, "shape", ())) == MATRIX_DIMENSIONS
    ):  # a matrix
        return np.array([[evaluate(each, values) for each in row] for row in expression.tolist()])
    if getattr(expression, "is_Number", False):  # to look it up would take longer
        return float(expression)
    if expression not in values:
        values[expression] = _evaluate_formula(expression, values)
    return values[expression]


def _evaluate_formula(expression: Any, values: dict[Any, Any]) -> Any:
    if getattr(expression, "is_NumberSymbol", False):
        return float(expression)
    arguments = getattr(expression, "args", ())
    if not arguments:
        raise Unwalkable
    if expression.is_Pow and arguments[1].is_Integer:
        return evaluate(arguments[0], values) ** int(arguments[1])
    numbers = [evaluate(each, values) for each in arguments]
    if expression.is_Add:
        return sum(numbers)
    if expression.is_Mul:
        return math.prod(numbers)
    if expression.is_Pow:
        return np.power(*numbers)
    function = FUNCTIONS.get(type(expression).__name__)
    if function is None:
        raise Unwalkable
    return function(*numbers)
