"""Edits that move a statement: past a few others, behind its loop, or into the loop."""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterator

from crosscheck.trial.source.changes import SIMPLE
from crosscheck.trial.source.edit import Edit
from crosscheck.trial.source.syntax import SourceTree

MOST_PASSED = 4  # statements that one is moved past


def list_moves(tree: SourceTree, likelihood: tuple[int, int]) -> Iterator[Edit]:
    """The moves of single statements that can make a difference."""
    for node in tree.list_nodes():
        followers = _list_followers(tree, node)
        if isinstance(node, ast.For | ast.While):
            *others, last = node.body
            if others and isinstance(last, SIMPLE | ast.Return):
                text = f"{_write_loop(node, others)}\n{ast.unparse(last)}"
                yield Edit(likelihood, node, text)
            follower = followers[0] if followers else None
            if isinstance(follower, SIMPLE) and _is_order_significant(node, follower):
                text = _write_loop(node, [*node.body, follower])
                yield Edit(likelihood, node, text, (follower, "pass"))
        if isinstance(node, SIMPLE):
            yield from _list_moves_in_block(node, followers[:MOST_PASSED], likelihood)


def _list_moves_in_block(
    node: ast.stmt, followers: list[ast.stmt], likelihood: tuple[int, int]
) -> Iterator[Edit]:
    """The moves of later statements before one, and of that one behind them."""
    node_text = ast.unparse(node)
    for count, last in enumerate(followers, start=1):
        if not isinstance(last, SIMPLE):
            return
        passed, text = [node, *followers[: count - 1]], ast.unparse(last)
        if any(_is_order_significant(each, last) for each in passed):
            yield Edit(likelihood, node, f"{text}\n{node_text}", (last, "pass"))
        if count > 1 and any(_is_order_significant(node, each) for each in followers[:count]):
            yield Edit(likelihood, node, "pass", (last, f"{text}\n{node_text}"))


def _list_followers(tree: SourceTree, node: ast.AST) -> list[ast.stmt]:
    """The statements after a statement, in the same block."""
    if not isinstance(node, ast.stmt):
        return []
    parent, name, index = tree.places[id(node)]
    return [] if index is None else getattr(parent, name)[index + 1 :]


def _is_order_significant(node: ast.AST, follower: ast.stmt) -> bool:
    """Whether one of two statements stores what the other names."""
    stored, names = _list_stored(node), _list_names(node)
    return bool(stored & _list_names(follower) or _list_stored(follower) & names)


def _write_loop(loop: ast.For | ast.While, body: list[ast.stmt]) -> str:
    other = copy.copy(loop)
    other.body = body
    return ast.unparse(other)


def _list_names(node: ast.AST) -> set[str]:
    """The names that a statement reads, changes or stores."""
    return {each.id for each in ast.walk(node) if isinstance(each, ast.Name)}


def _list_stored(node: ast.AST) -> set[str]:
    """The names that a statement stores, or of which it stores an element."""
    stored = (each for each in ast.walk(node) if isinstance(getattr(each, "ctx", None), ast.Store))
    return set().union(*map(_list_names, stored))
