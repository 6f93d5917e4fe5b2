"""Code with many edits in it, of which a number chooses one while it runs.

Idea: an edit is compiled with the whole statement at the top that holds it, a class of a hundred
lines, which takes longer than to run it; and then the equations are made anew. So many edits share
one compilation: where `a + b` may be `a - b` stands `a - b if number == 7 else a + b`. Difficulty:
what ran while the equations were made, or is remembered from the first call, does not see another
number. Remedy: equations are made anew for each edit of a line that ran then, or runs only once;
those that SymPy derives are made with a variation in the place of the edits.
"""

from __future__ import annotations

import ast
import itertools
import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from types import CodeType
from typing import Any

from crosscheck.trial.source.answer_key import Answer, AnswerKey
from crosscheck.trial.source.code import UserCode
from crosscheck.trial.source.derivation import Derivation
from crosscheck.trial.source.differences import Difference
from crosscheck.trial.source.edit import NONE, Edit
from crosscheck.trial.source.hooks import HOOK, call_hook, make_hook
from crosscheck.trial.source.recorder import VariedPlace
from crosscheck.trial.source.syntax import SourceTree

NUMBERS = "_crosscheck_numbers"  # name by which edited code finds the numbers that choose
COUNTER = "_crosscheck_counter"  # name by which it finds numbers that differ each time


def _call(place: int, evaluate: Callable[[], Any]) -> Any:
    return evaluate()


@dataclass(frozen=True)
class EditedCode:
    """Compiled statements with edits, and the numbers that choose one or stand in its text.

    numbers: the list that the code reads; chosen: what it must hold for this edit; shared: the
    answers of equations that are made once for several edits, empty until then; None where each
    edit needs its own; varied: those of equations with a variation that is the edit's.
    """

    code: UserCode
    compiled: Sequence[Any]
    chosen: Sequence[float] = ()
    numbers: list[float] = field(default_factory=list)
    shared: list[Answer] | None = None
    varied: Callable[[Sequence[float]], Answer] | None = None

    @property
    def is_made_anew(self) -> bool:
        """Whether equations are made for this edit alone."""
        return self.shared is None and self.varied is None

    def bind(self, answer_key: AnswerKey) -> Answer:
        """The answers of equations made anew, each asked for once. Raises what the code raises."""
        return cache(self.make_answer(answer_key))

    def bind_shared(self, answer_key: AnswerKey) -> Answer:
        """The same of equations that are made once, where that is enough; of one answer key."""
        if self.varied is not None:
            return self.varied(self.chosen)
        if self.shared is None:
            return self.bind(answer_key)
        self.numbers[:] = self.chosen
        if not self.shared:
            self.shared.append(self.make_answer(answer_key))
        return cache(self.shared[0])

    def make_answer(
        self, answer_key: AnswerKey, hook: Callable[[int, Callable[[], Any]], Any] = _call
    ) -> Answer:
        """The answers of equations made anew; hook: gets what places of a derivation evaluate."""
        self.numbers[:] = self.chosen
        compiled = self.compiled
        if answer_key.exchanged:
            compiled = [_exchange_constants(each, answer_key.exchanged) for each in compiled]
        called = partial(call_hook, hook)
        names = {NUMBERS: self.numbers, COUNTER: itertools.count(), HOOK: called}
        return answer_key.bind(self.code.run(compiled, names))


def _return_first(answer: Answer, chosen: Sequence[float]) -> Answer:
    return answer


def _list_names(node: ast.AST) -> Iterator[str]:
    return (each.id for each in ast.walk(node) if isinstance(each, ast.Name))


def list_constants(code: CodeType) -> Iterator[float]:
    """The numbers with a fraction of a code object, without their signs."""
    for each in code.co_consts:
        if isinstance(each, CodeType):
            yield from list_constants(each)
        for number in each if isinstance(each, tuple) else (each,):
            if isinstance(number, float):
                yield abs(number)


def _exchange_constants(constant: Any, numbers: Mapping[float, float]) -> Any:
    """A code object, or one of its constants, with other numbers for some."""
    if isinstance(constant, CodeType):
        constants = _exchange_constants(constant.co_consts, numbers)
        return constant.replace(co_consts=constants)
    if isinstance(constant, tuple):
        return tuple(_exchange_constants(each, numbers) for each in constant)
    if isinstance(constant, float) and abs(constant) in numbers:
        return math.copysign(numbers[abs(constant)], constant)
    return constant


