"""A kernel's text run by Python, every operation rounded as IEEE 754 says: what it must make.

Independent of how the text is translated: Python's own floats, and the C library's ``fma``.
"""

import ast
import ctypes
import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np

from crosscheck.analytic.kernel.program import Program
from crosscheck.analytic.kernel.text.functions import ROUNDING
from crosscheck.analytic.kernel.text.fusion import fuse_products


def exact_fma(a: float, b: float, c: float) -> float:
    """a b + c of finite numbers, rounded once: by fractions."""
    exact = Fraction(a) * Fraction(b) + Fraction(c)
    return float(exact) if exact else a * b + c


fma = ctypes.CDLL(
    None
).fma  # the C library's: the same (tests/engines/test_kernel.py), in less time
fma.restype, fma.argtypes = ctypes.c_double, [ctypes.c_double] * 3


@dataclass
class Memory:
    """Numbers from a place on."""

    numbers: np.ndarray
    first: int = 0

    def __getitem__(self, place: int) -> float:
        return float(self.numbers[self.first + place])

    def __setitem__(self, place: int, value: float) -> None:
        self.numbers[self.first + place] = value


@dataclass
class Lane:
    """The rows of one member of a block."""

    block: Memory
    lanes: int
    lane: int

    def __getitem__(self, row: int) -> float:
        return self.block[row * self.lanes + self.lane]

    def __setitem__(self, row: int, value: float) -> None:
        self.block[row * self.lanes + self.lane] = value


def power_of_two(shifted: float) -> float:
    """2 to the whole number that is given with ROUNDING added."""
    return math.nan if math.isnan(shifted) else math.ldexp(1.0, int(shifted - ROUNDING))


class _Divisions(ast.NodeTransformer):
    """Division by 0 as IEEE 754 has it."""

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        self.generic_visit(node)
        if isinstance(node.op, ast.Div):
            return ast.Call(ast.Name("divided", ast.Load()), [node.left, node.right], [])
        return node


@lru_cache(maxsize=4)  # states of one structure follow each other
def interpreted(program: Program) -> dict[str, Callable[..., Any]]:
    """The functions of a program by name; arrays are given as arrays of numbers."""
    tree = ast.parse(program.text)
    named = ((f, f.args.args[0].annotation) for f in tree.body if isinstance(f, ast.FunctionDef))
    straight = {f.name for f, of in named if isinstance(of, ast.Name) and of.id == "rows"}
    tree.body = [
        fuse_products(node) if isinstance(node, ast.FunctionDef) and node.name in straight else node
        for node in tree.body
    ]
    names: dict[str, Any] = {
        "fma": fma,
        "sqrt": math.sqrt,
        "rint": lambda x: float(np.rint(x)),
        "divided": lambda a, b: float(np.divide(a, b)),
        "power_of_two": power_of_two,
        "pick": lambda rows, first, place: rows[first + int(place)],
        "at": lambda memory, place: Memory(memory.numbers, memory.first + place),
        **dict.fromkeys(("rows", "array")),
    }
    whole = ast.fix_missing_locations(_Divisions().visit(tree))
    with np.errstate(divide="ignore", invalid="ignore"):
        exec(compile(whole, "kernel", "exec"), names)
    for name in straight:
        names[name] = _in_all_lanes(names[name], program.lanes)
    return {
        node.name: _on_arrays(names[node.name])
        for node in tree.body
        if isinstance(node, ast.FunctionDef)
    }


def _in_all_lanes(function: Callable[..., None], lanes: int) -> Callable[..., None]:
    def run(block: Memory, *rest: Any) -> None:
        for lane in range(lanes):
            function(Lane(block, lanes, lane), *rest)

    return run


def _on_arrays(function: Callable[..., Any]) -> Callable[..., Any]:
    def run(*arguments: Any) -> Any:
        given = (Memory(a.reshape(-1)) if isinstance(a, np.ndarray) else a for a in arguments)
        with np.errstate(divide="ignore", invalid="ignore"):
            return function(*given)

    return run


def addresses(arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    """The same arguments for machine code."""
    return tuple(a.ctypes.data if isinstance(a, np.ndarray) else a for a in arguments)
