"""Search for the change of a mechanism that explains a difference, in all parts or some entries."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice, product
from typing import Any

import numpy as np

from crosscheck.checks.robot_states import TOLERANCE
from crosscheck.models.robot.robot import Robot, RobotBody
from crosscheck.trial.changes.mistakes import list_frame_mistakes
from crosscheck.trial.changes.numbers import (
    ALIKE,
    AXES,
    FIXED,
    RobotNumber,
    get_link_name,
    put_value,
    set_entry,
)
from crosscheck.trial.changes.pairs import PairSearch, Single
from crosscheck.trial.changes.problem import (
    ACCELERATION,
    LEFT,
    ROUNDING,
    ChangeProblem,
    DynamicsTerms,
    Entry,
    Places,
)
from crosscheck.trial.changes.steps import Steps
from crosscheck.trial.changes.table import ChangeTable
from crosscheck.trial.judge.entries import PART_TITLES, LevelDistance

# Largest residual of a number's effect that is worth a try, over the difference's norm.
CLOSE = 1e-4
PROMISING = 0.9  # largest residual after a first Newton step, relative to the one before
STEPS = 12  # steps of Newton's method
NEAR = 1e-4  # step of differentiation, relative to that of the number
SLENDER = 1e-9  # inertia of a thin rod about its own axis, over its largest moment of inertia
MOST_EQUAL_PAIRS = 12  # pairs that explain a difference, at which the search stops
MOST_SCREENED = 64  # places of a row, those of the largest differences, at which all are screened
# Largest second-order effect of a number that counts as linear, over the first-order one.
LINEAR = 1e-9
MOST_NAMED = 3  # entries that are named one by one
MOST_OTHERS = 3  # causes of one part, beyond which they are no more than a coincidence
MOST_EQUALS = 2  # causes in one sentence that no state distinguishes
LEAST_ENTRIES = 3  # wrong entries needed before fitting six inertias means more than chance
# A mistake in Kane's sum in words, what may have it, and what it changes of a row (names, places).
StepRows = tuple[str, list[str], np.ndarray]


@dataclass(frozen=True)
class Cause:
    """The cause of a difference, in words that complete `with ...`.

    usual: whether the number is 0, has the other sign, is twice or half as large or is another of
    the file, so that somebody may well have written it. missing: name of a number that is 0; path:
    of the number; is_compound: whether several numbers are changed at once.
    """

    words: str
    usual: bool
    missing: str = ""
    path: str = ""
    is_compound: bool = False


class CauseSearch(PairSearch):
    """The search for what makes the difference between equations and a level."""

    def __init__(self, problem: ChangeProblem, table: ChangeTable | None = None) -> None:
        super().__init__(problem, table or ChangeTable(problem))
        self.difference = problem.difference
        self.row, self.can_explain = problem.lay_out, problem.can_explain

    def find_causes(self, places: Places = slice(None)) -> list[Cause]:
        """Every likely change that leaves nothing of the difference in some places of the row."""
        numbers = list(self._find_numbers(places))
        plain = [cause for number, cause in numbers if not number.factor]
        numbers_alone = plain or [cause for _, cause in numbers]  # a factor says no more than one
        mistakes = list(self._find_mistakes(places))
        alone = [each for each in mistakes if not each.several] or mistakes
        # All products of inertia of a link say no more than the only one.
        alike = tuple(f"{each.name.partition(': I')[0]}: all products" for each, _ in numbers)
        alone = [each for each in alone if not each.words.startswith(alike)]
        return [*numbers_alone, *(Cause(each.words, usual=True) for each in alone)]

    @cached_property
    def number_rows(self) -> tuple[np.ndarray, np.ndarray]:
        """First- and second-order effect (numbers, places) of each number on the row."""
        linear, square = map(self.row, self.table.compute_number_effects(self.level))
        return linear, square

    def _find_numbers(self, places: Places) -> Iterator[tuple[RobotNumber, Cause]]:
        wrong, numbers = self.difference[places], self.table.select_numbers(self.level)
        allowed = CLOSE * np.linalg.norm(wrong)
        linears, squares = (effect[:, places] for effect in self.number_rows)
        near = measure_rest(wrong, linears, squares) <= 2 * allowed  # by any two factors
        for number, linear, square in zip(
            np.array(numbers)[near], linears[near], squares[near], strict=True
        ):
            by = solve_step(linear, square, wrong)
            left = np.linalg.norm(wrong - linear * by - square * by**2)
            value = number.value + by * number.step
            value *= abs(value) > ROUNDING * number.step  # no mass just below 0
            if not by or left > allowed or not self.is_possible(number, value):
                continue
            if self._holds(number, value, places):
                is_left_out = abs(value) < ALIKE * number.step and not number.factor
                words, usual = self.describe_value(number, value), self.is_usual(number, value)
                yield number, Cause(words, usual, number.name * is_left_out, number.path)

    def _holds(self, number: RobotNumber, value: float, places: Places) -> bool:
        """Whether a value explains the difference, by terms computed with the value itself."""
        return self.can_explain(self._compute_row(number.put(value)), places)

    def _compute_row(self, robot: Robot) -> np.ndarray:
        """What a robot changes of the row."""
        return self.row(self.table.compute_changes([robot], self.level))[0]

    @cached_property
    def step_rows(self) -> list[StepRows]:
        """All mistakes in Kane's sum, at several states."""
        return self._lay_out_steps(self.table.list_steps(self.level), self.table.several)

    def _lay_out_steps(self, steps: Sequence[Steps], states: slice) -> list[StepRows]:
        rows = []
        for words, changes in (pair for each in steps for pair in each.items()):
            stacked = DynamicsTerms(*map(np.array, zip(*changes.values(), strict=True)))
            rows.append((words, list(changes), self.row(stacked, states)))
        return rows

    @cached_property
    def _mistakes(self) -> list[Single]:
        """Each thing that may be taken for another: at one link, joint or rotor; at every one."""
        few, singles = self.problem.list_places(self.table.few), list[Single]()
        for words, names, rows in self._lay_out_steps(self.table.body_steps, slice(None)):
            for name, row in zip(names, rows, strict=True):
                singles.append(Single(f"{name}: {words}", row[few], row))
            if len(names) > 1:
                every, together = rows.sum(axis=0), _join_names(names, names)
                singles.append(Single(f"{together}: {words}", every[few], every, several=True))
        mistakes = list(list_frame_mistakes(self.table.robot, self.level))
        states, robots = self.table.few, [each.robot for each in mistakes]
        changed = self.row(self.table.compute_changes(robots, self.level, states), states)
        for each, row in zip(mistakes, changed, strict=True):
            singles.append(Single(each.words, row, robot=each.robot, several=each.several))
        return singles

    def _find_mistakes(self, places: Places) -> Iterator[Single]:
        """The things taken for others that have an effect in some places and explain these."""
        at, chosen = self.problem.select_screened(places, self.table.few)
        rows = np.array([each.row[chosen] for each in self._mistakes])
        left = np.abs(rows - self.difference[at]) - 2 * self.problem.allowed[at]
        for number in np.flatnonzero((left <= TOLERANCE).all(axis=1)).tolist():
            each = self._mistakes[number]
            row = self._compute_row(each.robot) if each.robot else each.whole
            assert row is not None  # of a link
            has_effect = np.abs(row[places]).max(initial=0.0) > TOLERANCE
            if has_effect and self.can_explain(row, places):
                yield each

    def find_pair_causes(self, places: Places = slice(None)) -> list[Cause]:
        """Two changes at once that leave nothing of the difference, at least one of them usual.

        Those come first of which both are.
        """
        pairs = dict(islice(self.find_pairs(places), MOST_EQUAL_PAIRS))
        causes = [
            Cause(f"two changes: {words}", usual, is_compound=True)
            for words, usual in pairs.items()
        ]
        return sorted(causes, key=lambda cause: not cause.usual)

    @cached_property
    def singles(self) -> list[Single]:
        """Every single change, of which two may be made: numbers first."""
        return [*self._list_number_changes(), *self._mistakes]

    def _list_number_changes(self) -> Iterator[Single]:
        few = self.problem.list_places(self.table.few)
        linears, squares = self.number_rows
        numbers = self.table.select_numbers(self.level)
        for number, linear, square in zip(numbers, linears[:, few], squares[:, few], strict=True):
            if np.abs(square).max() <= LINEAR * np.abs(linear).max():
                yield Single("", linear, number=number)
            values = [by * number.value for by in number.usual_factors]
            for value in dict.fromkeys([*values, *number.list_counterparts(numbers)]):
                steps = (value - number.value) / number.step
                row = linear * steps + square * steps**2
                yield Single("", row, number=number, value=value)

    def find_acceleration_causes(self, row: int) -> Iterator[Cause]:
        """Numbers with other values of which one row of the accelerations alone is right."""
        states, values = self.problem.states, self.problem.values["acceleration"][:, row]
        base = self.table.compute_base(self.level)
        effects = self.table.compute_number_effects(self.level)
        for place, number in enumerate(self.table.select_numbers(self.level)):

            def left(by: float, place: int = place) -> np.ndarray:
                mass, bias, gravity = (
                    term + by * first[place] + by**2 * second[place]
                    for term, first, second in zip(base, *effects, strict=True)
                )
                try:
                    pushed = (states.torques - bias - gravity)[..., None]
                    return values - np.linalg.solve(mass, pushed)[:, row, 0]
                except np.linalg.LinAlgError:
                    return np.full_like(values, np.nan)

            by = find_root(left, 0.0, 1.0)
            if by and np.abs(left(by)).max() <= LEFT * np.abs(left(0.0)).max():
                value = number.value + by * number.step
                if self.is_possible(number, value):
                    yield Cause(self.describe_value(number, value), self.is_usual(number, value))

    def find_inertia_causes(self, places: Places = slice(None)) -> Iterator[Cause]:
        """The six inertias of a link together."""
        robot, entries = self.table.robot, np.argwhere(np.triu(np.ones((3, 3)))).tolist()
        for number, body in enumerate(robot.bodies):
            units = np.array([set_entry(np.zeros((3, 3)), tuple(entry), 1.0) for entry in entries])
            path = "bodies", number, "inertia"
            robots = [put_value(robot, path, body.inertia + unit) for unit in units]
            rows = self.row(self.table.compute_changes(robots, self.level))
            scale = np.maximum(np.abs(rows).max(axis=1), 1e-300)
            columns = (rows[:, places] / scale[:, None]).T
            fit, _, rank, _ = np.linalg.lstsq(columns, self.difference[places], rcond=1e-10)
            if self.can_explain(fit / scale @ rows, places):
                inertia = body.inertia + np.tensordot(fit / scale, units, 1)
                link = get_link_name(robot, number)
                words = describe_inertia(link, body, inertia, rank == 6)
                yield Cause(words, usual=False, is_compound=True)

    def find_step_causes(self, several: Sequence[Places]) -> Iterator[tuple[int, Cause]]:
        """Mistakes in Kane's sum at some bodies or joints, and the places that each explains.

        several: of the row, by number; each mistake is reported with the first ones it explains.
        """
        wholes = list[str]()
        inside = [self.problem.select_screened(each, self.table.several) for each in several]
        for words, names, rows in self.step_rows:
            for number, (at, places) in enumerate(inside):
                chosen, _ = self.choose_rows(rows[:, places], at)
                if not chosen:
                    continue
                there = [
                    n for n, row in zip(names, rows, strict=True) if np.abs(row).max() > TOLERANCE
                ]
                whole = f"{_join_names([names[n] for n in chosen], there)}: {words}"
                if not any(whole.startswith(each) for each in wholes):  # a place says no more
                    wholes.append(whole)
                    yield number, Cause(whole, usual=True)
                break

    def find_within(
        self, part: str, wrong: Mapping[str, Entry], *, alone: bool
    ) -> tuple[str, list[Cause]]:
        """Causes of the difference of one part, and where they hold: in it, or in its entries.

        wrong: entries by name; alone: whether no other part is wrong. Beside others some number
        would often explain one part by chance, so that it counts only if somebody may well have
        written it.
        """
        # A row of the balance that accelerations are held in is no row of these.
        has_entries = part not in ("bias", ACCELERATION)
        if len(wrong) == 1 and has_entries:
            ((name, place),) = wrong.items()
            causes = self.find_causes(self.problem.select_entries(part, [place]))
            if lost := [each for each in causes if each.missing]:
                return name, lost
        within = self._generate_within(part, wrong, alone, has_entries)
        return next((each for each in within if each[1]), (part, []))

    def _generate_within(
        self, part: str, wrong: Mapping[str, Entry], alone: bool, has_entries: bool
    ) -> Iterator[tuple[str, list[Cause]]]:
        """What may explain a part, or all of its wrong entries, the likeliest first."""
        whole, some = self.problem.select_part(part), f"the wrong entries of {part}"
        yield part, [each for each in self.find_causes(whole) if alone or each.usual]
        inside = self.problem.select_entries(part, wrong.values())
        steps = list(self.find_step_causes([whole, inside] if has_entries else [whole]))
        yield part, [cause for number, cause in steps if not number]
        if has_entries:
            where = " and ".join(wrong) if len(wrong) <= MOST_NAMED else some
            yield where, [each for each in self.find_causes(inside) if each.usual]
            yield where, [cause for _, cause in steps]
        if alone and len(wrong) > 1:
            yield part, [each for each in self.find_pair_causes(whole) if each.usual]
        if alone and part == "mass_matrix" and len(wrong) >= LEAST_ENTRIES:
            yield part, list(self.find_inertia_causes(whole))

    def choose_rows(
        self, rows: np.ndarray, places: Places, *, is_free: bool = False
    ) -> tuple[list[int], float]:
        """Numbers of the changes (changes, places) that together explain some places of the row.

        Each once, or all times one factor where that is free.
        """
        wrong, allowed = self.difference[places], self.problem.allowed[places]
        there = np.flatnonzero(np.abs(rows).max(axis=1, initial=0.0) > TOLERANCE)
        if not there.size:
            return [], 0.0
        inside, screened = rows[there], np.argsort(-np.abs(wrong))[:MOST_SCREENED]
        fit = np.linalg.lstsq(inside[:, screened].T, wrong[screened], rcond=1e-10)[0]
        left = np.abs(fit @ inside[:, screened] - wrong[screened])
        if (left > 2 * allowed[screened]).any():  # nor do any others leave less
            return [], 0.0
        some = np.abs(fit) > ALIKE if is_free else np.clip(np.rint(fit), 0, 1)
        single, every = np.eye(there.size), np.ones(there.size)
        picks = [every, *single] if is_free else [*single, every, *(every - single)]
        for pick in (*picks, some):
            total = pick @ inside
            square = float(total @ total)
            by = float(total @ wrong) / square if is_free and square else 1.0
            if square and (np.abs(wrong - by * total) <= allowed).all():
                return list(there[pick > 0]), by
        return [], 0.0


