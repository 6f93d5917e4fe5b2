"""Entries of M that differ from their mirror images, in words."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.robot_states import TOLERANCE
from crosscheck.models.robot.robot import Level
from crosscheck.report.formatting import list_first
from crosscheck.trial.robots.judge import RobotProblem


def describe_asymmetry(problem: RobotProblem, level: Level) -> str:
    """The sentence on entries of M that differ from their mirror images; '' for none."""
    if "mass_matrix" not in problem.parts:
        return ""
    mass, size = problem.answers.values["mass_matrix"], problem.sizes[level].mass_matrix
    wrong = _find_wrong_places(problem, level, "mass_matrix")
    for which, half in (("below", np.tri(len(wrong), k=-1)), ("above", np.tri(len(wrong), k=-1).T)):
        if wrong.any() and not (mass * half).any() and not (wrong & (half == 0)).any():
            return (
                f"mass_matrix is 0 {which} the diagonal, and right elsewhere: is one of its"
                " triangles alone filled?"
            )
    unequal = (np.abs(mass - mass.swapaxes(1, 2)) > TOLERANCE * size).any(axis=0)
    pairs = np.argwhere(np.triu(unequal & (wrong | wrong.T), 1)).tolist()
    if not pairs:
        return ""
    also = list_first([problem.entry_name("mass_matrix", each) for each in pairs])
    return f"mass_matrix is not symmetric: {also}"


def _find_wrong_places(problem: RobotProblem, level: Level, part: str) -> np.ndarray:
    """Which entries of a part, (n,) or (n, n), differ from a level."""
    errors = problem.relative_errors(level)[part]
    wrong: np.ndarray = ~(np.abs(errors).max(axis=0) <= problem.sizes[level].tolerance(part))
    return wrong
