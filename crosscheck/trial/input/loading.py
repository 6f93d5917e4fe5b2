"""Equations from a user's own file or package: this runs the user's code."""

from __future__ import annotations

import ast
import difflib
import hashlib
import importlib
import importlib.util
import inspect
import linecache
import os
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, replace
from functools import lru_cache, partial
from pathlib import Path
from types import BuiltinFunctionType, FunctionType, ModuleType, SimpleNamespace
from typing import Any, get_args

import numpy as np

import crosscheck
from crosscheck.mechanisms import supply
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError, describe_error, describe_type
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.robot.robot import RIGID, Robot
from crosscheck.report.formatting import list_first
from crosscheck.runner.interruption import was_stopped
from crosscheck.runner.supervision import track_foreign_code
from crosscheck.trial.input.calls import (
    MEANT,
    TAKES,
    list_parameters,
    make_named_calls,
    read_signature,
    select_parts,
)
from crosscheck.trial.input.equations import Coordinates, Equations, Level
from crosscheck.trial.source.code import UserCode, find_module_code, find_object_code

EXPECTED = "file.py, file.py:name, package.module:name or file.fmu"
OF_SYMPY = "what crosscheck.testing.from_sympy makes of its matrices"
ACCEPTED = "Equations, a function that returns them, or an object with mass_matrix, bias, ..."
MOST_NAMED = 5
MOST_REMEMBERED = 64  # arms and scenarios, of whose equations a factory is asked once
# Friction arguments of robots, whose files have none.
FRICTION = ("viscous_friction", "coulomb_friction")
# Attributes that are asked of no object.
SET_HERE = {"rebuild", "rebuilt_as", "any_arm", "any_scenario", "unused", "find_code", "reading"}
Maker = Callable[..., Any]


def load_equations(text: str, mechanism: Any, scenario: Scenario | None = None) -> Equations:
    """The equations that a user names, with the numbers of an arm or of a robot.

    text: ``file.py:name`` or ``package.module:name``; the name is of Equations, of an object with
    functions called like theirs, or of a function or class that takes none, one or both of arm and
    scenario, or a robot, and gives either. Raises InputError for whatever is wrong with it, in one
    line.
    """
    build = supply("build_equations", mechanism.section)
    with run_user_code(text):
        given = import_object(text), mechanism, scenario, text
        equations: Equations = build(*given, find_code=partial(find_named_code, text))
    return equations


def find_named_code(text: str) -> UserCode | None:
    """The source of what ``file.py:name`` or ``package.module:name`` names, once it was loaded."""
    module, name, _ = _parse_location(text)
    return find_module_code(sys.modules[_module_name(module)], name)


def import_object(text: str) -> Any:
    """The object that ``file.py:name`` or ``package.module:name`` names.

    The code runs in ``run_user_code``. Raises InputError.
    """
    module, name, folder = _parse_location(text)
    loaded = _load_module(text, module, folder)
    if not name:
        if not vars(select_parts(vars(loaded))):
            reason = f"has none of {', '.join(TAKES)}; name what has them, as file.py:name"
            near = [difflib.get_close_matches(name, TAKES, 1, 0.75) for name in vars(loaded)]
            meant = "".join(f" (did you mean {part}?)" for (part,) in filter(None, near))
            raise InputError(text, "", None, f"{reason}{_list_names(loaded)}{meant}")
        return loaded
    named_object: Any = loaded
    for part in name.split("."):
        if isinstance(getattr(named_object, part, sys), ModuleType):  # which may be none
            raise InputError(text, "", None, f"no {part} in {module}{_list_names(loaded, part)}")
        named_object = getattr(named_object, part)
    return named_object


def _list_names(module: ModuleType, wanted: str = "") -> str:
    """Words on names that a module defines: those near one that is wanted, else functions first."""
    values = {
        name: value
        for name, value in vars(module).items()
        if not name.startswith("_") and not _is_imported(value, module)
    }
    names = sorted(values, key=lambda name: not callable(values[name]))
    near = difflib.get_close_matches(wanted, names, n=MOST_NAMED, cutoff=0.5) or names
    return f"; it defines {list_first(near, MOST_NAMED)}" if near else ""


