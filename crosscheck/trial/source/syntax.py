"""A user's source as a tree, and what its expressions were while it ran."""

from __future__ import annotations

import ast
import copy
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from inspect import CO_OPTIMIZED
from types import CodeType, FrameType
from typing import Any, TypeAlias, cast

import numpy as np

from crosscheck.trial.source.code import UserCode
from crosscheck.trial.source.edit import Edit

Kind: TypeAlias = tuple[Any, ...]  # ("int",), ("number",), ("array", *shape) or (class,)
INDEX, NUMBER = ("int",), ("number",)
MOST_ELEMENTS = 8  # elements of the longest list whose elements may replace each other
MOST_FIELDS = 4  # elements of a tuple that a list has for each body
MOST_UNWRITTEN = 80  # elements and attributes of a function's objects that its text does not name
LEAF = ast.Name | ast.Attribute | ast.Subscript
FUNCTION = ast.FunctionDef | ast.Lambda
COMPREHENSIONS = {"<listcomp>", "<genexpr>", "<setcomp>", "<dictcomp>"}


@dataclass(eq=False)
class Scope:
    """A function of the source, or all of it: what its names, attributes and elements are.

    kinds: by text, of what the code names there; unwritten: of more that it could name there;
    inner: texts that comprehensions alone name;
    values: of its names, at the end of its first call; result: the kind of what that returned.
    """

    node: ast.AST
    around: Scope | None
    kinds: dict[str, Kind] = field(default_factory=dict)
    unwritten: dict[str, Kind] = field(default_factory=dict)
    nodes: list[ast.AST] = field(default_factory=list)
    inner: set[str] = field(default_factory=set)
    values: dict[str, Any] = field(default_factory=dict)
    result: Kind | None = None

    @cached_property
    def unused(self) -> set[str]:
        """Names that it, or what is around it, gives values to and that nothing reads."""
        names = [each for each in ast.walk(self.node) if isinstance(each, ast.Name)]
        read = {each.id for each in names if isinstance(each.ctx, ast.Load)}
        stored = {each.id for each in names if isinstance(each.ctx, ast.Store)}
        return (stored - read) | (self.around.unused if self.around else set())

    def kind(self, text: str) -> Kind | None:
        """The kind of what a text names here; None where that is unknown."""
        here = self.kinds.get(text) or self.unwritten.get(text)
        return here or (self.around.kind(text) if self.around else None)

    def list_values(self) -> dict[str, Any]:
        """The values of all names that a function has or could take from those around it."""
        return {**(self.around.list_values() if self.around else {}), **self.values}

    def are_alike(self, text: str, other: str) -> bool:
        """Whether not one of two names or elements is a coordinate of SymPy's, one a constant."""
        kinds = set[bool | None]()
        for each in (text, other):
            value = self._values.get(each.partition("[")[0])
            element = value[0] if isinstance(value, list | tuple) and value else value
            kinds.add(getattr(element, "is_Symbol", None))
        return kinds != {True, False}

    @cached_property
    def _values(self) -> dict[str, Any]:
        return self.list_values()

    def list_own_leaves(self) -> Iterator[tuple[str, Kind]]:
        """Text and kind of what the function itself names, or could: its arguments' elements."""
        yield from {**self.unwritten, **self.kinds}.items()

    def list_leaves(self, *, written: bool | None = None) -> Iterator[tuple[str, Kind]]:
        """Text and kind of all that can stand here, once: what the code names there, or not."""
        listed, scope = dict[str, tuple[Kind, bool]](), cast("Scope | None", self)
        while scope is not None:
            for is_written, kinds in ((True, scope.kinds), (False, scope.unwritten)):
                for text, kind in kinds.items():
                    listed.setdefault(text, (kind, is_written))
            scope = scope.around
        for text, (kind, is_written) in listed.items():
            if written in (None, is_written):
                yield text, kind


