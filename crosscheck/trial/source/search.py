"""Smallest edits of a user's source that make all parts right: which are tried, in what order.

Idea: wrong equations are mostly one expression away from right ones. So expressions are replaced
one at a time by what somebody may have meant, and each edited source is judged as the user's own:
by the right values of its parts. Difficulty: there are tens of thousands of such edits, and where
numbers are equal (a length of 1 m, a zero offset) wrong edits fit by chance. Remedy: the likely
kinds come first, and the search ends with the rank that has an answer; a part that is wrong is
asked at one state before all else is asked; and what fits must fit at all states and on another
mechanism of the same structure, whose numbers are unequal. Where an edit mends much, but not all,
it is made, and the search begins once more.
"""

from __future__ import annotations

import ast
import copy
import sys
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, cached_property, partial
from itertools import combinations, islice
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from crosscheck.trial.source.answer_key import EQUAL, USUAL_FACTORS, Answer, AnswerKey
from crosscheck.trial.source.changes import is_fraction
from crosscheck.trial.source.code import UserCode
from crosscheck.trial.source.derivation import Derivation, Run
from crosscheck.trial.source.edit import NONE, Edit
from crosscheck.trial.source.edited_code import COUNTER, EditCompiler, EditedCode
from crosscheck.trial.source.edits import ADDING_RANK, KINDS, RANKS, list_edits
from crosscheck.trial.source.judge import EditVerdict, Response, SourceJudge, Wrong
from crosscheck.trial.source.pairs import list_additive_pairs
from crosscheck.trial.source.site import Site, write_operand
from crosscheck.trial.source.solving import (
    is_round,
    list_equal_products,
    read_literals,
    solve_numbers,
    write_number,
)
from crosscheck.trial.source.source_edit import SourceAnswer, SourceEdit, describe_edit
from crosscheck.trial.source.syntax import LEAF, NUMBER, SourceTree, list_run_lines

BUDGET_S = 15.0  # [s] of processor time, of a whole search
# [s] of that of code that derives equations, whose edits take longer, with that of some
# derivations; and the most.
DERIVING_BUDGET_S, DERIVATIONS, LONGEST_BUDGET_S = 40.0, 20, 60.0
DERIVING_S = 0.005  # [s] of processor time, that making equations takes if they are derived
# Ranks of edits with numbers that are solved for.
LITERAL_RANK, VECTOR_RANK, SUMMAND_RANK, STATED_RANK = 2, 3, ADDING_RANK, RANKS[-1]
# Digits of numbers as people write them: in place of a number of the file, and of any other.
FEW_DIGITS, MANY_DIGITS = 3, 6
LARGEST_RATIO = 3e3  # of a number and the one that was meant: a thousand, or degrees
MOVED = "({} * 1.37 + 0.11)"  # a value that is another one, whatever it is
MOVED_UNLIKE = f"({{}} * (1.37 + next({COUNTER}) % 7) + 0.11)"  # another one each time
MOVING = Response(moves_wrong=True, moves_all_wrong=True, moves_right=True)
MOST_ALTERNATIVES = 2
MOST_PAIRS = 60  # pairs with the right sum that are judged
PAIRS_S = 4.0  # [s] of processor time, of their judging
MOST_COMPILED = 64  # edits that share a compilation
MOST_VARIED = 512  # those of a derivation, whose differences are worked out in one run
# Share of the budget, after each rank of likely edits, of those that are derived anew.
DEFERRED_SHARE = 1 / 8
MOST_INCOMPLETE = 12  # edits that mend some entries, of which pairs are tried


class MendingEdit(NamedTuple):
    """An edit that mends entries at a level and makes none wrong; wrong: those that stay so."""

    edit: Edit
    level: str
    wrong: Wrong

    @property
    def is_right_here(self) -> bool:
        """Whether all is right on the user's own mechanism, whose answer key is the first."""
        return all(number for number, _ in self.wrong)

    @property
    def badness(self) -> tuple[int, tuple[int, int]]:
        """By which the best comes first: how much stays wrong, how unlikely the edit is."""
        return len(self.wrong), self.edit.likelihood


class MendingPair(NamedTuple):
    """Two edits that together make all right, beside a level."""

    edits: Sequence[Edit]
    level: str


class EditEffect(NamedTuple):
    """What the first wrong part is at one state with an edit."""

    edit: Edit
    values: np.ndarray


