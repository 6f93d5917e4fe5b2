"""The project's own files that a result is made by, for keys that change when the code does.

From the functions and classes that make a result, every name is followed to where it is defined:
through imports at any depth, base classes, constants, models that are named by a string, and data
files named so. What counts is every file with a definition that was reached, as a whole, and every
imported file that does more than define. A chapter's measure does therefore not hang on the drawing
that its file imports, and nothing that is run is left out.
"""

from __future__ import annotations

import ast
import hashlib
import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from crosscheck.registry import MODELS, home

ROOT = Path(__file__).parent.parent.parent
OWN = "crosscheck"
DATA = ("crosscheck/models/arms", "crosscheck/models/scenarios")
# These name what others choose, and a key has what was chosen.
CHOSEN_BY_OTHERS = (
    *("crosscheck.registry", "crosscheck.audit.experiments.variant"),
    *(
        f"crosscheck.audit.{name}"
        for name in ("measures.rigid", "experiments.starts", "experiments.preload")
    ),
)
# Watches over processes in which code runs, and changes no number.
NOT_FOLLOWED = (
    "crosscheck.runner.supervision",
    "crosscheck.runner.interruption",
    "crosscheck.entry",
)
BUILDERS = {("crosscheck.registry", "build"), ("crosscheck.registry", "model_class")}
Name = tuple[str, str | None]  # module and what is defined there; None: all of it


@cache
def code_hash(*names: tuple[str, str]) -> str:
    """Of all code and data that these functions and classes, (module, name) each, run."""
    walk = walked(*names)
    digest = hashlib.sha256(json.dumps(sorted(walk.reached)).encode())
    for path in sorted(walk.files):
        digest.update(f"\n{path.name} ".encode())
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def walked(*names: tuple[str, str]) -> Walk:
    """Everything that can be reached from these."""
    walk = Walk({module: _file(module) for module, _ in names})
    walk.waiting += names
    while walk.waiting:
        walk.follow(*walk.waiting.pop())
    return walk


@dataclass
class Walk:
    """What has been reached: definitions, and the files that count. given: where it began."""

    given: dict[str, Path | None]
    waiting: list[Name] = field(default_factory=list)
    reached: set[tuple[str, str]] = field(default_factory=set)
    loaded: set[str] = field(default_factory=set)
    files: set[Path] = field(default_factory=set)

    def follow(self, module: str, name: str | None) -> None:
        """To the definition of a name, and to all that it uses."""
        path = self.given.get(module) or own_path(module)
        if path is None or module in NOT_FOLLOWED or (module, name or "*") in self.reached:
            return
        self.load(module, path)
        source = source_of(path)
        if name is None:
            self._reach(module, "*", path)
            self.waiting += [(module, defined) for defined in source.definitions]
        elif name in source.definitions:
            self._reach(module, name, path)
            self._go(uses(path, module, name))
        elif name in source.imports:
            self.waiting += _meant(source, name, None)
        elif own_path(f"{module}.{name}") is not None:
            self.waiting.append((f"{module}.{name}", None))
        else:  # made in a way that cannot be read off
            self.waiting.append((module, None))

    def load(self, module: str, path: Path | None) -> None:
        """What importing a module does, and the modules that it imports."""
        if path is None or module in self.loaded or module in NOT_FOLLOWED:
            return
        self.loaded.add(module)
        package = module.rpartition(".")[0]
        self.load(package, own_path(package))
        source = source_of(path)
        for imported in _modules(source.imports):
            self.load(imported, own_path(imported))
        if source.acts:
            self.files.add(path)
            self._go(uses(path, module, None))

    def _reach(self, module: str, name: str, path: Path) -> None:
        self.reached.add((module, name))
        self.files.add(path)

    def _go(self, used: Uses) -> None:
        self.waiting += used.names
        self.files |= used.data
        for module in used.modules:
            self.load(module, own_path(module))


@dataclass(frozen=True)
class Uses:
    """What a definition needs: names elsewhere, data files, and modules that it imports itself."""

    names: frozenset[Name]
    data: frozenset[Path]
    modules: frozenset[str]


@cache
def uses(path: Path, module: str, name: str | None) -> Uses:
    """Of a definition in a file; None: of what importing the file does."""
    source = source_of(path)
    seen = _seen(tuple(source.acts if name is None else source.definitions[name]))
    inside = _Source(source.definitions, source.imports | seen.imports, [])
    names = {meant for used in seen.names for meant in _meant(inside, *used, module)}
    strings = frozenset(seen.strings | _texts(source, seen))
    if module in CHOSEN_BY_OTHERS or module.startswith(
        ("crosscheck.models.", "crosscheck.analytic.")
    ):
        strings = frozenset()
    named = [model for text in strings for model in _models_named(text)]
    if BUILDERS & names and not named and module not in CHOSEN_BY_OTHERS:
        named = list(MODELS)  # it does not say here which
    names |= {home(model) for model in named}
    names |= {(text, None) for text in strings if _is_dotted(text)}
    data = frozenset(path for text in strings for path in _data().get(text, ()))
    return Uses(frozenset(names), data, frozenset(_modules(seen.imports)))