def find_explanations(
    searches: Mapping[Any, CauseSearch], distances: Sequence[LevelDistance]
) -> tuple[Any, list[Cause]]:
    """The first level at which single changes explain all, and these; else the first, and none.

    Among levels of as many wrong entries one where somebody may well have made the change.
    """
    level, single_causes = distances[0].level, list[Cause]()
    first: int | None = None
    for each in distances:
        if first is not None and each.entries > first:
            break
        causes = searches[each.level].find_causes()
        if causes and (first is None or any(cause.usual for cause in causes)):
            level, single_causes, first = each.level, causes, each.entries
        if any(cause.usual for cause in causes):
            break
    return level, single_causes


def find_rarer_explanations(
    searches: Mapping[Any, CauseSearch], distances: Sequence[LevelDistance]
) -> tuple[Any, list[Cause]]:
    """Explain by a term of Kane's sum, two changes or six inertias, at the nearest level.

    Among levels with equally many wrong entries the first is taken.
    """

    def find_steps(search: CauseSearch) -> list[Cause]:
        equals = search.find_step_causes([slice(None)])
        return [cause for _, cause in islice(equals, 1 + MOST_OTHERS)]

    def find_inertias(search: CauseSearch) -> list[Cause]:
        has_inertia = "mass_matrix" in search.problem.parts
        is_wide = has_inertia and distances[0].entries >= LEAST_ENTRIES
        return list(search.find_inertia_causes()) if is_wide else []

    nearest = [each.level for each in distances if each.entries == distances[0].entries]
    pairs = CauseSearch.find_pair_causes
    kinds: list[Callable[[CauseSearch], list[Cause]]] = [find_steps, pairs, find_inertias]
    for find, level in product(kinds, nearest):
        if causes := find(searches[level]):
            return level, causes
    return distances[0].level, []


