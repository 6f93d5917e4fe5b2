"""Finds the arm file's numbers on which equations depend, by changing one at a time.

What the answers do not follow is a number in the user's code, or one that the equations leave out
because the arm has none of it. That is no error on this arm, and other arms must not change it.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, combinations, islice

import numpy as np
from pydantic import ValidationError

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.loading import Case
from crosscheck.trial.arms.questions import VerificationProblem
from crosscheck.trial.changes.arms.arm_numbers import (
    Powers,
    find_natural_powers,
    get_number,
    list_number_names,
    nonzero_substitute,
    replace_numbers,
)
from crosscheck.trial.changes.arms.comparison import EntryComparison, Perform, ask_and_compare
from crosscheck.trial.judge.entries import EntryPlace, Part, entry_place, find_part

FEW_STATES = 3
FACTORS = (1.23, 0.77)  # factors on a number; the second is used if the first is out of its range
MOST_CHOICES = 64  # sets tried of numbers that may scale with another


@dataclass(frozen=True)
class IgnoredNumber:
    """A number of the arm's file that equations do not follow.

    parts: those of the equations that stay as they are while the right ones change, none of a
    number that by itself changes neither, and may in company; goes_with: the
    numbers that it goes with instead, and their powers; certain: whether an entry that depends on
    it is right on the user's arm, or the number is 0 there. If not, it may be an error. partly:
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
    """Dependence of equations on the numbers of their arm's file.

    comparison: the comparison on that arm; perform: asks questions of models.
    """

    comparison: EntryComparison
    perform: Perform

    @cached_property
    def _wrong_places(self) -> frozenset[EntryPlace]:
        return frozenset(wrong.place for wrong in self.comparison.wrong_entries)

    @cached_property
    def _unchanged_comparison(self) -> EntryComparison | None:
        """The comparison on the arm itself, at the few states."""
        (comparison,) = self._compare_on_arms([self.comparison.problem.case.arm])
        return comparison

    def find_ignored_numbers(self) -> list[IgnoredNumber]:
        """The numbers that the equations do not follow, in the order of the file."""
        if self._unchanged_comparison is None:
            return []
        names = list(list_number_names(self.comparison.problem.case.arm))
        arms = [self._scale_numbers(name, {}) for name in names]
        numbers, drivers = list[IgnoredNumber](), list[str]()
        for name, there in zip(names, self._compare_on_arms(arms), strict=True):
            if there is None:
                continue
            number = self._judge_number(name, there)
            if number is not None:
                numbers.append(number)
            elif self._has_new_errors(there):
                drivers.append(name)
        return self._mark_tied_numbers(numbers, drivers)

    @property
    def is_of_richer_level(self) -> bool:
        """Whether the equations follow a number of a joint that the level has not."""
        names = list_number_names(self.comparison.problem.case.arm)
        arms = [self._scale_numbers(name, {}) for name in names if name.startswith("joints")]
        return self._unchanged_comparison is not None and any(
            self._follows_alone(there) for there in self._compare_on_arms(arms) if there
        )

    def _follows_alone(self, there: EntryComparison) -> bool:
        """Whether the equations change from the arm to another, and the level does not."""
        here = self._unchanged_comparison
        assert here is not None  # else nobody asks
        moves = np.zeros(2, dtype=bool)
        for quantity, right in here.reference_values.items():
            if quantity in there.user_values:
                rounding = here.sizes.tolerance(quantity) * here.sizes.entry_sizes(quantity)
                for place, (new, old) in enumerate(
                    (
                        (there.user_values[quantity], here.user_values[quantity]),
                        (there.reference_values[quantity], right),
                    )
                ):
                    moves[place] |= bool((np.abs(new - old) > rounding).any())
        return bool(moves[0] and not moves[1])

    def _judge_number(self, name: str, there: EntryComparison) -> IgnoredNumber | None:
        """Judgment on a number, by the comparison on an arm with another value of it."""
        unchanged = self._unchanged_comparison
        assert unchanged is not None  # else nobody asks
        parts, right_entry, partly, matters = list[Part](), False, False, False
        for quantity, before in unchanged.reference_values.items():
            if quantity not in there.user_values:
                return None
            sizes = unchanged.sizes
            rounding = sizes.tolerance(quantity) * sizes.entry_sizes(quantity)
            moved = np.abs(there.reference_values[quantity] - before).max(axis=0) > rounding
            still = there.user_values[quantity] - unchanged.user_values[quantity]
            follows = bool((np.abs(still).max(axis=0) > rounding).any())
            matters = matters or follows or bool(moved.any())
            partly = partly or (follows and bool(moved.any()))
            if follows or not moved.any():
                continue
            parts.append(find_part(quantity))
            places = {entry_place(quantity, tuple(index)) for index in np.argwhere(moved).tolist()}
            right_entry = right_entry or not places <= self._wrong_places
        if matters and not parts:
            return None
        value = get_number(self.comparison.problem.case.arm, name)
        # Nearly everybody writes 9.81 into the code, where it is the file's number too.
        is_constant = name.startswith("gravity")
        certain = right_entry or value == 0 or is_constant or not matters
        return IgnoredNumber(name, value, tuple(parts), certain=certain, partly=partly)

    def _has_new_errors(self, there: EntryComparison) -> bool:
        """Whether entries differ there that do not on the user's arm."""
        return not {wrong.place for wrong in there.wrong_entries} <= self._wrong_places

    def _mark_tied_numbers(
        self, numbers: list[IgnoredNumber], drivers: Sequence[str]
    ) -> list[IgnoredNumber]:
        """The numbers, those that go with a driver so marked: its change alone is not followed."""
        arm = self.comparison.problem.case.arm
        loose = {each.name for each in numbers if each.parts}
        natural = {driver: find_natural_powers(arm, driver).items() for driver in drivers}
        all_loose = {driver: {n: p for n, p in natural[driver] if n in loose} for driver in drivers}
        # All that may go with a driver, as a rule does; else the fewest that do.
        settled = self._find_agreeing_choices(list(all_loose.items()))
        fewer = [
            (driver, chosen)
            for driver, powers in all_loose.items()
            if driver not in settled
            for chosen in _subsets(powers)
        ]
        settled |= self._find_agreeing_choices(fewer)
        goes_with: dict[str, dict[str, int]] = {}
        for driver, powers in settled.items():
            for name, power in powers.items():
                goes_with.setdefault(name, {})[driver] = power
        # Of one that goes with another here and is followed there, one of the two is an error.
        return [
            replace(each, goes_with=goes_with.get(each.name, {}))
            for each in numbers
            if not (each.partly and each.name in goes_with)
        ]

    def _find_agreeing_choices(self, choices: Sequence[tuple[str, Powers]]) -> dict[str, Powers]:
        """By driver, the first choice with which no more entries differ than on this arm."""
        arms = [self._scale_numbers(*each) if each[1] else None for each in choices]
        agreeing_powers: dict[str, Powers] = {}
        for (driver, powers), there in zip(choices, self._compare_on_arms(arms), strict=True):
            if there is not None and not self._has_new_errors(there):
                agreeing_powers.setdefault(driver, powers)
        return agreeing_powers

    def _scale_numbers(self, driver: str, powers: Powers) -> Arm | None:
        """The arm with another number of this name, others by the powers of its factor.

        None where there is none.
        """
        arm = self.comparison.problem.case.arm
        for factor in FACTORS:
            scaled = {driver: 1, **powers}
            numbers = {n: get_number(arm, n) * factor**power for n, power in scaled.items()}
            numbers[driver] = numbers[driver] or nonzero_substitute(arm, driver)
            with suppress(ValidationError):
                return replace_numbers(arm, numbers) if numbers[driver] else None
        return None

    def _compare_on_arms(self, arms: Sequence[Arm | None]) -> list[EntryComparison | None]:
        """The comparison on each arm at a few states, None where there is no arm or no answer."""
        problems = [None if arm is None else self._adapt_to_arm(arm) for arm in arms]
        answering = [each for each in problems if each is not None]
        compared = iter(ask_and_compare(answering, self.comparison.level, self.perform))
        return [None if each is None else next(compared) for each in problems]

    def _adapt_to_arm(self, arm: Arm) -> VerificationProblem | None:
        """The problem on another arm at few states, the drive as it is.

        Of the corners of mesh laws, which may be 64, the bias by pairs of rates needs none.
        """
        problem = self.comparison.problem
        case = Case(arm, problem.case.scenario, problem.case.switches)
        try:
            equations = problem.equations.adapt_to_arm(arm, case.scenario)
        except InputError:  # equations of some arms alone
            return None
        return replace(problem, equations=equations, case=case, count=FEW_STATES, few_corners=0)


def _subsets(powers: Powers) -> list[dict[str, int]]:
    """Choices of some of the numbers that may go with a driver, the fewest first."""
    chosen = chain.from_iterable(combinations(powers, size) for size in range(1, len(powers)))
    return [{name: powers[name] for name in names} for names in islice(chosen, MOST_CHOICES)]
