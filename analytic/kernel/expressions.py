"""Numbers that remember how they were made, and the straight-line text that makes them again.

An algorithm that is written for floats runs once on expressions and leaves its operations.
Python's own 0, 1 and -1 stand for numbers that belong to the structure: whatever they meet is
folded, so the rest has no operation that a zero makes needless. Equal expressions are one.
What depends on constants alone, a model's own numbers, is not in the text but worked out before.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from crosscheck.analytic.kernel.text.functions import cosine, sine
from crosscheck.analytic.kernel.text.meshes import PER_TURN

Number = Any  # an Expression, or any number of Python
OPERATORS: Mapping[str, Callable[[Number, Number], Number]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
}
COMMUTATIVE = ("+", "*")
FUNCTIONS = {"cos": cosine, "sin": sine}
NAME, LITERAL, NEGATIVE = "name", "literal", "negative"


class ExpressionGraph:
    """All expressions that were made together; equal ones are one."""

    def __init__(self) -> None:
        self._expressions: dict[object, Expression] = {}

    def variable(self, name: str) -> Expression:
        """The number of a state that text calls by this name."""
        return self.make(NAME, (), False, name)

    def constant(self, name: str) -> Expression:
        """The number of a model that is called by this name."""
        return self.make(NAME, (), True, name)

    def cos_and_sin(self, angle: Number) -> tuple[Expression, Expression]:
        """Cosine and sine of an angle [rad] that depends on the state."""
        return self.make("cos", (angle,), False), self.make("sin", (angle,), False)

    def make(
        self, operation: str, operands: tuple[Expression, ...], is_constant: bool, value: object = 0
    ) -> Expression:
        """The expression of an operation, made at its first call."""
        if operation in COMMUTATIVE:
            operands = tuple(sorted(operands, key=lambda each: each.place))
        key = operation, value, tuple(each.place for each in operands)
        if key not in self._expressions:
            place = len(self._expressions)
            self._expressions[key] = Expression(
                self, place, operation, operands, is_constant, value
            )
        return self._expressions[key]


@dataclass(frozen=True, eq=False, slots=True)
class Expression:
    """A number by the operation that makes it of others.

    place: in the order in which expressions were made; is_constant: no state is in it; value: of a
    name or a literal.
    """

    graph: ExpressionGraph
    place: int
    operation: str
    operands: tuple[Expression, ...]
    is_constant: bool
    value: Any

    def _of(self, other: Number) -> Expression:
        if isinstance(other, Expression):
            return other
        return self.graph.make(LITERAL, (), True, other)

    def _with(self, operation: str, left: Number, right: Number) -> Expression:
        operands = self._of(left), self._of(right)
        return self.graph.make(operation, operands, all(each.is_constant for each in operands))

    def __neg__(self) -> Number:
        if self.operation == NEGATIVE:
            return self.operands[0]
        if self.operation == "-":
            return self.operands[1] - self.operands[0]
        return self.graph.make(NEGATIVE, (self,), self.is_constant)

    def __add__(self, other: Number) -> Number:
        if _is_number(other, 0):
            return self
        if _is_negative(other):
            return self - other.operands[0]
        if _is_negative(self):
            return other - self.operands[0]
        return self._with("+", self, other)

    __radd__ = __add__

    def __sub__(self, other: Number) -> Number:
        if _is_number(other, 0):
            return self
        if other is self:
            return 0
        if _is_negative(other):
            return self + other.operands[0]
        return self._with("-", self, other)

    def __rsub__(self, other: Number) -> Number:
        return -self if _is_number(other, 0) else self._with("-", other, self)

    def __mul__(self, other: Number) -> Number:
        if _is_number(other, 0):
            return 0
        if _is_number(other, 1):
            return self
        if _is_number(other, -1):
            return -self
        for one, factor in ((self, other), (other, self)):
            if _is_negative(one):
                return -(one.operands[0] * factor)
        return self._with("*", self, other)

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> Number:
        return self._with("/", self, other)

    def __rtruediv__(self, other: Number) -> Number:
        return 0 if _is_number(other, 0) else self._with("/", other, self)


def _is_number(value: Number, number: int) -> bool:
    return not isinstance(value, Expression) and bool(value == number)


def _is_negative(value: Number) -> bool:
    return isinstance(value, Expression) and value.operation == NEGATIVE


class StraightLines(NamedTuple):
    """Text of an algorithm: its lines, and the constants by the names that it has for them."""

    lines: tuple[str, ...]
    constants: Mapping[str, Expression]


def write_lines(results: Mapping[str, Number]) -> StraightLines:
    """Text that sets every result, by its name, from variables and constants.

    A product that one sum alone asks for stands in it, where it can be fused.
    """
    needed = _list_needed(results.values())
    uses = Counter(each for it in needed if not it.is_constant for each in it.operands)
    writer = _Writer(uses)
    lines = [line for expression in needed for line in writer.lines(expression)]
    lines += [f"{name} = {writer.text(value)}" for name, value in results.items()]
    return StraightLines(tuple(lines), writer.constants)


def _list_needed(results: Any) -> list[Expression]:
    """Parts that results need besides parts of constants, in the order of their making."""
    result: dict[Expression, None] = {}
    left = [value for value in results if isinstance(value, Expression)]
    while left:
        expression = left.pop()
        if expression not in result:
            result[expression] = None
            left.extend(() if expression.is_constant else expression.operands)
    return sorted(result, key=lambda each: each.place)


class _Writer:
    """Text of expressions, each with the number of its uses."""

    def __init__(self, uses: Mapping[Expression, int]) -> None:
        self._uses = uses
        self.constants: dict[str, Expression] = {}

    def lines(self, expression: Expression) -> Iterator[str]:
        """Lines that set an expression's own name, if it has one."""
        operation = expression.operation
        if expression.is_constant or operation == NAME or self._is_within_sum(expression):
            return
        name, operands = _name(expression), [self.text(each) for each in expression.operands]
        if operation in FUNCTIONS:
            yield from FUNCTIONS[operation](name, f"{operands[0]} * {PER_TURN}")
        elif operation == NEGATIVE:
            yield f"{name} = -{operands[0]}"
        else:
            yield f"{name} = {operands[0]} {operation} {operands[1]}"

    def text(self, value: Number) -> str:
        """A value as it stands in a line."""
        if not isinstance(value, Expression):
            return repr(float(value))
        if value.operation == LITERAL:
            return repr(float(value.value))
        if value.is_constant:
            self.constants[_name(value)] = value
        if value.is_constant or not self._is_within_sum(value):
            return _name(value)
        left, right = (self.text(each) for each in value.operands)
        return f"({left} * {right})"

    def _is_within_sum(self, expression: Expression) -> bool:
        return expression.operation == "*" and self._uses[expression] == 1


def _name(expression: Expression) -> str:
    if expression.operation == NAME:
        return str(expression.value)
    return f"{'n' if expression.is_constant else 'e'}{expression.place}"


def evaluate_constants(
    constants: Mapping[str, Expression], numbers: Mapping[str, Number]
) -> dict[str, Number]:
    """Values of constants by name, of numbers by name: floats, arrays of them, or exact ones."""
    values: dict[Expression, Number] = {}

    def value_of(expression: Expression) -> Number:
        if expression not in values:
            values[expression] = compute(expression)
        return values[expression]

    def compute(expression: Expression) -> Number:
        if expression.operation == NAME:
            return numbers[expression.value]
        if expression.operation == LITERAL:
            return expression.value
        operands = [value_of(each) for each in expression.operands]
        if expression.operation == NEGATIVE:
            return -operands[0]
        return OPERATORS[expression.operation](*operands)

    return {name: value_of(expression) for name, expression in constants.items()}