class EditSearch:
    """The search of one source for edits that make it right, rank by rank.

    It is made in a worker that is confined. Raises whatever the code raises as it is.

    Args:
        code: The source.
        answer_keys: What it must answer.
    """

    def __init__(self, code: UserCode, answer_keys: Sequence[AnswerKey]) -> None:
        self.begun_s = time.process_time()
        self.answer_keys = answer_keys
        self.code, self.judge, self.tree = code, SourceJudge(code, answer_keys), SourceTree(code)
        self.texts = {(each.lineno, ast.unparse(each)) for each in self.tree.list_statements()}
        self.mending, self.effects = list[MendingEdit](), list[EditEffect]()
        self.pairs = set[frozenset[int]]()  # of edits, by identity, that are judged together
        self.budget_s = BUDGET_S
        if (making_s := self.judge.making_s) > DERIVING_S:
            self.budget_s = min(DERIVING_BUDGET_S + DERIVATIONS * making_s, LONGEST_BUDGET_S)
        self.deferred = deque[tuple[Edit, EditedCode]]()
        self.compiler = EditCompiler(self.tree, self.judge.compiled, self._observe())
        self.compiler.derivation = self._find_derivation()
        is_quick = self.compiler.derivation is not None or not self.judge.is_slow
        self.responses = self._measure_responses() if is_quick else {}

    def _observe(self) -> set[int]:
        """See what runs and what names are meanwhile: lines that run whenever parts are asked."""
        judge, answers = self.judge, list[Answer]()
        made, _ = self.tree.observe(
            lambda: answers.append(judge.bind()), lambda: judge.ask(answers[0])
        )
        if judge.is_slow:
            return set()
        return list_run_lines(self.code.file, lambda: judge.ask(answers[0])) - made

    def _find_derivation(self) -> Derivation | None:
        """The derivation by SymPy in which edits are judged; None without any that takes long."""
        if self.judge.making_s < DERIVING_S or sys.modules.get("sympy") is None:
            return None

        def compile_tree() -> Run:
            compiled = [self.code.compile(each) for each in self.code.statements]
            return EditedCode(self.code, compiled, [NONE]).make_answer

        try:
            derivation = Derivation(
                self.tree,
                self.answer_keys[0],
                self.judge.making_s,
                compile_tree,
                self.judge.is_as_is,
            )
        except Exception:  # whatever the code raises where its expressions are seen
            return None
        is_symbolic = any(not place.is_number for place in derivation.places.values())
        return derivation if is_symbolic else None

    @property
    def answers(self) -> list[MendingEdit]:
        """The edits that make all right at the trial's level, the likeliest first."""
        return [each for each in self._list_right() if each.level == self.judge.level]

    def _list_right(self) -> list[MendingEdit]:
        """The edits that make all right, at any level, the likeliest first.

        Of a rank those in the least words: more of them mend by chance, or say the same.
        """

        def rate(each: MendingEdit) -> tuple[int, int, int]:
            return each.edit.rank, self._count_new_names(each.edit), each.edit.likelihood[1]

        return sorted((each for each in self.mending if not each.wrong), key=rate)

    @property
    def is_late(self) -> bool:
        """Whether there is no time left."""
        return time.process_time() - self.begun_s > self.budget_s

    @property
    def is_spent(self) -> bool:
        """Whether there is nothing to mend, or no time left."""
        return not self.judge.states or self.is_late

    def try_rank(self, rank: int, *, is_likely: bool) -> None:
        """Try the edits of a rank where one can mend all that is wrong, or where none is likely to.

        Numbers are solved for with the latter, within the budget.
        """
        if not self.judge.states:
            return
        begun_s = time.process_time()
        edits = list_edits(
            self.tree, rank, lambda node: self._is_promising(node, rank) == is_likely
        )
        self._judge_edits(
            edit
            for edit in edits
            if not self._is_stated(edit.node) or ast.unparse(edit.node) in edit.text
        )
        if rank == RANKS[0] and is_likely:
            self._judge_edits(self._list_file_numbers())
        is_last = (rank, is_likely) == (RANKS[-1], False)
        needed_s = time.process_time() - begun_s
        share_s = self.budget_s * DEFERRED_SHARE if is_likely else 0.0
        self._judge_deferred(self.budget_s if is_last else max(needed_s, share_s))
        if rank == LITERAL_RANK and not is_likely:
            self._judge_edits(self._list_file_numbers(are_stated=True))
        solved: dict[int, Callable[[], Iterator[Edit]]] = {
            LITERAL_RANK: partial(self._solve_literals, LITERAL_RANK),
            VECTOR_RANK: partial(self._solve_literals, VECTOR_RANK),
            SUMMAND_RANK: self._solve_summands,
            STATED_RANK: partial(self._solve_literals, STATED_RANK),
        }
        if rank in solved and not is_likely and not self.answers:
            self._judge_edits(solved[rank]())

    def _judge_deferred(self, seconds: float) -> None:
        """Judge edits for which equations are derived anew, as long as there is processor time.

        Of a rank other names come first: a frame, a point or an axis.
        """
        last_s = time.process_time() + seconds
        self.deferred = deque(sorted(self.deferred, key=_rate_deferred))
        while self.deferred and not self.is_late and time.process_time() < last_s:
            self._judge_compiled([self.deferred.popleft()])

    def _is_stated(self, node: ast.AST) -> bool:
        """Whether it is a number as the file states it, which is right unless nothing else is."""
        value = node.value if isinstance(node, ast.Constant) else None
        return isinstance(value, int | float) and self._is_number_stated(node, value)

    def _is_number_stated(self, node: ast.AST, number: float) -> bool:
        """Whether the file states a number of a node, which in formulas may be a factor."""
        key = self.answer_keys[0]
        return key.has_number(number) if self.tree.is_datum(node) else key.is_stated(number)

    def _is_promising(self, node: ast.AST, rank: int) -> bool | None:
        """Whether an edit of a node may mend all that is wrong and leave the rest as it is.

        None where it changes nothing that is wrong. An edit of a rank that adds a summand may add 0
        wherever the rest is right. Statements may bring anything in, and slow code is not measured:
        both may mend all.
        """
        is_formula = not self.tree.is_datum(node)  # where people err more often
        above: ast.AST | None = node
        while isinstance(above, ast.expr | ast.Slice) and self.responses:
            response = self.responses.get(id(above))
            if response is not None:
                is_harmless = rank >= ADDING_RANK or not response.moves_right
                is_clean = response.moves_all_wrong and is_harmless
                return is_clean and is_formula if response.moves_wrong else None
            above = self.tree.parent(above)
        return is_formula

    def _measure_responses(self) -> dict[int, Response]:
        """What moves with the values of expressions, by their identity, where that can be seen.

        What moves alike in two calls may cancel, though an edit might make it unlike: if nothing
        moves, each evaluation has another value. What stands in a place of a derivation that moves
        nothing wrong, or what is right, needs no look. Where places cannot be looked at together,
        nothing is: each derivation would take too long.
        """
        places = dict[int, Response]()
        for key, scaled in self.compiler.scale_places().items():
            with suppress(BaseException):  # whatever another value leads to
                places[key] = self.judge.measure_response(scaled)
        if self.compiler.derivation is not None and not places:
            return {}
        idle = {key for key, each in places.items() if each.moves_right or not each.moves_wrong}
        nodes = [
            node
            for node in self.tree.list_nodes()
            if isinstance(node, ast.expr)
            and Site(self.tree, node).is_value
            and not ((place := self.compiler.find_place(node)) and id(place.node) in idle)
        ]
        responses = places | self._move(nodes, MOVED)
        still = [node for node in nodes if not responses.get(id(node), MOVING).moves_wrong]
        unlike = self._move(still, MOVED_UNLIKE)
        return responses | {key: each for key, each in unlike.items() if each.moves_wrong}

    def _move(self, nodes: Iterable[ast.expr], text: str) -> dict[int, Response]:
        """What moves with expressions, each in a text that makes another value of it."""
        responses = dict[int, Response]()
        moved = (Edit((0, 0), node, text.format(write_operand(node))) for node in nodes)
        for edit, edited in self._compile_batches(moved):
            is_long = self.judge.is_slow or self.compiler.derivation is not None
            if is_long and edited.is_made_anew:
                continue
            try:
                responses[id(edit.node)] = self.judge.measure_response(edited)
            except BaseException:  # whatever another value leads to
                continue
        return responses

    def _compile_batches(self, edits: Iterable[Edit]) -> Iterator[tuple[Edit, EditedCode]]:
        """Edits with the code that has them, as long as there is time.

        Those that share equations come once more, each with its own, if one of them has changed
        what these are made of: a list or an array that it takes for one of its own.
        """
        remaining = iter(edits)
        is_derived = self.compiler.derivation is not None
        while batch := list(islice(remaining, MOST_VARIED if is_derived else MOST_COMPILED)):
            compiled = list(self.compiler.compile_each(batch))
            yield from self._list_in_time(compiled)
            sharing = [(edit, each) for edit, each in compiled if each and each.shared]
            if sharing and not self.judge.is_intact(sharing[0][1]):
                alone = [(edit, replace(each, shared=None)) for edit, each in sharing]
                yield from self._list_in_time(alone)

    def _list_in_time(
        self, compiled: Iterable[tuple[Edit, EditedCode | None]]
    ) -> Iterator[tuple[Edit, EditedCode]]:
        for edit, edited in compiled:
            if self.is_spent:
                return
            if edited is not None:
                yield edit, edited

    def _solve_literals(self, rank: int) -> Iterator[Edit]:
        """Numbers of the code, or vectors of them, that others in their place make right.

        Those that the file states come last: others would make up for a term that is lost. Where
        names are given numbers, these are copied from the file, and at most mistaken for another.
        """
        for node, site in self._list_sites():
            text, start = read_literals(site) or ("", [])
            is_stated = partial(self._is_number_stated, node)
            usual_rank = VECTOR_RANK if len(start) > 1 else LITERAL_RANK
            are_stated = bool(start) and all(map(is_stated, start))
            is_sought = start and rank == (STATED_RANK if are_stated else usual_rank)
            is_sought = is_sought and not (are_stated and site.is_datum)
            for values in self._solve(node, text, start) if is_sought else ():
                digits = FEW_DIGITS if rank == STATED_RANK else MANY_DIGITS
                if _are_likely(start, values, digits, is_stated):
                    yield Edit((rank, len(KINDS)), node, text.format(*map(write_number, values)))

    def _list_file_numbers(self, *, are_stated: bool = False) -> Iterator[Edit]:
        """Numbers of the file for numbers of the code that are none, nor factors.

        are_stated: for those that are, but of something else, where names are given numbers.
        """
        rank = LITERAL_RANK if are_stated else RANKS[0]
        numbers = sorted({abs(number) for number in self.answer_keys[0].numbers if number})
        for node, site in self._list_sites():
            if not is_fraction(site) or (are_stated and not site.is_datum):
                continue
            value = ast.literal_eval(node)
            if (value in numbers) == are_stated and value not in USUAL_FACTORS:
                for number in numbers:
                    if number != value and 1 / LARGEST_RATIO < value / number < LARGEST_RATIO:
                        yield Edit((rank, len(KINDS)), node, repr(number))

    def _solve_summands(self) -> Iterator[Edit]:
        """Sums that lack the same number at every state, or the same times a name of the function.

        The number is a product of what can be named there; times a rate it is friction. On one
        mechanism alone nothing tells a product from others that are as large: the shortest are
        taken.
        """
        are_shortest = not self.judge.is_unequal
        for node, site in self._list_sites():
            for factor in _list_factors(site):
                text = f"{write_operand(node)} + {{}}{factor}"
                for (value,) in self._solve(node, text, [0.0]):
                    for product in list_equal_products(site, value, are_shortest=are_shortest):
                        summand = f"{site.text} {product}{factor}"
                        yield Edit((SUMMAND_RANK, len(KINDS)), node, summand)

    def _list_sites(self) -> Iterator[tuple[ast.expr, Site]]:
        """The expressions, as long as there is time."""
        for node in list(self.tree.list_nodes()):
            if isinstance(node, ast.expr) and not self.is_spent:
                yield node, Site(self.tree, node)

    def _solve(self, node: ast.expr, text: str, start: Sequence[float]) -> list[list[float]]:
        """The numbers that make the wrong parts right, all or one, in a text.

        One is solved for at one state, where several may not be determined.
        """
        count, everywhere = len(self.judge.states), len(start) > 1

        @cache
        def compute_residuals(values: tuple[float, ...]) -> list[np.ndarray]:
            chosen = replace(edited, chosen=values)
            return self.judge.compute_residuals(chosen, everywhere=everywhere)

        def solve_parts(parts: Sequence[int]) -> np.ndarray | None:
            def compute_residual(values: np.ndarray) -> np.ndarray:
                residuals = compute_residuals(tuple(values.tolist()))
                return np.concatenate([residuals[part] for part in parts])

            return solve_numbers(compute_residual, np.array(start))

        try:
            edited = self.compiler.compile_gaps(node, text, start)
            whole = solve_parts(range(count))
            is_open = whole is None and count > 1
            singles = [solve_parts([part]) for part in range(count)] if is_open else []
        except BaseException:  # whatever a number leads to, it is none that mends
            return []
        return [values.tolist() for values in (whole, *singles) if values is not None]

    def _judge_edits(self, edits: Iterable[Edit]) -> None:
        """Judge edits and keep those that mend anything."""
        self._judge_compiled(self._defer(self._compile_batches(edits)))

    def _defer(
        self, compiled: Iterable[tuple[Edit, EditedCode]]
    ) -> Iterator[tuple[Edit, EditedCode]]:
        """The edits of a derivation that need no derivation of their own: the others come later."""
        for edit, edited in compiled:
            if self.compiler.derivation is not None and edited.is_made_anew:
                self.deferred.append((edit, edited))
            else:
                yield edit, edited

    def _judge_compiled(self, compiled: Iterable[tuple[Edit, EditedCode]]) -> None:
        for edit, edited in compiled:
            verdict = self._judge(edited)
            if verdict is None:
                continue
            self.effects.append(EditEffect(edit, verdict.values))
            mending = _choose_level(edit, verdict)
            if mending is None or not self._is_new(edit):
                continue
            # Where the code takes its numbers from the mechanism, what fits this alone is chance.
            if not (self.judge.is_certain and mending.wrong and mending.is_right_here):
                self.mending.append(mending)

    def _judge(self, edited: EditedCode) -> EditVerdict | None:
        """What edited code mends; None if it fails."""
        try:
            return self.judge.judge(edited)
        except BaseException:  # whatever an edit leads to, it is none that mends
            return None

    def _judge_pair(self, edits: Sequence[Edit]) -> MendingEdit | None:
        """Judge edits that are made together; the first one stands for them."""
        edited = self.compiler.compile(edits)
        verdict = None if edited is None else self._judge(edited)
        return None if verdict is None else _choose_level(edits[0], verdict)

    def _is_new(self, edit: Edit) -> bool:
        """Whether no other edit has made the same text of the statement."""
        statement, count = self.tree.statement(edit.node), len(self.texts)
        self.tree.make(edit)
        text = edit.text if statement is edit.node else ast.unparse(statement)
        self.tree.undo(edit)
        self.texts.add((statement.lineno, text))
        return len(self.texts) > count

    def _find_pair(self) -> list[MendingEdit]:
        """Two edits that together make all right, each of which mends what the other does not."""
        last_s = time.process_time() + PAIRS_S
        for pair in combinations(sorted(self.mending, key=get_badness)[:MOST_INCOMPLETE], 2):
            if time.process_time() > last_s:
                return []
            statements = {id(self.tree.statement(each.edit.node)) for each in pair}
            are_disjoint = len(statements) > 1 and not pair[0].wrong & pair[1].wrong
            key = frozenset(id(each.edit) for each in pair)
            if are_disjoint and key not in self.pairs:  # which are asked for after each rank
                self.pairs.add(key)
                both = self._judge_pair([each.edit for each in pair])
                if both is not None and not both.wrong:
                    return sorted(pair, key=lambda each: each.edit.node.lineno)
        return []

    def _list_equivalents(self, pair: Sequence[MendingEdit]) -> list[MendingEdit]:
        """Edits of the same statement that mend what one of a pair mends, the likeliest first."""
        firsts = {(id(self.tree.statement(each.edit.node)), each.wrong): each for each in pair}
        others = (
            each
            for each in sorted(self.mending, key=get_badness)
            if each not in pair
            and (first := firsts.get((id(self.tree.statement(each.edit.node)), each.wrong)))
            and self._is_as_plain(each, first)
        )
        return list(islice(others, MOST_ALTERNATIVES))

    def _is_as_plain(self, other: MendingEdit, first: MendingEdit) -> bool:
        """Whether an edit needs no more names than another one, and does not negate a sum.

        Who writes more for the same says nothing else, and where a sum may have the other sign, the
        sign makes no difference.
        """
        is_negated = other.edit.text.startswith("-(")
        growth, usual = (self._count_new_names(each.edit) for each in (other, first))
        return growth <= max(usual, 0) and not is_negated

    def _count_new_names(self, edit: Edit) -> int:
        """How many more names there are with an edit."""

        def count_names(node: ast.AST) -> int:
            return sum(isinstance(each, ast.Name) for each in ast.walk(node))

        return count_names(edit.parse()) - count_names(edit.node)

    @cached_property
    def pair(self) -> MendingPair | None:
        """Two edits that make all right and whose effects add up; None without any."""
        last_s = time.process_time() + PAIRS_S
        for edits in islice(self._list_additive_pairs(), MOST_PAIRS):
            mending = self._judge_pair(edits)
            if mending is not None and not mending.wrong:
                return MendingPair(edits, mending.level)
            if time.process_time() > last_s:
                return None
        return None

    def _list_additive_pairs(self) -> Iterator[Sequence[Edit]]:
        """Edits of two statements whose effects make the first wrong part right, likely ones first.

        That is at one state, beside any level.
        """
        judge = self.judge
        effects = [each for each in self.effects if (each.values != judge.first_value).any()]
        pairs = set[tuple[int, int]]()
        for missing, allowed in judge.measure_distances() if effects else ():
            moved = [((each.values - judge.first_value) / allowed).ravel() for each in effects]
            pairs |= set(list_additive_pairs(np.array(moved), missing.ravel()))
        edits = [[effects[number].edit for number in pair] for pair in pairs]
        for both in sorted(edits, key=lambda both: sorted(each.likelihood for each in both)[::-1]):
            if len({id(self.tree.statement(edit.node)) for edit in both}) > 1:
                yield sorted(both, key=lambda edit: edit.node.lineno)

    def find_pair_answer(self) -> SourceAnswer | None:
        """The answer of two edits whose effects add up; None without any."""
        if self.pair is None:
            return None
        edits, level = self.pair
        described = tuple(self._describe_edit(edit, ()) for edit in edits)
        level = "" if level == self.judge.level else level
        return SourceAnswer(described, level=level, is_unequal=self.judge.is_unequal)

    def find_answer(self) -> SourceAnswer | None:
        """The answer so far; None where no edit mends anything that says much."""
        is_unequal = self.judge.is_unequal
        # Equations of another level are right without a rotor, but somebody meant to have it.
        if edits := self.answers or self._list_right():
            # On unequal numbers all right edits of a statement say the same.
            edits = self._select_by_statement(edits) if is_unequal else edits
            return self._make_answer(edits, is_unequal)
        if pair := self._find_pair():
            others = [] if is_unequal else self._list_equivalents(pair)
            described, alternatives = (tuple(map(self._describe, each)) for each in (pair, others))
            return SourceAnswer(described, alternatives, is_unequal=is_unequal)
        right_here = [each for each in self.mending if each.is_right_here]
        telling = right_here or [each for each in self.mending if self._mends_much(each)]
        best = sorted(telling, key=get_badness)[: None if right_here else 1]
        return self._make_answer(best, is_unequal and not right_here)

    @cached_property
    def second(self) -> tuple[SourceEdit, EditSearch] | None:
        """The edit that mends most, but not all, and the search of the code with it.

        That is at the level at which the edit mends: two errors may hide which one that is.
        """
        incomplete = [each for each in self.mending if each.wrong]
        first = min(incomplete, key=get_badness, default=None)
        if first is None:
            return None
        statements, number = list(self.code.statements), self.tree.statements[id(first.edit.node)]
        self.tree.make(first.edit)
        for node in ast.walk(statements[number]):  # no edit of an edit
            vars(node)["is_new"] = id(node) not in self.tree.scopes
        statements[number] = copy.deepcopy(statements[number])
        self.tree.undo(first.edit)
        edited = replace(self.code, statements=statements)
        keys = [
            replace(key, levels={first.level: key.levels[first.level], **key.levels})
            for key in self.judge.answer_keys
        ]
        search = EditSearch(edited, keys)
        search.budget_s = BUDGET_S
        return self._describe(first), search

    def _make_answer(self, edits: Sequence[MendingEdit], is_unequal: bool) -> SourceAnswer | None:
        """The first edit as an answer, others as alternatives; None without any."""
        if not edits:
            return None
        first, *others = edits
        others = [each for each in others if self._is_as_plain(each, first)]
        return SourceAnswer(
            (self._describe(first),),
            tuple(map(self._describe, others[:MOST_ALTERNATIVES])),
            self.judge.format_entries(frozenset((n, e) for n, e in first.wrong if not n)),
            "" if first.level == self.judge.level else first.level,
            is_unequal,
        )

    def _select_by_statement(self, edits: Sequence[MendingEdit]) -> list[MendingEdit]:
        """The first edit of each statement."""
        selected: dict[int, MendingEdit] = {}
        for each in edits:
            selected.setdefault(id(self.tree.statement(each.edit.node)), each)
        return list(selected.values())

    def _mends_much(self, mending: MendingEdit) -> bool:
        """Whether a whole part is mended, or half of all: single entries may be so by chance."""
        parts = {part for _, (part, *_) in mending.wrong}
        most = len(self.judge.wrong[mending.level]) / 2
        return parts < set(self.judge.states) or len(mending.wrong) <= most

    def _describe(self, mending: MendingEdit) -> SourceEdit:
        mended = self.judge.wrong[mending.level] - mending.wrong
        return self._describe_edit(mending.edit, self.judge.format_entries(mended))

    def _describe_edit(self, edit: Edit, entries: tuple[str, ...]) -> SourceEdit:
        """The record of an edit, with whether it puts a number of the file where another stood."""
        described = describe_edit(self.tree, edit, entries)
        key = self.answer_keys[0]
        old = _read_numbers(described.removed) or _read_numbers(described.old)
        new = _read_numbers(described.added) or _read_numbers(described.new)
        if len(new) > 1 and len(old) == len(new):
            usual = [each for each in new if abs(each) in USUAL_FACTORS]
            has_all = all(each in usual or key.has_signed_number(each) for each in new)
            return replace(described, is_stated=has_all and len(usual) < len(new))
        if len(old) != 1 or len(new) != 1:
            return described
        has_number = key.has_signed_number if new[0] == -old[0] else key.has_number
        return replace(described, is_stated=has_number(new[0]) and not has_number(old[0]))


