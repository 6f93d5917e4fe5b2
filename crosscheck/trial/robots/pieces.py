"""Pieces that equations are summed up of, one of which may be wrong by a factor.

Of an acceleration: what each motor, the weights and each product of two rates make of it. Of a
bias, by Kane's sum: of each body what its centre's acceleration asks for, its angular acceleration,
and its gyroscopic torque.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.models.robot.robot import BASE, Level, Robot
from crosscheck.trial.robots.candidates import ALIKE, get_link_name
from crosscheck.trial.robots.judge import RobotProblem
from crosscheck.trial.robots.rates import sample_bias_terms

SIZABLE = 1e-9  # of an entry's size: a piece that is less cannot be told
USUAL = {0.0: "missing", -1.0: "with the opposite sign", 0.5: "half as large", 2.0: "twice"}
Pieces = Mapping[str, np.ndarray]


def describe_wrong_piece(difference: np.ndarray, pieces: Pieces, size: float, most: int) -> str:
    """The fewest pieces, at most `most`, that all are wrong by one factor, in words; '' for none.

    difference (k,): yours less right, at all states; pieces: what is right of each, alike.
    """
    there = {name: p for name, p in pieces.items() if np.abs(p).max() > SIZABLE * size}
    for count in range(1, most + 1):
        for names in combinations(there, count):
            total = sum((there[name] for name in names), np.zeros_like(difference))
            share = float(total @ difference / (total @ total)) if total.any() else 0.0
            left = np.abs(difference - share * total).max()
            if left <= ALIKE * np.abs(difference).max():
                factor = 1 + share
                usual = [words for by, words in USUAL.items() if abs(factor - by) < ALIKE]
                words = usual[0] if usual else f"{factor:.6g} times as large"
                makes = "makes" if count == 1 else "make"
                return f"what {' and '.join(names)} {makes}: {words}"
    return ""


def list_acceleration_pieces(problem: RobotProblem, level: Level) -> dict[str, np.ndarray]:
    """What each motor, the weights and each product of rates make of the accelerations."""
    states, names = problem.states, problem.names
    model = AnalyticRobot(problem.robot, level)
    inverse = np.linalg.inv(model.mass_matrix(states.q))
    forces = {"the weights": -model.gravity(states.q)}
    for number, name in enumerate(names):
        torque = np.zeros_like(states.torques)
        torque[:, number] = states.torques[:, number]
        forces[f"the torque of {name}"] = torque
    products = sample_bias_terms(model.bias, states).products
    for j, k in zip(*np.triu_indices(len(names)), strict=True):
        rates = f"{names[j]}'^2" if j == k else f"{names[j]}' {names[k]}'"
        forces[rates] = -products[:, :, j, k] * (states.v[:, j] * states.v[:, k])[:, None]
    return {name: np.einsum("sij,sj->si", inverse, each) for name, each in forces.items()}


def describe_bias_pieces(problem: RobotProblem, level: Level) -> Iterator[str]:
    """The sentence on a piece of Kane's sum that is wrong in the bias: of one body, or of all."""
    robot, states = problem.robot, problem.states
    difference = problem.answers.values["bias"] - problem.reference_values[level]["bias"]
    pieces = _list_bias_pieces(robot, states.q, states.v)
    size = float(problem.sizes[level].bias.max())
    kinds: dict[str, np.ndarray] = {}
    for (kind, _), piece in pieces.items():
        kinds[kind] = kinds.get(kind, np.zeros_like(piece)) + piece
    single = {f"{kind} of {link}": piece.ravel() for (kind, link), piece in pieces.items()}
    every = {f"{kind} of every link": piece.ravel() for kind, piece in kinds.items()}
    for group in (every, single):
        if words := describe_wrong_piece(difference.ravel(), group, size, 1):
            yield f"bias, {words}"
            return


def _list_bias_pieces(
    robot: Robot, q: np.ndarray, v: np.ndarray
) -> dict[tuple[str, str], np.ndarray]:
    """Generalized forces (states, n) by kind and link; {} for robots that have mimics."""
    if any(joint.mimic for joint in robot.joints):
        return {}
    rows = [_sum_up_state(robot, *each) for each in zip(q, v, strict=True)]
    return {key: np.array([row[key] for row in rows]) for key in rows[0]}


def _sum_up_state(robot: Robot, q: np.ndarray, v: np.ndarray) -> dict[tuple[str, str], np.ndarray]:
    size, still = len(robot.joints), np.zeros(3)
    # Of each body: rotation, place, rate, angular and linear acceleration; columns of Jacobians.
    bodies: list[tuple[np.ndarray, ...]] = []
    base = (np.eye(3), still, still, still, still, np.zeros((3, size)), np.zeros((3, size)))
    pieces: dict[tuple[str, str], np.ndarray] = {}
    for number, (joint, body) in enumerate(zip(robot.joints, robot.bodies, strict=True)):
        R, p, w, dw, a, turning, moving = base if joint.parent == BASE else bodies[joint.parent]
        arm = R @ joint.placement.position
        R = R @ joint.placement.rotation
        axis, turning, moving = R @ joint.axis, turning.copy(), moving.copy()
        slid = axis * q[number] if joint.kind == "prismatic" else still
        arm = arm + slid
        moving = moving + _cross_columns(turning, arm)
        a = a + np.cross(dw, arm) + np.cross(w, np.cross(w, arm))
        if joint.kind == "prismatic":
            moving[:, number] = axis
            a = a + 2 * np.cross(w, axis * v[number])
        else:
            turning[:, number] = axis
            dw = dw + np.cross(w, axis * v[number])
            w = w + axis * v[number]
            R = R @ _rotate(joint.axis, q[number])
        bodies.append((R, p + arm, w, dw, a, turning, moving))
        com, inertia = R @ body.com, R @ body.inertia @ R.T
        centre = a + np.cross(dw, com) + np.cross(w, np.cross(w, com))
        at_centre, link = moving + _cross_columns(turning, com), get_link_name(robot, number)
        pieces |= {
            ("the acceleration of the centre", link): body.mass * at_centre.T @ centre,
            ("the angular acceleration", link): turning.T @ inertia @ dw,
            ("the gyroscopic torque w x I w", link): turning.T @ np.cross(w, inertia @ w),
        }
    return pieces


def _cross_columns(columns: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """What rates about columns (3, n) make of the velocity at the end of an arm, (3, n)."""
    velocities: np.ndarray = np.cross(columns.T, arm).T
    return velocities


def _rotate(axis: np.ndarray, angle: float) -> np.ndarray:
    """The rotation (3, 3) about a unit vector."""
    skew = np.cross(np.eye(3), axis)
    turned: np.ndarray = np.eye(3) + np.sin(angle) * skew + (1 - np.cos(angle)) * skew @ skew
    return turned


def describe_accelerations(
    problem: RobotProblem, level: Level, rows: Sequence[int]
) -> Iterator[str]:
    """Sentences on rows of an acceleration in which one or two pieces are wrong by a factor."""
    difference = problem.answers.values["acceleration"]
    difference = difference - problem.reference_values[level]["acceleration"]
    pieces, sizes = list_acceleration_pieces(problem, level), problem.sizes[level].acceleration
    for row in rows:
        of_row = {name: piece[:, row] for name, piece in pieces.items()}
        words = describe_wrong_piece(difference[:, row], of_row, float(sizes[:, row].max()), 2)
        if words:
            yield f"acceleration[{problem.names[row]}], {words}"
