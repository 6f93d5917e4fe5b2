"""Edits compiled together answer as each alone; pairs add up; walked formulas have their values."""

from itertools import combinations

import numpy as np
import pytest
import sympy as sp

from crosscheck.trial.source.edit import Edit
from crosscheck.trial.source.edited_code import EditCompiler, EditedCode
from crosscheck.trial.source.edits import list_edits
from crosscheck.trial.source.expressions import MOST_WALKS, LambdifiedExpression
from crosscheck.trial.source.pairs import list_additive_pairs
from crosscheck.trial.source.search import EditSearch
from tests.trial.source.test_source_edits import make_answer_key, write_code

REMEMBERING = """
import functools
import numpy as np

def make():
    lever = 0.7 * 1.3

    @functools.cache
    def remember(x):
        return 0.3 + x * x

    def ask(q):
        return np.array([lever * q[0] + remember(q[1]), q[0] - 2 * q[1]])

    return {"ask": ask}
"""


@pytest.fixture
def search(tmp_path):
    code = write_code(tmp_path, REMEMBERING, ("2 * q[1]", "3 * q[1]"))
    return EditSearch(code, [make_answer_key(REMEMBERING)])


def answer(search: EditSearch, edited: EditedCode | None) -> np.ndarray | None:
    """What edited code answers at a state; None if it fails."""
    try:
        assert edited is not None
        return edited.bind_shared(search.answer_keys[0])("ask", 0)
    except Exception:  # whatever an edit leads to
        return None


def test_edits_of_one_compilation_answer_as_each_alone(search):
    """Also where a number is made once, or a value is remembered from the first call."""
    edits = [
        edit for rank in (1, 2, 3) for edit in list_edits(search.tree, rank, lambda node: True)
    ]
    together = [answer(search, edited) for _, edited in search.compiler.compile_each(edits)]
    alone = [answer(search, search.compiler.compile([edit])) for edit in edits]
    for edit, value, right in zip(edits, together, alone, strict=True):
        assert (value is None) == (right is None), edit.text
        if value is not None and right is not None:
            np.testing.assert_array_equal(value, right, edit.text)
    texts = REMEMBERING.splitlines()
    edited_lines = {texts[edit.node.lineno - 1].strip()[:10] for edit in edits}
    assert edited_lines >= {"lever = 0.", "return 0.3", "return np."}


def test_equations_are_shared_by_edits_of_what_is_asked_each_time(search):
    shared = {}
    edits = list(list_edits(search.tree, 1, lambda node: True))
    for edit, edited in search.compiler.compile_each(edits):
        shared.setdefault(edit.node.lineno, set()).add(edited.shared is not None)
    text = REMEMBERING.splitlines()
    by_line = {text[line - 1].strip()[:10]: kinds for line, kinds in shared.items()}
    assert by_line["lever = 0."] == {False}
    assert by_line["return 0.3"] == {False}
    assert by_line["return np."] == {True}


def test_an_edit_that_cannot_be_chosen_among_others_is_compiled_alone(search):
    """A part of an f-string, or of a pattern, may be no choice."""
    compiler = EditCompiler(search.tree, search.judge.compiled, set())
    nodes = [edit.node for edit in list_edits(search.tree, 1, lambda node: True)]
    bad, good = Edit((1, 0), nodes[0], "1 +"), Edit((1, 0), nodes[0], "1.5")
    (_, first), (_, second) = compiler.compile_each([bad, good])
    assert first is None
    assert second is not None


def test_pairs_are_those_of_all_pairs_whose_effects_add_up():
    rng = np.random.default_rng(5)
    effects = rng.integers(-3, 4, (60, 3)) * 10.0 + rng.uniform(-0.3, 0.3, (60, 3))
    missing = np.array([20.0, -10.0, 30.0])
    every = {
        (a, b)
        for a, b in combinations(range(60), 2)
        if np.abs(effects[a] + effects[b] - missing).max() <= 1
    }
    assert len(every) > 2
    assert set(list_additive_pairs(effects, missing)) == every


x, y = sp.symbols("x y")
MATRIX = sp.Matrix([[sp.sin(x) ** 2 / 3, sp.pi * y], [sp.sqrt(x + y), -x * sp.Rational(2, 7)]])


@pytest.mark.parametrize(
    "expression",
    [[x**-2 + sp.atan2(y, x)], MATRIX, [x, MATRIX, 3 * y], [sp.Piecewise((x, x > 0), (y, True))]],
)
def test_walked_expressions_have_the_values_of_the_function_that_sympy_writes(expression):
    """The last is none that is walked; after many calls the function is written in any case."""
    write = sp.lambdify([x, [y]], expression)
    mine, other = (LambdifiedExpression(lambda: write, [x, [y]], expression, {}) for _ in range(2))
    for _ in range(MOST_WALKS + 1):
        for value, right in zip(mine(0.7, [0.4]), write(0.7, [0.4]), strict=True):
            np.testing.assert_allclose(value, right, rtol=1e-15)  # the order of sums differs
    assert mine.written is write
    with pytest.raises(TypeError):
        other(1.0)
