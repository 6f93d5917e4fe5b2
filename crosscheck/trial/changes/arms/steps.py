"""Changes of an arm and of its derivation, by the search that finds those of robots."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robot_states import RandomStates
from crosscheck.models.robot.planar import build_level_robots
from crosscheck.trial.changes.arms.arm_numbers import list_robot_numbers
from crosscheck.trial.changes.arms.comparison import EntryComparison
from crosscheck.trial.changes.kane import FACTORS
from crosscheck.trial.changes.numbers import ALIKE
from crosscheck.trial.changes.problem import ChangeProblem
from crosscheck.trial.changes.search import CauseSearch, find_explanations, name_causes
from crosscheck.trial.changes.table import ChangeTable
from crosscheck.trial.judge.entries import (
    PART_TITLES,
    LevelDistance,
    Part,
    Term,
    TermError,
    find_part,
)

UNITS = {  # of whole parts
    by**power: f"{by**power:.6g} times as large: another unit?"
    for by in (1e3, 180 / np.pi)
    for power in (1, -1, 2, -2)
}
STATES = 12  # at which a step must make the difference
MOST_MATCHES = 12
NUMBERED = re.compile(r"\b(?:joint )?(link|joint|motor|ring|carrier)_(\d+)")  # names in the robot
OUT_OF_PLANE = re.compile(r"\bz\b|\bI[xyz]{2}\b")  # what a plane has none of


def find_steps(arms: Sequence[EntryComparison], part: Part) -> list[TermError]:
    """Steps of a derivation that make all that is wrong in a part, on every arm.

    They are in the words of the arm's robot.
    """

    def find(problem: ChangeProblem) -> Iterator[str]:
        wrong, right = problem.differences[part], problem.right[part]
        for by, factor in (FACTORS | UNITS).items():
            if np.abs(wrong - (by - 1) * right).max() <= ALIKE * np.abs(wrong).max():
                yield f"all of {PART_TITLES.get(part, part)} {factor}"
        search = CauseSearch(problem)
        yield from (each.words for each in search.find_causes() if each.usual)
        yield from (cause.words for _, cause in search.find_step_causes([slice(None)]))

    words, frame = list[str](), arms[0].frame
    if part == "acceleration" and len(frame.names) > len(frame.layout.theta):
        return []  # what gears weigh is none of the robot's
    for number, arm in enumerate(arms):
        problem = build_change_problem(arm, [part])
        there = [words for words in find(problem) if not OUT_OF_PLANE.search(words)]
        words = [each for each in words if each in there] if number else there
        if not words:
            break
    described = map(_name_by_number, list(dict.fromkeys(words))[:MOST_MATCHES])
    return [TermError("swapped", Term(""), each) for each in described]


class LevelChanges(NamedTuple):
    """A level, and changes in words, each of which explains all that is wrong beside it.

    is_unusual: whether the first changes several numbers, or one to a value of no meaning.
    """

    level: str
    words: list[str]
    is_unusual: bool = False


def find_changes(
    arms: Mapping[str, EntryComparison],
    distances: Sequence[LevelDistance],
    compare_probes: Callable[[str], Sequence[EntryComparison]],
) -> LevelChanges:
    """The level of an arm at which one change explains all that is wrong, and such changes.

    Else two that somebody may well have made, if there are no other arms.

    arms: the comparison with each level that may be meant; distances: theirs, the nearest first;
    compare_probes: the comparisons of other arms with a level, which the change must explain too.
    """
    searches = {level: _search_numbers(arm) for level, arm in arms.items()}
    level, causes = find_explanations(searches, distances)
    causes = [each for each in causes if each.path] or causes  # not left out twice, as 0 and as so
    probes = compare_probes(level)
    if not (causes or probes):
        causes = [each for each in searches[level].find_pair_causes() if each.usual]
    for probe in probes if causes else ():
        there = {each.path or each.words for each in _search_numbers(probe).find_causes()}
        causes = [each for each in causes if (each.path or each.words) in there]
    described = name_causes([each for each in causes if not OUT_OF_PLANE.search(each.words)])
    is_unusual = any(not each.usual or each.is_compound for each in causes[:1])
    return LevelChanges(level, list(map(_name_by_number, described)), is_unusual)


def _search_numbers(arm: EntryComparison) -> CauseSearch:
    """The search among the numbers of an arm's file and what its robot may be taken for."""
    problem = build_change_problem(arm, [find_part(each) for each in arm.user_values])
    numbers = list_robot_numbers(arm.problem.case.arm, has_gears=arm.level != "links")
    return CauseSearch(problem, ChangeTable(problem, list(numbers)))


def _name_by_number(words: str) -> str:
    """Words on links and joints by their numbers, not by their names in the arm's robot."""
    return NUMBERED.sub(r"\1 \2", words)


def build_change_problem(arm: EntryComparison, parts: Sequence[Part]) -> ChangeProblem:
    """The differences of parts at some states, as changes of the arm's robot must make them.

    A geared arm has the bodies of one whose gears are dead weight, for its others only spin.
    Friction is taken from the torques.
    """
    robot, level = build_level_robots(arm.problem.case.arm)[arm.level or "carriers"]
    matrix, theta = arm.frame.matrix, arm.frame.layout.theta
    assert matrix is not None  # else there are no terms
    few, u = slice(STATES), arm.states.u[:STATES]
    v, still = u @ matrix[theta].T, np.zeros_like(arm.angles[few])
    values, right, sizes = dict[str, Any](), dict[str, Any](), dict[str, Any]()
    quantities = {find_part(each): each for each in arm.user_values}
    for part in parts:
        quantity = quantities[part]
        size = arm.sizes.entry_sizes(quantity)
        values[part], right[part] = (
            each[quantity][few] for each in (arm.user_values, arm.reference_values)
        )
        if part == "bias":
            for terms in (values, right):
                terms[part] = np.einsum("sijk,sj,sk->si", terms[part], u, u)
            size = np.einsum("ijk,sj,sk->si", size, np.abs(u), np.abs(u))
        elif part == "acceleration":
            size = arm.sizes.force  # of the balance
        sizes[part] = np.where(size > 0, size, 1.0) + np.zeros_like(values[part])
    is_pushed = "acceleration" in parts
    diagonal = np.einsum("sii->si", AnalyticRobot(robot, level).mass_matrix(arm.angles[few]))
    mass_size = np.sqrt(diagonal[:, :, None] * diagonal[:, None])
    return ChangeProblem(
        robot=robot,
        level=level,
        states=RandomStates(
            arm.angles[few],
            v,
            still,
            arm.states.torque[few] - v * robot.friction if is_pushed else still,
        ),
        values=values,
        right=right,
        sizes={"mass_matrix": mass_size, **sizes},
        tolerances={part: arm.sizes.tolerance(quantities[part]) for part in parts},
        is_driven=arm.problem.has_gravity,
        turns=matrix[theta],
    )
