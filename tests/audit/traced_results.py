"""Which files a kept result hangs on, and which of the project's were called while it was made.

``python traced_results.py`` prints JSON: for every result the files of code
that its key is made of, with the data that it names, and those that were read or had a function
that ran while it was made.
"""

import cProfile
import ctypes
import gc
import importlib
import importlib.util
import inspect
import json
import multiprocessing
import sys
from functools import partial
from pathlib import Path
from types import CodeType
from typing import Any

ROOT = Path(__file__).parents[2]
OWN = [ROOT / name for name in ("crosscheck", "models", "analytic", "audit")]
# What cuts a measure or a question to milliseconds: constants of modules, (module, name) -> value.
CUTS: dict[tuple[str, str], Any] = {
    ("crosscheck.audit.measures.events", "THIRD_S"): (0.0, 2e-3),
    ("crosscheck.audit.statics.teeth", "HARMONICS"): 2,
    ("crosscheck.audit.statics.statics", "BASE_MASSES"): ("5",),
}
read: set[Path] = set()


def build_questions() -> dict[str, Any]:
    """Questions about the shortest runs; their modules are imported after numba is replaced."""
    from crosscheck.audit.errata.finder import ErrataQuestion
    from crosscheck.audit.experiments.ensembles import CoursesQuestion, EnsembleNumbersQuestion
    from crosscheck.audit.experiments.variant import Variant
    from crosscheck.audit.findings.clock import ClockTest
    from crosscheck.audit.statics.statics import Statics

    vary = partial(Variant, "constant-torque", duration_s=2e-3, record_every=1)
    exudyn = vary(model="exudyn:tree", planets="free")
    return {
        "analytic run": CoursesQuestion((vary(),)),
        "rigid run": CoursesQuestion((vary(model="analytic:coupled"),)),
        "printed run": CoursesQuestion((vary(model="analytic:printed"),)),
        "exudyn run": CoursesQuestion((vary(model="exudyn:tree"),)),
        "pinocchio run": CoursesQuestion((vary(model="pinocchio:coupled"),)),
        "starts of exudyn": EnsembleNumbersQuestion(exudyn, (1,)),
        "back and forth beside rigid arms": EnsembleNumbersQuestion(vary(), (1, 2), "swing"),
        "errata": ErrataQuestion("paper-labelled", 1e-4),
        "statics": Statics("paper-labelled"),
        "clock test": ClockTest(vary(), (1,)),
    }


def traced() -> dict[str, dict[str, list[str]]]:
    """Files called and files of the key, result by result, each in a process of its own."""
    for library in ("xarray", "sympy", "scipy.signal", "scipy.optimize", "numba", "pydantic",
                    "h5netcdf", "matplotlib.figure", "pinocchio", "exudyn", "rich.table",
                    "jinja2", "scipy.integrate", "scipy.ndimage"):  # fmt: skip
        importlib.import_module(library)
    numba = importlib.import_module("numba")
    # The only intrinsic there is takes an address.
    pointer = partial(ctypes.cast, typ=ctypes.POINTER(ctypes.c_double))
    numba.extending.intrinsic = lambda typed: pointer
    numba.njit, numba.vectorize = uncompiled, lambda **_: importlib.import_module("numpy").vectorize
    questions = build_questions()
    sources = importlib.import_module("crosscheck.runner.sources")
    for asked in questions.values():  # files are read for their imports once, not by every child
        sources.find_source_files(type(asked).__module__)
    with multiprocessing.get_context("fork").Pool(1, maxtasksperchild=1) as children:
        return dict(
            zip(questions, children.map(looked_at, questions.values(), chunksize=1), strict=True)
        )


def uncompiled(*given: Any, **_: Any) -> Any:
    """In place of numba's decorator: a call of a function is seen."""

    def left(function: Any) -> Any:
        function.compile = lambda signature: function
        return function

    return left(given[0]) if given and callable(given[0]) else left


def looked_at(asked: Any) -> dict[str, list[str]]:
    for (module, name), value in CUTS.items():
        if module in sys.modules:
            assert hasattr(sys.modules[module], name)
            setattr(sys.modules[module], name, value)
    studies = importlib.import_module("crosscheck.audit.experiments.study")
    sources = importlib.import_module("crosscheck.runner.sources")
    modules: list[str] = []
    studies.compute_code_hash = lambda *names: modules.extend(names) or "code"  # type: ignore[func-returns-value]
    sys.addaudithook(note_data)
    studies.question_key(asked)
    profile = cProfile.Profile(subcalls=False, builtins=False)
    profile.runcall(asked.answer)
    called = [entry.code for entry in profile.getstats() if isinstance(entry.code, CodeType)]
    functions = {
        Path(code.co_filename)
        for code in called
        if code.co_flags & inspect.CO_OPTIMIZED and not code.co_name.startswith("<")
    }  # no class's body
    every = {path.resolve() for path in functions | read}
    ran = {path for path in every if any(path.is_relative_to(folder) for folder in OWN)}
    data = {path for path in ran if path.suffix == ".toml" and f'"{path.stem}"' in asked.inputs}
    counts = {*sources.find_source_files(*modules), *data}
    return {
        name: sorted(path.relative_to(ROOT).as_posix() for path in paths)
        for name, paths in (("called", ran), ("counts", counts))
    }


def note_data(event: str, arguments: tuple[Any, ...]) -> None:
    if event == "open" and str(arguments[0]).endswith(".toml"):
        read.add(Path(arguments[0]))


if __name__ == "__main__":
    gc.disable()  # which each of the children would else do for all that it shares
    json.dump(traced(), sys.stdout)
