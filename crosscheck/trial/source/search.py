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
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from itertools import combinations, count
from operator import attrgetter
from typing import Any, NamedTuple

from crosscheck.runner.outcomes import Failure, SelfKeyedTask
from crosscheck.runner.progress_update import ProgressCallback, ProgressUpdate
from crosscheck.runner.workers import Workers
from crosscheck.trial.source.answer_key import Answer, AnswerKey, Entry
from crosscheck.trial.source.code import UserCode
from crosscheck.trial.source.edits import RANKS, Edit, list_edits
from crosscheck.trial.source.sandbox import enter_sandbox, limit_processor_time
from crosscheck.trial.source.source_edit import SourceAnswer, SourceEdit, describe_edit
from crosscheck.trial.source.syntax import SourceTree

BUDGET_S = 10.0  # [s] of processor time, of a whole search
CLOSING_S = 20  # [s] beyond it, after which the process is ended
SLOWER, LEAST_S = 20.0, 0.2  # times the code as it is, and [s] on top, that an edit may take
IGNORED = 0.5  # of entries that are right here: if more are wrong there, numbers are ignored
MOST_ALTERNATIVES = 2
MOST_INCOMPLETE = 12  # edits that mend some entries, of which pairs are tried
Wrong = frozenset[tuple[int, Entry]]  # wrong entries, each with the number of its answer key
MakeAnswerKeys = Callable[[], Iterable[AnswerKey]]


class MendingEdit(NamedTuple):
    """An edit that mends entries at a level and makes none wrong; wrong: those that stay so."""

    edit: Edit
    level: str
    wrong: Wrong

    @property
    def badness(self) -> tuple[int, tuple[int, int]]:
        """By which the best comes first: how much stays wrong, how unlikely the edit is."""
        return len(self.wrong), self.edit.likelihood


