"""The source of a user's equations: its text, and how equations are taken from it anew."""

from __future__ import annotations
import __future__

import ast
import linecache
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial, reduce
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

from crosscheck.trial.input.calls import TAKES, select_parts
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.input.source_lines import PACKAGE
from crosscheck.trial.source.statements import list_made_names, select_statements

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
        names_of_file = [name for name in self.names if name != "__builtins__"]
        module.__dict__.update({name: _copy(self.names[name], copies) for name in names_of_file})
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
    names, first = vars(module), name.partition(".")[0]
    select = partial(_select_named, name) if name else select_parts
    return _read_code(names.get("__file__") or "", names, select, {first} if name else {*TAKES})


def _select_named(name: str, defined: Names) -> Any:
    first, *others = name.split(".")
    return reduce(getattr, others, defined[first])


def find_code(equations: Equations) -> UserCode | None:
    """The source of equations; None of a table, and of those that have none."""
    if equations.table is not None:
        return None
    code = equations.find_code() if equations.find_code else find_object_code(equations)
    return None if code is None or PACKAGE in Path(code.file).parents else code


def find_object_code(source: Any) -> UserCode | None:
    """The source of what a user gave, or of its parts; None where it has none, or several.

    What it uses of its file is defined anew; other names have the values that they have.
    """
    if (home := _find_home(source)) is not None:
        names, name = home
        return _read_code(_find_file(source, names), names, partial(_select_named, name), {name})
    functions: Names = {"": source}
    if isinstance(source, Equations):
        given = {part: getattr(source, part) for part in TAKES}
        functions = {part: each for part, each in given.items() if each is not None}
    names, wanted, local_lines = dict[str, Any](), dict[str, str](), set[int]()
    files = set[str]()
    for part, each in functions.items():
        owner = getattr(each, "__self__", each)  # of a method
        if (home := _find_home(owner)) is not None:
            names |= home[0]
            files.add(_find_file(owner, home[0]))
            wanted[part] = home[1] + f".{each.__name__}" * (owner is not each)
        elif isinstance(each, FunctionType):
            names |= each.__globals__ | _read_closure(each)
            files.add(each.__code__.co_filename)
            wanted[part] = each.__name__
            local_lines.add(each.__code__.co_firstlineno)
        else:
            return None
    if len(files) > 1:
        return None

    def select(defined: Names) -> Any:
        made = {part: _select_named(name, defined) for part, name in wanted.items()}
        return replace(source, **made) if isinstance(source, Equations) else made[""]

    firsts = {name.partition(".")[0] for name in wanted.values()}
    return _read_code(files.pop(), names, select, firsts, local_lines)


def _find_file(source: Any, names: Names) -> str:
    """The file of a function, which may be a cell of a notebook, or of an object's module."""
    code = getattr(source, "__code__", None)
    return code.co_filename if code else names.get("__file__") or ""


def _find_home(source: Any) -> tuple[Names, str] | None:
    """The names of a module, and the one under which an object was made there."""
    if isinstance(source, FunctionType):
        homes = [source.__globals__]
    elif isinstance(source, type):
        homes = [vars(sys.modules.get(source.__module__, ModuleType("")))]
    else:
        homes = [vars(each) for each in [*sys.modules.values()] if hasattr(each, "__file__")]
    for names in homes:
        if id(source) not in map(id, names.values()):  # as of nearly all of a thousand modules
            continue
        for name, value in names.items():
            if value is source and name in list_made_names(_parse(_find_file(source, names))):
                return names, name
    return None


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
    wanted: Iterable[str],
    local_lines: Iterable[int] = (),
) -> UserCode | None:
    """The source of names of a file and of local functions at these lines, with all that they use.

    names: those that are there, with their values.
    """
    text = "".join(linecache.getlines(file))
    tree, local = _parse(file), list[ast.stmt]()
    for line in sorted(local_lines):
        at_line = [
            n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef) and _first(n) == line
        ]
        if not at_line:
            return None
        local += at_line
    statements = [*select_statements(file, tree.body, names, {*wanted}, local), *local]
    return UserCode(file, text, statements, names, select) if statements else None


def _parse(file: str) -> ast.Module:
    """The statements of a file; none of a notebook's own commands."""
    try:
        return ast.parse("".join(linecache.getlines(file)))
    except (SyntaxError, ValueError):
        return ast.Module([], [])


def _first(node: ast.FunctionDef) -> int:
    """The first line of a function, decorators included."""
    return min([node.lineno, *(each.lineno for each in node.decorator_list)])
