"""How an edited source is judged: by the right values of the parts, on every mechanism.

A part that is wrong is asked at one state before all else is asked, for most edits mend nothing.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from crosscheck.trial.source.answer_key import EQUAL, Answer, AnswerKey, Entry, LevelAnswers
from crosscheck.trial.source.code import UserCode
from crosscheck.trial.source.edit import NONE
from crosscheck.trial.source.edited_code import EditedCode, list_constants
from crosscheck.trial.source.sandbox import limit_processor_time

SLOWER, LEAST_S = 20.0, 0.2  # times the code as it is, and [s] on top, that an edit may take
SLIGHTLY_SLOWER = 4.0  # times of slow code, whose edits would take too long
SLOW_S = 0.15  # processor time [s] of code of which each run counts
IGNORED = 0.5  # of entries that are right here: if more are wrong there, numbers are ignored
Wrong = frozenset[tuple[int, Entry]]  # wrong entries, each with the number of its answer key


class Response(NamedTuple):
    """Whether a change moves any part that is wrong, all of these, and any that is right.

    Of parts, not of entries: an edit may bring a variable in on which no entry depends yet.
    """

    moves_wrong: bool
    moves_all_wrong: bool
    moves_right: bool


class EditVerdict(NamedTuple):
    """What an edit does to what is wrong.

    mended: by level for which it corrects some entries and breaks none, those that stay wrong;
    values: of the first wrong part at one state, with the edit.
    """

    mended: Mapping[str, Wrong]
    values: np.ndarray


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
        self.as_is = EditedCode(code, self.compiled)
        begun, as_is = time.process_time(), self.as_is.bind(here)
        self.making_s = time.process_time() - begun
        seconds = {part: _measure_seconds(as_is, part) for part in trusted.right}
        self.parts = [part for part, needed in seconds.items() if needed is not None]
        wrong_parts = {part for part, *_ in trusted.find_wrong_entries(as_is, self.parts)}
        needed_s = time.process_time() - begun
        self.is_slow = needed_s > SLOW_S
        self.limit_s = LEAST_S + needed_s * (SLOWER if not self.is_slow else SLIGHTLY_SLOWER)
        pairs = [(each, self._follow(each, trusted, as_is, wrong_parts)) for each in others]
        followed = [(key, answer) for key, answer in pairs if answer is not None]
        self.answer_keys = [here, *(key for key, _ in followed)]
        answers = [as_is, *(answer for _, answer in followed)]
        self.wrong = {
            level: self._find_wrong_entries(answers, level)
            for level in here.levels
            if all(level in each.levels for each in self.answer_keys)
        }
        # Of each wrong part, the quickest first, the state at which most is wrong, its answer
        # there and, by level, what is wrong of it.
        self.states = dict[str, int]()
        for part in sorted(wrong_parts, key=partial(_sum_seconds, seconds, trusted.holds)):
            wrong = [len(trusted.find_wrong_entries(as_is, [part], [s])) for s in trusted.states]
            self.states[part] = wrong.index(max(wrong))
        self.values = {part: as_is(part, self.states.get(part, 0)) for part in self.parts}
        self.wrong_there = {
            (level, part): self._mark_wrong(level, part, self.values[part])
            for level in self.wrong
            for part in self.states
        }

    @cached_property
    def is_unequal(self) -> bool:
        """Whether it judges on a mechanism of unequal numbers too."""
        constants = {each for code in self.compiled for each in list_constants(code)}
        return any(not constants & each.equal for each in self.answer_keys[1:])

    @property
    def is_certain(self) -> bool:
        """Whether nothing that is right on the user's mechanism is wrong on another one.

        Then the code takes its numbers from the mechanism: another one is as good a judge. Where
        they are the code's, some may stand for what does not change with the mechanism.
        """
        if any(each.exchanged for each in self.answer_keys):
            return False
        here = {entry for number, entry in self.wrong[self.level] if not number}
        there = {entry for number, entry in self.wrong[self.level] if number}
        return there <= here

    @property
    def first_part(self) -> str:
        """The wrong part that is asked first."""
        return next(iter(self.states))

    @property
    def first_value(self) -> np.ndarray:
        """The answer of that part at its state."""
        return self.values[self.first_part]

    def bind(self) -> Answer:
        """The answers of the equations as they are, made anew and remembering nothing."""
        return self.answer_keys[0].bind(self.code.run(self.compiled))

    def ask(self, answer: Answer) -> None:
        """Ask each wrong part at one state."""
        for part, state in self.states.items():
            answer(part, state)

    def measure_response(self, edited: EditedCode) -> Response:
        """What a change of the code moves at one state. Raises whatever the code raises."""
        here = self.answer_keys[0]
        with limit_processor_time(self.limit_s):
            answer = edited.bind_shared(here)
            trusted = here.levels[self.level]
            moved = [
                not (
                    np.abs(answer(part, state) - self.values[part])
                    <= trusted.allowance(part, state)
                ).all()
                for part, state in self.states.items()
            ]
            right = [part for part in self.parts if part not in self.states]
            broken = trusted.find_wrong_entries(answer, right, [0])
        return Response(any(moved), all(moved), bool(broken))

    def is_as_is(self, answer: Answer) -> bool:
        """Whether answers are those of the source as it is, but for their last digits."""
        return all(
            np.allclose(answer(part, self.states.get(part, 0)), value, rtol=EQUAL, atol=EQUAL)
            for part, value in self.values.items()
        )

    def is_intact(self, edited: EditedCode) -> bool:
        """Whether equations that edits share still answer as they are without any edit."""
        try:
            with limit_processor_time(self.limit_s):
                answer = replace(edited, chosen=[NONE]).bind_shared(self.answer_keys[0])
                return all(
                    np.array_equal(answer(part, self.states.get(part, 0)), value)
                    for part, value in self.values.items()
                )
        except BaseException:  # whatever the code raises
            return False

    def judge(self, edited: EditedCode) -> EditVerdict:
        """What an edit mends. Raises whatever the code raises, and TooSlow."""
        with limit_processor_time(self.limit_s):
            answer = edited.bind_shared(self.answer_keys[0])
            levels = self._list_mended_levels(answer)
            values = answer(self.first_part, self.states[self.first_part])
            answers = [edited.bind(key) for key in self.answer_keys] if levels else []
            wrong = {level: self._find_wrong_entries(answers, level) for level in levels}
        mended = {level: each for level, each in wrong.items() if each < self.wrong[level]}
        return EditVerdict(mended, values)

    def compute_residuals(self, edited: EditedCode, *, everywhere: bool) -> list[np.ndarray]:
        """The answers of each wrong part less the right ones, at all states or at one.

        Raises whatever the code raises, and TooSlow.
        """
        here = self.answer_keys[0]
        trusted = here.levels[self.level]
        with limit_processor_time(self.limit_s):
            answer = edited.bind_shared(here)
            return [
                np.ravel([answer(part, k) - trusted.right[part][k] for k in states])
                for part, state in self.states.items()
                for states in [trusted.states if everywhere else [state]]
            ]

    def measure_distances(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """What the first wrong part lacks, by what is allowed, and the latter, beside each level.

        At its state, of levels beside which it is wrong there.
        """
        here, part = self.answer_keys[0], self.first_part
        for level in self.wrong:
            if self.wrong_there[level, part].any():
                trusted, state = here.levels[level], self.states[part]
                allowed = trusted.allowance(part, state)
                yield (trusted.right[part][state] - self.first_value) / allowed, allowed

    def format_entries(self, wrong: Wrong) -> tuple[str, ...]:
        """Entries in words, each once."""
        entries = sorted({entry for _, entry in wrong})
        return tuple(map(self.answer_keys[0].format_entry, entries))

    def _follow(
        self,
        answer_key: AnswerKey,
        trusted_here: LevelAnswers,
        answer_here: Answer,
        wrong_here: Collection[str],
    ) -> Answer | None:
        """The answers for another mechanism; None if the code does not take its numbers from it.

        It does not if it answers the same there, or if parts that are right here are mostly wrong
        there; of code whose numbers are exchanged, if nothing shows that it does: no entry right.
        """
        if self.level not in answer_key.levels:
            return None
        try:
            answer = self.as_is.bind(answer_key)
            if all(np.array_equal(answer(part, 0), answer_here(part, 0)) for part in self.parts):
                return None
        except Exception:  # of the user's code
            return None
        trusted = answer_key.levels[self.level]
        if answer_key.exchanged:
            right = self._list_right_entries(trusted_here, answer_here)
            wrong = trusted.find_wrong_entries(answer, self.parts)
            return answer if right and not right & wrong else None
        parts = [part for part in self.parts if part not in wrong_here]
        wrong = trusted.find_wrong_entries(answer, parts)
        is_followed = len(wrong) <= IGNORED * sum(trusted.right[part][0].size for part in parts)
        return answer if is_followed else None

    def _list_right_entries(self, trusted: LevelAnswers, answer: Answer) -> set[Entry]:
        """The entries that are right on a mechanism and not 0."""
        entries = {
            (part, *index)
            for part in self.parts
            for index in np.argwhere(
                (np.abs(trusted.right[part]) > trusted.allowed[part]).any(axis=0)
            ).tolist()
        }
        return entries - trusted.find_wrong_entries(answer, self.parts)

    def _find_wrong_entries(self, answers: Iterable[Answer], level: str) -> Wrong:
        """The entries that are wrong beside a level at any state, on all mechanisms."""
        keys = self.answer_keys
        return frozenset(
            (number, entry)
            for number, (key, answer) in enumerate(zip(keys, answers, strict=True))
            for entry in key.levels[level].find_wrong_entries(answer, self.parts)
        )

    def _mark_wrong(self, level: str, part: str, values: np.ndarray) -> np.ndarray:
        """Which entries of a wrong part are wrong at the one state, beside a level."""
        trusted, state = self.answer_keys[0].levels[level], self.states[part]
        distance = np.abs(values - trusted.right[part][state])
        wrong: np.ndarray = ~(distance <= trusted.allowance(part, state))
        return wrong

    def _list_mended_levels(self, answer: Answer) -> list[str]:
        """The levels beside which a wrong part is mended at one state, and none made worse."""
        holds = self.answer_keys[0].levels[self.level].holds
        levels, mended = list(self.wrong), set[str]()
        rows_left = dict[str, np.ndarray]()  # by part, those that stay wrong beside every level
        for part, state in self.states.items():
            before = {level: self.wrong_there[level, part] for level in levels}
            after, held = before, rows_left.get(holds.get(part, ""))
            if held is not None and all(
                (_mark_rows(each) <= held).all() for each in before.values()
            ):
                rows_left[part] = held
                continue
            values = answer(part, state)
            if (values != self.values[part]).any():
                after = {level: self._mark_wrong(level, part, values) for level in levels}
            levels = [level for level in levels if (after[level] <= before[level]).all()]
            mended |= {level for level in levels if (after[level] < before[level]).any()}
            if not levels:
                break
            rows_left[part] = np.asarray(
                np.all([_mark_rows(each) for each in after.values()], axis=0)
            )
        return [level for level in levels if level in mended]


def _mark_rows(wrong: np.ndarray) -> np.ndarray:
    """Which rows of a part have a wrong entry."""
    return np.asarray(wrong.reshape(len(wrong), -1).any(axis=1))


def _sum_seconds(seconds: Mapping[str, float | None], holds: Mapping[str, str], part: str) -> float:
    """Processor time [s] of a part and of those that it holds, which are to be asked before it."""
    held = _sum_seconds(seconds, holds, holds[part]) if part in holds else 0.0
    return held + (seconds[part] or 0.0)


def _measure_seconds(answer: Answer, part: str) -> float | None:
    """Processor time [s] that the first answer of a part takes; None if there is none."""
    begun = time.process_time()
    try:
        answer(part, 0)
    except Exception:  # of the user's code, which the trial has reported
        return None
    return time.process_time() - begun