def _read_numbers(text: str) -> list[float]:
    """The numbers of a text that is a number, or an array of numbers; else none."""
    try:
        return np.ravel(ast.literal_eval(text)).astype(float).tolist()
    except (SyntaxError, TypeError, ValueError):
        return []


get_badness = attrgetter("badness")


def _rate_deferred(deferred: tuple[Edit, EditedCode]) -> tuple[int, bool]:
    """By which the likeliest edits come first."""
    edit, _ = deferred
    is_exchange = isinstance(edit.node, LEAF) and isinstance(edit.parse(), LEAF)
    return edit.rank, not is_exchange


def _are_likely(
    start: Sequence[float],
    values: Sequence[float],
    digits: int,
    is_stated: Callable[[float], bool],
) -> bool:
    """Whether somebody may have meant these numbers: what nobody writes mends by chance."""
    pairs = list(zip(start, values, strict=True))
    if any(a and b and not 1 / LARGEST_RATIO < abs(b / a) < LARGEST_RATIO for a, b in pairs):
        return False
    has_many = not all(is_round(value, digits) for value in start)
    # Of several, those that the file states are right.
    changed = [(a, b) for a, b in pairs if abs(a - b) > EQUAL * abs(a)] if start[1:] else []
    if any(is_stated(a) and not is_stated(b) for a, b in changed):
        return False
    return has_many or all(is_round(v, digits) or is_stated(v) for v in values)


def _list_factors(site: Site) -> Iterator[str]:
    """What follows a number that a sum may lack: nothing, or a name that it is multiplied by."""
    is_place = site.is_sum_place(outer=True)
    is_formula = site.is_whole_formula or (site.is_leaf and is_place)
    if is_formula and site.kind in (NUMBER, None):
        yield ""
        for name, kind in site.scope.list_own_leaves() if is_place else ():
            if kind == NUMBER:
                yield f" * {name}"


def _choose_level(edit: Edit, verdict: EditVerdict) -> MendingEdit | None:
    """The edit beside the level at which it mends most; None if it mends nothing."""
    by_level = (MendingEdit(edit, level, wrong) for level, wrong in verdict.mended.items())
    return min(by_level, key=get_badness, default=None)
