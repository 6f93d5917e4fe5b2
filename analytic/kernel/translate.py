"""A kernel's text translated to LLVM IR.

The text is a small part of Python. A *row function* has a first argument ``w: rows``: the numbers
of a block of members that are worked on side by side, its ``lanes``. ``w[k]`` is row k, one number
of every member, and the function is straight-line: every line holds for all lanes at once. Other
functions are loops over single numbers and call row functions. Arguments are ``array`` (numbers in
memory), ``int``, or a number without annotation.

Arithmetic is IEEE 754 in double precision, operation by operation, in the order of the text. The
only fused operation is ``fma``, which rounds once; analytic.kernel.text.fusion puts it into row
functions. So a text gives the same bits on every processor, at every number of lanes, for every
version of the compiler and every level of optimisation.
"""

from __future__ import annotations

import ast
import struct
from collections.abc import Sequence
from typing import NamedTuple

from crosscheck.analytic.kernel.text.fusion import fuse_products

ValueKind = (
    str  # of a value: "float", "lanes", "int", "bool", "mask" (a bool of every lane), "array"
)

_FLOAT = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
_INT = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.FloorDiv: "sdiv", ast.Mod: "srem"}
# No NaN passes a comparison, but for the last.
_ORDERED = {
    ast.Gt: "ogt",
    ast.Lt: "olt",
    ast.GtE: "oge",
    ast.LtE: "ole",
    ast.Eq: "oeq",
    ast.NotEq: "une",
}
_WHOLE = {
    ast.Gt: "sgt",
    ast.Lt: "slt",
    ast.GtE: "sge",
    ast.LtE: "sle",
    ast.Eq: "eq",
    ast.NotEq: "ne",
}
EXPONENT_BIAS, FRACTION_DIGITS = 1023, 52  # of a double
# The stack begins at a line of the cache: what of a row is kept there never spans two.
ATTRIBUTES = "attributes #0 = { nounwind alignstack=64 }"


class Value(NamedTuple):
    """A value: its text in IR and its kind; number: of a constant."""

    text: str
    kind: ValueKind
    number: float | None = None


# Instructions of a block of straight-line code. LLVM's quick compilation takes a time that grows
# with the square of a block's: 160,000 in one, a robot's of 64 joints, took 50 times as long.
BLOCK_INSTRUCTIONS = 2000


class Signature(NamedTuple):
    """Kinds of a function's arguments and of its result, ``void`` for nothing."""

    arguments: tuple[ValueKind, ...]
    return_kind: ValueKind


def translate_to_ir(text: str, lanes: int) -> str:
    """The IR of a kernel's text for so many lanes. Raises NotImplementedError beyond its part."""
    tree = ast.parse(text)
    functions = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    constants = {
        node.targets[0].id: ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)
    }
    signatures = {function.name: _signature(function) for function in functions}
    lines = list(_declarations(lanes))
    for function in functions:
        straight = "rows" in signatures[function.name].arguments
        lines += _Function(
            fuse_products(function) if straight else function, lanes, constants, signatures
        ).lines()
    return "\n".join([*lines, ATTRIBUTES, ""])


def _declarations(lanes: int) -> list[str]:
    types = [("f64", "double")] + [(f"v{lanes}f64", f"<{lanes} x double>")] * (lanes > 1)
    return [
        f"declare {kind} @llvm.{name}.{suffix}({', '.join([kind] * count)})"
        for suffix, kind in types
        for name, count in (("fabs", 1), ("rint", 1), ("sqrt", 1), ("fma", 3))
    ]


def _signature(function: ast.FunctionDef) -> Signature:
    argument_types = tuple(
        _annotation_kind(argument.annotation, "float") for argument in function.args.args
    )
    return Signature(argument_types, _annotation_kind(function.returns, "void"))


def _annotation_kind(annotation: ast.expr | None, otherwise: ValueKind) -> ValueKind:
    if annotation is None or (isinstance(annotation, ast.Constant) and annotation.value is None):
        return otherwise
    assert isinstance(annotation, ast.Name)
    return annotation.id