def _is_imported(value: Any, module: ModuleType) -> bool:
    """Whether a value of a module is another module, or a class or function of one."""
    is_named = isinstance(value, type | FunctionType | BuiltinFunctionType)
    is_of_library = isinstance(value, ModuleType | np.ufunc)
    return is_of_library or (is_named and value.__module__ != module.__name__)


@contextmanager
def run_user_code(text: str) -> Iterator[None]:
    """Run a user's code inside; whatever it raises is an InputError that names it by its text."""
    folder = _parse_location(text)[2]
    with track_foreign_code(text), _translate_errors(text, folder), _make_importable(folder):
        yield


def build_equations(
    source: Any,
    arm: Arm,
    scenario: Scenario | None,
    where: str,
    find_code: Callable[[], UserCode | None] | None = None,
) -> Equations:
    """Equations out of what a user gave, see handed_over.

    find_code: finds the code of an object that is named, by ``where``.
    """
    beside = _parse_location(where)[2] if find_code else Path.cwd().resolve()
    if not _is_factory(source):
        extracted = extract_equations(source, where)
        if isinstance(source, ModuleType):  # whose own names these are: an arm's file says so
            extracted = replace(extracted, viscous_friction=None, coulomb_friction=None)
        extracted = replace(extracted, find_code=find_code) if find_code else extracted
        return _require_arm_equations(extracted.adapt_to_arm(arm, scenario), where)
    find_code = find_code or partial(find_object_code, source)
    by_arm = _match_arguments(source, where, ("arm", "scenario"))

    @lru_cache(maxsize=MOST_REMEMBERED)  # deriving equations may take a second
    def call_source(*values: object) -> Any:
        with _translate_errors(where, beside), _make_importable(beside):
            return _call_factory(source, dict(zip(by_arm, values, strict=True)))

    def rebuild(other: Arm, drive: Scenario | None) -> Equations:
        values = {"arm": other, "scenario": drive or scenario}
        answer = call_source(*(values[of] for of in by_arm.values()))
        whole = _require_arm_equations(
            extract_equations(answer, where, "returned").adapt_to_arm(other, drive), where
        )
        any_arm = whole.any_arm or "arm" in by_arm.values()
        any_scenario = whole.any_scenario or "scenario" in by_arm.values()
        return replace(
            whole,
            rebuild=rebuild,
            any_arm=any_arm,
            any_scenario=any_scenario,
            find_code=find_code,
        )

    return rebuild(arm, scenario)


def build_robot_equations(
    source: Any,
    robot: Robot,
    scenario: Scenario | None,
    where: str,
    find_code: Callable[[], UserCode | None] | None = None,
) -> Equations:
    """Make a robot's equations from what a user supplied.

    A factory takes the robot, or nothing: no scenario is run. find_code: finds the source of an
    object that is named. Raises InputError for whatever is wrong with it.
    """
    if _is_factory(source):
        taken = _match_arguments(source, where, ("robot",))
        answer = _call_factory(source, dict.fromkeys(taken, robot))
        equations = extract_equations(answer, where, "returned")
    else:
        equations = extract_equations(source, where)
    if equations.symbolic is not None:
        from crosscheck.trial.input.symbolic import bind_to_robot  # sympy takes a while

        equations = bind_to_robot(equations, robot)
    if find_code is None and _is_factory(source):
        find_code = partial(find_object_code, source)
    equations = replace(equations, find_code=find_code) if find_code else equations
    return require_robot_equations(equations, where)


def _is_factory(source: Any) -> bool:
    """Whether what a user named makes the equations, and is not these."""
    if isinstance(source, Equations) or not callable(source):
        return False
    return isinstance(source, type) or not _has_parts(source)


def _call_factory(factory: Maker, arguments: Mapping[str, Any]) -> Any:
    bound = read_signature(factory).bind_partial()
    bound.arguments.update(arguments)
    return factory(*bound.args, **bound.kwargs)


