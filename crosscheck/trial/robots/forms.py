"""Sentences on friction that a robot's equations have wrong, and on rows of its accelerations."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, combinations_with_replacement

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.models.robot.robot import Level
from crosscheck.trial.changes.forms import SIZABLE, format_factor
from crosscheck.trial.changes.numbers import ALIKE
from crosscheck.trial.judge.entries import format_rates
from crosscheck.trial.robots.judge import RobotProblem
from crosscheck.trial.robots.rates import sample_bias_terms


def list_acceleration_pieces(problem: RobotProblem, level: Level) -> dict[str, np.ndarray]:
    """Contribution of each motor, the weights and each product of rates to the accelerations."""
    states, names = problem.states, problem.names
    model = AnalyticRobot(problem.robot, level)
    inverse = np.linalg.inv(model.mass_matrix(states.q))
    forces = {"the weights": -model.gravity(states.q), "the springs": -problem.spring_torques}
    for number, name in enumerate(names):
        torque = np.zeros_like(states.torques)
        torque[:, number] = states.torques[:, number]
        forces[f"the torque of {name}"] = torque
    products = sample_bias_terms(model.bias, states).products
    for j, k in combinations_with_replacement(range(len(names)), 2):
        rates = format_rates((j, k), names)
        forces[rates] = -products[:, :, j, k] * (states.v[:, j] * states.v[:, k])[:, None]
    return {name: np.einsum("sij,sj->si", inverse, each) for name, each in forces.items()}


def describe_friction(
    problem: RobotProblem, level: Level, part: str, difference: np.ndarray
) -> Iterator[tuple[str, list[int]]]:
    """Sentences on friction that a force or bias has wrong, and the rows that it makes wrong.

    difference (states, n): yours less right, at the first states.
    """
    first = slice(len(difference))
    where = problem.answers.sources[part]
    size = np.broadcast_to(problem.sizes[level].entry_sizes(part, where), problem.states.v.shape)
    # What is right of a bias that seems to have none has none either.
    is_there = part == "force" or where == "inverse_dynamics" or problem.answers.friction_in_bias
    rows_by_factor: dict[str, list[int]] = {}
    for row in range(len(problem.names)):
        friction, wrong = problem.friction[first, row], difference[:, row]
        friction = -friction if part == "force" else friction
        least = SIZABLE * float(size[:, row].max())
        if np.abs(wrong).max() <= least or np.abs(friction).max() <= least:
            continue
        share = float(wrong @ friction / (friction @ friction))
        if np.abs(wrong - share * friction).max() <= ALIKE * np.abs(wrong).max():
            rows_by_factor.setdefault(format_factor(is_there + share), []).append(row)
    for factor, rows in rows_by_factor.items():
        names = [problem.names[row] for row in rows]
        entry = f"{where}[{names[0]}]" if len(names) == 1 else where
        yield f"{entry}, the friction of {' and '.join(names)}: {factor}", rows


def describe_accelerations(
    problem: RobotProblem, level: Level, rows: Sequence[int]
) -> Iterator[str]:
    """Sentences on rows of an acceleration in which one or two pieces are wrong by a factor."""
    user_values, right = (
        values["acceleration"]
        for values in (problem.answers.values, problem.reference_values[level])
    )
    pieces, sizes = list_acceleration_pieces(problem, level), problem.sizes[level].acceleration
    described = False
    for row in rows:
        wrong, least = user_values[:, row] - right[:, row], SIZABLE * float(sizes[:, row].max())
        there = {name: each[:, row] for name, each in pieces.items()}
        there = {name: each for name, each in there.items() if np.abs(each).max() > least}
        for names in (*combinations(there, 1), *combinations(there, 2)):
            total = np.sum([there[name] for name in names], axis=0)
            share = float(total @ wrong / (total @ total)) if total.any() else 0.0
            if np.abs(wrong - share * total).max() <= ALIKE * np.abs(wrong).max():
                part = f"the part due to {' and '.join(names)}"
                yield f"acceleration[{problem.names[row]}], {part}: {format_factor(1 + share)}"
                described = True
                break
    ratios = user_values / right
    if not described and len(rows) > 1 and np.ptp(ratios, axis=1).max() <= ALIKE * ratios.max():
        yield (
            "acceleration: at each state all rows are wrong by the same factor, from"
            f" {ratios.min():.4g} to {ratios.max():.4g}: their common denominator, M's determinant"
        )
