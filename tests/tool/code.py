"""Pieces of code that are kept: a function that numba compiles, and one of the kernel's text."""

from ctypes import c_double, c_void_p
from pathlib import Path

import numpy as np

from crosscheck.analytic.kernel.machine import Code, load_machine_code

SOURCE = """
from crosscheck.models.numba_cache import njit

@njit(cache=True)
def doubled(x):
    return 2.0 * x
"""


def doubled(folder: Path) -> tuple[float, bool]:
    """Of 3.0, by a function of a file there; and whether it was found compiled."""
    found: dict[str, object] = {"__name__": "doubling"}
    exec(compile(SOURCE, str(folder / "doubling.py"), "exec"), found)
    function = found["doubled"]
    value = function(3.0)  # type: ignore[operator]
    return value, bool(function.stats.cache_hits)  # type: ignore[attr-defined]


SUM = 'def add(out: array, a, b):\n    """a + b."""\n    out[0] = a + b\n'
OTHER = SUM.replace("a + b\n", "a - b\n")


def add(text: str = SUM) -> float:
    """What kept or new machine code makes of 2 and 3."""
    out = np.zeros(1)
    data = load_machine_code(text, 1, 1)
    Code(data, {"add": (c_void_p, c_double, c_double)})["add"](out.ctypes.data, 2.0, 3.0)
    return float(out[0])
