"""Conversion of a user's answer to numbers: arrays, matrices and columns, nothing else."""

from __future__ import annotations

from typing import Any

import numpy as np

from crosscheck.models.errors import describe_type


class NotNumbers(ValueError):
    """An unfit answer, with words on its form and on the form that is expected."""


def convert_to_numbers(answer: Any, shape: tuple[int, ...]) -> np.ndarray:
    """The answer as finite float64 of this shape; vectors may come as a row or a column.

    Raises NotNumbers.
    """
    if type(answer) is np.ndarray and answer.dtype == np.float64:  # as nearly always
        array = answer.copy()
    else:
        array = _real(_array(answer))
    if array.shape != shape and [n for n in array.shape if n != 1] == [n for n in shape if n != 1]:
        array = array.reshape(shape)
    if array.shape != shape:
        raise NotNumbers(f"has shape {array.shape}, must be {shape}")
    if not np.isfinite(array).all():
        what = "NaN" if np.isnan(array).any() else "an infinite number"
        place = tuple(int(k) for k in np.argwhere(~np.isfinite(array))[0])
        raise NotNumbers(f"has {what} at {list(place)}, must be finite")
    return array


def _real(array: np.ndarray) -> np.ndarray:
    """An array as float64. Raises NotNumbers."""
    if array.dtype.kind not in "biufc":
        raise NotNumbers(f"is of type {array.dtype}, must be numbers")
    if array.dtype.kind == "c" and np.any(array.imag != 0):
        raise NotNumbers("is complex, must be real")
    return array.real.astype(np.float64)


def _array(answer: Any) -> np.ndarray:
    """Convert an answer to an array; other libraries' numbers, as SymPy's, become complex."""
    if callable(getattr(answer, "full", None)):  # a casadi DM, sparse or not
        answer = answer.full()
    if answer is None or np.ma.is_masked(answer):
        raise NotNumbers(f"is {'None' if answer is None else 'masked'}, must be numbers")
    name = describe_type(answer)
    try:
        array = np.array(answer)
    except ValueError:
        raise NotNumbers("has rows of unequal length, must be an array of numbers") from None
    except TypeError:  # a casadi expression
        raise NotNumbers(f"is {name}, must be numbers") from None
    if array.dtype != object:
        return array
    try:
        return np.array([complex(item) for item in array.flat]).reshape(array.shape)
    except OverflowError:
        raise NotNumbers(f"is {name} that holds an integer too large for a float") from None
    except (TypeError, ValueError):
        type_names = ", ".join(sorted({type(item).__name__ for item in array.flat}))
        raise NotNumbers(f"is {name} that holds {type_names or name}, must be numbers") from None


def is_single_precision(numbers: np.ndarray) -> bool:
    """Whether numbers have no digit beyond single precision, and some have all of its digits."""
    with np.errstate(over="ignore"):
        single, half = (numbers.astype(kind) == numbers for kind in (np.float32, np.float16))
    return bool(single.all() and not half.all())


def format_vector(vector: np.ndarray) -> str:
    """A state's numbers as text for an error line."""
    return f"[{', '.join(f'{value:.6g}' for value in vector)}]"
