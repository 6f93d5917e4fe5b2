"""Numbers that make equations right: in place of those of the code, or as a missing summand.

Idea: such a number is an unknown, and the answers that are wrong are equations for it. Difficulty:
they depend on it in any way; a length enters a mass matrix by its square. Remedy: a few steps of
Gauss and Newton, whose slopes are differences; what nothing solves is given up after two of them.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from itertools import chain, combinations, combinations_with_replacement, islice

import numpy as np

from crosscheck.trial.source.site import Site
from crosscheck.trial.source.syntax import MOST_ELEMENTS, NUMBER

MOST_STEPS = 8
GAIN = 0.5  # of the residual, that a step must leave at most
SHARES = 1.0, 0.5, 0.25  # of a step, of which the first is taken that leaves no more
SOLVED = 1e-9  # of the first residual
EQUAL = 1e-8  # relative difference of a number and a product of names that is one
MOST_NAMES = 40  # of which products are made
MOST_FACTORS, FACTORS = 3, {1.0: "", 2.0: "2 * ", 0.5: "0.5 * "}
MOST_DIGITS = 10
Residual = Callable[[np.ndarray], np.ndarray]


def solve_numbers(residual: Residual, start: np.ndarray) -> np.ndarray | None:
    """Numbers (n,) at which a residual (k,) vanishes, from a start; None where none are near."""
    numbers, steps = start, 0.1 * np.abs(start)
    steps[steps == 0] = 0.1
    rest = residual(numbers)
    first = float(np.linalg.norm(rest))
    for _ in range(MOST_STEPS):
        slopes = [(residual(numbers + row) - rest) / row.sum() for row in np.diag(steps)]
        if not np.isfinite(slopes).all() or not np.any(slopes):
            return None
        change = np.linalg.lstsq(np.transpose(slopes), -rest)[0]
        before, begin = float(np.linalg.norm(rest)), numbers
        for share in SHARES:  # a square's step may be too long
            numbers = begin + share * change
            rest = residual(numbers)
            size = float(np.linalg.norm(rest))
            if size <= SOLVED * first:
                return numbers
            if size <= GAIN * before:
                break
        else:
            return None
        steps = np.where(change == 0, steps, 1e-3 * change)
    return None


def write_number(value: float) -> str:
    """The shortest text of a number that is that number, but for rounding."""
    if abs(value) < SOLVED:
        return "0.0"
    texts = (f"{value:.{digits}g}" for digits in range(1, MOST_DIGITS))
    short = (text for text in texts if abs(float(text) - value) <= EQUAL * abs(value))
    return next(short, repr(value))


def is_round(value: float, digits: int) -> bool:
    """Whether so many digits are all of a number."""
    rest = abs(float(f"{value:.{digits}g}") - value)
    return rest <= EQUAL * abs(value) or abs(value) < SOLVED


def list_equal_products(site: Site, value: float, *, are_shortest: bool) -> Iterator[str]:
    """Products of a few numbers that a site can name, with their sign, which have a value.

    Among them a mass times the square of a distance: of a difference of two. are_shortest: whether
    only those of as few numbers as possible.
    """
    numbers = dict(islice(_list_numbers(site), MOST_NAMES))
    has_any = False
    for count in range(1, MOST_FACTORS + 1):
        if are_shortest and has_any:
            return
        for texts in combinations_with_replacement(sorted(numbers), count):
            product = float(np.prod([numbers[text] for text in texts]))
            for factor, written in FACTORS.items():
                if abs(abs(value) - abs(factor * product)) <= EQUAL * abs(value):
                    sign = "+" if value * product > 0 else "-"
                    powers = Counter(texts).items()
                    named = (text if power == 1 else f"{text} ** {power}" for text, power in powers)
                    has_any = True
                    yield f"{sign} {written}{' * '.join(named)}"
    for (a, end), (b, begin) in combinations(numbers.items(), 2):
        for text, number in numbers.items() if end != begin else ():
            ratio = value / (number * (end - begin) ** 2)
            if abs(abs(ratio) - 1) <= EQUAL:
                yield f"{'+' if ratio > 0 else '-'} {text} * ({a} - {b}) ** 2"


def _list_numbers(site: Site) -> Iterator[tuple[str, float]]:
    """The names, attributes and elements that are numbers at a site, with their values."""
    values: Mapping[str, object] = site.scope.list_values()
    leaves = (site.scope.list_leaves(written=written) for written in (True, False))
    for text, kind in chain.from_iterable(leaves):
        if kind == NUMBER:
            try:
                number = float(eval(text, {"__builtins__": {}}, dict(values)))
            except Exception:  # a symbol, or a name that has no value any more
                continue
            if number != 0 and np.isfinite(number):
                yield text, number


def read_literals(site: Site) -> tuple[str, list[float]] | None:
    """A number of the code, or those of a vector: its text with gaps for them, and the numbers.

    None of all else, and of indices.
    """
    node = site.node
    if isinstance(node, ast.Constant):
        number = _read_number(node)
        return None if number is None or site.is_index else ("{}", [number])
    if not isinstance(node, ast.List | ast.Tuple) or len(node.elts) > MOST_ELEMENTS:
        return None
    numbers = list(map(_read_number, node.elts))
    values = [each for each in numbers if each is not None]
    is_vector = len(values) > 1 and not (site.is_index and all(map(float.is_integer, values)))
    texts = (
        ast.unparse(each).replace("{", "{{").replace("}", "}}") if number is None else "{}"
        for each, number in zip(node.elts, numbers, strict=True)
    )
    listed = ", ".join(texts)
    return (f"[{listed}]" if isinstance(node, ast.List) else listed, values) if is_vector else None


def _read_number(node: ast.expr) -> float | None:
    """The number that an expression is, with its sign."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        number = _read_number(node.operand)
        return None if number is None else -number
    value = node.value if isinstance(node, ast.Constant) else None
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None
