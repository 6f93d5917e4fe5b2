"""New text of a source, written as its author writes: the same numbers, blanks at operators."""

from __future__ import annotations

import io
import tokenize
from ast import literal_eval
from collections import Counter, defaultdict
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

OPERATORS = frozenset("+-*/@,") | {"**"}
BEFORE, AFTER = "before", "after"  # where blanks are


class Token(NamedTuple):
    """A token of an expression, with its place; operator: the one that it is between two values."""

    text: str
    is_number: bool
    operator: str
    line: int
    begin: int
    end: int


def imitate(text: str, model: str) -> str:
    """An expression on one line, in the style of the source around it.

    Numbers that stand there too are spelled as there, and operators have as many blanks around them
    as they have there most often.
    """
    numbers = {literal_eval(each.text): each.text for each in _list_tokens(model) if each.is_number}
    habits = defaultdict[tuple[str, str], Counter[int]](Counter)
    for left, right in pairwise(_list_tokens(model)):
        if left.line == right.line:
            for habit in _list_habits(left, right):
                habits[habit][right.begin - left.end] += 1
    tokens = list(_list_tokens(text))
    written = ""
    for token, following in zip(tokens, [*tokens[1:], None], strict=True):
        has_spelling = token.is_number and literal_eval(token.text) in numbers
        written += numbers[literal_eval(token.text)] if has_spelling else token.text
        if following is not None:
            blanks = following.begin - token.end
            for habit in _list_habits(token, following):
                blanks = habits[habit].most_common(1)[0][0] if habits[habit] else blanks
            written += " " * blanks
    return written[1:-1]


def _list_habits(left: Token, right: Token) -> Iterator[tuple[str, str]]:
    """What the blanks between two tokens depend on."""
    if right.operator and right.operator != ",":
        yield right.operator, BEFORE
    if left.operator:
        yield left.operator, AFTER


def _list_tokens(text: str) -> Iterator[Token]:
    """The tokens of an expression in parentheses, up to where one that is no whole ends."""
    is_value = False  # whether a value ends here, so that what follows is no sign
    try:
        for each in tokenize.generate_tokens(io.StringIO(f"({text})").readline):
            if each.string.strip() and each.type != tokenize.COMMENT:
                operator = each.string * (is_value and each.string in OPERATORS)
                is_value = each.string in tuple(")]}") or each.type != tokenize.OP
                is_number = each.type == tokenize.NUMBER
                (line, begin), (_, end) = each.start, each.end
                yield Token(each.string, is_number, operator, line, begin, end)
    except (tokenize.TokenError, IndentationError):
        return
