"""Functions of the user's that measure a run: where their code is, and calling them.

Their files go with the study as text, so that a worker on another machine needs none of them.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import xarray as xr

from crosscheck.sweeps.quantities import Function
from models.errors import InputError

Measuring = Callable[[xr.Dataset], dict[str, float]]


def source_of(function: str, folder: Path) -> str:
    """The text of the file that a function is in; folder: of the study. Raises InputError."""
    where, colon, name = function.rpartition(":")
    if not colon or not name.isidentifier() or not where:
        raise InputError("function", "", function, "must be module:function or file.py:function")
    try:
        path = folder / where if where.endswith(".py") else _origin(where)
        return path.read_text(encoding="utf-8")
    except (OSError, ValueError, ImportError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError("function", "", function, f"cannot be read: {reason}") from None


def _origin(module: str) -> Path:
    found = importlib.util.find_spec(module)
    if found is None or not found.origin or not found.origin.endswith(".py"):
        raise ImportError(f"no module {module} with a source file")
    return Path(found.origin)


@lru_cache(maxsize=64)
def function_of(function: str, source: str) -> Measuring:
    """The function itself; its file is run. Raises InputError."""
    where, _, name = function.rpartition(":")
    try:
        module = _run(where, source) if where.endswith(".py") else importlib.import_module(where)
    except Exception as error:
        reason = f"{type(error).__name__}: {error}"
        raise InputError("function", "", function, f"cannot be loaded: {reason}") from None
    found = getattr(module, name, None)
    if not callable(found):
        raise InputError("function", "", function, f"{where} has no function {name}")
    return found


def _run(file: str, source: str) -> ModuleType:
    name = f"crosscheck_measures_{hashlib.sha256(source.encode()).hexdigest()[:16]}"
    module = ModuleType(name)
    module.__file__ = file
    sys.modules[name] = module  # which records defined in it look for
    exec(compile(source, file, "exec"), module.__dict__)
    return module


def returned(quantity: Function, source: str, run: xr.Dataset) -> dict[str, float]:
    """What the function says of a run, nan for None. Raises InputError for anything else."""
    function = function_of(quantity.function, source)
    try:
        answer: Any = function(run)
    except Exception as error:
        reason = f"{type(error).__name__}: {error}"
        raise InputError("function", "", quantity.function, f"raised {reason}") from None
    if not isinstance(answer, dict) or set(answer) != set(quantity.returns):
        allowed = f"must return numbers by the names {', '.join(quantity.returns)}"
        raise InputError("function", "", quantity.function, allowed)
    try:
        return {name: np.nan if n is None else float(n) for name, n in answer.items()}
    except (TypeError, ValueError):
        allowed = "must return plain numbers, or None"
        raise InputError("function", "", quantity.function, allowed) from None
