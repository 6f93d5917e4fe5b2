"""Equations of an arm that are right in other coordinates than those that they state."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from crosscheck.checks.invariants import torques_at
from crosscheck.models.arm.arm import Planetary
from crosscheck.models.experiment.drive import drive_data
from crosscheck.models.interface import Model
from crosscheck.registry import build
from crosscheck.trial.coordinates.readings import (
    FITS,
    JointCoordinates,
    Reading,
    has_same_values,
    list_pairs,
    list_readings,
    select_first_kind,
)
from crosscheck.trial.judge.questions import VerificationProblem

STATES = 8  # number of states at which models are evaluated in other coordinates


def find_readings(
    problem: VerificationProblem, user_values: Mapping[str, np.ndarray]
) -> tuple[str, list[Reading]]:
    """The level and the readings in which all parts agree, the simplest ones alone; "" for none.

    user_values: of mass_matrix, bias, gravity, force and acceleration, those that answer.
    """
    matrix, case = problem.frame.matrix, problem.case
    if problem.gearing != "rigid" or matrix is None or not user_values:
        return "", []
    size = len(case.arm.joints)
    ratios = [
        1 + joint.ring_teeth / joint.sun_teeth if isinstance(joint, Planetary) else 1.0
        for joint in case.arm.joints
    ]
    joints = JointCoordinates(
        [f"theta_{number + 1}" for number in range(size)],
        range(size),
        {place: range(place) for place in range(size)},
        np.array(ratios),
    )
    identity = np.eye(size)
    relative = Reading("relative", "relative angles", identity, identity, identity, np.zeros(size))
    models = {
        level: build(problem.reference(level), case.arm, case.scenario, case.switches)
        for level in problem.levels
    }
    simple = [relative, *list_readings(joints)]
    stated = [each for each in simple if _is_stated(each, matrix)]
    x, y = case.arm.gravity_m_per_s2
    lifted_arms = [
        case.arm.model_copy(update={"gravity_m_per_s2": gravity})
        for gravity in dict.fromkeys(((-x, -y), (-x, y), (x, -y)))
    ]
    lifted = [
        build(problem.reference(level), arm, case.scenario, case.switches)
        for level in problem.levels
        for arm in lifted_arms
    ]
    if any(
        _agrees(each, model, problem, user_values)
        for each in stated
        for model in (*models.values(), *lifted)
    ):
        # The residual is within tolerance, or gravity's sign is wrong: a commoner error than
        # all senses reversed, which forces and accelerations alone cannot distinguish from it.
        return "", []
    for group in (simple, list_pairs(joints)):
        for level, model in models.items():
            readings = [
                each
                for each in group
                if not _is_stated(each, matrix) and _agrees(each, model, problem, user_values)
            ]
            if readings:
                return level, select_first_kind(readings)
    return "", []


def _is_stated(reading: Reading, matrix: np.ndarray) -> bool:
    return not reading.offset.any() and np.array_equal(reading.position, matrix)


def _agrees(
    reading: Reading,
    model: Model,
    problem: VerificationProblem,
    user_values: Mapping[str, np.ndarray],
) -> bool:
    few = {part: values[:STATES] for part, values in user_values.items()}
    first = {part: values[:1] for part, values in few.items()}
    # What is right at all states is as large as the answers there, but for what readings may leave.
    allowed = {part: 2 * FITS * np.abs(values).max() for part, values in few.items()}

    def is_near(right: Mapping[str, np.ndarray]) -> bool:
        return all(
            np.abs(first[part] - each).max() <= allowed[part] for part, each in right.items()
        )

    def evaluate(parts: Collection[str], count: int, by_rows: bool) -> dict[str, np.ndarray]:
        return _evaluate(reading, model, problem, parts, count, by_rows=by_rows)

    if "mass_matrix" in few and not is_near(evaluate({"mass_matrix"}, 1, False)):
        return False  # as with most
    return any(
        is_near(evaluate(few, 1, by_rows)) and has_same_values(few, evaluate(few, STATES, by_rows))
        for by_rows in (False, True)
    )


def _evaluate(
    reading: Reading,
    model: Model,
    problem: VerificationProblem,
    parts: Collection[str],
    count: int,
    *,
    by_rows: bool,
) -> dict[str, np.ndarray]:
    """Values of some parts at the first states if x were read as other coordinates.

    count: of states. by_rows: whether torques are those of the joints, not of x.
    """
    drive = drive_data(problem.case.scenario, len(problem.case.arm.joints))
    rows: dict[str, list[np.ndarray]] = {part: [] for part in parts}
    for state in problem.states[:count]:
        q, v = reading.position @ state.x + reading.offset, reading.rates @ state.u
        mass = reading.rows.T @ model.mass_matrix(q) @ reading.rates
        values = {"mass_matrix": mass}
        if set(parts) != {"mass_matrix"}:
            bias = reading.rows.T @ model.bias(q, v)
            loads = model.generalized_force(state.t, q, v) - torques_at(drive, state.t, q, v)
            torque = reading.rows.T @ state.torque if by_rows else state.torque
            force = reading.rows.T @ loads + torque
            acceleration = np.linalg.solve(mass, force - bias)
            values |= {"bias": bias, "force": force, "acceleration": acceleration}
            if problem.has_gravity:
                rest = 0 * v
                torques = torques_at(drive, 0.0, q, rest)
                weights = reading.rows.T @ (model.generalized_force(0.0, q, rest) - torques)
                values |= {"gravity": -weights, "force": force - weights}
        for part in parts:
            rows[part].append(values[part])
    return {part: np.array(values) for part, values in rows.items()}