class SourceTree:
    """The statements of a user's code with the place of each node, and what ran.

    lines: numbers of those that have run; functions: those that have a name.
    """

    def __init__(self, code: UserCode) -> None:
        self.code = code
        self.places: dict[int, tuple[Any, str, int | None]] = {}
        self.scopes: dict[int, Scope] = {}
        self.statements: dict[int, int] = {}
        self.lines = set[int]()
        top = Scope(ast.Module([*code.statements], []), None)
        self.functions: dict[str, Scope] = {}
        for number, statement in enumerate(code.statements):
            self.scopes[id(statement)], self.statements[id(statement)] = top, number
            self._place(statement, top, number)

    def _place(self, node: ast.AST, scope: Scope, number: int) -> None:
        scope.nodes.append(node)
        inner = Scope(node, scope) if isinstance(node, FUNCTION) else scope
        if isinstance(node, ast.FunctionDef):
            self.functions[node.name] = inner
        for name, value in ast.iter_fields(node):
            for index, child in enumerate(value) if isinstance(value, list) else [(None, value)]:
                if isinstance(child, ast.AST):
                    self.places[id(child)] = node, name, index
                    self.scopes[id(child)], self.statements[id(child)] = inner, number
                    self._place(child, inner, number)

    def parent(self, node: ast.AST) -> ast.AST | None:
        """The node around a node; None of a statement at the top."""
        place = self.places.get(id(node))
        return place and place[0]

    def put(self, node: ast.AST, other: ast.AST) -> None:
        """Let another node stand in the place of a node; the same with both undoes it."""
        parent, name, index = self.places[id(node)]
        if index is None:
            setattr(parent, name, other)
        else:
            getattr(parent, name)[index] = other

    def make(self, edit: Edit) -> None:
        """Let an edit's nodes stand where they belong. Raises SyntaxError."""
        for node, other in list(edit.list_replacements()):
            self.put(node, other)

    def undo(self, edit: Edit) -> None:
        """Let the nodes stand again that an edit replaces."""
        for node in edit.list_nodes():
            self.put(node, node)

    def list_nodes(self) -> Iterator[ast.AST]:
        """The expressions and statements that ran, but for statements at the top."""
        for node in self.list_all_nodes():
            is_new = getattr(node, "is_new", False)
            if id(node) in self.places and not is_new and self.has_run(node, self.lines):
                yield node

    def list_all_nodes(self) -> Iterator[ast.AST]:
        """Everything in the source, function by function."""
        for scope in dict.fromkeys(self.scopes.values()):
            yield from scope.nodes

    @cached_property
    def loaded_names(self) -> set[str]:
        """All names that stand anywhere in the source but where a function is defined."""
        return {each.id for each in self.list_all_nodes() if isinstance(each, ast.Name)}

    @cached_property
    def _read_names(self) -> set[str]:
        """All names and attributes that a line reads."""
        leaves = (n for n in self.list_all_nodes() if isinstance(n, ast.Name | ast.Attribute))
        read = (each for each in leaves if isinstance(each.ctx, ast.Load))
        return {each.id if isinstance(each, ast.Name) else each.attr for each in read}

    @cached_property
    def unread_names(self) -> set[str]:
        """Names, and arguments, that no line reads."""
        arguments = (node.arg for node in self.list_all_nodes() if isinstance(node, ast.arg))
        return (self.loaded_names | {*arguments}) - self._read_names

    def is_unread(self, text: str) -> bool:
        """Whether no line reads a name, or an attribute of its name of any object."""
        name = text.rpartition(".")[2]
        return name.isidentifier() and name not in self._read_names

    def list_arguments(self, function: str) -> list[str]:
        """Names of the arguments of a function of the source."""
        arguments = getattr(self.functions[function].node, "args", None)
        return [each.arg for each in arguments.args] if arguments is not None else []

    def list_statements(self) -> Iterator[ast.stmt]:
        """All statements."""
        return (node for node in self.list_all_nodes() if isinstance(node, ast.stmt))

    def statement(self, node: ast.AST) -> ast.stmt:
        """The innermost statement that a node is in, or is."""
        while not isinstance(node, ast.stmt):
            node = self.places[id(node)][0]
        return node

    def is_datum(self, node: ast.AST) -> bool:
        """Whether the statement of a node gives names numbers, and reads nothing."""
        return id(self.statement(node)) in self._data_statements

    @cached_property
    def _data_statements(self) -> set[int]:
        """The identities of assignments that read nothing."""
        assigned = (n for n in self.list_statements() if isinstance(n, ast.Assign | ast.AnnAssign))
        return {id(node) for node in assigned if not any(map(self.is_leaf, ast.walk(node)))}

    def list_lines(self, node: ast.AST) -> range:
        """Numbers of the lines of a node's statement, of one with a body of its first line."""
        around = self.statement(node)
        last = around.lineno if hasattr(around, "body") else around.end_lineno or around.lineno
        return range(around.lineno, last + 1)

    def has_run(self, node: ast.AST, lines: set[int]) -> bool:
        """Whether the statement of a node is among lines that ran."""
        return getattr(node, "lineno", 0) in lines or not lines.isdisjoint(self.list_lines(node))

    def is_leaf(self, node: ast.AST) -> bool:
        """Whether a node is a whole name, attribute or element that is read, and is not called."""
        if not isinstance(node, LEAF) or not isinstance(node.ctx, ast.Load):
            return False
        parent, name, _ = self.places[id(node)]
        return not (isinstance(parent, LEAF) and name == "value") and name not in (
            "func",
            "annotation",
        )

    def kind(self, node: ast.AST) -> Kind | None:
        """The kind of an expression, as far as its text or its operands show it."""
        scope = self.scopes[id(node)]
        if isinstance(node, LEAF):
            return scope.kind(ast.unparse(node))
        if isinstance(node, ast.Constant):
            return find_kind(node.value)
        if isinstance(node, ast.UnaryOp):
            return self.kind(node.operand)
        if isinstance(node, ast.BinOp):
            left, right = self.kind(node.left), self.kind(node.right)
            if left is None or right is None:
                return None
            if isinstance(node.op, ast.MatMult):
                return find_product_kind(left, right)
            return next((each for each in (left, right) if each[0] == "array"), NUMBER)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute | ast.Name):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else node.func.id
            if name in ("cos", "sin", "cross", "sqrt") and node.args:
                return self.kind(node.args[0])
            if name == "array" and node.args and isinstance(node.args[0], ast.List):
                return _find_display_kind(node.args[0])
            function = self.functions.get(name)
            return function.result if function else None
        return None

    def _list_siblings(self, scope: Scope) -> dict[str, None]:
        """Attributes of elements of a function, by names that attributes have anywhere.

        And its elements by its other indices.
        """
        attributes = [node for node in self.list_all_nodes() if isinstance(node, ast.Attribute)]
        elements = (
            ast.unparse(node.value)
            for node in attributes
            if self.scopes[id(node)] is scope
            and isinstance(node.value, ast.Subscript)
            and not _has_call(node.value)
        )
        names = dict.fromkeys(node.attr for node in attributes)
        siblings = dict.fromkeys(f"{element}.{name}" for element in elements for name in names)
        return siblings | dict.fromkeys(_list_other_elements(scope))

    def _list_like_attributes(self, scope: Scope) -> Iterator[str]:
        """Attributes of a function's objects, by names that those of their like have: an axis."""
        leaves = (n for n in self.list_all_nodes() if isinstance(n, ast.Attribute))
        attributes = defaultdict[str, dict[str, None]](dict)
        for node in leaves:
            if isinstance(node.value, ast.Name) and self.is_leaf(node):
                attributes[node.value.id][node.attr] = None
        here = {node.id for node in scope.nodes if isinstance(node, ast.Name)}
        for name in (name for name in attributes if name in here):
            for like in attributes.values():
                if like.keys() & attributes[name].keys():
                    yield from (f"{name}.{attribute}" for attribute in like)

    def observe(self, *runs: Callable[[], object]) -> list[set[int]]:
        """See what all names are while equations are made and asked: the lines of each run."""
        leaves: dict[int, dict[str, CodeType]] = {}
        siblings: dict[int, dict[str, CodeType]] = {}
        indices: dict[int, set[str]] = {}
        by_name, by_line = dict[tuple[int, str], Scope](), dict[int, Scope]()
        top = self.scopes[id(self.code.statements[0])]
        every = dict.fromkeys([top, *self.scopes.values()])
        for scope in every:
            written = dict.fromkeys(filter(None, map(_write_leaf, scope.nodes)))
            written |= dict.fromkeys(self._list_like_attributes(scope))
            leaves[id(scope)] = {text: compile(text, "leaf", "eval") for text in written}
            siblings[id(scope)] = {
                text: compile(text, "leaf", "eval")
                for text in self._list_siblings(scope)
                if text not in written
            }
            subscripts = (node for node in scope.nodes if isinstance(node, ast.Subscript))
            indices[id(scope)] = {
                ast.unparse(node.slice)
                for node in subscripts
                if isinstance(node.slice, ast.Name | ast.Constant | ast.BinOp)
                and not _has_call(node.slice)
            }
            if isinstance(scope.node, FUNCTION):
                name = getattr(scope.node, "name", "<lambda>")
                decorators = getattr(scope.node, "decorator_list", [])
                first = min([scope.node.lineno, *(each.lineno for each in decorators)])
                by_name[first, name] = scope
                for line in range(first, (scope.node.end_lineno or first) + 1):
                    by_line[line] = scope  # inner functions come later

        texts = (text for each in leaves.values() for text in each if not text.isidentifier())
        elsewhere = dict.fromkeys(texts)  # names of other functions, if they mean something here

        def record(frame: FrameType, result: object) -> None:
            first, name = frame.f_code.co_firstlineno, frame.f_code.co_name
            around = top if name == "<module>" else by_line.get(first, top)
            scope = by_name.get((first, name), around)
            is_inner = name in COMPREHENSIONS
            written = scope.kinds, frame, leaves[id(scope)], scope.inner
            _record_kinds(*written, is_inner=is_inner)
            _record_kinds(scope.unwritten, frame, siblings[id(scope)], set(), is_inner=False)
            is_class = name != "<module>" and not frame.f_code.co_flags & CO_OPTIMIZED
            # Frames of comprehensions and of classes are not the function's.
            if not is_inner and not is_class:
                scope.result = scope.result or find_kind(result)
                # Of a file's names, which are many, those that have been forgotten.
                values = dict(frame.f_locals) if name != "<module>" else {}
                names = frame.f_globals
                values |= {each: names[each] for each in scope.unused if each in names}
                unwritten = [*elsewhere, *_list_unwritten(values, indices[id(scope)])]
                _record_values(scope, frame, unwritten)

        lines = [list_run_lines(self.code.file, run, record) for run in runs]
        self.lines.update(*lines)
        return lines


