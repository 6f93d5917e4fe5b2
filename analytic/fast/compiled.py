"""A kernel's module, from a folder of the user's own where its machine code is kept."""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import logging
import os
import sys
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from types import ModuleType

from analytic.fast import hyperbolic, memory, sines
from analytic.fast.program import Program
from models import drive
from models.places import cache_folder, make_private, temporary_folder

FOLDER = "kernels"
LOG = logging.getLogger(__name__)
# numba compiles a function anew when its own file changes, not when one that it calls does.
TAKEN_IN = (memory, sines, hyperbolic, drive)


@lru_cache(maxsize=64)
def module_of(program: Program) -> ModuleType:
    """The program's module, imported; numba compiles it at the first call, or finds it compiled."""
    name = f"kernel_{_digest(program.text)[:16]}"
    path = _folder() / f"{name}.py"
    if not _holds(path, program.text):
        _write(path, program.text)
    if not any(path.parent.glob(f"__pycache__/{name}.*.nbi")):
        LOG.info("compiling a kernel for this structure of arm, once: some seconds")
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None  # it ends in .py
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def _digest(text: str) -> str:
    """Of a kernel: of its text, and of the sources whose code is compiled into it."""
    digest = hashlib.sha256(text.encode())
    for module in TAKEN_IN:
        digest.update(inspect.getsource(module).encode())
    return digest.hexdigest()


def _folder() -> Path:
    """Where kernels are kept between runs; else until the end of this one."""
    folder = cache_folder() / FOLDER
    try:
        make_private(cache_folder())
        make_private(folder)
    except OSError:
        folder = temporary_folder() / FOLDER
        folder.mkdir(exist_ok=True)
    return folder


def _holds(path: Path, text: str) -> bool:
    with suppress(OSError, UnicodeDecodeError):
        return path.read_text(encoding="utf-8") == text
    return False


def _write(path: Path, text: str) -> None:
    """At once: another process may be reading it."""
    draft = path.with_suffix(f".{os.getpid()}.draft")
    draft.write_text(text, encoding="utf-8")
    draft.replace(path)
