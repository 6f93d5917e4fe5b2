"""Which files a kept result hangs on, and which of the project's were called while it was made.

Run in a copy of the project, ``python traced_results.py ROOT``; prints JSON: for every result in
RESULTS the files of code that its key is made of, with the data whose edit changes it, and those
that were read or had a function that ran while it was made.
"""

import ast
import builtins
import ctypes
import gc
import importlib
import importlib.machinery
import importlib.util
import json
import os
import sys
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

ROOT = Path(sys.argv[1] if __name__ == "__main__" else __file__)
OWN = "crosscheck"
SHORT = {"scenario": "constant-torque", "duration_s": 2e-3, "record_every": 1}
PAPER = "crosscheck.audit"
# What cuts a measure or a question to milliseconds: constants of modules, (module, name) -> value.
CUTS: dict[tuple[str, str], Any] = {
    (f"{PAPER}.measures.events", "THIRD_S"): (0.0, 2e-3),
    (f"{PAPER}.statics.teeth", "HARMONICS"): 2,
}
called: set[str] = set()
builtins.called_files = called  # type: ignore[attr-defined]
Result = tuple[Callable[[], str], Callable[[], object]]


def run(**given: Any) -> Callable[[], Result]:
    """A simulation."""
    return lambda: question("experiments.courses.CoursesQuestion", (variant(**given),))()


def question(kind: str, *values: Any) -> Callable[[], Result]:
    """An answer."""

    def result() -> Result:
        asked = found(kind)(*values)
        studies = importlib.import_module("crosscheck.audit.experiments.study")
        return partial(studies.question_key, asked), asked.answer

    return result


def found(name: str) -> Any:
    module, _, attribute = name.rpartition(".")
    return getattr(importlib.import_module(f"{PAPER}.{module}"), attribute)


def variant(**given: Any) -> Any:
    """The shortest."""
    return importlib.import_module("crosscheck.audit.experiments.variant").Variant(**SHORT | given)


def cell() -> Any:
    """The paper's law at a small damping, planets free."""
    conditions = importlib.import_module(f"{PAPER}.experiments.paper_conditions")
    return conditions.Condition(conditions.PRINTED, 0.005)


def of_variant(kind: str, *values: Any, **given: Any) -> Callable[[], Result]:
    """An answer about the shortest variant."""
    return lambda: question(kind, variant(**given), *values)()


RESULTS: dict[str, Callable[[], Result]] = {
    "analytic run": run(),
    "rigid run": run(model="analytic:coupled"),
    "printed run": run(model="analytic:printed"),
    "exudyn run": run(model="exudyn:tree"),
    "pinocchio run": run(model="pinocchio:coupled"),
    "starts of exudyn": of_variant(
        *("experiments.ensembles.TransientPdQuestion", (1,)), model="exudyn:tree", planets="free"
    ),
    "bands of all starts": of_variant("experiments.bands.BandsQuestion", (1, 2), 20),
    "back and forth beside rigid arms": of_variant("experiments.ensembles.SwingQuestion", (1, 2)),
    "errata": question("errata.finder.ErrataQuestion", "paper-labelled", 1e-4),
    "statics": question("statics.statics.Statics", "paper-labelled"),
    "back and forth": question("findings.shaking.ShakingQuestion", "time", 0.05, (1,), 1e-3),
    "clock test": lambda: question("findings.clock.ClockTest", cell().law, 2e-3, (1,))(),
    "modes": of_variant("findings.stability.Linearisation", (1,), 5),
}


class Traced(importlib.machinery.SourceFileLoader):
    """Loads the project's files so that every function notes its file when it is called."""

    def get_code(self, fullname: str) -> Any:
        return noting(Path(self.get_filename(fullname)))