def describe_causes(causes: Sequence[Cause], where: str) -> Iterator[str]:
    """Sentences on causes in one place, the usual ones first.

    Beside a usual one no number is named that nobody would have written.
    """
    usual = sorted(filter(lambda cause: cause.usual, causes), key=lambda cause: not cause.missing)
    place, named, also = PART_TITLES.get(where, where), usual or causes, ""
    if named and named[0].missing:
        yield f"{named[0].missing} is missing in {place}"
        named, also = named[1:], " also"
    if named:
        words = list_equals([cause.words for cause in named])
        yield f"{place} alone would{also} be explained by {words}"


def name_causes(causes: Sequence[Cause]) -> list[str]:
    """What explains all, in words; of many numbers that nobody would have written so, two.

    A constant in one entry is made by many numbers.
    """
    words = list(dict.fromkeys(cause.words for cause in causes))
    if len(words) <= MOST_OTHERS or any(cause.usual for cause in causes):
        return words
    return [f"another value of one of {len(words)} numbers, such as {' or '.join(words[:2])}"]


def list_equals(causes: Sequence[str]) -> str:
    """The first two of causes that no state distinguishes, in words after `by`."""
    return ", or by ".join(causes[:MOST_EQUALS])


def _join_names(names: Sequence[str], there: Sequence[str]) -> str:
    """Names of bodies or joints at which something is wrong, of those at which it may be."""
    for begin in ("joint ", ""):
        alike = [name for name in there if name.startswith(begin)]
        if len(names) > 1 and list(names) == alike:
            every = f"every {begin.split(' ')[0] or 'link'}"
            return every + FIXED * names[0].endswith(FIXED)
    return " and ".join(names)


