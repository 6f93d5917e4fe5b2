"""The source of a user's equations: its text, and how equations are taken from it anew."""

from __future__ import annotations
import __future__

import ast
import functools
import linecache
import pickle
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

from crosscheck.trial.input.calls import TAKES, select_parts
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.input.source_lines import PACKAGE

LIBRARIES = ("numpy", "math")  # modules whose functions make data
CELL = "this cell"  # of a notebook, whose code stands in no file
MODULE = "_crosscheck_edited"  # name of modules that are made of edited source
Names = Mapping[str, Any]


@dataclass(frozen=True)
class UserCode:
    """The source of equations.

    file: path of the file, or a notebook's name of a cell; statements: those that define the
    equations, with all that they use in this file; names: what else they find defined; select:
    takes, out of what they define, the object that the equations are made of.
    """

    file: str
    text: str
    statements: Sequence[ast.stmt]
    names: Names
    select: Callable[[Names], Any]

    @property
    def name(self) -> str:
        """What sentences call the file."""
        path = Path(self.file)
        return CELL if path.is_absolute() and not path.exists() else path.name

    @property
    def place(self) -> str:
        """The file, with the first and last line of the statements."""
        first = min(each.lineno for each in self.statements)
        last = max(each.end_lineno or each.lineno for each in self.statements)
        return f"{self.name}:{first}-{last}"

    def compile(self, statement: ast.stmt) -> Any:
        """The code object of a statement, which may be an edited one."""
        flags = sum(
            getattr(__future__, alias.name).compiler_flag
            for each in self.statements
            if isinstance(each, ast.ImportFrom) and each.module == "__future__"
            for alias in each.names
        )
        return compile(ast.Module([statement], []), self.file, "exec", flags, dont_inherit=True)

    def run(self, codes: Iterable[Any], names: Names | None = None) -> Any:
        """The object that the equations are made of, by compiled statements in a fresh module.

        names: more that the statements find defined.
        """
        module = ModuleType(MODULE)
        copies = dict[int, Any]()
        module.__dict__.update({name: _copy(value, copies) for name, value in self.names.items()})
        module.__dict__.update(names or {}, __name__=MODULE, __file__=self.file)
        sys.modules[MODULE] = module  # dataclasses look their module up
        for code in codes:
            exec(code, module.__dict__)
        return self.select(module.__dict__)


def _copy(value: Any, copies: dict[int, Any]) -> Any:
    """A copy of data, which code may change in place, with all arrays in it; all else as it is.

    copies: those made so far, by the identity of the data; what holds itself is not copied there.
    """
    if id(value) in copies:
        return copies[id(value)]
    made = copies[id(value)] = value
    if isinstance(value, np.ndarray):
        made = value.copy()
    elif type(value) in (list, tuple, set):
        made = type(value)(_copy(each, copies) for each in value)
    elif type(value) is dict:
        made = {key: _copy(each, copies) for key, each in value.items()}
    copies[id(value)] = made
    return made


def find_module_code(module: ModuleType, name: str) -> UserCode | None:
    """The source of an object by its name in a module that was loaded; None without a file.

    Without a name it is that of all parts of equations that the module defines.
    """
    file = getattr(module, "__file__", None) or ""

    def select(defined: Names) -> Any:
        if not name:
            return select_parts(defined)
        first, *others = name.split(".")
        return functools.reduce(getattr, others, defined[first])

    return _read_code(file, {"__package__": module.__package__}, select, lambda statement: True)


def find_code(equations: Equations) -> UserCode | None:
    """The source of equations; None of a table, and of those that have none."""
    if equations.table is not None:
        return None
    code = equations.find_code() if equations.find_code else find_object_code(equations)
    return None if code is None or PACKAGE in Path(code.file).parents else code


def find_object_code(source: Any) -> UserCode | None:
    """The source of a factory, or of Equations of plain functions; None where it has none.

    Functions and classes of the file are defined anew, and its data; other names have the values
    that they have.
    """
    functions: Names = {"": source}
    if isinstance(source, Equations):
        given = {part: getattr(source, part) for part in TAKES}
        functions = {part: each for part, each in given.items() if each is not None}
    names, local_lines, files = dict[str, Any](), set[int](), set[str]()
    for each in functions.values():
        module = vars(sys.modules.get(getattr(each, "__module__", None) or "", ModuleType("")))
        is_local = "<locals>" in getattr(each, "__qualname__", "<locals>")
        if isinstance(each, type) and not is_local:
            names |= module
            files.add(module.get("__file__") or "")
        elif isinstance(each, FunctionType):
            names |= each.__globals__
            files.add(each.__code__.co_filename)
            if is_local:
                names |= _read_closure(each)
                local_lines.add(each.__code__.co_firstlineno)
        else:
            return None
    if len(files) > 1:
        return None

    def select(defined: Names) -> Any:
        made = {part: defined[each.__name__] for part, each in functions.items()}
        return replace(source, **made) if isinstance(source, Equations) else made[""]

    def is_needed(statement: ast.stmt) -> bool:
        is_definition = isinstance(statement, ast.FunctionDef | ast.ClassDef)
        return is_definition or _is_data(statement, names)

    return _read_code(files.pop(), names, select, is_needed, local_lines)


def _is_data(statement: ast.stmt, names: Names) -> bool:
    """Whether a statement gives data to names that still have them, and does nothing else.

    It calls functions of libraries of numbers alone: any other might begin a trial again.
    """
    if not isinstance(statement, ast.Assign):
        return False
    calls = [node.func for node in ast.walk(statement) if isinstance(node, ast.Call)]
    functions = list(map(ast.unparse, calls))
    owners = [function.partition(".")[0] for function in functions]
    stored = [node for target in statement.targets for node in ast.walk(target)]
    targets = [node.id for node in stored if isinstance(node, ast.Name)]
    is_of_library = (getattr(names.get(owner), "__name__", "") in LIBRARIES for owner in owners)
    if not all(is_of_library) or any(".random." in function for function in functions):
        return False
    again = dict(names)
    try:
        exec(compile(ast.Module([statement], []), "", "exec"), again)
        return all(pickle.dumps(again[name]) == pickle.dumps(names[name]) for name in targets)
    except Exception:  # it takes what is there no more, or makes what cannot be compared
        return False


def _read_closure(function: FunctionType) -> dict[str, Any]:
    """Variables that a local function takes from the functions around it."""
    values = {}
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        with suppress(ValueError):  # not assigned yet
            values[name] = cell.cell_contents
    return values


def _read_code(
    file: str,
    names: Names,
    select: Callable[[Names], Any],
    is_needed: Callable[[ast.stmt], bool],
    local_lines: Iterable[int] = (),
) -> UserCode | None:
    """The source of a file, with its statements at the top and local functions at these lines."""
    text = "".join(linecache.getlines(file))
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError):  # a notebook's own commands
        return None
    statements = [statement for statement in tree.body if is_needed(statement)]
    for line in sorted(local_lines):
        at_line = [
            n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef) and _first(n) == line
        ]
        if not at_line:
            return None
        statements += at_line
    return UserCode(file, text, statements, names, select) if statements else None


def _first(node: ast.FunctionDef) -> int:
    """The first line of a function, decorators included."""
    return min([node.lineno, *(each.lineno for each in node.decorator_list)])