def _texts(source: _Source, seen: _Seen) -> set[str]:
    """The strings in those constants of the file that are used."""
    used = [node for name, _ in seen.names for node in source.definitions.get(name, ())]
    return _seen(tuple(node for node in used if isinstance(node, ast.Assign))).strings


def _modules(imports: dict[str, Name]) -> Iterator[str]:
    """All that they could name as a module."""
    for module, item in imports.values():
        yield module
        if item is not None:
            yield f"{module}.{item}"


def _meant(source: _Source, name: str, attribute: str | None, here: str = "") -> Iterator[Name]:
    """What ``name`` or ``name.attribute`` stands for in a file of the project."""
    if name in source.imports:
        module, item = source.imports[name]
        whole = module if item is None else f"{module}.{item}"
        if own_path(whole) is not None:
            yield whole, attribute
        elif item is not None:
            yield module, item
    elif name in source.definitions and here:
        yield here, name


def _file(module: str) -> Path | None:
    """Of a module of the project, or of any other, where a walk begins: a guest's model, say.

    What a guest's file imports counts by the versions of its packages.
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
    """The file of a module of the project."""
    if module.partition(".")[0] != OWN:
        return None
    place = ROOT.joinpath(*module.split("."))
    found = (place / "__init__.py", place.with_suffix(".py"))
    return next((path.resolve() for path in found if path.is_file()), None)


@dataclass(frozen=True)
class _Source:
    """A file: definitions by name, imports by the name they give, and what it does besides."""

    definitions: dict[str, list[ast.stmt]]
    imports: dict[str, Name]
    acts: list[ast.stmt]


@cache
def source_of(path: Path) -> _Source:
    """What a file holds."""
    return _parsed(path.read_text(encoding="utf-8"))


@cache
def _parsed(text: str) -> _Source:
    source = _Source({}, {}, [])
    for node in ast.parse(text).body:
        names = _defined(node)
        for name in names:
            source.definitions.setdefault(name, []).append(node)
        source.imports.update(_imported(node))
        if not names and not isinstance(node, ast.Import | ast.ImportFrom) and not _is_text(node):
            source.acts.append(node)
            source.imports.update(_seen((node,)).imports)
    return source


def _defined(node: ast.AST) -> list[str]:
    """The names that a statement of a module defines."""
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        return [node.name]
    if isinstance(node, ast.Assign | ast.AnnAssign):
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        inner = [part for target in targets for part in ast.walk(target)]
        if not any(isinstance(part, ast.Attribute | ast.Subscript) for part in inner):
            return [part.id for part in inner if isinstance(part, ast.Name)]
    return []


def _imported(node: ast.AST) -> dict[str, Name]:
    """The name that an import gives -> module and what of it."""
    if isinstance(node, ast.ImportFrom) and node.module is not None:
        return {alias.asname or alias.name: (node.module, alias.name) for alias in node.names}
    if isinstance(node, ast.Import):
        return {a.asname or a.name.partition(".")[0]: (a.name, None) for a in node.names}
    return {}


def _is_text(node: ast.AST) -> bool:
    """Whether it is a docstring."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


class _Seen(ast.NodeVisitor):
    """Names (with attribute), strings and imports in some statements."""

    def __init__(self) -> None:
        self.names: set[Name] = set()
        self.strings: set[str] = set()
        self.imports: dict[str, Name] = {}

    def visit_Attribute(self, node: ast.Attribute) -> None:
        if isinstance(node.value, ast.Name):
            self.names.add((node.value.id, node.attr))
        else:
            self.generic_visit(node)

    def visit_Name(self, node: ast.Name) -> None:
        self.names.add((node.id, None))

    def visit_Constant(self, node: ast.Constant) -> None:
        if isinstance(node.value, str):
            self.strings.add(node.value)

    def visit_Expr(self, node: ast.Expr) -> None:
        if not _is_text(node):
            self.generic_visit(node)

    def visit_Import(self, node: ast.Import) -> None:
        self.imports |= _imported(node)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        self.imports |= _imported(node)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        # Not the annotations: they are text.
        for part in (*node.decorator_list, *node.args.defaults, *node.args.kw_defaults, *node.body):
            if part is not None:
                self.visit(part)


@cache
def _seen(nodes: tuple[ast.stmt, ...]) -> _Seen:
    seen = _Seen()
    for node in nodes:
        seen.visit(node)
    return seen


@cache
def _models_named(text: str) -> list[str]:
    """The models that a string names, or begins to name as f"analytic:{level}" does."""
    return [
        name for name in MODELS if text == name or (text.endswith(":") and name.startswith(text))
    ]


def _is_dotted(text: str) -> bool:
    """Whether it could be a module's name."""
    return "." in text and all(part.isidentifier() for part in text.split("."))


@cache
def _data() -> dict[str, list[Path]]:
    """The files of every built-in arm's or scenario's name."""
    named: dict[str, list[Path]] = {}
    for folder in DATA:
        for path in (ROOT / folder).glob("*.toml"):
            named.setdefault(path.stem, []).append(path)
    return named
