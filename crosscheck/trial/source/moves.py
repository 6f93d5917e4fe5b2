"""Edits that move a statement: before the one in front of it, behind its loop, or into the loop."""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterator

from crosscheck.trial.source.changes import SIMPLE
from crosscheck.trial.source.edit import Edit
from crosscheck.trial.source.syntax import SourceTree


def list_moves(tree: SourceTree, likelihood: tuple[int, int]) -> Iterator[Edit]:
    """The moves of single statements that can make a difference."""
    for node in tree.list_nodes():
        follower = _find_follower(tree, node)
        if isinstance(node, ast.For | ast.While):
            *others, last = node.body
            if others and isinstance(last, SIMPLE | ast.Return):
                text = f"{_write_loop(node, others)}\n{ast.unparse(last)}"
                yield Edit(likelihood, node, text)
        if not isinstance(follower, SIMPLE) or not _is_order_significant(node, follower):
            continue
        if isinstance(node, SIMPLE):
            yield Edit(likelihood, node, ast.unparse(follower), (follower, ast.unparse(node)))
        if isinstance(node, ast.For | ast.While):
            yield Edit(
                likelihood, node, _write_loop(node, [*node.body, follower]), (follower, "pass")
            )


def _find_follower(tree: SourceTree, node: ast.AST) -> ast.stmt | None:
    """The statement after a statement, in the same block."""
    if not isinstance(node, ast.stmt):
        return None
    parent, name, index = tree.places[id(node)]
    block = getattr(parent, name)
    return block[index + 1] if index is not None and index + 1 < len(block) else None


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
