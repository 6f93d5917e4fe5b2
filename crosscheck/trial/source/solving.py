"""Numbers that make equations right: in place of one of the code, or as a missing summand.

Idea: such a number is an unknown, and the answers that are wrong are equations for it. Difficulty:
they depend on it in any way; a length enters a mass matrix by its square. Remedy: a few steps of
Gauss and Newton, whose slopes are differences; what nothing solves is given up after two of them.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping
from itertools import chain, combinations_with_replacement, islice

import numpy as np

from crosscheck.trial.source.site import Site
from crosscheck.trial.source.syntax import NUMBER

MOST_STEPS = 8
GAIN = 0.5  # of the residual, that a step must leave at most
SOLVED = 1e-9  # of the first residual
EQUAL = 1e-8  # relative difference of a number and a product of names that is one
MOST_NAMES = 40  # of which products are made
MOST_FACTORS, FACTORS = 3, {1.0: "", 2.0: "2 * ", 0.5: "0.5 * "}
MOST_DIGITS = 10
Residual = Callable[[float], np.ndarray]


def solve_number(residual: Residual, start: float) -> float | None:
    """The number at which a residual (k,) vanishes, from a start; None where none is near."""
    number, step = start, 0.1 * abs(start) or 0.1
    rest = residual(number)
    first = float(np.linalg.norm(rest))
    for _ in range(MOST_STEPS):
        slope = (residual(number + step) - rest) / step
        if not slope.any() or not np.isfinite(slope).all():
            return None
        change = -float(slope @ rest / (slope @ slope))
        before, number = float(np.linalg.norm(rest)), number + change
        rest = residual(number)
        size = float(np.linalg.norm(rest))
        if size <= SOLVED * first:
            return number
        if not size <= GAIN * before:
            return None
        step = 1e-3 * change
    return None


def write_number(value: float) -> str:
    """The shortest text of a number that is that number, but for rounding."""
    if abs(value) < SOLVED:
        return "0.0"
    texts = (f"{value:.{digits}g}" for digits in range(1, MOST_DIGITS))
    short = (text for text in texts if abs(float(text) - value) <= EQUAL * abs(value))
    return next(short, repr(value))


def list_equal_products(site: Site, value: float) -> Iterator[str]:
    """Products of a few numbers that a site can name, with their sign, which have a value."""
    numbers = dict(islice(_list_numbers(site), MOST_NAMES))
    for count in range(1, MOST_FACTORS + 1):
        for texts in combinations_with_replacement(sorted(numbers), count):
            product = float(np.prod([numbers[text] for text in texts]))
            for factor, written in FACTORS.items():
                if abs(abs(value) - abs(factor * product)) <= EQUAL * abs(value):
                    sign = "+" if value * product > 0 else "-"
                    yield f"{sign} {written}{' * '.join(texts)}"


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
            if number not in (0.0, 1.0) and np.isfinite(number):
                yield text, number


def read_literal(site: Site) -> float | None:
    """The number of the code that a site is, to compute with; None of all else."""
    value = site.node.value if isinstance(site.node, ast.Constant) else None
    if not isinstance(value, int | float) or isinstance(value, bool) or site.is_index:
        return None
    return float(value)
