"""Which numbers of the arm's file equations follow: each is changed by itself, at a few states.

What the answers do not follow is a number in the user's code, or one that the equations leave out
because the arm has none of it. That is no error on this arm, and other arms must not change it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, combinations, islice

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
MOST_CHOICES = 64  # of numbers that may go with another
Perform = Callable[[Sequence[ModelTask]], Results]


@dataclass(frozen=True)
class Unfollowed:
    """A number of the arm's file that equations do not follow.

    parts: those of the equations that stay as they are while the right ones change, none of a
    number that by itself changes neither, and may in company; goes_with: the
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
        parts, right_entry, partly, matters = list[Part](), False, False, False
        for quantity, before in self._unchanged.right.items():
            if quantity not in there.yours:
                return None
            rounding = self._unchanged.sizes.tolerance(quantity) * self._unchanged.sizes.of(
                quantity
            )
            moved = np.abs(there.right[quantity] - before).max(axis=0) > rounding
            still = there.yours[quantity] - self._unchanged.yours[quantity]
            follows = bool((np.abs(still).max(axis=0) > rounding).any())
            matters = matters or follows or bool(moved.any())
            partly = partly or (follows and bool(moved.any()))
            if follows or not moved.any():
                continue
            parts.append(PARTS[quantity])
            places = {place_of(quantity, tuple(index)) for index in np.argwhere(moved).tolist()}
            right_entry = right_entry or not places <= self._wrong_here
        if matters and not parts:
            return None
        value = number_at(self.here.problem.case.arm, name)
        certain = right_entry or value == 0 or not matters
        return Unfollowed(name, value, tuple(parts), certain=certain, partly=partly)

    def _differs_beyond(self, there: Compared) -> bool:
        """Whether entries differ there that do not on the arm on trial."""
        return not {wrong.place for wrong in there.wrong} <= self._wrong_here

    def _together(self, found: list[Unfollowed], drivers: Sequence[str]) -> list[Unfollowed]:
        """The numbers, those that go with a driver so marked: its change alone is not followed."""
        arm = self.here.problem.case.arm
        loose = {each.name for each in found if each.parts}
        natural = {driver: natural_powers(arm, driver) for driver in drivers}
        all_loose = {
            driver: {name: power for name, power in powers.items() if name in loose}
            for driver, powers in natural.items()
        }
        # All that may go with a driver, as a rule does; else the fewest that do.
        settled = self._agreeing(list(all_loose.items()))
        fewer = [
            (driver, chosen)
            for driver, powers in all_loose.items()
            if driver not in settled
            for chosen in _subsets(powers)
        ]
        settled |= self._agreeing(fewer)
        goes_with: dict[str, dict[str, int]] = {}
        for driver, powers in settled.items():
            for name, power in powers.items():
                goes_with.setdefault(name, {})[driver] = power
        # Of one that goes with another here and is followed there, one of the two is an error.
        return [
            replace(each, goes_with=goes_with.get(each.name, {}))
            for each in found
            if not (each.partly and each.name in goes_with)
        ]

    def _agreeing(self, choices: Sequence[tuple[str, Powers]]) -> dict[str, Powers]:
        """By driver, the first choice with which no more entries differ than on this arm."""
        made = [self._scaled(driver, powers) if powers else None for driver, powers in choices]
        answers = iter(self._compared([each for each in made if each is not None]))
        found: dict[str, Powers] = {}
        for (driver, powers), arm in zip(choices, made, strict=True):
            there = None if arm is None else next(answers)
            if there is not None and not self._differs_beyond(there):
                found.setdefault(driver, powers)
        return found

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


def _subsets(powers: Powers) -> list[dict[str, int]]:
    """Choices of some of the numbers that may go with a driver, the fewest first."""
    chosen = chain.from_iterable(combinations(powers, size) for size in range(1, len(powers)))
    return [{name: powers[name] for name in names} for names in islice(chosen, MOST_CHOICES)]
