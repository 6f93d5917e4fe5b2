"""The project's own code that a module runs, for keys that change when the code does."""

from __future__ import annotations

import ast
import hashlib
import importlib.util
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

OWN = ("models", "analytic", "crosscheck")


@lru_cache
def code_hash(*modules: str) -> str:
    """Of the modules and all of the project's modules that they import, directly or not."""
    digest = hashlib.sha256()
    for path in sorted(set(_closure(modules))):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _closure(modules: tuple[str, ...]) -> Iterator[Path]:
    waiting, seen = list(modules), set()
    while waiting:
        name = waiting.pop()
        if name in seen or name.split(".")[0] not in OWN:
            continue
        seen.add(name)
        path = _file(name)
        if path is not None:
            yield path
            waiting += _imports(path)


@lru_cache
def _file(name: str) -> Path | None:
    try:
        spec = importlib.util.find_spec(name)
    except ModuleNotFoundError:  # a name inside a module, not a module
        return None
    return Path(spec.origin) if spec is not None and spec.origin is not None else None


@lru_cache
def _imports(path: Path) -> tuple[str, ...]:
    """Every name that an import statement of the file could mean as a module."""
    names = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            names += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return tuple(names)