@cache
def noting(path: Path) -> Any:
    """The code of one of the project's files, with the note in every function."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    note = ast.parse(f"called_files.add({str(path.relative_to(ROOT))!r})").body
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            node.body[:0] = note
    return compile(ast.fix_missing_locations(tree), str(path), "exec")


def traced() -> dict[str, dict[str, list[str]]]:
    """Files called and files of the key, result by result, each in a process of its own."""
    for library in ("xarray", "sympy", "scipy.signal", "scipy.optimize", "numba", "pydantic",
                    "h5netcdf", "matplotlib.figure", "pinocchio", "exudyn", "rich.table",
                    "jinja2", "scipy.integrate", "scipy.ndimage"):  # fmt: skip
        importlib.import_module(library)
    if importlib.util.find_spec("dask"):  # xarray imports it where it is installed
        importlib.import_module("dask.array")
    numba = importlib.import_module("numba")
    # The only intrinsic there is takes an address.
    pointer = partial(ctypes.cast, typ=ctypes.POINTER(ctypes.c_double))
    numba.extending.intrinsic = lambda typed: pointer
    numba.njit, numba.vectorize = uncompiled, lambda **_: importlib.import_module("numpy").vectorize
    sys.path_hooks.insert(0, finder)
    sys.path_importer_cache.clear()
    for path in (ROOT / OWN).rglob("*.py"):  # compiled once for all children
        noting(path)
    for result in RESULTS.values():  # nor is what describes them imported in each
        result()
    return {name: in_child(partial(looked_at, result)) for name, result in RESULTS.items()}


def finder(folder: str) -> Any:
    """For the project's folders alone."""
    if ROOT not in (Path(folder), *Path(folder).parents):
        raise ImportError
    suffixes = importlib.machinery.SOURCE_SUFFIXES
    return importlib.machinery.FileFinder(folder, (Traced, suffixes))


def uncompiled(*given: Any, **_: Any) -> Any:
    """In place of numba's decorator: a call of a function is seen."""

    def left(function: Any) -> Any:
        function.compile = lambda signature: function
        return function

    return left(given[0]) if given and callable(given[0]) else left


def looked_at(result: Callable[[], Result]) -> dict[str, list[str]]:
    key, make = result()
    for (module, name), value in CUTS.items():
        if module in sys.modules:
            assert hasattr(sys.modules[module], name)
            setattr(sys.modules[module], name, value)
    studies = importlib.import_module("crosscheck.audit.experiments.study")
    sources = importlib.import_module("crosscheck.runner.sources")
    modules: list[str] = []
    studies.compute_code_hash = lambda *names: modules.extend(names) or "code"  # type: ignore[func-returns-value]
    sys.addaudithook(note_data)
    before = key()
    code = [str(path.relative_to(ROOT)) for path in sources.find_source_files(*modules)]
    called.difference_update([file for file in called if file.endswith(".py")])  # by the key alone
    make()
    ran = sorted(called)
    data = [file for file in ran if file.endswith(".toml") and edited_key(file, key) != before]
    return {"called": ran, "counts": code + data}


def edited_key(file: str, key: Callable[[], str]) -> str:
    """The key while a file of data has another title."""
    text = (ROOT / file).read_text(encoding="utf-8")
    edited = text.replace('title = "', 'title = "edited ', 1)
    assert edited != text
    (ROOT / file).write_text(edited, encoding="utf-8")
    other = key()
    (ROOT / file).write_text(text, encoding="utf-8")
    return other


def note_data(event: str, arguments: tuple[Any, ...]) -> None:
    if event == "open" and str(arguments[0]).endswith(".toml"):
        called.add(str(Path(arguments[0]).relative_to(ROOT)))


def in_child(work: Callable[[], Any]) -> Any:
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        with os.fdopen(writing, "w") as stream:
            json.dump(work(), stream)
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as stream:
        text = stream.read()
    os.waitpid(child, 0)
    return json.loads(text)


if __name__ == "__main__":
    gc.disable()  # which each of the children would else do for all that it shares
    json.dump(traced(), sys.stdout)
