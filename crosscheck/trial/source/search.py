"""Smallest edits of a user's source that make all parts right: which are tried, in what order.

Idea: wrong equations are mostly one expression away from right ones. So expressions are replaced
one at a time by what somebody may have meant, and each edited source is judged as the user's own:
by the right values of its parts. Difficulty: there are tens of thousands of such edits, and where
numbers are equal (a length of 1 m, a zero offset) wrong edits fit by chance. Remedy: the likely
kinds come first, and the search ends with the rank that has an answer; a part that is wrong is
asked at one state before all else is asked; and what fits must fit at all states and on another
mechanism of the same structure, whose numbers are unequal.
"""

from __future__ import annotations

import ast
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations, count
from typing import Any, NamedTuple

from crosscheck.runner.outcomes import Failure, SelfKeyedTask
from crosscheck.runner.progress_update import ProgressCallback, ProgressUpdate
from crosscheck.runner.workers import Workers
from crosscheck.trial.source.code import UserCode
from crosscheck.trial.source.edits import RANKS, Edit, list_edits
from crosscheck.trial.source.sandbox import enter_sandbox, limit_processor_time
from crosscheck.trial.source.source_edit import SourceAnswer, describe_edit
from crosscheck.trial.source.syntax import SourceTree
from crosscheck.trial.source.target import Answer, Entry, Target

BUDGET_S = 10.0  # [s] of processor time, of a whole search
CLOSING_S = 20  # [s] beyond it, after which the process is ended
SLOWER, LEAST_S = 20.0, 0.2  # times the code as it is, and [s] on top, that an edit may take
FOLLOWED = 0.7  # of the entries on another mechanism: where more are wrong, its numbers are ignored
MOST_ALTERNATIVES = 2
MOST_PARTIAL = 12  # edits that mend some entries, of which pairs are tried
Wrong = frozenset[tuple[int, Entry]]  # wrong entries, each with the number of its target
MakeTargets = Callable[[], Sequence[Target]]


class MendingEdit(NamedTuple):
    """An edit that mends entries and makes none wrong; wrong: the entries that stay so."""

    edit: Edit
    wrong: Wrong


