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
PACKAGE = "crosscheck"
# They watch over processes in which code runs, and change no number.
NOT_FOLLOWED = ("crosscheck.cli", "crosscheck.entry", "crosscheck.runner")
STATEMENTS = ast.stmt, ast.ExceptHandler, ast.match_case  # syntax nodes that may contain an import


@cache
def compute_code_hash(*modules: str) -> str:
    """SHA-256 of all code of these modules and of what they import."""
    digest = hashlib.sha256()
    for path in find_source_files(*modules):
        digest.update(f"\n{path.name} ".encode())
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def find_source_files(*modules: str) -> list[Path]:
    """The files of these modules and of all that they import, sorted."""
    paths = {path for path in map(_find_file, modules) if path is not None}
    waiting = [name for path in paths for name in find_imports(path)]
    while waiting:
        module = waiting.pop()
        path = find_project_file(module)
        if path is not None and path not in paths and not module.startswith(NOT_FOLLOWED):
            paths.add(path)
            waiting += [module.rpartition(".")[0], *find_imports(path)]
    return sorted(paths)


@cache
def find_imports(path: Path) -> frozenset[str]:
    """Names of all that a file imports, anywhere in it, or could name as a module."""
    return frozenset(_walk_imports(ast.parse(path.read_text(encoding="utf-8")).body))


def _walk_imports(nodes: Iterable[ast.AST]) -> Iterator[str]:
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif not (isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"):
            inner = (each for each in ast.iter_child_nodes(node) if isinstance(each, STATEMENTS))
            yield from _walk_imports(inner)


def _find_file(module: str) -> Path | None:
    """The file of any module where a walk begins, a plug-in's model, say; None where none is known.

    What a plug-in's file imports from elsewhere counts by the versions of its packages.
    """
    place = find_project_file(module)
    if place is not None:
        return place
    if module in sys.modules:
        file = getattr(sys.modules[module], "__file__", None)
    else:
        spec = find_spec(module)
        file = spec.origin if spec else None
    return Path(file) if file else None


@cache
def find_project_file(module: str) -> Path | None:
    """The file of a module of the project; None for any other."""
    if module.partition(".")[0] != PACKAGE:
        return None
    place = ROOT.joinpath(*module.split("."))
    candidates = (place / "__init__.py", place.with_suffix(".py"))
    return next((path.resolve() for path in candidates if path.is_file()), None)
