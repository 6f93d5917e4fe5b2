"""Functions of libraries that edits call often, without what takes long and changes no value."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

SIMPLIFYING = (
    "simplify", "trigsimp", "exptrigsimp", "powsimp", "powdenest", "radsimp", "ratsimp", "combsimp",
    "gammasimp", "signsimp", "logcombine", "fu",
)  # fmt: skip
# Where a user's code, and the methods of expressions and matrices, look these functions up.
MODULES = ("sympy", "sympy.simplify", "sympy.simplify.simplify", "sympy.simplify.trigsimp")
VECTOR = (3,)  # shape
_cross_arrays = np.cross


def quicken_libraries() -> None:
    """Quicken NumPy's cross products, and skip SymPy's simplifications if it is loaded, for good.

    Simplifying takes seconds; np.cross takes as long as ten products of vectors.
    """
    vars(np)["cross"] = cross_vectors
    for module in filter(None, map(sys.modules.get, MODULES)):
        for name in SIMPLIFYING:
            if callable(getattr(module, name, None)):
                setattr(module, name, _return_expression)


def _return_expression(expression: Any, *options: object, **more: object) -> Any:
    return expression


def cross_vectors(a: Any, b: Any, *options: Any, **more: Any) -> Any:
    """The bits of np.cross, of two vectors in a tenth of its time."""
    left, right = np.asarray(a), np.asarray(b)
    is_plain = left.shape == right.shape == VECTOR and left.dtype == right.dtype == float
    if options or more or not is_plain:
        return _cross_arrays(a, b, *options, **more)
    (x, y, z), (u, v, w) = left.tolist(), right.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])