def _parse_location(text: str) -> tuple[str, str, Path]:
    """Module or file, the name in it, and the folder that it is in. Raises InputError.

    The name is '' of a whole file, whose functions are parts of equations.
    """
    module, colon, name = text.rpartition(":")
    if not colon and text.endswith(".py"):
        module, name = text, ""
    elif not colon or not module or not name:
        front = "is a folder; " if Path(text).is_dir() else ""
        raise InputError(text, "", None, f"{front}must be {EXPECTED}")
    folder = _resolve(module).parent if module.endswith(".py") else Path.cwd().resolve()
    return module, name, folder


def _resolve(file: str) -> Path:
    """Where a file is, links followed, and for one that leads to itself where it is named."""
    return Path(os.path.realpath(file))


def _load_module(text: str, module: str, folder: Path) -> ModuleType:
    if not module.endswith(".py") and "/" not in module:
        with _translate_errors(text, folder), _make_importable(folder):
            return importlib.import_module(module)
    if not Path(module).is_file():
        raise InputError(text, "", None, f"no such file; must be {EXPECTED}")
    if not module.endswith(".py"):
        raise InputError(text, "", None, f"is not a Python file; must be {EXPECTED}")
    path, name = _resolve(module), _module_name(module)
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None  # a .py file always has a loader
    assert spec.loader is not None
    user_module = importlib.util.module_from_spec(spec)
    sys.modules[name] = user_module  # dataclasses and pickles look their module up
    linecache.checkcache(str(path))  # the file may have changed since the last trial
    with _translate_errors(text, folder), _make_importable(folder):
        spec.loader.exec_module(user_module)
    return user_module


def _module_name(module: str) -> str:
    """The name under which a module is loaded: of a file a private one, which hides no other."""
    if not module.endswith(".py"):
        return module
    path = str(_resolve(module)).encode()
    return f"_crosscheck_trial_{hashlib.sha256(path).hexdigest()[:16]}"


@contextmanager
def _make_importable(folder: Path) -> Iterator[None]:
    """Make what stands in a folder importable, after all else; nothing compiled is left in it."""
    before = sys.dont_write_bytecode
    sys.path.append(str(folder))
    sys.dont_write_bytecode = True
    try:
        yield
    finally:
        sys.dont_write_bytecode = before
        sys.path.remove(str(folder))


@contextmanager
def _translate_errors(where: str, folder: Path) -> Iterator[None]:
    """Turn whatever the user's code raises into an InputError that names the line of the code."""
    try:
        yield
    except InputError:
        raise
    except SyntaxError as error:
        place = f"{Path(error.filename or where).name}, line {error.lineno}"
        raise InputError(where, "", None, f"is not Python: {error.msg} ({place})") from error
    except BaseException as error:
        if was_stopped():
            raise
        words, place = describe_error(error), format_error_line(error, folder)
        if isinstance(error, AttributeError) and isinstance(error.obj, Robot):
            words += "; a robot has bodies, joints, rotors, stages and gravity"
        reason = f"raises {words}{place}"
        raise InputError(where, "", None, reason) from error


def format_error_line(error: BaseException, folder: Path) -> str:
    """File and line of what raised: the last of the user's own, else the last of anybody's."""
    package_folder = Path(crosscheck.__file__).parent
    called = [
        (frame.f_code.co_filename, line) for frame, line in traceback.walk_tb(error.__traceback__)
    ]
    frames = [
        (Path(name), line)
        for name, line in called
        if package_folder not in Path(name).parents and not name.startswith("<frozen")
    ]
    user_frames = [
        (path, line)
        for path, line in frames
        if folder in path.parents and "site-packages" not in path.parts
    ]
    path, line = (user_frames or frames or [(Path(), 0)])[-1]
    return f" ({path.name}, line {line})" if line else ""


def _has_parts(source: Any) -> bool:
    return any(callable(getattr(source, part, None)) for part in TAKES)


