"""Functions of the user's that measure a run: where their code is, and calling them.

Their files go with the study as text, so that a worker on another machine needs none of them.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import sys
from collections.abc import Callable
from functools import lru_cache, partial
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import xarray as xr

from crosscheck.models.errors import InputError, describe_error
from crosscheck.models.files import LARGEST_FILE
from crosscheck.models.inputs import read_content
from crosscheck.runner.interruption import was_stopped
from crosscheck.runner.supervision import track_foreign_code
from crosscheck.studies.definition.quantities import Function

MeasureFunction = Callable[[xr.Dataset], dict[str, float]]


def read_source(function: str, folder: Path) -> str:
    """The text of the file that a function is in; folder: of the study. Raises InputError."""
    where, colon, name = function.rpartition(":")
    if not colon or not name.isidentifier() or not where:
        raise InputError("function", "", function, "must be module:function or file.py:function")
    try:
        if where.endswith(".py"):
            path = folder / where
        else:
            with track_foreign_code(where):  # a package that it is in is imported
                spec = importlib.util.find_spec(where)
            if spec is None or not spec.origin or not spec.origin.endswith(".py"):
                raise ImportError(f"no module {where} with a source file")
            path = Path(spec.origin)
        return read_content(path, LARGEST_FILE).decode("utf-8")
    except (OSError, ValueError, ImportError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError("function", "", function, f"cannot be read: {reason}") from None


@lru_cache(maxsize=64)
def load_function(function: str, source: str) -> MeasureFunction:
    """The user's function; the file that it is in is run. Raises InputError."""
    where, _, name = function.rpartition(":")
    load = partial(_run_source, where, source)
    if not where.endswith(".py"):
        load = partial(importlib.import_module, where)
    module, raised = _call_user_code(load)
    if raised:
        raise InputError("function", "", function, f"cannot be loaded: {raised}")
    attribute = getattr(module, name, None)
    if not callable(attribute):
        raise InputError("function", "", function, f"{where} has no function {name}")
    return attribute


def _call_user_code(call: Callable[[], Any]) -> tuple[Any, str]:
    """The result of the user's code, and the error that it raised, if any, in words.

    The exception itself does not go on: elsewhere nobody may know its class.
    """
    try:
        return call(), ""
    except BaseException as error:
        if was_stopped():
            raise
        return None, describe_error(error)


def _run_source(file: str, source: str) -> ModuleType:
    name = f"crosscheck_measures_{hashlib.sha256(source.encode()).hexdigest()[:16]}"
    module = ModuleType(name)
    module.__file__ = file
    sys.modules[name] = module  # which records defined in it look for
    exec(compile(source, file, "exec"), module.__dict__)
    return module


def call_function(quantity: Function, source: str, run: xr.Dataset) -> dict[str, float]:
    """The function's result for a run, nan for None. Raises InputError for anything else."""
    function = load_function(quantity.function, source)
    answer, raised = _call_user_code(partial(function, run))
    if raised:
        raise InputError("function", "", quantity.function, f"raised {raised}")
    try:
        given = [answer[name] for name in quantity.returns]
        sound = len(answer) == len(given)
    except Exception:  # whatever it returned may raise whatever it likes
        sound = False
    if not sound:
        allowed = f"must return numbers by the names {', '.join(quantity.returns)}"
        raise InputError("function", "", quantity.function, allowed)
    try:
        numbers = [np.nan if n is None else float(n) for n in given]
    except Exception:
        allowed = "must return plain numbers a double can hold, or None"
        raise InputError("function", "", quantity.function, allowed) from None
    return dict(zip(quantity.returns, numbers, strict=True))
