"""Code with many edits in it, of which a number chooses one while it runs.

Idea: an edit is compiled with the whole statement at the top that holds it, a class of a hundred
lines, which takes longer than to run it; and then the equations are made anew. So many edits share
one compilation: where `a + b` may be `a - b` stands `a - b if number == 7 else a + b`. Difficulty:
what ran while the equations were made, or is remembered from the first call, does not see another
number. Remedy: equations are made anew for each edit of a line that ran then, or runs only once.
"""

from __future__ import annotations

import ast
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from types import CodeType
from typing import Any

from crosscheck.trial.source.answer_key import Answer, AnswerKey
from crosscheck.trial.source.code import UserCode
from crosscheck.trial.source.edit import Edit
from crosscheck.trial.source.syntax import SourceTree

NUMBERS = "_crosscheck_numbers"  # name by which edited code finds the numbers that choose
COUNTER = "_crosscheck_counter"  # name by which it finds numbers that differ each time
NONE = -1  # number that chooses no edit


@dataclass(frozen=True)
class EditedCode:
    """Compiled statements with edits, and the numbers that choose one or stand in its text.

    numbers: the list that the code reads; chosen: what it must hold for this edit; shared: the
    answers of equations that are made once for several edits, empty until then; None where each
    edit needs its own.
    """

    code: UserCode
    compiled: Sequence[Any]
    chosen: Sequence[float] = ()
    numbers: list[float] = field(default_factory=list)
    shared: list[Answer] | None = None

    def bind(self, answer_key: AnswerKey) -> Answer:
        """The answers of equations made anew, each asked for once. Raises what the code raises."""
        return cache(self._bind(answer_key))

    def bind_shared(self, answer_key: AnswerKey) -> Answer:
        """The same of equations that are made once, where that is enough; of one answer key."""
        if self.shared is None:
            return self.bind(answer_key)
        self.numbers[:] = self.chosen
        if not self.shared:
            self.shared.append(self._bind(answer_key))
        return cache(self.shared[0])

    def _bind(self, answer_key: AnswerKey) -> Answer:
        self.numbers[:] = self.chosen
        compiled = self.compiled
        if answer_key.exchanged:
            compiled = [_exchange_constants(each, answer_key.exchanged) for each in compiled]
        names = {NUMBERS: self.numbers, COUNTER: itertools.count()}
        return answer_key.bind(self.code.run(compiled, names))


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

    def compile_each(self, edits: Sequence[Edit]) -> Iterator[tuple[Edit, EditedCode | None]]:
        """Each edit with the code that has it, together where possible; None if it is no Python."""
        joint = {}
        for number, edit in enumerate(edits):
            if isinstance(edit.node, ast.expr) and not edit.is_slice:
                try:
                    joint[number] = edit.parse()
                except SyntaxError:
                    continue
        together = self._compile_together(edits, joint) if len(joint) > 1 else None
        numbers, shared, unread = list[float](), list[Answer](), self.tree.unread_names
        for number, edit in enumerate(edits):
            if together is None or number not in joint:
                yield edit, self.compile([edit])
            else:
                # What nothing else reads another edit may have changed in place, and none sees it.
                is_alone = unread and not unread.isdisjoint(_list_names(joint[number]))
                sharing = shared if self.is_repeated(edit.node) and not is_alone else None
                yield edit, EditedCode(self.tree.code, together, [number], numbers, sharing)

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

    def compile_gaps(self, node: ast.expr, text: str, count: int) -> EditedCode:
        """The code with a text in place of an expression, whose gaps are numbers to be chosen.

        Raises SyntaxError.
        """
        gaps = (f"{NUMBERS}[{number}]" for number in range(count))
        edited = self.compile([Edit((0, 0), node, text.format(*gaps))])
        if edited is None:
            raise SyntaxError(text)
        shared = list[Answer]() if self.is_repeated(node) else None
        return EditedCode(edited.code, edited.compiled, [], [], shared)

    def is_repeated(self, node: ast.AST) -> bool:
        """Whether an expression runs whenever the equations are asked, and not before."""
        ran = self.tree.lines.intersection(self.tree.list_lines(node))
        return bool(ran) and ran <= self.repeated_lines

    def _compile_together(
        self, edits: Sequence[Edit], joint: dict[int, ast.expr | ast.stmt]
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
            for key, choice in choices.items():
                self.tree.put(nodes[key], choice)
            return self._compile(list(nodes.values()))
        except (SyntaxError, ValueError, TypeError):
            return None
        finally:
            for node in nodes.values():
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