def extract_equations(source: Any, where: str, verb: str = "is") -> Equations:
    """Equations out of an object whose functions are called like those of Equations.

    Raises InputError, also for a function that is called almost like a part that is missing.
    """
    if isinstance(source, Equations):
        return source
    is_namespace = isinstance(source, SimpleNamespace | ModuleType)
    if isinstance(source, type) or not (_has_parts(source) or is_namespace):
        kind = "None" if source is None else describe_type(source)
        must = "must return" if verb == "returned" else "must be"
        must = f"{must} an instance of it, or" if isinstance(source, type) else must
        is_sympy = type(source).__module__.startswith("sympy.")
        reason = f"{verb} {kind}; {must} {OF_SYMPY if is_sympy else ACCEPTED}"
        raise InputError(where, "", None, reason)
    names = {entry.name for entry in fields(Equations)} - SET_HERE
    # Of a file's other names, such as level, nobody knows what they mean.
    parts = select_parts(vars(source)) if isinstance(source, ModuleType) else source
    attributes = {
        name: getattr(parts, name) for name in names if getattr(parts, name, None) is not None
    }
    return Equations(**attributes, unused=_find_unused(source, names, set(attributes), where))


def _find_unused(source: Any, names: set[str], given: set[str], where: str) -> tuple[str, ...]:
    """Names of an object's or file's functions that are no part; of a namespace, of anything.

    names: of what is read; given: of those that are there. Raises InputError for a name like that
    of a part that is missing, of a function that takes what parts take, and for any other name in a
    namespace.
    """
    missing, other = [part for part in TAKES if part not in given], _public_names(source) - names
    for name in sorted(other):
        near = next((part for part in missing if part in name.lower()), "")
        near = near or next(iter(difflib.get_close_matches(name.lower(), missing, 1, 0.75)), "")
        parameters = list_parameters(getattr(source, name)) or ()
        needed = [each.name for each in parameters if each.default is each.empty]
        is_like = set(needed) <= set(MEANT) or len(needed) == len(TAKES.get(near, ()))
        near = near if is_like else ""
        if near or isinstance(source, SimpleNamespace):
            meant = f" (did you mean {near}?)" if near else ""
            reason = f"is not a part of equations{meant}; parts are {', '.join(TAKES)}"
            raise InputError(where, name, None, reason)
    return tuple(sorted(other))


def _find_unread_names(module: ModuleType) -> set[str]:
    """Public functions that a file defines and that nothing in it reads but its tests and main."""
    if not (module.__dict__.get("__file__") or "").endswith(".py"):
        return set()
    defined, read = set[str](), set[str]()
    for statement in ast.parse(Path(str(module.__file__)).read_bytes()).body:
        name = getattr(statement, "name", "")  # of a function or class
        if name == "main" or name.startswith("test_") or _is_main_guard(statement):
            continue
        nodes = list(ast.walk(statement))
        names = [node for node in nodes if isinstance(node, ast.Name)]
        read |= {node.id for node in names if isinstance(node.ctx, ast.Load)} - {name}
        if isinstance(statement, ast.FunctionDef):
            defined.add(name)
        elif not isinstance(statement, ast.ClassDef):
            defined |= {node.id for node in names if isinstance(node.ctx, ast.Store)}
    functions = {name: vars(module).get(name) for name in defined - read}
    return {
        name
        for name, value in functions.items()
        if not name.startswith("_")
        and callable(value)
        and not isinstance(value, type)
        # Symbols of sympy can be called as well.
        and list_parameters(value) is not None
    }


def _is_main_guard(statement: ast.stmt) -> bool:
    """Whether a statement is ``if __name__ == "__main__"``."""
    if not isinstance(statement, ast.If):
        return False
    return any(getattr(node, "id", "") == "__name__" for node in ast.walk(statement.test))


def _public_names(source: Any) -> set[str]:
    """Public names of an object's functions, those of libraries' classes excepted."""
    if isinstance(source, ModuleType):
        return _find_unread_names(source)
    if isinstance(source, SimpleNamespace):
        return {name for name in vars(source) if not name.startswith("_")}
    home = type(source).__module__
    places = [getattr(source, "__dict__", {})]
    places += [vars(c) for c in type(source).__mro__ if c.__module__ == home]
    return {
        name
        for place in places
        for name, value in place.items()
        if not name.startswith("_") and callable(value) and not isinstance(value, type)
    }