class _Function:
    """Translation of one function to IR."""

    def __init__(
        self,
        function: ast.FunctionDef,
        lanes: int,
        constants: dict[str, int | float],
        signatures: dict[str, Signature],
    ) -> None:
        self.function, self.lanes, self.constants = function, lanes, constants
        self.signatures, self.signature = signatures, signatures[function.name]
        self.straight = "rows" in self.signature.arguments
        self.begin, self.body, self.count = list[str](), list[str](), 0
        self.values = dict[str, Value]()  # arguments, and of row functions all names
        self.places = dict[str, Value]()  # of a loop's variables: where each is kept
        self.loops = list[str]()  # labels to go on at

    def lines(self) -> list[str]:
        """Lines of the function's whole definition in IR."""
        arguments = []
        names = [argument.arg for argument in self.function.args.args]
        for name, kind in zip(names, self.signature.arguments, strict=True):
            self.values[name] = Value(f"%{name}", kind)
            pointer = kind in ("array", "rows")
            arguments.append(f"{'ptr noalias' if pointer else self._type(kind)} %{name}")
        full = BLOCK_INSTRUCTIONS
        for statement in self.function.body:
            self._statement(statement)
            if self.straight and self.count > full:
                full = self.count + BLOCK_INSTRUCTIONS
                self._begin_block()
        if self.signature.return_kind == "void":
            self.body.append("  ret void")
        else:
            self.body.append("  unreachable")
        head = f"define {self._type(self.signature.return_kind)} @{self.function.name}"
        inlined = "noinline " if self.straight else ""
        opened = f"{head}({', '.join(arguments)}) {inlined}#0 {{"
        return [opened, "entry:", *self.begin, *self.body, "}"]

    def _type(self, kind: ValueKind) -> str:
        if kind in ("lanes", "mask"):
            part = "double" if kind == "lanes" else "i1"
            return f"<{self.lanes} x {part}>" if self.lanes > 1 else part
        simple = {"float": "double", "int": "i64", "bool": "i1", "void": "void"}
        return simple.get(kind, "ptr")

    def _put(self, instruction: str) -> str:
        self.count += 1
        self.body.append(f"  %.{self.count} = {instruction}")
        return f"%.{self.count}"

    # Statements

    def _statement(self, node: ast.stmt) -> None:
        match node:
            case ast.Expr(value=ast.Constant()):  # a docstring
                return
            case ast.Expr(value=ast.Call() as call):
                self._call(call)
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                self._assign(name, self._expression(value))
            case ast.AugAssign(target=ast.Name(id=name), op=op, value=value):
                changed = ast.BinOp(ast.Name(name), op, value)
                self._assign(name, self._expression(changed))
            case ast.Assign(targets=[ast.Subscript() as target], value=value):
                self._store(target, self._expression(value))
            case ast.Return(value=None):
                self._leave("ret void")
            case ast.Return(value=value) if value is not None:
                returned = self._as(self._expression(value), self.signature.return_kind)
                self._leave(f"ret {self._type(returned.kind)} {returned.text}")
            case _ if not self.straight:
                self._flow(node)
            case _:
                raise NotImplementedError(ast.dump(node))

    def _flow(self, node: ast.stmt) -> None:
        match node:
            case ast.For(target=ast.Name(id=name), iter=ast.Call(args=bounds), body=body):
                self._count(name, bounds, body)
            case ast.While(test=test, body=body):
                self._loop(test, body, ())
            case ast.If(test=test, body=body, orelse=orelse):
                self._if(test, body, orelse)
            case ast.Continue():
                self._leave(f"br label %{self.loops[-1]}")
            case _:
                raise NotImplementedError(ast.dump(node))

    def _assign(self, name: str, value: Value) -> None:
        if self.straight:
            self.values[name] = value
            return
        if name not in self.places:
            self.begin.append(f"  %{name}.at = alloca {self._type(value.kind)}")
            self.places[name] = Value(f"%{name}.at", value.kind)
        place = self.places[name]
        stored = self._as(value, place.kind)
        self.body.append(f"  store {self._type(place.kind)} {stored.text}, ptr {place.text}")

    def _store(self, target: ast.Subscript, value: Value) -> None:
        place, kind = self._place(target)
        stored = self._as(value, kind)
        self.body.append(
            f"  store {self._type(kind)} {stored.text}, ptr {place}{self._alignment(kind)}"
        )

    def _leave(self, instruction: str) -> None:
        """End the block; whatever follows in it is not reached."""
        self.body.append(f"  {instruction}")
        self._label(self._new_label())

    def _new_label(self) -> str:
        self.count += 1
        return f"at{self.count}"

    def _label(self, name: str) -> None:
        self.body.append(f"{name}:")

    def _begin_block(self) -> None:
        label = self._new_label()
        self._goto(label)
        self._label(label)

    def _goto(self, label: str) -> None:
        self.body.append(f"  br label %{label}")

    def _branch(self, test: ast.expr, yes: str, no: str) -> None:
        condition = self._as(self._expression(test), "bool")
        self.body.append(f"  br i1 {condition.text}, label %{yes}, label %{no}")

    def _loop(self, test: ast.expr, body: Sequence[ast.stmt], after: Sequence[ast.stmt]) -> None:
        """Add a loop; ``after`` ends every turn, those that ``continue`` too."""
        head, inside, step, end = (self._new_label() for _ in range(4))
        self._goto(head)
        self._label(head)
        self._branch(test, inside, end)
        self._label(inside)
        self.loops.append(step)
        for statement in body:
            self._statement(statement)
        self.loops.pop()
        self._goto(step)
        self._label(step)
        for statement in after:
            self._statement(statement)
        self._goto(head)
        self._label(end)

    def _count(self, name: str, bounds: Sequence[ast.expr], body: Sequence[ast.stmt]) -> None:
        """Add ``for name in range(...)``, whose step is 1."""
        first, last = (ast.Constant(0), *bounds) if len(bounds) == 1 else bounds
        self._assign(name, self._expression(first))
        limit = self._expression(last)
        self.count += 1
        end = f"{name}.end{self.count}"
        self.values[end] = limit
        test = ast.Compare(ast.Name(name), [ast.Lt()], [ast.Name(end)])
        self._loop(test, body, [ast.AugAssign(ast.Name(name), ast.Add(), ast.Constant(1))])

    def _if(self, test: ast.expr, body: Sequence[ast.stmt], orelse: Sequence[ast.stmt]) -> None:
        yes, no, end = (self._new_label() for _ in range(3))
        self._branch(test, yes, no)
        for label, statements in ((yes, body), (no, orelse)):
            self._label(label)
            for statement in statements:
                self._statement(statement)
            self._goto(end)
        self._label(end)

    # Expressions

    def _expression(self, node: ast.expr) -> Value:
        match node:
            case ast.Constant(value=bool() as value):
                return Value(str(value).lower(), "bool")
            case ast.Constant(value=int() as value):
                return Value(str(value), "int", value)
            case ast.Constant(value=float() as value):
                return _float_constant(value)
            case ast.Name(id=name):
                return self._name_value(name)
            case ast.Subscript():
                place, kind = self._place(node)
                loaded = f"load {self._type(kind)}, ptr {place}{self._alignment(kind)}"
                return Value(self._put(loaded), kind)
            case ast.BinOp(left=left, op=op, right=right):
                return self._binary(op, self._expression(left), self._expression(right))
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return self._negation(self._expression(operand))
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                inner = self._as(self._expression(operand), "bool")
                return Value(self._put(f"xor i1 {inner.text}, true"), "bool")
            case ast.BoolOp(op=op, values=values):
                return self._logic(op, [self._expression(value) for value in values])
            case ast.Compare(left=left, ops=[op], comparators=[right]):
                return self._compare(op, self._expression(left), self._expression(right))
            case ast.IfExp(test=test, body=body, orelse=orelse):
                parts = (self._expression(each) for each in (test, body, orelse))
                return self._select(*parts)
            case ast.Call():
                return self._call(node)
        raise NotImplementedError(ast.dump(node))

    def _name_value(self, name: str) -> Value:
        if name in self.values:
            return self.values[name]
        if name in self.constants:
            return self._expression(ast.Constant(self.constants[name]))
        place = self.places[name]
        return Value(self._put(f"load {self._type(place.kind)}, ptr {place.text}"), place.kind)

    def _as(self, value: Value, kind: ValueKind) -> Value:
        """The value as one of another kind: a number for all lanes, a whole one as a float."""
        if kind == "lanes" and self.lanes == 1:
            kind = "float"
        if value.kind == kind or ({value.kind, kind} <= {"float", "lanes"} and self.lanes == 1):
            return value._replace(kind=kind)
        if value.kind == "int" and kind in ("float", "lanes"):
            if value.number is not None:
                return self._as(_float_constant(float(value.number)), kind)
            return self._as(Value(self._put(f"sitofp i64 {value.text} to double"), "float"), kind)
        if value.kind == "float" and kind == "lanes":
            return Value(self._spread(value), kind)
        if value.kind == "mask" and kind == "bool" and self.lanes == 1:
            return value._replace(kind=kind)
        raise NotImplementedError(f"{value.kind} as {kind} in {self.function.name}")

    def _spread(self, value: Value) -> str:
        row, zeros = self._type("lanes"), f"<{self.lanes} x i32> zeroinitializer"
        if value.number is not None:
            return "<" + ", ".join([f"double {value.text}"] * self.lanes) + ">"
        first = self._put(f"insertelement {row} poison, double {value.text}, i64 0")
        return self._put(f"shufflevector {row} {first}, {row} poison, {zeros}")

    def _common(self, *values: Value) -> list[Value]:
        """The values as ones of the kind that can hold each."""
        value_types = {value.kind for value in values}
        wide = "lanes" in value_types and self.lanes > 1
        common = "lanes" if wide else "int" if value_types == {"int"} else "float"
        return [self._as(value, common) for value in values]

    def _binary(self, op: ast.operator, a: Value, b: Value) -> Value:
        a, b = self._common(a, b)
        operations = _INT if a.kind == "int" and not isinstance(op, ast.Div) else _FLOAT
        if operations is _FLOAT and a.kind == "int":
            a, b = self._as(a, "float"), self._as(b, "float")
        operation = operations[type(op)]
        return Value(self._put(f"{operation} {self._type(a.kind)} {a.text}, {b.text}"), a.kind)

    def _negation(self, value: Value) -> Value:
        if value.number is not None:
            return (
                _float_constant(-value.number)
                if value.kind == "float"
                else Value(str(-value.number), "int", -value.number)
            )
        if value.kind == "int":
            return Value(self._put(f"sub i64 0, {value.text}"), "int")
        return Value(self._put(f"fneg {self._type(value.kind)} {value.text}"), value.kind)

    def _logic(self, op: ast.boolop, values: Sequence[Value]) -> Value:
        name, result = "and" if isinstance(op, ast.And) else "or", self._as(values[0], "bool")
        for value in values[1:]:
            other = self._as(value, "bool")
            result = Value(self._put(f"{name} i1 {result.text}, {other.text}"), "bool")
        return result

    def _compare(self, op: ast.cmpop, a: Value, b: Value) -> Value:
        if {a.kind, b.kind} == {"bool"}:
            return Value(self._put(f"icmp {_WHOLE[type(op)]} i1 {a.text}, {b.text}"), "bool")
        a, b = self._common(a, b)
        compared = f"icmp {_WHOLE[type(op)]}" if a.kind == "int" else f"fcmp {_ORDERED[type(op)]}"
        kind = "mask" if a.kind == "lanes" else "bool"
        return Value(self._put(f"{compared} {self._type(a.kind)} {a.text}, {b.text}"), kind)

    def _select(self, test: Value, yes: Value, no: Value) -> Value:
        yes, no = self._common(yes, no)
        if test.kind == "mask" and self.lanes > 1:
            yes, no = self._as(yes, "lanes"), self._as(no, "lanes")
        kind = self._type(yes.kind)
        chosen = f"select {self._type(test.kind)} {test.text}, {kind} {yes.text}, {kind} {no.text}"
        return Value(self._put(chosen), yes.kind)

    def _call(self, node: ast.Call) -> Value:
        assert isinstance(node.func, ast.Name)
        name, values = node.func.id, [self._expression(argument) for argument in node.args]
        match name:
            case "abs" | "rint" | "sqrt" | "fma":
                return self._intrinsic({"abs": "fabs"}.get(name, name), values)
            case "min" | "max":
                a, b = self._common(*values)
                test = self._compare(ast.Lt() if name == "min" else ast.Gt(), b, a)
                return self._select(test, b, a)
            case "at":
                pointer, place = values
                return Value(self._put(_address(pointer.text, place.text)), "array")
            case "power_of_two":
                return self._power_of_two(values[0])
            case "pick":
                return self._pick(*values)
        return self._function_call(name, values)

    def _intrinsic(self, name: str, values: Sequence[Value]) -> Value:
        values = self._common(*values)
        if values[0].kind == "int":
            values = [self._as(value, "float") for value in values]
        kind = self._type(values[0].kind)
        suffix = "f64" if kind == "double" else f"v{self.lanes}f64"
        arguments = ", ".join(f"{kind} {value.text}" for value in values)
        return Value(self._put(f"call {kind} @llvm.{name}.{suffix}({arguments})"), values[0].kind)

    def _function_call(self, name: str, values: Sequence[Value]) -> Value:
        signature = self.signatures[name]
        arguments = ", ".join(
            f"{self._type(kind)} {(value if kind == 'rows' else self._as(value, kind)).text}"
            for value, kind in zip(values, signature.arguments, strict=True)
        )
        returned = self._type(signature.return_kind)
        call = f"call {returned} @{name}({arguments})"
        if signature.return_kind == "void":
            self.body.append(f"  {call}")
            return Value("", "void")
        return Value(self._put(call), signature.return_kind)

    # Memory

    def _place(self, node: ast.Subscript) -> tuple[str, ValueKind]:
        """Address and kind of ``w[k]``: a row of row functions, else a number."""
        assert isinstance(node.value, ast.Name)
        pointer, index = self._name_value(node.value.id), self._expression(node.slice)
        if pointer.kind == "rows":
            assert index.number is not None  # rows are numbered in the text
            return self._put(_address(pointer.text, str(index.number * self.lanes))), "lanes"
        return self._put(_address(pointer.text, index.text)), "float"

    def _alignment(self, kind: ValueKind) -> str:
        return f", align {8 * self.lanes if kind == 'lanes' else 8}"

    def _pick(self, pointer: Value, first: Value, place: Value) -> Value:
        """Row first + place, place a whole number that may differ from lane to lane."""
        assert first.number is not None
        if self.lanes == 1:
            index = self._put(f"fptosi double {self._as(place, 'float').text} to i64")
            row = self._put(f"add i64 {index}, {first.number}")
            return Value(
                self._put(f"load double, ptr {self._put(_address(pointer.text, row))}"), "lanes"
            )
        places, vector = self._as(place, "lanes").text, "poison"
        for lane in range(self.lanes):
            lane_place = self._put(f"extractelement {self._type('lanes')} {places}, i64 {lane}")
            row = self._put(f"fptosi double {lane_place} to i64")
            begun = self._put(f"mul i64 {row}, {self.lanes}")
            at = self._put(f"add i64 {begun}, {int(first.number) * self.lanes + lane}")
            number = self._put(f"load double, ptr {self._put(_address(pointer.text, at))}")
            vector = self._put(
                f"insertelement {self._type('lanes')} {vector}, double {number}, i64 {lane}"
            )
        return Value(vector, "lanes")

    def _power_of_two(self, shifted: Value) -> Value:
        """2 to a whole number, which is given with ``functions.ROUNDING`` added: its last bits.

        They are shifted to where a double has its exponent; a NaN makes some number.
        """
        wide = shifted.kind == "lanes" and self.lanes > 1
        whole = f"<{self.lanes} x i64>" if wide else "i64"

        def lane_constant(number: int) -> str:
            return "<" + ", ".join([f"i64 {number}"] * self.lanes) + ">" if wide else str(number)

        kind = self._type(shifted.kind)
        bits = self._put(f"bitcast {kind} {shifted.text} to {whole}")
        moved = self._put(f"shl {whole} {bits}, {lane_constant(FRACTION_DIGITS)}")
        biased = self._put(
            f"add {whole} {moved}, {lane_constant(EXPONENT_BIAS << FRACTION_DIGITS)}"
        )
        return Value(self._put(f"bitcast {whole} {biased} to {kind}"), shifted.kind)


def _float_constant(number: float) -> Value:
    bits = struct.unpack("<Q", struct.pack("<d", number))[0]
    return Value(f"0x{bits:016X}", "float", number)


def _address(pointer: str, place: str) -> str:
    return f"getelementptr inbounds double, ptr {pointer}, i64 {place}"
