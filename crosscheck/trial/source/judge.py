"""How an edited source is judged: by the right values of the parts, on every mechanism.

A part that is wrong is asked at one state before all else is asked, for most edits mend nothing.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from crosscheck.trial.source.answer_key import Answer, AnswerKey, Entry
from crosscheck.trial.source.code import UserCode
from crosscheck.trial.source.sandbox import limit_processor_time

SLOWER, LEAST_S = 20.0, 0.2  # times the code as it is, and [s] on top, that an edit may take
IGNORED = 0.5  # of entries that are right here: if more are wrong there, numbers are ignored
Wrong = frozenset[tuple[int, Entry]]  # wrong entries, each with the number of its answer key


class SourceJudge:
    """The wrong entries of a source as it is, and of what edits make of it.

    Raises whatever the code raises as it is.

    Args:
        code: The source.
        answer_keys: What it must answer, on the user's mechanism first. Another mechanism counts
            if the code may take its numbers from it.
    """

    def __init__(self, code: UserCode, answer_keys: Sequence[AnswerKey]) -> None:
        self.code = code
        self.compiled = [code.compile(statement) for statement in code.statements]
        here, *others = answer_keys
        self.level, trusted = next(iter(here.levels.items()))
        self.parts = [part for part in trusted.right if self._is_answered(here, part)]
        begun, as_is = time.process_time(), self._bind(here)
        wrong_parts = {part for part, *_ in trusted.find_wrong_entries(as_is, self.parts)}
        self.limit_s = LEAST_S + SLOWER * (time.process_time() - begun)
        followed = (each for each in others if self._is_followed(each, as_is, wrong_parts))
        self.answer_keys = [here, *followed]
        self.wrong = {
            level: self._find_wrong_entries(self.compiled, level)
            for level in here.levels
            if all(level in each.levels for each in self.answer_keys)
        }
        # Of each wrong part, the quickest first, the state at which most is wrong, its answer
        # there and, by level, what is wrong of it.
        self.states = dict[str, int]()
        for part in sorted(wrong_parts, key=self._measure_seconds):
            wrong = [len(trusted.find_wrong_entries(as_is, [part], [s])) for s in trusted.states]
            self.states[part] = wrong.index(max(wrong))
        self.values = {part: as_is(part, state) for part, state in self.states.items()}
        self.wrong_there = {
            (level, part): here.levels[level].find_wrong_entries(as_is, [part], [state])
            for level in self.wrong
            for part, state in self.states.items()
        }

    @property
    def is_unequal(self) -> bool:
        """Whether it judges on a mechanism of unequal numbers too."""
        return len(self.answer_keys) > 1

    @property
    def is_certain(self) -> bool:
        """Whether the code takes its numbers from the mechanism: another one is as good a judge.

        So it is if nothing that is right on the user's mechanism is wrong on the other.
        """
        here = {entry for number, entry in self.wrong[self.level] if not number}
        there = {entry for number, entry in self.wrong[self.level] if number}
        return self.is_unequal and there <= here

    def ask(self, parts: Iterable[str]) -> None:
        """Make the equations as they are, and ask wrong parts at one state."""
        answer = self._bind(self.answer_keys[0])
        for part in parts:
            answer(part, self.states[part])

    def find_mended(self, compiled: Sequence[Any]) -> Mapping[str, Wrong]:
        """Remaining errors, by level for which the edit corrects some and breaks none.

        Raises whatever the code raises, and TooSlow.
        """
        with limit_processor_time(self.limit_s):
            levels = self._list_mended_levels(compiled)
            wrong = {level: self._find_wrong_entries(compiled, level) for level in levels}
        return {level: each for level, each in wrong.items() if each < self.wrong[level]}

    def compute_residuals(self, compiled: Sequence[Any]) -> list[np.ndarray]:
        """The answers of each wrong part less the right ones, at one state.

        Raises whatever the code raises, and TooSlow.
        """
        here = self.answer_keys[0]
        right = here.levels[self.level].right
        with limit_processor_time(self.limit_s):
            answer = self._bind(here, compiled)
            states = self.states.items()
            return [np.ravel(answer(part, state) - right[part][state]) for part, state in states]

    def format_entries(self, wrong: Wrong) -> tuple[str, ...]:
        """Entries in words, each once."""
        entries = sorted({entry for _, entry in wrong})
        return tuple(map(self.answer_keys[0].format_entry, entries))

    def _bind(self, answer_key: AnswerKey, compiled: Sequence[Any] = ()) -> Answer:
        """The answers of the code, edited or as it is, each asked for once."""
        return cache(answer_key.bind(self.code.run(compiled or self.compiled)))

    def _is_answered(self, answer_key: AnswerKey, part: str) -> bool:
        try:
            self._bind(answer_key)(part, 0)
        except Exception:  # of the user's code, which the trial has reported
            return False
        return True

    def _is_followed(
        self, answer_key: AnswerKey, answer_here: Answer, wrong_here: Collection[str]
    ) -> bool:
        """Whether the code may take the numbers that differ from the mechanism.

        It does not if it answers the same on another mechanism, or if parts that are right here are
        mostly wrong there.
        """
        if self.level not in answer_key.levels or not self._is_answered(answer_key, self.parts[0]):
            return False
        answer = self._bind(answer_key)
        if all(np.array_equal(answer(part, 0), answer_here(part, 0)) for part in self.parts):
            return False
        parts = [part for part in self.parts if part not in wrong_here]
        trusted = answer_key.levels[self.level]
        wrong = trusted.find_wrong_entries(answer, parts)
        return len(wrong) <= IGNORED * sum(trusted.right[part][0].size for part in parts)

    def _measure_seconds(self, part: str) -> float:
        """Processor time [s] that an answer of a part takes."""
        answer, begun = self._bind(self.answer_keys[0]), time.process_time()
        answer(part, 0)
        return time.process_time() - begun

    def _find_wrong_entries(self, compiled: Sequence[Any], level: str) -> Wrong:
        """The entries that are wrong beside a level at any state, on all mechanisms."""
        return frozenset(
            (number, entry)
            for number, key in enumerate(self.answer_keys)
            for entry in key.levels[level].find_wrong_entries(self._bind(key, compiled), self.parts)
        )

    def _list_mended_levels(self, compiled: Sequence[Any]) -> list[str]:
        """The levels beside which a wrong part is mended at one state, and none made worse."""
        here, answer = self.answer_keys[0], self._bind(self.answer_keys[0], compiled)
        levels, mended = list(self.wrong), set[str]()
        for part, state in self.states.items():
            if (answer(part, state) == self.values[part]).all():
                continue
            before = {level: self.wrong_there[level, part] for level in levels}
            after = {
                level: here.levels[level].find_wrong_entries(answer, [part], [state])
                for level in levels
            }
            levels = [level for level in levels if after[level] <= before[level]]
            mended |= {level for level in levels if after[level] < before[level]}
            if not levels:
                break
        return [level for level in levels if level in mended]
