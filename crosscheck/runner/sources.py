"""The project's own files that a result is made by, for keys that change when the code does.

They are those of the modules that make a result and of all that these import, at any depth. What is
chosen by a name, such as a model, is imported by nobody: whoever asks for a result names it.
"""

from __future__ import annotations

import ast
import hashlib
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).parent.parent.parent
OWN = "crosscheck"
# They watch over processes in which code runs, and change no number.
NOT_FOLLOWED = ("crosscheck.cli", "crosscheck.entry", "crosscheck.runner")


@cache
def code_hash(*modules: str) -> str:
    """SHA-256 of all code of these modules and of what they import."""
    digest = hashlib.sha256()
    for path in files(*modules):
        digest.update(f"\n{path.name} ".encode())
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def files(*modules: str) -> list[Path]:
    """The files of these modules and of all that they import, sorted."""
    found = {path for path in map(_file, modules) if path is not None}
    waiting = [name for path in found for name in imported(path)]
    waiting += [module.rpartition(".")[0] for module in modules]  # their packages
    while waiting:
        module = waiting.pop()
        path = own_path(module)
        if path is not None and path not in found and not module.startswith(NOT_FOLLOWED):
            found.add(path)
            waiting += [module.rpartition(".")[0], *imported(path)]
    return sorted(found)


@cache
def imported(path: Path) -> frozenset[str]:
    """Names of all that a file imports, anywhere in it, or could name as a module."""
    return frozenset(_imported(ast.parse(path.read_text(encoding="utf-8")).body))


def _imported(nodes: Iterable[ast.AST]) -> Iterator[str]:
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif not (isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"):
            yield from _imported(ast.iter_child_nodes(node))


def _file(module: str) -> Path | None:
    """The file of any module where a walk begins, a guest's model, say; None where none is known.

    What a guest's file imports from elsewhere counts by the versions of its packages.
    """
    place = own_path(module)
    if place is not None:
        return place
    if module in sys.modules:
        file = getattr(sys.modules[module], "__file__", None)
    else:
        found = find_spec(module) if find_spec(module.partition(".")[0]) else None
        file = found.origin if found else None
    return Path(file) if file else None


@cache
def own_path(module: str) -> Path | None:
    """The file of a module of the project; None for any other."""
    if module.partition(".")[0] != OWN:
        return None
    place = ROOT.joinpath(*module.split("."))
    found = (place / "__init__.py", place.with_suffix(".py"))
    return next((path.resolve() for path in found if path.is_file()), None)
