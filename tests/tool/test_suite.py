"""No test can pass by being empty: where every assertion is in a loop, the loop has items.

And none takes time for what it does not look at.
"""

import ast
from collections.abc import Iterator, Sequence
from typing import Any

import pytest

from crosscheck.provenance import ROOT
from crosscheck.trial import trial
from crosscheck.trial.source.code import find_code

MODULES = sorted((ROOT / "tests").rglob("test_*.py"))
WRAPPERS = {"enumerate", "pairwise", "product", "range", "reversed", "sorted", "zip"}
GUARD = "require_items"
EMPTY_LOOP = "def test_all():\n    for value in values():\n        assert value\n"
GUARDED = "def test_all():\n    for value in require_items(values()):\n        assert value\n"
BRANCH = "def test_all():\n    if happens():\n        assert happens()\n"


def unguarded_tests(source: str) -> list[str]:
    """Names of the tests of a module that may pass without a single assertion."""
    tests = [
        node
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    ]
    return [test.name for test in tests if (runs := [*assertions(test.body)]) and not any(runs)]


def assertions(body: Sequence[ast.stmt], runs: bool = True) -> Iterator[bool]:
    """Of every assertion below, whether it surely runs; of both branches, as one."""
    for node in body:
        match node:
            case ast.Assert():
                yield runs
            case ast.For():
                yield from assertions(node.body, runs and has_items(node.iter))
            case ast.If():
                branches = [[*assertions(each, runs)] for each in (node.body, node.orelse)]
                yield all(any(branch) for branch in branches)
            case ast.With():
                if any("raises" in ast.unparse(item.context_expr) for item in node.items):
                    yield runs
                yield from assertions(node.body, runs)
            case ast.Try():
                yield from assertions(node.body, runs)
            case ast.Expr(value=ast.Call(func=function)):
                if ast.unparse(function).startswith(("assert_", "np.testing", "pytest.fail")):
                    yield runs


def has_items(node: ast.expr) -> bool:
    """Whether what a loop goes over surely has items."""
    match node:
        case ast.Tuple(elts=items) | ast.List(elts=items) | ast.Set(elts=items):
            return bool(items)
        case ast.Dict(keys=keys):
            return bool(keys)
        case ast.Constant():
            return True
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return name == GUARD or (name in WRAPPERS and all(map(has_items, arguments)))
        case ast.Call(func=ast.Attribute(value=value, attr="items" | "values" | "keys")):
            return has_items(value)
    return False


@pytest.mark.parametrize("module", MODULES, ids=lambda path: path.name)
def test_every_test_asserts_something(module):
    assert unguarded_tests(module.read_text(encoding="utf-8")) == []


def test_an_empty_loop_or_branch_is_seen():
    assert unguarded_tests(EMPTY_LOOP) == unguarded_tests(BRANCH) == ["test_all"]
    assert unguarded_tests(GUARDED) == []


def test_a_trial_seeks_no_line_unless_a_test_asks_for_it(request):
    """Else each trial of wrong functions would search for up to 15 s of processor time."""
    assert trial.find_code(Any) is None
    request.getfixturevalue("source_search")
    assert trial.find_code is find_code