def list_run_lines(
    file: str,
    run: Callable[[], object],
    record: Callable[[FrameType, object], None] = lambda frame, result: None,
) -> set[int]:
    """Numbers of the lines of a file that run meanwhile.

    record: called with each frame of the file and its result as it ends.
    """
    lines = set[int]()

    def look(frame: FrameType, event: str, argument: object) -> Any:
        if frame.f_code.co_filename != file:
            return None
        lines.add(frame.f_lineno)
        if event == "return":
            record(frame, argument)
        return look

    sys.settrace(look)
    try:
        run()
    finally:
        sys.settrace(None)
    return lines


def _write_leaf(node: ast.AST) -> str:
    """The text of a name, attribute or element; '' of what is none, or would call something.

    A name counts also where nothing reads it, since it may be that what was forgotten.
    """
    if isinstance(node, ast.arg):
        return node.arg
    if not isinstance(node, LEAF) or _has_call(node):
        return ""
    is_read = isinstance(node, ast.Name) or isinstance(node.ctx, ast.Load)
    return ast.unparse(node) if is_read else ""


def _list_other_elements(scope: Scope) -> Iterator[str]:
    """Elements of elements in a function, by one of its other names for their first index.

    Or by another number for their second: of a list of pairs.
    """
    stored = (node for node in scope.nodes if isinstance(node, ast.Name))
    names = dict.fromkeys(node.id for node in stored if isinstance(node.ctx, ast.Store))
    for node in (each for each in scope.nodes if isinstance(each, ast.Subscript)):
        inner = node.value
        if not isinstance(inner, ast.Subscript) or _has_call(node):
            continue
        if isinstance(inner.slice, ast.Name):
            for name in names:
                other: Any = copy.deepcopy(node)
                other.value.slice.id = name
                yield ast.unparse(other)
        if isinstance(node.slice, ast.Constant):
            yield from (f"{ast.unparse(inner)}[{place}]" for place in range(MOST_FIELDS))


