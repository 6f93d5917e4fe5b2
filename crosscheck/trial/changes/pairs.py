"""Two changes of a robot at once: all pairs of single ones, by what each alone makes of a row.

Where neither alters what the other one makes, a difference is the sum of both rows, and one matrix
of their products says what every pair leaves.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from crosscheck.checks.robot_states import TOLERANCE
from crosscheck.models.robot.robot import Robot
from crosscheck.trial.changes.numbers import RobotNumber
from crosscheck.trial.changes.problem import Places
from crosscheck.trial.changes.table import ValueSearch

FITS = 1e-6  # largest residual of a pair at the screened states, over the difference's norm
LARGEST = 10.0  # largest norm of a row in a pair, over the difference's norm
BLOCK = 512  # rows that are paired with all others at once
NEAR = 1e-9  # rounding error of products of large rows, over the difference's square


@dataclass(frozen=True)
class Single:
    """A change that may be one of two: a number with a value, or one thing taken for another.

    row: what it makes at few states, once or in a step of its number where that is free; whole: at
    all states, of one without a robot; value: of its number, None where it is free; robot: with
    one thing taken for another, where it is no sum; several: whether at every part of a kind.
    """

    words: str
    row: np.ndarray
    whole: np.ndarray | None = None
    robot: Robot | None = None
    number: RobotNumber | None = None
    value: float | None = None
    several: bool = False

    @property
    def is_free(self) -> bool:
        """Whether the change may be made any number of times."""
        return self.number is not None and self.value is None

    def get_value(self, times: float) -> float:
        """The value of its number; of a free one after so many steps."""
        assert self.number is not None  # whose value is asked for
        free = self.number.value + self.number.step * times
        return free if self.value is None else self.value


class PairSearch(ValueSearch, ABC):
    """The search for two changes that together make the difference from a level."""

    @property
    @abstractmethod
    def singles(self) -> Sequence[Single]:
        """The changes that may be one of two."""

    @property
    def owners(self) -> np.ndarray:
        """What each change is of: two of one number are no pair."""
        return np.array([id(each.number or each) for each in self.singles])

    def find_pairs(self, places: Places) -> Iterator[tuple[str, bool]]:
        """Pairs that leave nothing of the difference in some places, in words.

        With each, whether both are values or things that somebody may well have written.
        """
        described = set[str]()
        at, chosen = self.problem.select_screened(places, self.table.few)
        difference = self.problem.difference[at]
        rows = np.array([each.row[chosen] for each in self.singles])
        is_free = np.array([each.is_free for each in self.singles])
        sizes, norm = np.linalg.norm(rows, axis=1), float(np.linalg.norm(difference))
        is_part = (sizes > TOLERANCE * np.sqrt(len(at))) & (sizes <= LARGEST * norm)
        kept = np.flatnonzero(is_part)
        pairs = rank_pairs(rows[kept], is_free[kept], difference, self.owners[kept])
        for i, j, times in pairs:
            pair = self.singles[kept[i]], self.singles[kept[j]]
            factors = [times if each.is_free else 1.0 for each in pair]
            if np.linalg.norm(difference - factors @ rows[kept[[i, j]]]) > FITS * norm:
                continue
            words = sorted(self._describe(each, times) for each in pair)
            together = "; and ".join(words)
            if together not in described and all(words) and self._makes_all(pair, times, places):
                described.add(together)
                yield together, all(self._is_likely(each, times) for each in pair)

    def _describe(self, change: Single, times: float) -> str:
        """The words on a change; '' for a value that no robot has."""
        if change.number is None:
            return change.words
        value = change.get_value(times)
        is_possible = self.is_possible(change.number, value)
        return self.describe_value(change.number, value) if is_possible else ""

    def _is_likely(self, change: Single, times: float) -> bool:
        number = change.number
        return number is None or self.is_usual(number, change.get_value(times))

    def _makes_all(self, pair: Sequence[Single], times: float, places: Places) -> bool:
        """Whether a pair explains the difference at all states."""
        total = np.zeros_like(self.problem.difference)
        for each in pair:
            if each.whole is not None:
                total += each.whole
                continue
            robot = each.number.put(each.get_value(times)) if each.number else each.robot
            assert robot is not None  # of one thing taken for another that is no sum
            changes = self.table.compute_changes([robot], self.problem.level)
            total += self.problem.lay_out(changes)[0]
        return self.problem.can_explain(total, places)


def rank_pairs(
    rows: np.ndarray, is_free: np.ndarray, difference: np.ndarray, owners: np.ndarray
) -> list[tuple[int, int, float]]:
    """Pairs that leave nothing of a difference (places,), and how often their free one is made.

    rows (changes, places): what each change makes, once or, if free, times any factor; owners
    (changes,): what each is a change of, two of which are no pair. Nor are two free changes: any
    difference of two dimensions would be such a pair.
    """
    along, square = rows @ difference, float(difference @ difference)
    norms = np.maximum((rows**2).sum(axis=1), 1e-300)
    alone = square - 2 * along + norms  # residual if each is made alone
    pairs, fixed = list[tuple[int, int, float]](), np.flatnonzero(~is_free)
    for begin in range(0, len(fixed), BLOCK):
        some = fixed[begin : begin + BLOCK]
        gram = rows[some] @ rows.T
        times = np.where(is_free, (along - gram) / norms, 1.0)
        left = alone[some, None] - times * (2 * (along - gram) - times * norms)
        once = is_free | (some[:, None] < np.arange(len(rows)))  # of two fixed ones, in one order
        is_pair = once & (owners[some, None] != owners) & (left <= NEAR * square)
        pairs += [(int(some[i]), int(j), float(times[i, j])) for i, j in np.argwhere(is_pair)]
    return pairs
