"""What a user's function gave, as numbers: any array, matrix or column, and nothing else."""

from __future__ import annotations

from typing import Any

import numpy as np


class NotNumbers(ValueError):
    """What is wrong with an answer: what came, and what must come."""


def numbers_of(answer: Any, shape: tuple[int, ...]) -> np.ndarray:
    """The answer as finite float64 of this shape; vectors may come as a row or a column.

    Raises NotNumbers.
    """
    found = _array(answer)
    if found.dtype.kind not in "biufc":
        raise NotNumbers(f"is of type {found.dtype}, must be numbers")
    if found.dtype.kind == "c" and np.any(found.imag != 0):
        raise NotNumbers("is complex, must be real")
    found = found.real.astype(np.float64)
    if [n for n in found.shape if n != 1] == [n for n in shape if n != 1]:
        found = found.reshape(shape)
    if found.shape != shape:
        raise NotNumbers(f"has shape {found.shape}, must be {shape}")
    if not np.isfinite(found).all():
        what = "NaN" if np.isnan(found).any() else "an infinite number"
        place = tuple(int(k) for k in np.argwhere(~np.isfinite(found))[0])
        raise NotNumbers(f"has {what} at {list(place)}, must be finite")
    return found


def _array(answer: Any) -> np.ndarray:
    """An answer as an array of numbers; those that numpy does not know, sympy's, become complex."""
    if callable(getattr(answer, "full", None)):  # a casadi DM, sparse or not
        answer = answer.full()
    if answer is None or np.ma.is_masked(answer):
        raise NotNumbers(f"is {'None' if answer is None else 'masked'}, must be numbers")
    name = type(answer).__name__
    try:
        found = np.array(answer)
    except ValueError:
        raise NotNumbers("has rows of unequal length, must be an array of numbers") from None
    except TypeError:  # a casadi expression
        raise NotNumbers(f"is a {name}, must be numbers") from None
    if found.dtype != object:
        return found
    try:
        return np.array([complex(item) for item in found.flat]).reshape(found.shape)
    except OverflowError:
        raise NotNumbers(f"is a {name} that holds an integer too large for a float") from None
    except (TypeError, ValueError):
        kinds = ", ".join(sorted({type(item).__name__ for item in found.flat}))
        raise NotNumbers(f"is a {name} that holds {kinds or name}, must be numbers") from None


def shown(vector: np.ndarray) -> str:
    """A state's numbers as text for an error line."""
    return f"[{', '.join(f'{value:.6g}' for value in vector)}]"
