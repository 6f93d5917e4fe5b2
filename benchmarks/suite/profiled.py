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

LOOK_S, TELL_S = 0.002, 0.1
IMPORTING = "<frozen importlib"
WAITING = "waiting for processes"
# Of the innermost frame that belongs to one; a stack within an import is importing, whatever runs.
CATEGORIES = {
    "drawing": ("/matplotlib/", "/PIL/", "crosscheck/report/", "/figures/", "/jinja2/"),
    "integration": (
        *("analytic/kernel/batch", "analytic/kernel/adaptive_kernel", "analytic/ensemble"),
        *("/scipy/", "models/exudyn", "models/pinocchio"),
    ),
    "derivation": ("/sympy/", "/mpmath/", "analytic/derivation/"),
    "compiling": ("/numba/", "/llvmlite/", "analytic/kernel/"),
    "files": ("/h5netcdf/", "/h5py/", "/xarray/", "/pydantic/", "tomllib", "/json/"),
    WAITING: ("multiprocessing", "concurrent/"),
}


def classify_stack(frame: FrameType | None) -> str:
    """Of a stack, from its innermost frame outwards."""
    category = "other"
    while frame is not None:
        file = frame.f_code.co_filename
        if IMPORTING in file:
            return "imports"
        if category == "other":
            categories = (
                kind for kind, words in CATEGORIES.items() if any(w in file for w in words)
            )
            category = next(categories, "other")
        frame = frame.f_back
    return category


def record_stacks(thread: int, folder: str) -> None:
    """Keep what each kind took in a file of this process, as long as it lasts."""
    seconds, last, written_s = dict[str, float](), time.perf_counter(), 0.0
    while True:
        time.sleep(LOOK_S)
        frame, now = sys._current_frames().get(thread), time.perf_counter()
        if frame is not None and frame.f_code.co_filename != __file__:  # the command has ended
            kind = classify_stack(frame)
            seconds[kind] = seconds.get(kind, 0.0) + now - last
        last = now
        if now - written_s > TELL_S:  # a worker is stopped without a word
            written_s = now
            draft = f"{folder}/{os.getpid()}.draft"
            with open(draft, "w") as file:
                json.dump(seconds, file)
            os.replace(draft, f"{folder}/{os.getpid()}.json")


def start_watching(folder: str) -> None:
    """This process's main thread, from a thread that ends with it."""
    watched = threading.main_thread().ident
    threading.Thread(target=record_stacks, args=(watched, folder), daemon=True).start()


def main() -> None:
    """`profiled.py FOLDER MODULE ARGUMENTS...`: runs a module; a file for every process forked."""
    folder, module, *arguments = sys.argv[1:]
    sys.argv, sys.path[0] = [module, *arguments], os.getcwd()
    os.register_at_fork(after_in_child=lambda: start_watching(folder))
    start_watching(folder)
    try:
        runpy.run_module(module, run_name="__main__", alter_sys=True)
    finally:
        time.sleep(2 * TELL_S)


if __name__ == "__main__":
    main()
