"""Statements of a file that define names, with all that they use of it."""

from __future__ import annotations

import ast
import dis
import os
import pickle
import sys
import traceback
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from types import CodeType, ModuleType
from typing import Any

import numpy as np

LIBRARIES = ("numpy", "math")  # modules whose functions make data
MUTABLE = (np.ndarray, list, dict, set)  # data that a call may change in place
Names = Mapping[str, Any]


def list_made_names(tree: ast.Module) -> set[str]:
    """Names to which statements of a file give values, imports excepted."""
    made = (each for each in tree.body if not isinstance(each, ast.Import | ast.ImportFrom))
    return {name for each in made for name in _list_names(_compile(each), "STORE")}


def select_statements(
    file: str, body: Sequence[ast.stmt], names: Names, wanted: set[str], local: Sequence[ast.stmt]
) -> list[ast.stmt]:
    """The statements of a file that define anything that these names may use.

    What has not run yet is left out, and calls that are of no use: they might begin a trial again.

    Args:
        file: Its path, or a notebook's name of a cell.
        body: All its statements.
        names: The values that names have.
        wanted: The names.
        local: Functions inside others that use them too.
    """
    last = min(_list_running_lines(file), default=sys.maxsize)
    changed = {
        each: {*_list_names(_compile(each), "STORE"), *_list_mutated(each, names)}
        for each in body
        if (each.end_lineno or 0) < last
    }
    stored = [name for each in changed.values() for name in each]
    once = {name for name in stored if stored.count(name) == 1}
    current = [each for each, own in changed.items() if not own <= once or _is_current(each, names)]
    wanted |= {name for each in local for name in _list_names(_compile(each), "LOAD")}
    selected = {each for each in current if _is_harmless(each, names)}
    wanted |= {name for each in selected for name in _list_names(_compile(each), "LOAD")}
    while new := [each for each in current if each not in selected and changed[each] & wanted]:
        selected |= {*new}
        wanted |= {name for each in new for name in _list_names(_compile(each), "LOAD")}
    # Imports of __future__ say how all others are compiled.
    return [
        each for each in body if each in selected or getattr(each, "module", "") == "__future__"
    ]


def _compile(statement: ast.stmt) -> CodeType:
    code: CodeType = compile(ast.Module([statement], []), "", "exec", dont_inherit=True)
    return code


def _list_names(code: CodeType, verb: str) -> Iterator[str]:
    """Names of a file that code loads or stores."""
    for each in dis.get_instructions(code):
        if each.opname in (f"{verb}_NAME", f"{verb}_GLOBAL"):
            yield each.argval
    for inner in code.co_consts if verb == "LOAD" else ():
        if isinstance(inner, CodeType):
            yield from _list_names(inner, verb)


def _list_mutated(statement: ast.stmt, names: Names) -> Iterator[str]:
    """Names whose values a statement changes in place, as far as can be seen."""
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        return
    for node in ast.walk(statement):
        if isinstance(node, ast.Subscript | ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield _find_root(node)
        if isinstance(node, ast.Expr | ast.Assign) and isinstance(node.value, ast.Call):
            root = _find_root(node.value.func)
            if root != ast.unparse(node.value.func) and not isinstance(names.get(root), ModuleType):
                yield root
            given = [each.id for each in node.value.args if isinstance(each, ast.Name)]
            is_alone = isinstance(node, ast.Expr)  # whose result nobody takes
            yield from (each for each in given if is_alone and isinstance(names.get(each), MUTABLE))
        if isinstance(node, ast.For):  # elements that it changes are those of what it goes through
            elements = {each.id for each in ast.walk(node.target) if isinstance(each, ast.Name)}
            if elements & {name for each in node.body for name in _list_mutated(each, names)}:
                yield from (each.id for each in ast.walk(node.iter) if isinstance(each, ast.Name))


def _find_root(node: ast.AST) -> str:
    """The name of which an expression takes parts; '' of others."""
    while isinstance(node, ast.Subscript | ast.Attribute):
        node = node.value
    return node.id if isinstance(node, ast.Name) else ""


def _list_running_lines(file: str) -> Iterator[int]:
    """Lines at which a file is being run, as the script that began the trial is."""
    for frame, line in traceback.walk_stack(None):
        is_module = frame.f_code.co_name == "<module>"
        if is_module and os.path.abspath(frame.f_code.co_filename) == os.path.abspath(file):
            yield line


def _is_harmless(statement: ast.stmt, names: Names) -> bool:
    """Whether it is a definition, or gives data that functions of libraries of numbers make."""
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        return True
    calls = (node.func for node in ast.walk(statement) if isinstance(node, ast.Call))
    owners = (ast.unparse(function).partition(".")[0] for function in calls)
    is_of_library = (getattr(names.get(owner), "__name__", "") in LIBRARIES for owner in owners)
    return isinstance(statement, ast.Assign) and all(is_of_library)


def _is_current(statement: ast.stmt, names: Names) -> bool:
    """Whether names still have the data that an assignment gives them; True of all else."""
    if not isinstance(statement, ast.Assign) or not _is_harmless(statement, names):
        return True
    if ".random." in ast.unparse(statement):
        return False
    again = dict(names)
    try:
        exec(compile(ast.Module([statement], []), "", "exec"), again)
        targets = [*_list_names(_compile(statement), "STORE")]
        return all(_are_equal(again[name], names[name]) for name in targets)
    except Exception:  # it takes what is there no more, or makes what cannot be compared
        return True


def _are_equal(made: Any, value: Any) -> bool:
    """Whether two data are equal, also symbols, which remember what they were asked."""
    if pickle.dumps(made) == pickle.dumps(value):
        return True
    with suppress(ValueError):  # of arrays
        return bool(made == value)
    return False
