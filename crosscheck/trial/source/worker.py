"""The search of a source in a worker of its own: round by round, until there is an answer."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import count, product
from typing import Literal, NamedTuple

from crosscheck.runner.outcomes import Failure, SelfKeyedTask
from crosscheck.runner.progress_update import ProgressCallback
from crosscheck.runner.workers import Workers
from crosscheck.trial.source.answer_key import AnswerKey
from crosscheck.trial.source.code import UserCode
from crosscheck.trial.source.edits import RANKS
from crosscheck.trial.source.libraries import quicken_libraries
from crosscheck.trial.source.sandbox import enter_sandbox
from crosscheck.trial.source.search import BUDGET_S, LONGEST_BUDGET_S, EditSearch
from crosscheck.trial.source.source_edit import SourceAnswer, SourceSearch

CLOSING_S = 20  # [s] of processor time beyond the budgets, after which the process is ended
MOST_AT_ONCE = 4  # likeliest ranks that come before their edits elsewhere
# Rounds of a search: ranks, first the edits that may mend all that is wrong, then the others.
ROUNDS = (
    *product(RANKS[:MOST_AT_ONCE], [True]),
    *product(RANKS[:MOST_AT_ONCE], [False]),
    *product(RANKS[MOST_AT_ONCE:], [True, False]),
)
BRIEF_ROUNDS = 2  # number of rounds where coordinates are the cause, and only its line is sought
SearchScope = Literal["likely", "whole", "all"]
MakeAnswerKeys = Callable[[], Iterable[AnswerKey]]


class RankOutcome(NamedTuple):
    """The answer after a rank, if there is one, and whether the search is over, or out of time.

    has_errors: whether there is anything to mend.
    """

    answer: SourceAnswer | None
    is_over: bool
    is_late: bool = False
    has_errors: bool = True


# Sources and what makes their answer keys, by the number of a search: workers know them that are
# forked then. And the searches of this process, if it is such a worker.
_requests: dict[int, tuple[UserCode, MakeAnswerKeys]] = {}
_searches: dict[int, EditSearch] = {}
_numbers = count()


@dataclass(frozen=True)
class RankTask(SelfKeyedTask):
    """The task of trying all edits of a rank, in the worker that tried those before.

    is_likely: whether of the edits that may mend all that is wrong, or of the others; is_second:
    whether the best edit that does not mend all is made already.
    """

    search: int
    rank: int
    is_likely: bool
    is_second: bool
    cost = BUDGET_S

    def perform(self) -> RankOutcome:
        """The outcome. Raises what the code raises as it is."""
        if self.search not in _searches:
            code, make_answer_keys = _requests[self.search]
            answer_keys = list(make_answer_keys())
            quicken_libraries()
            enter_sandbox(2 * int(BUDGET_S + LONGEST_BUDGET_S) + CLOSING_S)
            _searches[self.search] = EditSearch(code, answer_keys)
        search = _searches[self.search]
        if self.is_second:
            return self._try_second(search)
        search.try_rank(self.rank, is_likely=self.is_likely)
        answer = search.find_answer()
        is_over = (
            answer is not None and answer.is_whole and answer.is_unequal == search.judge.is_unequal
        )
        is_late, has_errors = search.is_late, bool(search.judge.states)
        return RankOutcome(answer, is_over or search.is_spent, is_late, has_errors)

    def _try_second(self, whole: EditSearch) -> RankOutcome:
        """Search for a second edit that, with the first, makes everything right.

        Two whose effects add up come before it.
        """
        if (answer := whole.find_pair_answer()) is not None:
            return RankOutcome(answer, is_over=True)
        if whole.second is None:
            return RankOutcome(None, True)
        first, search = whole.second
        search.try_rank(self.rank, is_likely=self.is_likely)
        answer = search.find_answer()
        if answer is None or not answer.is_whole or len(answer.edits) > 1:
            return RankOutcome(None, search.is_spent, search.is_late)
        edits = sorted((first, *answer.edits), key=lambda each: each.line)
        level = search.judge.level if search.judge.level != whole.judge.level else ""
        return RankOutcome(
            replace(answer, edits=tuple(edits), alternatives=(), level=level), is_over=True
        )


def find_source_answer(
    code: UserCode,
    make_answer_keys: MakeAnswerKeys,
    progress: ProgressCallback,
    scope: SearchScope = "all",
) -> SourceSearch:
    """Find the small edit of a source that makes it right, or some of its entries.

    make_answer_keys: what it must answer, on the user's mechanism first; called in a worker. scope:
    what is looked for: a likely edit that makes all right, any that does, or also two together and
    those that make some entries right. No file is written, and the code runs in that worker alone.
    """
    number = next(_numbers)
    answer: SourceAnswer | None = None
    place, is_late = "", False
    _requests[number] = code, make_answer_keys
    try:
        with Workers(1) as workers:
            for is_second in (False, True) if scope == "all" else (False,):
                for rank, is_likely in ROUNDS[:BRIEF_ROUNDS] if scope == "likely" else ROUNDS:
                    progress("looking for the line that must change")
                    task = RankTask(number, rank, is_likely, is_second)
                    outcome = workers.perform([task])[task]
                    # Then the code ended the worker, or raises as it is.
                    if isinstance(outcome, Failure):
                        return SourceSearch(answer)
                    answer, is_late = outcome.answer or answer, is_late or outcome.is_late
                    place = code.place if outcome.has_errors and scope != "likely" else ""
                    if outcome.is_over:
                        break
                if not place or (answer is not None and not answer.wrong):
                    break
    finally:
        del _requests[number]
    is_final = scope == "all" or (answer is not None and answer.is_whole)
    return SourceSearch(answer if is_final else None, place, scope == "all", is_late)