def describe_inertia(link: str, body: RobotBody, inertia: np.ndarray, is_unique: bool) -> str:
    """A link's inertia beside the right one, in words."""
    if not is_unique:
        return f"{link}: its inertia about the centre of mass another one"
    right, moments = np.linalg.eigvalsh(body.inertia), np.linalg.eigvalsh(inertia)
    size = float(right[-1]) or 1.0
    if np.abs(right - moments).max() < LEFT * size:
        return f"{link}: its principal axes of inertia turned, its principal moments right"
    changed = [
        f"I{AXES[i]}{AXES[j]} = {inertia[i, j]:.6g} kg m^2 (file: {body.inertia[i, j]:.6g} kg m^2)"
        for i, j in zip(*np.triu_indices(3), strict=True)
        if abs(inertia[i, j] - body.inertia[i, j]) > LEFT * size
    ]
    least = -SLENDER * moments[2]
    remark = ""
    if moments[0] < least or moments[0] + moments[1] - moments[2] < least:
        mixed = ": are its six numbers mixed up?" if len(changed) > 1 else ""
        remark = f"; no body has these moments{mixed}"
    elif moments[0] < -least:
        axis = int(np.abs(np.linalg.eigh(inertia)[1][:, 0]).argmax())
        remark = f": a slender rod along {AXES[axis]}"
    return f"{link}: its inertia {', '.join(changed)}{remark}"


