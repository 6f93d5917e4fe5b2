"""A command run in its own process with its stack looked at every few milliseconds.

What a stack was found at takes the time since the last look. Compiled code that holds the
interpreter is seen as soon as it returns, so nothing is lost; and no call is made slower, as it
would be by a profiler that counts calls.
"""

from __future__ import annotations

import json
import os
import runpy
import sys
import threading
import time
from types import FrameType

LOOK_S = 0.002
IMPORTING = "<frozen importlib"
# Of the innermost frame that belongs to one; a stack within an import is importing, whatever runs.
KINDS = {
    "drawing": ("/matplotlib/", "/PIL/", "crosscheck/report/", "/figures/", "/jinja2/"),
    "compiling": ("/numba/", "/llvmlite/"),
    "derivation": (
        *("/sympy/", "/mpmath/", "analytic/lagrange", "analytic/terms", "analytic/chain"),
        *("analytic/bodies", "analytic/symbol", "analytic/forms", "analytic/fast/links"),
        *("analytic/fast/numbers", "analytic/rigid", "analytic/gears"),
    ),
    "integration": (
        *("analytic/kernel", "analytic/fast/", "analytic/ensemble", "analytic/recording"),
        *("analytic/reference", "/scipy/", "models/exudyn", "models/pinocchio"),
    ),
    "files": ("/h5netcdf/", "/h5py/", "/xarray/", "/pydantic/", "tomllib", "/json/"),
    "waiting for processes": ("/joblib/", "multiprocessing", "concurrent/"),
}


def kind_of(frame: FrameType | None) -> str:
    """Of a stack, from its innermost frame outwards."""
    found = "other"
    while frame is not None:
        file = frame.f_code.co_filename
        if IMPORTING in file:
            return "imports"
        if found == "other":
            kinds = (kind for kind, words in KINDS.items() if any(w in file for w in words))
            found = next(kinds, "other")
        frame = frame.f_back
    return found


def watch(thread: int, seconds: dict[str, float], ended: threading.Event) -> None:
    """Add to the seconds of each kind until the run has ended."""
    last = time.perf_counter()
    while not ended.wait(LOOK_S):
        kind, now = kind_of(sys._current_frames().get(thread)), time.perf_counter()
        seconds[kind] = seconds.get(kind, 0.0) + now - last
        last = now


def main() -> None:
    """`profiled.py OUT MODULE ARGUMENTS...`: runs a module, and writes the seconds of each kind."""
    out, module, *arguments = sys.argv[1:]
    sys.argv, sys.path[0] = [module, *arguments], os.getcwd()
    seconds, ended = dict[str, float](), threading.Event()
    looking = threading.Thread(target=watch, args=(threading.get_ident(), seconds, ended))
    began = time.perf_counter()
    looking.start()
    try:
        runpy.run_module(module, run_name="__main__", alter_sys=True)
    except SystemExit:
        pass  # every command ends so
    finally:
        ended.set()
        looking.join()
    seconds["whole"] = time.perf_counter() - began
    with open(out, "w") as file:
        json.dump(seconds, file)


if __name__ == "__main__":
    main()
