"""A model's equations as one file of C, from the kernel's own text, operation by operation."""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from textwrap import fill

import numpy as np

from crosscheck.analytic.kernel.equations import TermEquations
from crosscheck.analytic.kernel.text.fusion import fuse_products
from crosscheck.analytic.kernel.text.terms import TermStructure, name_results
from crosscheck.models.experiment.drive import TABLE

OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
COMPARISONS = {ast.Gt: ">", ast.Lt: "<", ast.GtE: ">=", ast.LtE: "<="}
CALLS = {"abs": "fabs", "rint": "rint", "fma": "fma", "power_of_two": "power_of_two"}
POWER_OF_TWO = """\
/* 2 to a whole number, which comes with 1.5 * 2^52 added. */
static double power_of_two(double shifted) {
    uint64_t bits;
    double found;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits << 52) + ((uint64_t)1023 << 52);
    memcpy(&found, &bits, sizeof found);
    return found;
}

"""


@dataclass(frozen=True)
class CLine:
    """A line of C, ``target = value``; value_names: the names in the value."""

    target: str
    value: str
    value_names: frozenset[str]


@dataclass(frozen=True)
class CFunction:
    """A function of C: its name's end, arguments, the array that it fills, and with what."""

    name: str
    arguments: str
    result: str
    entries: tuple[str, ...]


def generate_c_source(equations: TermEquations, prefix: str, header: str) -> str:
    """One file of C that needs its standard library alone.

    M (n * n, row by row), bias, force and acceleration (n,) as functions whose names begin with
    prefix, of time, coordinates and rates of the layout, and the drive's torques (joints,) [N m],
    whatever law the model's scenario has. header: what the file begins with, as a comment.
    """
    structure = replace(equations.structure, drive=TABLE)
    lines = make_c_lines(structure.acceleration())
    numbers = equations.numbers
    functions = [_function(structure, part, lines, numbers, prefix) for part in _parts(structure)]
    body = "\n".join(functions)
    used = {name for name in numbers if re.search(rf"\b{name}\b", body)}
    constants = "".join(define_constant(name, numbers[name]) for name in sorted(used))
    return assemble_c_file(header, structure.size, len(structure.stages), constants, body)


def assemble_c_file(header: str, size: int, joints: int, constants: str, body: str) -> str:
    """One file of C: what it is, its sizes, constants and functions."""
    powers = POWER_OF_TWO if "power_of_two(" in body else ""
    return (
        f"/* {fill(header, 96, subsequent_indent='   ')} */\n"
        "#include <math.h>\n#include <stdint.h>\n#include <string.h>\n\n"
        f"enum {{ N = {size}, JOINTS = {joints} }};\n\n{constants}\n{powers}{body}"
    )


def _parts(s: TermStructure) -> Iterable[CFunction]:
    of_state = "const double q[N], const double v[N]"
    driven = f"double t, {of_state}, const double torque[JOINTS]"
    entries = name_results(s)
    yield CFunction("mass_matrix", "const double q[N]", "M", entries["mass_matrix"])
    yield CFunction("bias", of_state, "bias", entries["bias"])
    yield CFunction("force", driven, "force", entries["force"])
    yield CFunction("acceleration", driven, "a", entries["acceleration"])


def make_c_lines(text: Iterable[str]) -> list[CLine]:
    """The kernel's lines of text as lines of C, products fused as in it."""
    (function,) = ast.parse("def f():\n" + "".join(f"    {line}\n" for line in text)).body
    assert isinstance(function, ast.FunctionDef)
    return [_line(statement) for statement in fuse_products(function).body]


def _line(statement: ast.stmt) -> CLine:
    match statement:
        case ast.Assign(targets=[ast.Name(id=target)], value=value):
            pass
        case ast.AugAssign(target=ast.Name(id=target), op=op, value=added):
            value = ast.BinOp(ast.Name(target), op, added)
        case _:
            raise NotImplementedError(ast.dump(statement))
    names = {node.id for node in ast.walk(value) if isinstance(node, ast.Name)}
    return CLine(target, _c(value), frozenset(names))