def find_root(left: Callable[[float], np.ndarray], begin: float, size: float) -> float | None:
    """The number with which least is left, by Gauss and Newton; None where the first step fails."""
    value, near = begin, NEAR * size
    for step in range(STEPS):
        here, slope = left(value), (left(value + near) - left(value - near)) / (2 * near)
        square = float(slope @ slope)
        if not 0 < square < np.inf:
            return None
        by = -float(slope @ here) / square
        left_over = np.linalg.norm(here + by * slope)
        if not step and left_over > PROMISING * np.linalg.norm(here):
            return None
        value += float(np.clip(by, -size, size))
        if abs(by) < 1e-10 * size:
            break
    return value


def solve_step(linear: np.ndarray, square: np.ndarray, difference: np.ndarray) -> float:
    """x that makes linear x + square x^2 nearest to a difference; 0 if it changes nothing.

    Of two that do alike, as a ratio of either sign, the smaller one.
    """
    coefficients = [
        2 * square @ square,
        3 * linear @ square,
        linear @ linear - 2 * square @ difference,
        -linear @ difference,
    ]
    if not coefficients[2] and not coefficients[0]:
        return 0.0
    largest = max(map(abs, coefficients))
    trimmed = [each if abs(each) > 1e-24 * largest else 0.0 for each in coefficients]
    roots = np.roots(np.trim_zeros(trimmed, "f"))
    real = roots[np.abs(roots.imag) <= 1e-6 * (1 + np.abs(roots.real))].real
    if not real.size:
        return 0.0
    left = np.array([np.linalg.norm(difference - linear * x - square * x**2) for x in real])
    alike = real[left <= left.min() + ROUNDING * np.linalg.norm(difference)]
    return float(alike[int(np.argmin(np.abs(alike)))])


def measure_rest(difference: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """The norm of what two columns (..., states) together leave of a difference (states,)."""
    rest = _remove_part(np.broadcast_to(difference, first.shape), first)
    return np.linalg.norm(_remove_part(rest, _remove_part(second, first)), axis=-1)


def _remove_part(values: np.ndarray, column: np.ndarray) -> np.ndarray:
    """The values (..., states) less their part along a column, which may be 0."""
    square = (column * column).sum(axis=-1, keepdims=True)
    part: np.ndarray = (values * column).sum(axis=-1, keepdims=True) / np.where(square, square, 1)
    return values - part * column
