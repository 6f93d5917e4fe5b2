"""Arrays by their address: a view of a part of an array costs a count of references for each."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


def _generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return builder.inttoptr(arguments[0], ir.DoubleType().as_pointer())


def _typed(context: Any, address: Any) -> Any:
    return types.CPointer(types.float64)(types.intp), _generate


# To the floating-point numbers at an address, for ``numba.carray``.
pointer: Any = intrinsic(_typed)