def _match_arguments(factory: Maker, where: str, names: tuple[str, ...]) -> dict[str, str]:
    """Argument for each parameter of a factory: the one of its name, else the first left over.

    names: of what there is, such as arm and scenario.
    """
    try:
        parameters = read_signature(factory).parameters.values()
    except (TypeError, ValueError):
        raise InputError(where, "", None, f"is a builtin; must be {ACCEPTED}") from None
    meant = {p.name: p.name for p in parameters if p.name in names}
    free_names = [name for name in names if name not in meant]
    variadic = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    for parameter in parameters:
        if parameter.name in meant or parameter.kind in variadic:
            continue
        if parameter.default is not parameter.empty:
            continue
        if MEANT.get(parameter.name) in ("t", "x", "v", "torque"):
            arguments = {MEANT.get(p.name) for p in parameters if p.default is p.empty}
            name = getattr(factory, "__name__", "")
            alike = [part for part, takes in TAKES.items() if arguments == {*takes}]
            parts = [f"{part}=..." for part in alike] or ["mass_matrix=..., bias=..."]
            parts = [f"{name}={name}"] if name in TAKES else parts
            whole = " or ".join(f"Equations({each})" for each in parts)
            file, _, name = where.rpartition(":")
            is_part = file.endswith(".py") and name in TAKES
            how = f"name {file} alone for all its parts" if is_part else f"hand it over as {whole}"
            raise InputError(where, "", None, f"takes {parameter.name}, not {names[0]}; {how}")
        if not free_names or parameter.kind == parameter.KEYWORD_ONLY:
            reason = f"takes {parameter.name}; may take {' and '.join(names)} alone"
            raise InputError(where, "", None, reason)
        meant[parameter.name] = free_names.pop(0)
    return meant


def _require_arm_equations(equations: Equations, where: str) -> Equations:
    """Return the equations of an arm. Raises InputError if they cannot be used."""
    for name in FRICTION:
        if getattr(equations, name) is not None:
            reason = "is of robots alone; an arm's file says what friction it has"
            raise InputError(where, name, None, reason)
    _require_parts(equations, where)
    if not isinstance(equations.coordinates, Coordinates):
        reason = f"is {describe_type(equations.coordinates)}; must be Coordinates"
        raise InputError(where, "coordinates", None, reason)
    level, gearing = equations.level, equations.coordinates.gearing
    if level not in get_args(Level):
        allowed = ", ".join(filter(None, get_args(Level)))
        raise InputError(where, "level", level, f"must be one of {allowed}, or left out")
    if level and gearing != "rigid":
        reason = f"is of rigid models; coordinates.gearing is {gearing}"
        raise InputError(where, "level", level, reason)
    if not isinstance(equations.switches, Switches | None):
        reason = f"is {describe_type(equations.switches)}; must be Switches"
        raise InputError(where, "switches", None, reason)
    return equations


def require_robot_equations(equations: Equations, where: str) -> Equations:
    """The equations of a robot themselves. Raises InputError unless all of them can be judged."""
    if equations.switches is not None:
        reason = "is of arms alone; a robot's equations are of its joints' coordinates"
        raise InputError(where, "switches", None, reason)
    _require_parts(equations, where)
    levels = (*RIGID, "elastic")  # of joints: coordinates of links and motors
    if equations.level and equations.level not in levels:
        allowed = f"must be one of {', '.join(levels)}, or left out"
        raise InputError(where, "level", equations.level, allowed)
    return equations


def _require_parts(equations: Equations, where: str) -> None:
    """Raise InputError unless there is at least one part, each a function."""
    if all(getattr(equations, part) is None for part in TAKES):
        raise InputError(where, "", None, f"hands nothing over; needs one of {', '.join(TAKES)}")
    if equations.bias is not None and equations.coriolis is not None:
        raise InputError(where, "coriolis", None, "give either bias or coriolis")
    try:
        make_named_calls(equations)
    except InputError as error:
        raise InputError(where, error.field, error.value, error.allowed) from None