class EditSearch:
    """The search of one source for edits that make it right, rank by rank.

    It is made in a worker, which it confines. Raises whatever the code raises as it is.

    Args:
        code: The source.
        targets: What it must answer, on the user's mechanism first.
    """

    def __init__(self, code: UserCode, targets: Sequence[Target]) -> None:
        enter_sandbox(int(BUDGET_S) + CLOSING_S)
        self.code, self.begun_s = code, time.process_time()
        self.tree, self.texts = SourceTree(code), set[tuple[int, str]]()
        self.answers, self.partial = list[MendingEdit](), list[MendingEdit]()
        self.compiled = [code.compile(statement) for statement in code.statements]
        here, *others = (each.select_parts(self._list_parts(targets[0])) for each in targets)
        begun = time.process_time()
        wrong = len(here.find_wrong_entries(self._bind(here)))
        self.limit_s = LEAST_S + SLOWER * (time.process_time() - begun)
        self.targets = [here, *(each for each in others if self._is_followed(each, wrong))]
        self.everywhere = len(self.targets) > 1
        self.wrong = self._find_wrong_entries(self.compiled)
        parts = {part for number, (part, *_) in self.wrong if not number}
        # Of each wrong part its worst state, its answer there and what is wrong of it; M, of which
        # every column may be a call, last.
        self.states = {
            p: self._find_worst_state(p) for p in sorted(parts, key="mass_matrix".__eq__)
        }
        as_is = self._bind(here)
        self.values = {part: as_is(part, state) for part, state in self.states.items()}
        self.wrong_at = {
            part: here.find_wrong_entries(as_is, [part], [state])
            for part, state in self.states.items()
        }
        self.tree.observe(self._ask_wrong_parts)

    def _bind(self, target: Target, compiled: Sequence[Any] = ()) -> Answer:
        return target.bind(self.code.run(compiled or self.compiled))

    def _list_parts(self, target: Target) -> list[str]:
        """The parts that answer with the code as it is."""
        parts, answer = list[str](), self._bind(target)
        for part in target.right:
            try:
                answer(part, 0)
            except Exception:  # of the user's code, which the trial has reported
                continue
            parts.append(part)
        return parts

    def _is_followed(self, target: Target, wrong_here: int) -> bool:
        """Whether the code takes its numbers from the mechanism: it is not all wrong on another."""
        try:
            wrong = len(target.find_wrong_entries(self._bind(target)))
        except Exception:  # of code for one mechanism alone
            return False
        return wrong <= max(wrong_here, FOLLOWED * target.size)

    def _find_worst_state(self, part: str) -> int:
        """The state at which most entries of a part are wrong."""
        here, answer = self.targets[0], self._bind(self.targets[0])
        return max(here.states, key=lambda s: len(here.find_wrong_entries(answer, [part], [s])))

    def _ask_wrong_parts(self) -> None:
        answer = self._bind(self.targets[0])
        for part, state in self.states.items():
            answer(part, state)

    def _find_wrong_entries(
        self, compiled: Sequence[Any], allowed: Wrong | None = None
    ) -> Wrong | None:
        """The wrong entries at all states, on all mechanisms; None once one is not allowed."""
        wrong = set[tuple[int, Entry]]()
        for number, target in enumerate(self.targets):
            entries = target.find_wrong_entries(self._bind(target, compiled))
            wrong |= {(number, entry) for entry in entries}
            if allowed is not None and not wrong <= allowed:
                return None
        return frozenset(wrong)

    @property
    def is_over(self) -> bool:
        """Whether the search has an answer, or has spent its time."""
        answer = self.answers or self._find_pair()
        return bool(answer) or not self.states or self._spent_s > BUDGET_S

    @property
    def _spent_s(self) -> float:
        return time.process_time() - self.begun_s

    def try_rank(self, rank: int) -> None:
        """Try the edits of a rank, within the budget."""
        for edit in list_edits(self.tree, rank) if self.states else ():
            if self._spent_s > BUDGET_S:
                return
            wrong = self._judge([edit])
            if wrong is not None and wrong < self.wrong:
                (self.partial if wrong else self.answers).append(MendingEdit(edit, wrong))

    def _judge(self, edits: Sequence[Edit]) -> Wrong | None:
        """The entries that are wrong with edits; None where they mend none, or do not work."""
        for edit in edits:
            if not hasattr(edit.other, "lineno"):
                ast.copy_location(edit.other, edit.node)
            ast.fix_missing_locations(edit.other)
            self.tree.put(edit.node, edit.other)
        try:
            if len(edits) == 1 and not self._is_new(edits[0]):
                return None
            compiled = list(self.compiled)
            for edit in edits:
                number = self.tree.statements[id(edit.node)]
                compiled[number] = self.code.compile(self.code.statements[number])
            with limit_processor_time(self.limit_s):
                if self._mends(compiled):
                    return self._find_wrong_entries(compiled, self.wrong)
        except BaseException:  # whatever an edit leads to, it is none that mends
            return None
        finally:
            for edit in edits:
                self.tree.put(edit.node, edit.node)
        return None

    def _is_new(self, edit: Edit) -> bool:
        """Whether no other edit has made the same text of the statement."""
        statement = self.tree.statement(edit.node)
        text = ast.unparse(edit.other if statement is edit.node else statement)
        known, place = self.texts, (statement.lineno, text)
        is_new = place not in known
        known.add(place)
        return is_new

    def _mends(self, compiled: Sequence[Any]) -> bool:
        """Whether a wrong entry becomes right at the worst state, and none that is right wrong."""
        here, mends = self.targets[0], False
        answer = self._bind(here, compiled)
        for part, state in self.states.items():
            value = answer(part, state)
            if (value == self.values[part]).all():
                continue
            wrong = here.find_wrong_entries(lambda *_, value=value: value, [part], [state])
            if not wrong < self.wrong_at[part]:
                return False
            mends = True
        return mends

    def _find_pair(self) -> list[MendingEdit]:
        """Two edits that together make all right, each of which mends what the other does not."""
        likeliest = sorted(self.partial, key=lambda each: (len(each.wrong), each.edit.likelihood))
        for pair in combinations(likeliest[:MOST_PARTIAL], 2):
            statements = {id(self.tree.statement(each.edit.node)) for each in pair}
            if len(statements) > 1 and not pair[0].wrong & pair[1].wrong:
                if self._judge([each.edit for each in pair]) == frozenset():
                    return sorted(pair, key=lambda each: each.edit.node.lineno)
        return []

    def find_answer(self) -> SourceAnswer | None:
        """The answer so far; None where no edit mends anything."""
        chosen = sorted(self.answers, key=lambda each: each.edit.likelihood)
        if chosen:
            first, *others = self._select_unequal(chosen)
            return SourceAnswer(
                (self._describe(first),),
                tuple(map(self._describe, others[:MOST_ALTERNATIVES])),
                everywhere=self.everywhere,
            )
        if pair := self._find_pair():
            return SourceAnswer(tuple(map(self._describe, pair)), everywhere=self.everywhere)
        if not self.partial:
            return None
        best = min(self.partial, key=lambda each: (len(each.wrong), each.edit.likelihood))
        wrong = self._format_entries(best.wrong)
        return SourceAnswer((self._describe(best),), (), wrong, self.everywhere)

    def _select_unequal(self, edits: Sequence[MendingEdit]) -> list[MendingEdit]:
        """The likeliest edit of each statement.

        All give right values; on unequal numbers those of one statement then say the same.
        """
        if not self.everywhere:
            return list(edits)
        unequal: dict[int, MendingEdit] = {}
        for each in edits:
            unequal.setdefault(id(self.tree.statement(each.edit.node)), each)
        return list(unequal.values())

    def _describe(self, mending: MendingEdit) -> Any:
        entries = self._format_entries(self.wrong - mending.wrong)
        return describe_edit(self.tree, mending.edit, entries)

    def _format_entries(self, wrong: Iterable[tuple[int, Entry]]) -> tuple[str, ...]:
        entries = sorted({entry for _, entry in wrong})
        return tuple(map(self.targets[0].format_entry, entries))