class EditSearch:
    """The search of one source for edits that make it right, rank by rank.

    It is made in a worker, which it confines. Raises whatever the code raises as it is.

    Args:
        code: The source.
        answer_keys: What it must answer, on the user's mechanism first.
    """

    def __init__(self, code: UserCode, answer_keys: Sequence[AnswerKey]) -> None:
        enter_sandbox(int(BUDGET_S) + CLOSING_S)
        self.code, self.begun_s = code, time.process_time()
        self.tree = SourceTree(code)
        self.texts = {(each.lineno, ast.unparse(each)) for each in self.tree.list_statements()}
        self.mending = list[MendingEdit]()
        self.compiled = [code.compile(statement) for statement in code.statements]
        here, *others = answer_keys
        self.level, trusted = next(iter(here.levels.items()))
        self.parts = [part for part in trusted.right if self._is_answered(here, part)]
        begun = time.process_time()
        wrong = trusted.find_wrong_entries(self._bind(here), self.parts)
        self.limit_s = LEAST_S + SLOWER * (time.process_time() - begun)
        wrong_parts = {part for part, *_ in wrong}
        self.answer_keys = [
            here,
            *(each for each in others if self._is_followed(each, wrong_parts)),
        ]
        levels = [each for each in here.levels if all(each in t.levels for t in self.answer_keys)]
        self.wrong = {each: self._find_wrong_entries(self.compiled, each) for each in levels}
        # Of each wrong part, the quickest first, its worst state, its answer there and, by level,
        # what is wrong of it.
        order = sorted(wrong_parts, key=partial(self._measure_seconds, here))
        as_is = self._bind(here)
        self.states = {
            part: max(
                trusted.states, key=lambda s: len(trusted.find_wrong_entries(as_is, [part], [s]))
            )
            for part in order
        }
        self.values = {part: as_is(part, state) for part, state in self.states.items()}
        self.wrong_there = {
            (level, part): here.levels[level].find_wrong_entries(as_is, [part], [state])
            for level in levels
            for part, state in self.states.items()
        }
        # Lines that the first wrong part runs: an edit elsewhere does not make all right.
        self.first_lines = self.tree.observe(partial(self._ask, order[:1]))
        self.tree.observe(partial(self._ask, order))

    def _bind(self, answer_key: AnswerKey, compiled: Sequence[Any] = ()) -> Answer:
        """The answers of the code, edited or as it is, each asked for once."""
        return cache(answer_key.bind(self.code.run(compiled or self.compiled)))

    def _is_answered(self, answer_key: AnswerKey, part: str) -> bool:
        try:
            self._bind(answer_key)(part, 0)
        except Exception:  # of the user's code, which the trial has reported
            return False
        return True

    def _is_followed(self, answer_key: AnswerKey, wrong_here: Collection[str]) -> bool:
        """Whether the code may take its numbers from the mechanism.

        It does not if parts that are right here are mostly wrong on another mechanism.
        """
        parts = [part for part in self.parts if part not in wrong_here]
        if self.level not in answer_key.levels or not self._is_answered(answer_key, self.parts[0]):
            return False
        trusted = answer_key.levels[self.level]
        wrong = trusted.find_wrong_entries(self._bind(answer_key), parts)
        return len(wrong) <= IGNORED * sum(trusted.right[part][0].size for part in parts)

    def _measure_seconds(self, answer_key: AnswerKey, part: str) -> float:
        """Processor time [s] that an answer of a part takes."""
        answer, begun = self._bind(answer_key), time.process_time()
        answer(part, 0)
        return time.process_time() - begun

    def _ask(self, parts: Sequence[str]) -> None:
        answer = self._bind(self.answer_keys[0])
        for part in parts:
            answer(part, self.states[part])

    def _find_wrong_entries(self, compiled: Sequence[Any], level: str) -> Wrong:
        """The entries that are wrong beside a level at any state, on all mechanisms."""
        wrong = set[tuple[int, Entry]]()
        for number, answer_key in enumerate(self.answer_keys):
            answer = self._bind(answer_key, compiled)
            entries = answer_key.levels[level].find_wrong_entries(answer, self.parts)
            wrong |= {(number, entry) for entry in entries}
        return frozenset(wrong)

    @property
    def answers(self) -> list[MendingEdit]:
        """The edits that make all right, the likeliest first."""
        return sorted((each for each in self.mending if not each.wrong), key=get_badness)

    @property
    def is_over(self) -> bool:
        """Whether the search has an answer, or has spent its time."""
        is_spent = not self.states or time.process_time() - self.begun_s > BUDGET_S
        return is_spent or bool(self.answers or self._find_pair())

    def try_rank(self, rank: int) -> None:
        """Try the edits of a rank, within the budget.

        Those that cannot mend all that is wrong, as they leave one wrong part as it is, come last,
        and only where no other edit does.
        """
        elsewhere = list[Edit]()
        for edit in list_edits(self.tree, rank) if self.states else ():
            if self.tree.has_run(edit.node, self.first_lines):
                self._try_edit(edit)
            else:
                elsewhere.append(edit)
        for edit in elsewhere if not self.answers else ():
            self._try_edit(edit)

    def _try_edit(self, edit: Edit) -> None:
        is_spent = time.process_time() - self.begun_s > BUDGET_S
        mending = None if is_spent else self._judge([edit])
        if mending is not None:
            self.mending.append(mending)

    def _judge(self, edits: Sequence[Edit]) -> MendingEdit | None:
        """What edits mend together; None where that is nothing, and where they do not work."""
        try:
            for edit in edits:
                self.tree.put(edit.node, edit.parse())
            if len(edits) == 1 and not self._is_new(edits[0]):
                return None
            compiled = list(self.compiled)
            for edit in edits:
                number = self.tree.statements[id(edit.node)]
                compiled[number] = self.code.compile(self.code.statements[number])
            with limit_processor_time(self.limit_s):
                wrong = {
                    level: self._find_wrong_entries(compiled, level)
                    for level in self._list_mended_levels(compiled)
                }
        except BaseException:  # whatever an edit leads to, it is none that mends
            return None
        finally:
            for edit in edits:
                self.tree.put(edit.node, edit.node)
        mended = (
            MendingEdit(edits[0], level, each)
            for level, each in wrong.items()
            if each < self.wrong[level]
        )
        return min(mended, key=get_badness, default=None)

    def _is_new(self, edit: Edit) -> bool:
        """Whether no other edit has made the same text of the statement."""
        statement = self.tree.statement(edit.node)
        text = edit.text if statement is edit.node else ast.unparse(statement)
        count = len(self.texts)
        self.texts.add((statement.lineno, text))
        return len(self.texts) > count

    def _list_mended_levels(self, compiled: Sequence[Any]) -> list[str]:
        """The levels beside which a wrong part has less that is wrong, and nothing else is."""
        here, answer, is_changed = (
            self.answer_keys[0],
            self._bind(self.answer_keys[0], compiled),
            False,
        )
        levels = list(self.wrong)
        for part, state in self.states.items():
            if (answer(part, state) == self.values[part]).all():
                continue
            is_changed = True
            levels = [
                level
                for level in levels
                if here.levels[level].find_wrong_entries(answer, [part], [state])
                < self.wrong_there[level, part]
            ]
            if not levels:
                break
        return levels if is_changed else []

    def _find_pair(self) -> list[MendingEdit]:
        """Two edits that together make all right, each of which mends what the other does not."""
        for pair in combinations(sorted(self.mending, key=get_badness)[:MOST_INCOMPLETE], 2):
            statements = {id(self.tree.statement(each.edit.node)) for each in pair}
            if len(statements) > 1 and not pair[0].wrong & pair[1].wrong:
                both = self._judge([each.edit for each in pair])
                if both is not None and not both.wrong:
                    return sorted(pair, key=lambda each: each.edit.node.lineno)
        return []

    def find_answer(self) -> SourceAnswer | None:
        """The answer so far; None where no edit mends anything that says much."""
        is_unequal = len(self.answer_keys) > 1
        edits = self.answers
        if not edits:  # those that are right on the user's own mechanism
            right_here = (each for each in self.mending if all(n for n, _ in each.wrong))
            edits, is_unequal = sorted(right_here, key=get_badness), False
        if edits:
            if is_unequal:  # then all right edits of a statement say the same
                edits = self._select_by_statement(edits)
            first, *others = edits
            level = "" if first.level == self.level else first.level
            alternatives = tuple(map(self._describe, others[:MOST_ALTERNATIVES]))
            return SourceAnswer((self._describe(first),), alternatives, (), level, is_unequal)
        is_unequal = len(self.answer_keys) > 1
        if pair := self._find_pair():
            return SourceAnswer(tuple(map(self._describe, pair)), is_unequal=is_unequal)
        telling = [each for each in self.mending if self._mends_much(each)]
        if not telling:
            return None
        best = min(telling, key=get_badness)
        level, wrong = (
            "" if best.level == self.level else best.level,
            self._format_entries(best.wrong),
        )
        return SourceAnswer((self._describe(best),), (), wrong, level, is_unequal)

    def _select_by_statement(self, edits: Sequence[MendingEdit]) -> list[MendingEdit]:
        """The first edit of each statement."""
        selected: dict[int, MendingEdit] = {}
        for each in edits:
            selected.setdefault(id(self.tree.statement(each.edit.node)), each)
        return list(selected.values())

    def _mends_much(self, mending: MendingEdit) -> bool:
        """Whether a whole part is mended, or half of all: single entries may be so by chance."""
        parts = {part for _, (part, *_) in mending.wrong}
        return parts < set(self.states) or len(mending.wrong) <= len(self.wrong[mending.level]) / 2

    def _describe(self, mending: MendingEdit) -> SourceEdit:
        entries = self._format_entries(self.wrong[mending.level] - mending.wrong)
        return describe_edit(self.tree, mending.edit, entries)

    def _format_entries(self, wrong: Iterable[tuple[int, Entry]]) -> tuple[str, ...]:
        entries = sorted({entry for _, entry in wrong})
        return tuple(map(self.answer_keys[0].format_entry, entries))


get_badness = attrgetter("badness")


class RankOutcome(NamedTuple):
    """The answer after a rank, if there is one, and whether the search is over."""

    answer: SourceAnswer | None
    is_over: bool


# Sources and what makes their answer keys, by the number of a search: workers know them that are
# forked then. And the searches of this process, if it is such a worker.
_requests: dict[int, tuple[UserCode, MakeAnswerKeys]] = {}
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
            code, make_answer_keys = _requests[self.search]
            _searches[self.search] = EditSearch(code, list(make_answer_keys()))
        search = _searches[self.search]
        search.try_rank(self.rank)
        is_over = search.is_over
        return RankOutcome(search.find_answer(), is_over)


def find_source_answer(
    code: UserCode, make_answer_keys: MakeAnswerKeys, progress: ProgressCallback
) -> SourceAnswer | None:
    """What must change in a source, if a small edit makes it right, or some of its entries.

    make_answer_keys: what it must answer, on the user's mechanism first; called in a worker. No
    file is written, and the code runs in that worker alone.
    """
    number, answer = next(_numbers), None
    _requests[number] = code, make_answer_keys
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