def _has_call(node: ast.AST) -> bool:
    return any(isinstance(each, ast.Call) for each in ast.walk(node))


def _record_kinds(
    kinds: dict[str, Kind],
    frame: FrameType,
    leaves: dict[str, CodeType],
    inner: set[str],
    *,
    is_inner: bool,
) -> None:
    """Record what names are as a function returns, or a comprehension in it.

    inner: as in Scope, so far: the function's own names go before these; is_inner: whether the
    frame is a comprehension's.
    """
    for text, code in leaves.items():
        if text not in kinds or (text in inner and not is_inner):
            kind = _try_kind(code, frame, frame.f_locals)
            if kind is not None:
                kinds[text] = kind
                (inner.add if is_inner else inner.discard)(text)


def _record_values(scope: Scope, frame: FrameType, unwritten: Iterable[str]) -> None:
    """Record the values of names as a function returns, and the kinds of what it does not name."""
    if scope.values and scope.around is not None:  # of an earlier call; a file has a statement each
        return
    scope.values = dict(frame.f_locals)
    for text in unwritten:
        if len(scope.unwritten) >= MOST_UNWRITTEN:
            return
        if text not in scope.kinds and text not in scope.unwritten:
            kind = _try_kind(compile(text, "leaf", "eval"), frame, scope.list_values())
            if kind is not None and kind[0] in ("int", "number", "array"):
                scope.unwritten[text] = kind


