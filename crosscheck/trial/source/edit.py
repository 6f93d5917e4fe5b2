"""An edit of a source: other text in the place of an expression or a statement."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Any, NamedTuple

NONE = -1  # number that chooses no edit of several


class Edit(NamedTuple):
    """An edit: other text in the place of a node, and perhaps of one more.

    likelihood: rank of its kind, 1 of the likeliest, and the kind's place among all; further: the
    other node and its text, where a statement moves; is_slice: whether the text is a slice.
    """

    likelihood: tuple[int, int]
    node: ast.expr | ast.stmt
    text: str
    further: tuple[ast.stmt, str] | None = None
    is_slice: bool = False

    @property
    def rank(self) -> int:
        """Rank of the kind."""
        return self.likelihood[0]

    def list_nodes(self) -> list[ast.AST]:
        """The nodes that it replaces."""
        return [self.node, *([self.further[0]] if self.further else [])]

    def list_replacements(self) -> Iterator[tuple[ast.AST, ast.AST]]:
        """Each node, and what stands in its place. Raises SyntaxError."""
        yield self.node, self.parse()
        if self.further is not None:
            node, text = self.further
            yield node, _parse_statements(text)

    def parse(self) -> ast.expr | ast.stmt:
        """The other node; of several statements one that holds them. Raises SyntaxError."""
        if isinstance(self.node, ast.stmt):
            return _parse_statements(self.text)
        text = f"_[{self.text}]" if self.is_slice else self.text
        other: Any = ast.parse(text, mode="eval").body
        if isinstance(getattr(self.node, "ctx", None), ast.Store):  # what a statement assigns
            other.ctx = ast.Store()
        return other.slice if self.is_slice else other


def _parse_statements(text: str) -> ast.stmt:
    body = ast.parse(text).body
    only = body[0] if len(body) == 1 else ast.If(ast.Constant(True), body, [])
    return ast.fix_missing_locations(only)
