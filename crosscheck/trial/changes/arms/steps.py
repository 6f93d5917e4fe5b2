"""Steps of an arm's derivation done otherwise, by the search that finds those of robots."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robot_states import RandomStates
from crosscheck.models.robot.planar import build_level_robots
from crosscheck.trial.changes.arms.comparison import QUANTITIES, EntryComparison
from crosscheck.trial.changes.kane import FACTORS
from crosscheck.trial.changes.numbers import ALIKE
from crosscheck.trial.changes.problem import ChangeProblem
from crosscheck.trial.changes.search import CauseSearch
from crosscheck.trial.judge.entries import PART_TITLES, Part, Term, TermError

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
        there = [w for w in find(build_change_problem(arm, part)) if not OUT_OF_PLANE.search(w)]
        words = [each for each in words if each in there] if number else there
        if not words:
            break
    words = list(dict.fromkeys(words))
    described = [NUMBERED.sub(r"\1 \2", each) for each in words[:MOST_MATCHES]]
    return [TermError("swapped", Term(""), each) for each in described]


def build_change_problem(arm: EntryComparison, part: Part) -> ChangeProblem:
    """The differences of a part at some states, as changes of the arm's robot must make them.

    A geared arm has the bodies of one whose gears are dead weight, for its others only spin.
    Friction is taken from the torques.
    """
    robot, level = build_level_robots(arm.problem.case.arm)[arm.level or "carriers"]
    matrix, theta = arm.frame.matrix, arm.frame.layout.theta
    assert matrix is not None  # else there are no terms
    few, quantity = slice(STATES), QUANTITIES[part]
    u, sizes = arm.rates[few], arm.sizes.entry_sizes(quantity)
    values = [each[quantity][few] for each in (arm.user_values, arm.reference_values)]
    if part == "bias":
        values = [np.einsum("sijk,sj,sk->si", each, u, u) for each in values]
        sizes = np.einsum("ijk,sj,sk->si", sizes, np.abs(u), np.abs(u))
    sizes = np.where(sizes > 0, sizes, 1.0) + np.zeros_like(values[0])
    v, still = u @ matrix[theta].T, np.zeros_like(arm.angles[few])
    torques = still
    if part == "acceleration":
        torques = arm.force_states.torque[few] - v * robot.friction
        sizes = arm.sizes.force + np.zeros_like(v @ matrix[theta])  # of the balance
    diagonal = np.einsum("sii->si", AnalyticRobot(robot, level).mass_matrix(arm.angles[few]))
    return ChangeProblem(
        robot=robot,
        level=level,
        states=RandomStates(arm.angles[few], v, still, torques),
        values={part: values[0]},
        right={part: values[1]},
        sizes={"mass_matrix": np.sqrt(diagonal[:, :, None] * diagonal[:, None]), part: sizes},
        tolerances={part: arm.sizes.tolerance(quantity)},
        turns=matrix[theta],
    )