def _try_kind(code: CodeType, frame: FrameType, values: dict[str, Any]) -> Kind | None:
    try:
        return find_kind(eval(code, frame.f_globals, values))
    except Exception:  # a name that has no value there
        return None


def _list_unwritten(values_by_name: Mapping[str, Any], indices: set[str]) -> Iterator[str]:
    """Elements and attributes of objects by their names, in a function's notation of indices.

    Also by a whole number that has a name there: the only element by it may be what was lost.
    """
    values = list(values_by_name.items())
    names = [name for name, value in values if find_kind(value) == INDEX]
    for name, value in values:
        is_list = isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim)
        if is_list and 0 < len(value) <= MOST_ELEMENTS:
            for index in dict.fromkeys([*sorted(indices), *names]):
                yield f"{name}[{index}]"
                yield from (f"{name}[{index}].{each}" for each in _list_attributes(value[0]))
        else:
            yield from (f"{name}.{each}" for each in _list_attributes(value))


def _list_attributes(value: Any) -> list[str]:
    """Names of an object's own attributes, and of those that its class has or works out."""
    if not hasattr(value, "__dict__") or callable(value):
        return []
    of_class = (n for n, v in vars(type(value)).items() if hasattr(v, "fget") or _is_datum(v))
    names = {*vars(value), *of_class}
    return sorted(each for each in names if not each.startswith(("_", "model_")))


def _is_datum(value: Any) -> bool:
    return isinstance(value, int | float | list | tuple | np.ndarray)


def _find_display_kind(node: ast.List) -> Kind | None:
    """The kind of an array whose elements, or rows, are written out."""
    rows = [each for each in node.elts if isinstance(each, ast.List)]
    if len({len(row.elts) for row in rows}) == 1 and len(rows) == len(node.elts):
        return ("array", len(rows), len(rows[0].elts))
    return None if rows or not node.elts else ("array", len(node.elts))


def find_product_kind(left: Kind, right: Kind) -> Kind:
    """The kind of a product of matrices or vectors."""
    shape = *left[1:-1], *right[2:]
    return ("array", *shape) if shape else NUMBER


def find_kind(value: Any) -> Kind | None:
    """The kind of a value; None of one that no other stands for."""
    if hasattr(type(value), "free_symbols") and not hasattr(value, "shape"):
        return NUMBER  # sympy's symbols can be called
    if isinstance(value, bool | str | bytes) or value is None or callable(value):
        return None
    # Attributes are those of its type: pytest.mark ends a test where another one is asked for.
    shape = getattr(value, "shape", None) if hasattr(type(value), "shape") else None
    if isinstance(shape, tuple) and shape:
        return ("array", *shape)
    if isinstance(shape, tuple) and isinstance(value, np.ndarray):
        return NUMBER
    if isinstance(value, list) and value and all(isinstance(each, float | int) for each in value):
        return ("array", len(value))  # as what a product with a matrix takes it
    if isinstance(value, int | np.integer):
        return INDEX
    if isinstance(value, float | np.floating):
        return NUMBER
    if isinstance(value, type(sys)):
        return None
    of = (type(value[0]),) if isinstance(value, list | tuple) and value else ()
    return (type(value), *of)
