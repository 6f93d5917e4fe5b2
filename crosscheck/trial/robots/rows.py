"""Entries of M that differ from their mirror images; right rows say where the others go wrong."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.robot_states import TOLERANCE
from crosscheck.models.robot.robot import BASE, Level, Robot
from crosscheck.report.formatting import join_words, list_first
from crosscheck.trial.changes.numbers import get_link_name
from crosscheck.trial.robots.judge import RobotProblem


def describe_asymmetry(problem: RobotProblem, level: Level) -> str:
    """The sentence on entries of M that differ from their mirror images; '' for none."""
    if "mass_matrix" not in problem.parts:
        return ""
    mass, size = problem.answers.values["mass_matrix"], problem.sizes[level].mass_matrix
    errors = np.abs(problem.relative_errors(level)["mass_matrix"]).max(axis=0)
    wrong: np.ndarray = ~(errors <= problem.sizes[level].tolerance("mass_matrix"))
    for which, half in (("below", np.tri(len(wrong), k=-1)), ("above", np.tri(len(wrong), k=-1).T)):
        if wrong.any() and not (mass * half).any() and not (wrong & (half == 0)).any():
            return (
                f"M is 0 {which} the diagonal, and right elsewhere: is one of its"
                " triangles alone filled?"
            )
    unequal = (np.abs(mass - mass.swapaxes(1, 2)) > TOLERANCE * size).any(axis=0)
    pairs = np.argwhere(np.triu(unequal & (wrong | wrong.T), 1)).tolist()
    if not pairs:
        return ""
    if len(pairs) == 1:
        place, mirror = sorted((pairs[0], pairs[0][::-1]), key=lambda each: not wrong[tuple(each)])
        name, mirror_name = (problem.entry_name("mass_matrix", each) for each in (place, mirror))
        also = "both are wrong" if wrong[tuple(mirror)] else f"{mirror_name} is right"
        return f"M is not symmetric: {name} differs from {mirror_name}; {also}"
    rows, columns = (np.array(~wrong.any(axis=axis)) for axis in (1, 0))
    lines, right = ("rows", rows) if rows.any() else ("columns", columns)
    if right.any():
        also = f"{_join_places(lines, right)} right, {_join_places(lines, ~right)} wrong"
        also += _describe_way(problem.robot, lines, right) if rows.any() != columns.any() else ""
    else:
        also = list_first([problem.entry_name("mass_matrix", each) for each in pairs])
    return f"M is not symmetric in {len(pairs)} pairs; {also}"


def _describe_way(robot: Robot, lines: str, right: np.ndarray) -> str:
    """State between which links the outward or inward recursion fails, by right rows or columns.

    A wrong row means wrong forces at a joint, a wrong column wrong accelerations: at one joint and
    at all before it, if the recursion fails between two links.
    """
    if len(right) != len(robot.joints):
        return ""  # rows of joints that others follow are sums
    steps = [(n, joint.parent) for n, joint in enumerate(robot.joints) if joint.parent != BASE]
    broken = [(after, before) for after, before in steps if right[after] != right[before]]
    if len(broken) != 1 or not right[broken[0][0]]:
        return ""
    after, before = (get_link_name(robot, number) for number in broken[0])
    if lines == "rows":
        return f": forces go wrong on their way back, from {after} to {before}"
    return f": accelerations go wrong on their way out, from {before} to {after}"


def _join_places(lines: str, chosen: np.ndarray) -> str:
    """The chosen rows or columns by numbers from 1, such as `rows 1 and 4 to 7 are`."""
    numbers, runs = np.flatnonzero(chosen) + 1, list[str]()
    for run in np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1):
        runs += [f"{run[0]} to {run[-1]}"] if len(run) > 2 else [str(each) for each in run]
    line, verb = (lines, "are") if len(numbers) > 1 else (lines[:-1], "is")
    return f"{line} {join_words(runs)} {verb}"