def _c(node: ast.expr) -> str:
    """An expression in C, each operation in brackets: the order is that of the text."""
    match node:
        case ast.Constant(value=float() as value):
            return repr(value)
        case ast.Name(id=name):
            return name
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return f"(-{_c(operand)})"
        case ast.BinOp(left=left, op=op, right=right):
            return f"({_c(left)} {OPERATORS[type(op)]} {_c(right)})"
        case ast.Compare(left=left, ops=[compared], comparators=[right]):
            return f"({_c(left)} {COMPARISONS[type(compared)]} {_c(right)})"
        case ast.IfExp(test=test, body=body, orelse=orelse):
            return f"({_c(test)} ? {_c(body)} : {_c(orelse)})"
        case ast.Call(func=ast.Name(id="pick"), args=[_, table, place]):
            return f"{_c(table)}[(int){_c(place)}]"
        case ast.Call(func=ast.Name(id=name), args=arguments) if name in CALLS:
            return f"{CALLS[name]}({', '.join(map(_c, arguments))})"
    raise NotImplementedError(ast.dump(node))


def _function(
    s: TermStructure,
    part: CFunction,
    lines: Sequence[CLine],
    numbers: Mapping[str, float | np.ndarray],
    prefix: str,
) -> str:
    """Text of a part as a function of C, with the lines that it needs and no others."""
    loads = {f"{kind}_{x}": f"{kind}[{k}]" for kind in "qv" for k, x in enumerate(s.coordinates)}
    loads |= {f"table{j}": f"torque[{j - 1}]" for j in s.joints}
    return write_c_function(part, lines, loads, numbers, prefix)


def write_c_function(
    part: CFunction,
    lines: Sequence[CLine],
    loads: Mapping[str, str],
    numbers: Mapping[str, float | np.ndarray],
    prefix: str,
    has_numbers: bool = False,
) -> str:
    """The same; loads: names that arguments set, and how; has_numbers: those used stand in it."""
    needed = {name for name in part.entries if name != "0.0"}
    kept: list[CLine] = []
    for line in reversed(lines):
        if line.target in needed:
            kept.append(line)
            needed = (needed - {line.target}) | line.value_names
    first = [CLine(name, where, frozenset()) for name, where in loads.items() if name in needed]
    unknown = needed - set(loads) - set(numbers) - set(CALLS) - {"t", "pick", "w"}
    assert not unknown, unknown  # what a kernel's text uses is set in it, or a number
    declared: set[str] = set()
    body = []
    for line in [*first, *reversed(kept)]:
        body.append(f"{'' if line.target in declared else 'double '}{line.target} = {line.value};")
        declared.add(line.target)
    body += [f"{part.result}[{place}] = {entry};" for place, entry in enumerate(part.entries)]
    size = "N * N" if part.name == "mass_matrix" else "N"
    head = f"void {prefix}_{part.name}({part.arguments}, double {part.result}[{size}])"
    unused = "".join(
        f"    (void){name};\n"
        for name in re.findall(r"(\w+)(?=\[|,|$)", part.arguments)
        if name not in ("N", "JOINTS") and not any(re.search(rf"\b{name}\b", line) for line in body)
    )
    inside = set().union(*(line.value_names for line in kept)) & set(numbers)
    constants = "".join(f"    {define_constant(name, numbers[name])}" for name in sorted(inside))
    return (
        f"{head} {{\n{unused}{constants if has_numbers else ''}"
        + "".join(f"    {line}\n" for line in body)
        + "}\n"
    )


def define_constant(name: str, value: float | np.ndarray) -> str:
    if isinstance(value, np.ndarray):
        entries = ", ".join(map(_number, value.tolist()))
        return f"static const double {name}[{value.size}] = {{{entries}}};\n"
    return f"static const double {name} = {_number(float(value))};\n"


def _number(value: float) -> str:
    return repr(float(value)) if math.isfinite(value) else "INFINITY"