class RankOutcome(NamedTuple):
    """The answer after a rank, if there is one, and whether the search is over."""

    answer: SourceAnswer | None
    is_over: bool


# Sources and their targets by the number of a search, which workers know that are forked then; and
# the searches of this process, if it is such a worker.
_requests: dict[int, tuple[UserCode, MakeTargets]] = {}
_searches: dict[int, EditSearch] = {}
_numbers = count()


@dataclass(frozen=True)
class RankTask(SelfKeyedTask):
    """The task of trying all edits of a rank, in the worker that tried those before."""

    search: int
    rank: int
    cost = BUDGET_S

    def perform(self) -> RankOutcome:
        """The outcome. Raises what the code raises as it is."""
        if self.search not in _searches:
            code, make_targets = _requests[self.search]
            _searches[self.search] = EditSearch(code, make_targets())
        search = _searches[self.search]
        search.try_rank(self.rank)
        is_over = search.is_over
        return RankOutcome(search.find_answer(), is_over)


def find_source_answer(
    code: UserCode, make_targets: MakeTargets, progress: ProgressCallback
) -> SourceAnswer | None:
    """What must change in a source, if a small edit makes it right, or some of its entries.

    make_targets: what it must answer, on the user's mechanism first; called in a worker. No file is
    written, and the code runs in that worker alone.
    """
    number, answer = next(_numbers), None
    _requests[number] = code, make_targets
    try:
        with Workers(1) as workers:
            for rank in RANKS:
                progress(ProgressUpdate("looking for the line that must change"))
                task = RankTask(number, rank)
                outcome = workers.perform([task], lambda key: None)[task]
                if isinstance(outcome, Failure):  # the code ended the worker, or raises as it is
                    break
                answer = outcome.answer
                if outcome.is_over:
                    break
    finally:
        del _requests[number]
    return answer
