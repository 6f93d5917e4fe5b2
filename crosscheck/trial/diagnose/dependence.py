"""Which numbers of the arm's file equations follow: each is changed by itself, at a few states.

What the answers do not follow is a number in the user's code, or one that the equations leave out
because the arm has none of it. That is no error on this arm, and other arms must not change it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, combinations

import numpy as np
from pydantic import ValidationError

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.loading import Case
from crosscheck.planning.comparison import ModelTask, Results, Unavailable
from crosscheck.trial.diagnose.arm_numbers import (
    Powers,
    instead_of_0,
    names_of_numbers,
    natural_powers,
    number_at,
    with_numbers,
)
from crosscheck.trial.diagnose.reasons import Compared, compared, entry_questions
from crosscheck.trial.judge.places import PARTS, EntryPlace, Part, place_of
from crosscheck.trial.judge.questions import VerificationProblem

FEW_STATES = 3
FACTORS = (1.23, 0.77)  # of a number; the second where the first is out of its range
MOST_TOGETHER = 6  # numbers that are tried with another, in every choice of some of them
Perform = Callable[[Sequence[ModelTask]], Results]


@dataclass(frozen=True)
class Unfollowed:
    """A number of the arm's file that equations do not follow.

    parts: those of the equations that stay as they are while the right ones change; goes_with: the
    numbers that it goes with instead, and their powers; certain: whether an entry that depends on
    it is right on the arm on trial, or the number is 0 there. If not, it may be an error. partly:
    whether other parts follow it.
    """

    name: str
    value: float
    parts: tuple[Part, ...]
    goes_with: Powers = field(default_factory=dict)
    certain: bool = True
    partly: bool = False


@dataclass(frozen=True)
class Dependence:
    """How equations depend on the numbers of their arm's file.

    here: the comparison on that arm; perform: asks questions of models.
    """

    here: Compared
    perform: Perform

    @cached_property
    def _wrong_here(self) -> frozenset[EntryPlace]:
        return frozenset(wrong.place for wrong in self.here.wrong)

    @cached_property
    def _unchanged(self) -> Compared | None:
        """The comparison on the arm itself, at the few states."""
        (found,) = self._compared([self.here.problem.case.arm])
        return found

    def unfollowed(self) -> list[Unfollowed]:
        """The numbers that the equations do not follow, in the order of the file."""
        if self._unchanged is None:
            return []
        arm = self.here.problem.case.arm
        changes = {name: self._changed(name) for name in names_of_numbers(arm)}
        arms = [arm for arm in changes.values() if arm is not None]
        answers = iter(self._compared(arms))
        found, drivers = list[Unfollowed](), list[str]()
        for name, changed in changes.items():
            there = None if changed is None else next(answers)
            if there is None:
                continue
            own = self._judged(name, there)
            if own is not None:
                found.append(own)
            elif self._differs_beyond(there):
                drivers.append(name)
        return self._together(found, drivers)

    def _judged(self, name: str, there: Compared) -> Unfollowed | None:
        """What is said of a number, by the comparison on the arm where it is another one."""
        assert self._unchanged is not None  # else nobody asks
        parts, right_entry, partly = list[Part](), False, False
        for quantity, before in self._unchanged.right.items():
            if quantity not in there.yours:
                return None
            rounding = self._unchanged.sizes.tolerance(quantity) * self._unchanged.sizes.of(
                quantity
            )
            moved = np.abs(there.right[quantity] - before).max(axis=0) > rounding
            still = there.yours[quantity] - self._unchanged.yours[quantity]
            if not moved.any():
                continue
            if (np.abs(still).max(axis=0) > rounding).any():
                partly = True
                continue
            parts.append(PARTS[quantity])
            places = {place_of(quantity, tuple(index)) for index in np.argwhere(moved).tolist()}
            right_entry = right_entry or not places <= self._wrong_here
        if not parts:
            return None
        value = number_at(self.here.problem.case.arm, name)
        certain = right_entry or value == 0
        return Unfollowed(name, value, tuple(parts), certain=certain, partly=partly)

    def _differs_beyond(self, there: Compared) -> bool:
        """Whether entries differ there that do not on the arm on trial."""
        return not {wrong.place for wrong in there.wrong} <= self._wrong_here

    def _together(self, found: list[Unfollowed], drivers: Sequence[str]) -> list[Unfollowed]:
        """The numbers, those that go with a driver so marked: its change alone is not followed."""
        arm = self.here.problem.case.arm
        loose = {each.name for each in found}
        choices = [
            (driver, chosen)
            for driver in drivers
            for chosen in _subsets(natural_powers(arm, driver), loose)
        ]
        made = [self._scaled(driver, powers) for driver, powers in choices]
        answers = iter(self._compared([each for each in made if each is not None]))
        goes_with: dict[str, dict[str, int]] = {}
        settled: set[str] = set()
        for (driver, powers), there in zip(choices, made, strict=True):
            there_compared = None if there is None else next(answers)
            if driver in settled or there_compared is None:
                continue
            if not self._differs_beyond(there_compared):
                settled.add(driver)
                for name, power in powers.items():
                    goes_with.setdefault(name, {})[driver] = power
        # Of one that goes with another here and is followed there, one of the two is an error.
        return [
            replace(each, goes_with=goes_with.get(each.name, {}))
            for each in found
            if not (each.partly and each.name in goes_with)
        ]

    def _changed(self, name: str) -> Arm | None:
        """The arm with another number of this name; None where there is none."""
        arm = self.here.problem.case.arm
        value = number_at(arm, name)
        for factor in FACTORS:
            other = value * factor if value else instead_of_0(arm, name)
            try:
                return with_numbers(arm, {name: other}) if other else None
            except ValidationError:
                continue
        return None

    def _scaled(self, driver: str, powers: Powers) -> Arm | None:
        """The arm with a driver's number by a factor, others by the powers of that."""
        arm = self.here.problem.case.arm
        for factor in FACTORS:
            scaled = {driver: 1, **powers}
            numbers = {n: number_at(arm, n) * factor**power for n, power in scaled.items()}
            try:
                return with_numbers(arm, numbers)
            except ValidationError:
                continue
        return None

    def _compared(self, arms: Sequence[Arm]) -> list[Compared | None]:
        """The comparison on each arm at a few states, None where there is no answer."""
        problems = [self._on(arm) for arm in arms]
        level, quantities = self.here.level, list(self.here.yours)
        tasks = dict.fromkeys(
            task
            for problem in problems
            if problem is not None
            for task in entry_questions(problem, [level], quantities)
        )
        results = self.perform(list(tasks))
        found: list[Compared | None] = []
        for problem in problems:
            there = None if problem is None else _answered(problem, level, quantities, results)
            found.append(there)
        return found

    def _on(self, arm: Arm) -> VerificationProblem | None:
        """The problem on another arm at few states, the drive as it is."""
        problem = self.here.problem
        case = Case(arm, problem.case.scenario, problem.case.switches)
        try:
            equations = problem.equations.on(arm, case.scenario)
        except InputError:  # equations of some arms alone
            return None
        return replace(problem, equations=equations, case=case, count=FEW_STATES)


def kept_numbers(unfollowed: Sequence[Unfollowed]) -> Mapping[str, Powers]:
    """The numbers that other arms must not draw, and what each goes with."""
    return {each.name: each.goes_with for each in unfollowed}


def _answered(
    problem: VerificationProblem, level: str, quantities: Sequence[str], results: Results
) -> Compared | None:
    try:
        return compared(problem, level, quantities, results)
    except Unavailable:
        return None


def _subsets(powers: Powers, loose: set[str]) -> Iterator[dict[str, int]]:
    """Choices of numbers that may go with a driver, the fewest first; none of them is empty."""
    names = [name for name in powers if name in loose][:MOST_TOGETHER]
    sizes = range(1, len(names) + 1)
    for chosen in chain.from_iterable(combinations(names, size) for size in sizes):
        yield {name: powers[name] for name in chosen}
