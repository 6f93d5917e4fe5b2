"""Two changes of a robot at once: all pairs of single ones, by what each alone makes of a row.

Where neither alters what the other one makes, a difference is the sum of both rows, and one matrix
of their products says what every pair leaves. Where both act on one product, that sum is where the
search begins, and the terms of a robot that has both decide.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from crosscheck.checks.robot_states import TOLERANCE
from crosscheck.models.robot.robot import Robot
from crosscheck.trial.changes.numbers import RobotNumber, merge_records
from crosscheck.trial.changes.problem import Places
from crosscheck.trial.changes.values import ValueSearch

FITS = 1e-6  # largest residual of a pair at the screened states, over the difference's norm
LARGEST = 10.0  # largest norm of a row in a pair, over the difference's norm
BLOCK = 512  # rows that are paired with all others at once
NEAR = 1e-9  # rounding error of products of large rows, over the difference's square
FAR = 0.5  # largest residual at which a search begins, over the difference's square
MOST_MEETING = 400  # pairs that act on one product, those that leave least alone
NEVER, APART, MEETING = 0, 1, 2  # whether two changes are no pair, or act on one product
MOTION = "motion"


@dataclass(frozen=True)
class Single:
    """A change that may be one of two: a number with a value, or one thing taken for another.

    row: what it makes at few states, once or in a step of its number where that is free; whole: at
    all states, of one without a robot; value: of its number, None where it is free; robot: with
    one thing taken for another, where it is no sum.
    """

    words: str
    row: np.ndarray
    whole: np.ndarray | None = None
    robot: Robot | None = None
    number: RobotNumber | None = None
    value: float | None = None

    @property
    def is_free(self) -> bool:
        """Whether the change may be made any number of times."""
        return self.number is not None and self.value is None

    def get_value(self, times: float) -> float:
        """The value of its number; of a free one after so many steps."""
        assert self.number is not None  # whose value is asked for
        free = self.number.value + self.number.step * times
        return free if self.value is None else self.value

    def build_robot(self, times: float) -> Robot | None:
        """The robot that has the change; None where no robot can have it."""
        return self.robot if self.number is None else self.number.put(self.get_value(times))


class ChangePair(NamedTuple):
    """Two changes by number, and how many times the free one of them is made."""

    first: int
    second: int
    times: float


class PairSearch:
    """The search for two changes that together make the difference from a level."""

    def __init__(self, search: ValueSearch, singles: Sequence[Single]) -> None:
        self.search, self.problem, self.table = search, search.problem, search.table
        self.changes = singles
        self.rows = np.array([each.row for each in singles])
        self.is_free = np.array([each.is_free for each in singles])
        # Of one number there are several changes, two of which are none.
        self.owners = np.array([id(each.number or each) for each in singles])

    @cached_property
    def _touched(self) -> np.ndarray:
        """Parts of the robot that each change touches (changes, 1 + parts), as 0 or 1.

        The first part is the motion of all bodies.
        """
        touched = dict[int, set[str]]()
        for owner, change in zip(self.owners.tolist(), self.changes, strict=True):
            if owner not in touched:
                robot = change.build_robot(1.0)
                touched[owner] = find_changed_parts(self.table.robot, robot) if robot else set()
        parts = [MOTION, *sorted(set().union(*touched.values()) - {MOTION})]
        rows = {owner: np.isin(parts, list(those)) for owner, those in touched.items()}
        return np.array([rows[owner] for owner in self.owners.tolist()], np.float32)

    def _find_meetings(self, kept: np.ndarray) -> np.ndarray:
        """Whether two of some changes (changes, changes) are a pair, and act on one product.

        Those do, of which there are robots, of one body or rotor; and whatever moves bodies, with
        all others.
        """
        touched, owners = self._touched[kept], self.owners[kept]
        moves = touched[:, :1] * touched.any(axis=1)
        meets = (touched @ touched.T + moves + moves.T) > 0
        meetings = np.where(meets, np.int8(MEETING), np.int8(APART))
        meetings[owners == owners[:, None]] = NEVER
        return meetings

    def find_pairs(self, places: Places) -> Iterator[tuple[str, bool]]:
        """Pairs that leave nothing of the difference in some places, in words.

        With each, whether both are values or things that somebody may well have written.
        """
        described = set[str]()
        at, chosen = self.problem.select_screened(places, self.table.few)
        difference, rows = self.problem.difference[at], self.rows[:, chosen]
        sizes, norm = np.linalg.norm(rows, axis=1), float(np.linalg.norm(difference))
        is_part = (sizes > TOLERANCE * np.sqrt(len(at))) & (sizes <= LARGEST * norm)
        kept = np.flatnonzero(is_part)
        if not kept.size:
            return
        pairs, meeting = (
            [ChangePair(int(kept[i]), int(kept[j]), times) for i, j, times in each]
            for each in rank_pairs(
                rows[kept], self.is_free[kept], difference, self._find_meetings(kept)
            )
        )
        pairs = [
            pair for pair in pairs if self._measure_rest(pair, rows, difference) <= FITS * norm
        ]
        pairs += self._solve_meeting(meeting, difference, chosen)
        for pair in pairs:
            words = sorted(self._describe(self.changes[n], pair.times) for n in pair[:2])
            together = "; and ".join(words)
            if together not in described and all(words) and self._explains(pair, places):
                described.add(together)
                yield together, all(self._is_usual(self.changes[n], pair.times) for n in pair[:2])

    def _describe(self, change: Single, times: float) -> str:
        """The words on a change; '' for a value that no robot has."""
        if change.number is None:
            return change.words
        value = change.get_value(times)
        is_possible = self.search.is_possible(change.number, value)
        return self.search.describe_value(change.number, value) if is_possible else ""

    def _is_usual(self, change: Single, times: float) -> bool:
        number = change.number
        return number is None or self.search.is_usual(number, change.get_value(times))

    def _measure_rest(self, pair: ChangePair, rows: np.ndarray, difference: np.ndarray) -> float:
        times = [pair.times if self.is_free[number] else 1.0 for number in pair[:2]]
        return float(np.linalg.norm(difference - times @ rows[list(pair[:2])]))

    def _solve_meeting(
        self, pairs: list[ChangePair], difference: np.ndarray, chosen: np.ndarray
    ) -> list[ChangePair]:
        """Those pairs, on one product, that leave nothing: the terms of a robot are linear in one.

        chosen: the places of a row at few states.
        """
        robots = [self._merge(pair._replace(times=x)) for x in (0.0, 1.0) for pair in pairs]
        if not robots:
            return []
        few = self.table.few
        changes = self.table.compute_changes(robots, self.problem.level, few)
        rows, solved = self.problem.lay_out(changes, few)[:, chosen], list[ChangePair]()
        for pair, still, once in zip(pairs, *np.split(rows, 2), strict=True):
            step, wrong = once - still, difference - still
            square = float(step @ step)
            times = float(step @ wrong) / square if square else 0.0
            if np.linalg.norm(wrong - times * step) <= FITS * np.linalg.norm(difference):
                solved.append(pair._replace(times=times))
        return solved

    def _merge(self, pair: ChangePair) -> Robot:
        """The robot with both changes."""
        first, second = (self.changes[n].build_robot(pair.times) for n in pair[:2])
        robot: Robot = merge_records(self.table.robot, first, second)
        return robot

    def _explains(self, pair: ChangePair, places: Places) -> bool:
        """Whether a pair explains the difference at all states."""
        two = [self.changes[n] for n in pair[:2]]
        robots = [robot for each in two if (robot := each.build_robot(pair.times)) is not None]
        robots = [self._merge(pair)] if len(robots) == len(two) else robots
        total = np.zeros_like(self.problem.difference)
        total += sum(each.whole for each in two if each.whole is not None)
        if robots:
            changes = self.table.compute_changes(robots, self.problem.level)
            total = total + self.problem.lay_out(changes).sum(axis=0)
        return self.problem.can_explain(total, places)


def rank_pairs(
    rows: np.ndarray, is_free: np.ndarray, difference: np.ndarray, meets: np.ndarray
) -> tuple[list[ChangePair], list[ChangePair]]:
    """Pairs of changes that leave nothing of a difference (places,); those that may by a product.

    rows (changes, places): what each change makes, once or, if free, times any factor; meets
    (changes, changes): whether two act on one product, NEVER for what is no pair. Of these pairs
    there are the MOST_MEETING that leave least. Two free changes are none: any difference of two
    dimensions would be such a pair.
    """
    along, square = rows @ difference, float(difference @ difference)
    norms = np.maximum((rows**2).sum(axis=1), 1e-300)
    alone = square - 2 * along + norms  # residual if each is made alone
    exact, meeting = list[ChangePair](), list[tuple[float, ChangePair]]()
    fixed = np.flatnonzero(~is_free)
    for begin in range(0, len(fixed), BLOCK):
        some = fixed[begin : begin + BLOCK]
        gram = rows[some] @ rows.T
        times = np.where(is_free, (along - gram) / norms, 1.0)
        left = alone[some, None] - times * (2 * (along - gram) - times * norms)
        how = meets[some]
        once = is_free | (some[:, None] < np.arange(len(rows)))  # of two fixed ones, in one order
        places = np.argwhere(once & (how == APART) & (left <= NEAR * square))
        exact += [ChangePair(int(some[i]), int(j), float(times[i, j])) for i, j in places]
        places = np.argwhere(once & (how == MEETING) & (left < FAR * square))
        if len(places) > MOST_MEETING:
            chosen = np.argpartition(left[tuple(places.T)], MOST_MEETING)
            places = places[chosen[:MOST_MEETING]]
        meeting += [
            (float(left[i, j]), ChangePair(int(some[i]), int(j), float(times[i, j])))
            for i, j in places
        ]
    return exact, [pair for _, pair in sorted(meeting)[:MOST_MEETING]]


def find_changed_parts(base: Robot, robot: Robot) -> set[str]:
    """Names of parts that differ in another robot, as `bodies 2`, or the motion of all bodies."""
    if robot.joints is not base.joints or robot.gravity is not base.gravity:
        return {MOTION}
    changed = set()
    for kind in ("bodies", "rotors", "stages"):
        before, after = getattr(base, kind), getattr(robot, kind)
        count = max(len(before), len(after))
        same = [a is b for a, b in zip(before, after, strict=False)]
        changed |= {f"{kind} {n}" for n in range(count) if n >= len(same) or not same[n]}
    return changed