class EditCompiler:
    """What compiles edits of a source: many of them together, or one.

    Args:
        tree: The source.
        compiled: The code objects of its statements as they are.
        repeated_lines: Numbers of lines that run whenever the equations are asked, and not when
            they are made.
    """

    def __init__(self, tree: SourceTree, compiled: Sequence[Any], repeated_lines: set[int]) -> None:
        self.tree, self.compiled, self.repeated_lines = tree, compiled, repeated_lines
        self.derivation: Derivation | None = None

    def compile_each(self, edits: Sequence[Edit]) -> Iterator[tuple[Edit, EditedCode | None]]:
        """Each edit with the code that has it, together where possible; None if it is no Python.

        Where equations are derived, nor if the expression has no value with it.
        """
        joint = {}
        for number, edit in enumerate(edits):
            if isinstance(edit.node, ast.expr) and not edit.is_slice:
                try:
                    joint[number] = edit.parse()
                except SyntaxError:
                    continue
        expressions = dict[int, ast.expr]()
        if self.derivation is not None:
            expressions = {
                number: place.node if (place := self.find_place(node)) else node
                for number in joint
                if isinstance(node := edits[number].node, ast.expr) and not self.is_repeated(node)
            }
        together = None
        if len(joint) > 1 or expressions:
            together = self._compile_together(edits, joint, expressions.values())
        numbers, shared, unread = list[float](), list[Answer](), self.tree.unread_names
        edited = EditedCode(self.tree.code, together or self.compiled, [NONE], numbers)
        varied = self._vary(edited, expressions) if together else None
        for number, edit in enumerate(edits):
            if together is None or number not in joint:
                yield edit, self.compile([edit])
            elif varied is not None and number in expressions:
                if number in varied:
                    yield edit, replace(edited, chosen=[number], varied=varied[number])
            else:
                # What nothing else reads another edit may have changed in place, and none sees it.
                is_alone = unread and not unread.isdisjoint(_list_names(joint[number]))
                sharing = shared if self.is_repeated(edit.node) and not is_alone else None
                yield edit, replace(edited, chosen=[number], shared=sharing)

    def scale_places(self) -> dict[int, EditedCode]:
        """The code of a derivation with each place's value scaled, by the place's identity."""
        if self.derivation is None:
            return {}
        nodes = [place.node for place in self.derivation.places.values()]
        edited = EditedCode(self.tree.code, self._compile_with({}, [], nodes))
        scaled = self.derivation.scale(edited.make_answer)
        return {
            id(place.node): replace(edited, varied=partial(_return_first, answer))
            for place, answer in scaled.items()
        }

    def find_place(self, node: ast.AST) -> VariedPlace | None:
        """Where a derivation can be varied instead of making an edit of a node."""
        if self.derivation is None or self.is_repeated(node):
            return None
        return self.derivation.find_place(node)

    def _vary(
        self, edited: EditedCode, expressions: Mapping[int, ast.expr]
    ) -> dict[int, Callable[[Sequence[float]], Answer] | None] | None:
        """The answers with each edit that changes a value; None where they are derived anew.

        edited: the code with all edits, of which none is chosen; expressions: by an edit's number,
        a place or what is changed.
        """
        if self.derivation is None or not expressions:
            return None
        choices = defaultdict[int, list[int]](list)
        for number, node in expressions.items():
            choices[id(node)].append(number)

        def choose(number: int) -> None:
            edited.numbers[:] = [number]

        differences = self.derivation.record(edited.make_answer, choices, choose)
        by_place = defaultdict[VariedPlace, dict[int, Difference]](dict)
        for number, difference in differences.items():
            if difference is not None:
                place = self.derivation.places[id(expressions[number])]
                by_place[place][number] = difference
        # Of answers that are kept, no edit of a later line may be chosen.
        varied = self.derivation.vary(by_place, replace(edited, numbers=[]).make_answer)
        return {number: varied.get(number) for number in differences}

    def compile(self, edits: Sequence[Edit]) -> EditedCode | None:
        """The code with all of some edits; None if it is no Python."""
        try:
            for edit in edits:
                self.tree.make(edit)
            return EditedCode(self.tree.code, self._compile([edit.node for edit in edits]))
        except (SyntaxError, ValueError, TypeError):
            return None
        finally:
            for edit in edits:
                self.tree.undo(edit)

    def compile_gaps(self, node: ast.expr, text: str, start: Sequence[float]) -> EditedCode:
        """The code with a text in place of an expression, whose gaps are numbers to be chosen.

        start: numbers with which it is the code as it is. Raises SyntaxError.
        """
        gaps = (f"{NUMBERS}[{number}]" for number in range(len(start)))
        edit = Edit((0, 0), node, text.format(*gaps))
        place = self.find_place(edit.node)
        if place is not None:
            return self._vary_gaps(edit, place, start)
        edited = self.compile([edit])
        if edited is None:
            raise SyntaxError(text)
        shared = list[Answer]() if self.is_repeated(node) else None
        return EditedCode(edited.code, edited.compiled, [], [], shared)

    def _vary_gaps(self, edit: Edit, place: VariedPlace, start: Sequence[float]) -> EditedCode:
        """The same of a derivation, whose variation has symbols for the numbers."""
        import sympy as sp

        assert self.derivation is not None  # as there is a place
        other = edit.parse()
        assert isinstance(other, ast.expr)  # as the text of one is
        edited = EditedCode(
            self.tree.code,
            self._compile_with({id(edit.node): other}, [edit.node], [place.node]),
            start,
        )
        symbols = [sp.Dummy() for _ in start]

        def choose(number: int) -> None:
            edited.numbers[:] = start if number == NONE else symbols

        differences = self.derivation.record(edited.make_answer, {id(place.node): [0]}, choose)
        if not differences:
            raise SyntaxError(edit.text)
        difference = differences[0]
        if difference is None:
            return edited
        varied = self.derivation.vary({place: {0: difference}}, edited.make_answer, symbols)
        return replace(edited, varied=varied[0])

    def is_repeated(self, node: ast.AST) -> bool:
        """Whether an expression runs whenever the equations are asked, and not before."""
        ran = self.tree.lines.intersection(self.tree.list_lines(node))
        return bool(ran) and ran <= self.repeated_lines

    def _compile_together(
        self,
        edits: Sequence[Edit],
        joint: dict[int, ast.expr | ast.stmt],
        hooked: Iterable[ast.expr],
    ) -> list[Any] | None:
        """The code with a choice of edits at each place; None where a choice cannot stand."""
        choices = dict[int, ast.expr]()
        nodes = {id(edits[number].node): edits[number].node for number in joint}
        for number, other in joint.items():
            node = edits[number].node
            before = choices.get(id(node), node)
            assert isinstance(other, ast.expr)  # as the text of one is
            assert isinstance(before, ast.expr)
            choices[id(node)] = ast.copy_location(
                ast.IfExp(_parse_choice(number), other, before), node
            )
        try:
            return self._compile_with(choices, list(nodes.values()), hooked)
        except (SyntaxError, ValueError, TypeError):
            return None

    def _compile_with(
        self,
        others: Mapping[int, ast.expr],
        nodes: Sequence[ast.AST],
        hooked: Iterable[ast.expr],
    ) -> list[Any]:
        """The code with others of its nodes, by their identity, and hooks around expressions."""
        around = {id(node): node for node in hooked}
        try:
            for node in nodes:
                self.tree.put(node, others[id(node)])
            for key, node in around.items():
                self.tree.put(node, make_hook(self.tree, node, others.get(key, node)))
            return self._compile([*nodes, *around.values()])
        finally:
            for node in (*nodes, *around.values()):
                self.tree.put(node, node)

    def _compile(self, changed: Sequence[ast.AST]) -> list[Any]:
        """The code objects of all statements, anew of those that hold changed nodes."""
        compiled = list(self.compiled)
        for number in {self.tree.statements[id(node)] for node in changed}:
            compiled[number] = self.tree.code.compile(self.tree.code.statements[number])
        return compiled


@cache
def _parse_choice(number: int) -> ast.expr:
    """The question whether a number is chosen; many trees share it."""
    return ast.parse(f"{NUMBERS}[0] == {number}", mode="eval").body
