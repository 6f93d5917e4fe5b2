"""Calls that a user's code makes with its expressions while it runs, in their places.

Whoever runs the code sees each value, and may put another one in its place.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

from crosscheck.trial.source.syntax import SourceTree

HOOK = "_crosscheck_hook"  # name by which the code finds what is called with its expressions
Thunk = Callable[[], Any]
Hook = Callable[[int, Thunk], Any]  # called with an expression's identity, and what evaluates it


def make_hook(tree: SourceTree, place: ast.expr, node: ast.expr) -> ast.expr:
    """A call of the hook for a place, with what stands there now; and whose method it is."""
    owner = find_keeper(tree, place)
    nodes = [node] if owner is None else [node, owner]
    thunks = [ast.Lambda(ast.arguments([], [], None, [], [], None, []), each) for each in nodes]
    call = ast.Call(ast.Name(HOOK, ast.Load()), [ast.Constant(id(place)), *thunks], [])
    return ast.fix_missing_locations(ast.copy_location(call, place))


def find_keeper(tree: SourceTree, node: ast.AST) -> ast.expr | None:
    """The object of whose method a call is, where nobody else takes what that returns.

    So a point keeps its velocity: ``point.v2pt_theory(other, world, frame)``.
    """
    if not isinstance(tree.parent(node), ast.Expr):
        return None
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
        return node.func.value
    return None


def call_hook(hook: Hook, key: int, evaluate: Thunk, find_owner: Thunk | None = None) -> Any:
    """What a hook returns; an object whose method was called keeps that for what it returned."""
    if find_owner is None:
        return hook(key, evaluate)
    state = getattr(find_owner(), "__dict__", {})
    dictionaries = [each for each in state.values() if isinstance(each, dict)]
    before, values = [dict(each) for each in dictionaries], list[Any]()

    def evaluate_here() -> Any:
        values.append(evaluate())
        return values[-1]

    value = hook(key, evaluate_here)
    if len(values) > 1:  # with edits, of which the object keeps nothing
        for dictionary, each in zip(dictionaries, before, strict=True):
            dictionary.clear()
            dictionary.update(each)
        return evaluate()
    for dictionary in dictionaries:
        dictionary.update({name: value for name in dictionary if dictionary[name] is values[0]})
    return value
