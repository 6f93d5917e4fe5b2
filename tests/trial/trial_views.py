"""Trials of an arm's equations and of a robot's whose numbers are known.

Two numbers are wrong by what is known here; sizes follow from right answers at the trial's states.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.loading import load_scenario
from crosscheck.trial.input.equations import Coordinates, Equations
from crosscheck.trial.judge import entries
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.result import Trial
from crosscheck.trial.trial import run_trial
from tests.robots import two_link
from tests.robots.trials import run_robot_trial
from tests.trial.test_judge_table import two_link as two_link_arm
from tests.trial.test_trial import equations_of, in_frame

NAME = "yours"
INERTIA, MOMENT, SHARED = 0.0123, 3.7, 0.0045  # that are too much in M and force, and in M[0, 1]


def moment_at(x: np.ndarray) -> np.ndarray:
    """What is too much in the force: another moment in every pose."""
    return np.array([0.0, MOMENT * np.cos(7 * x[0])])


def wrong_equations(arm: Arm, scenario: Scenario) -> Equations:
    """Of a rigid arm: more inertia at the first joint, and a moment at the second."""
    moved = in_frame("analytic:links", Coordinates("rigid"), arm, scenario)
    right = equations_of(moved)
    return replace(
        right,
        mass_matrix=lambda x: moved.mass_matrix(x) + np.diag([INERTIA, 0.0]),
        force=lambda t, x, v, torque: right.force(t, x, v, torque) + moment_at(x),
        coordinates=Coordinates("rigid"),
        rebuild=wrong_equations,
    )


def tried_arm() -> Trial:
    """The trial of these equations."""
    arm = two_link_arm()
    own = wrong_equations(arm, load_scenario("pd"))
    return run_trial(TrialRequest(NAME, own, arm, quick=True))


kept_arm = lru_cache(tried_arm)


@lru_cache
def right_shares() -> dict[str, np.ndarray]:
    """How far M is off, and the force, by their sizes over the trial's states."""
    problem, rigid = kept_arm().problem, Coordinates("rigid")
    moved = in_frame("analytic:links", rigid, two_link_arm(), problem.case.scenario)
    placed = [np.asarray(state.x) for state in problem.states]
    root = np.sqrt(np.max([np.diag(moved.mass_matrix(x)) for x in placed], axis=0))
    forces = [moved.model.generalized_force(s.t, np.asarray(s.x), s.v) for s in problem.states]
    moments = np.max([np.abs(moment_at(x)) for x in placed], axis=0)
    return {
        "M": np.diag([INERTIA, 0.0]) / np.outer(root, root),
        "force": moments / np.sqrt(np.square(forces).mean(axis=0)),
    }


def wrong_arm(trial: Trial) -> Iterator[str]:
    """Numbers of a trial that are not those of its equations."""
    shares = right_shares()
    nearest, right = trial.distances[0], max(each.max() for each in shares.values())
    if not np.isclose(nearest.largest, right, rtol=1e-6):
        yield f"level {nearest.level}: {nearest.largest}, must be {right}"
    for part, name in (("mass_matrix", "M"), ("force", "force")):
        if not np.allclose(trial.relative_errors[part], shares[name], rtol=1e-6, atol=1e-9):
            yield f"{part}: {trial.relative_errors[part]}, must be {shares[name]}"
    line = f"M[theta_1, theta_1]: yours minus right is {INERTIA:g};"
    if not any(cause.startswith(line) for cause in trial.causes):
        yield f"no {line}"


def tried_robot() -> Trial:
    """Of the pendulum: M[j1, j2] and gravity[j2] are off by known shares of their sizes."""
    zero = np.zeros(2)

    def mass_matrix(q: np.ndarray) -> np.ndarray:
        off = INERTIA * two_link.sizes("mass_matrix", q, zero, zero, zero)[0, 1]
        return two_link.mass_matrix(q) + np.array([[0.0, off], [off, 0.0]])

    def gravity(q: np.ndarray) -> np.ndarray:
        off = SHARED * two_link.sizes("gravity", q, zero, zero, zero)[1]
        return two_link.gravity(q) - np.array([0.0, off])

    return run_robot_trial(
        two_link.right(mass_matrix=mass_matrix, gravity=gravity), two_link.robot()
    )


kept_robot = lru_cache(tried_robot)


def wrong_robot(trial: Trial) -> Iterator[str]:
    """Numbers of a trial that are not those of its equations."""
    entries = {entry.name: entry.share for entry in trial.diagnosis.entries}
    if entries != pytest.approx({"M[j1, j2]": INERTIA, "gravity[j2]": SHARED}):
        yield f"entries {entries}"
    nearest = trial.distances[0]  # of four entries of M, two of the bias and two of gravity
    if not np.isclose(nearest.mean, (2 * INERTIA + SHARED) / 8, rtol=1e-6):
        yield f"mean share of the nearest level: {nearest.mean}"


STATES = 7
# Of each row, how many times too large; and what the whole part counts as.
RATIOS = [
    ([1.0, 1e6], 1.0),  # one entry that is wrong, however large, changes nothing
    ([1e6, 1.0], 1.0),
    ([1e3, 1e3, 1e9], 1e3),
    ([1e-3, 1e-3], 1e-3),
    ([4.0, 0.0], 4.0),  # a row that is nothing says nothing
    ([np.inf, 1.0, 1.0], 1.0),
    ([0.0, 0.0], 1.0),
]


def wrong_unit_ratios() -> Iterator[str]:
    """A line for every ratio that is not named, of vectors and of matrices by their diagonals."""
    draw = np.random.default_rng(3)
    for times, ratio in RATIOS:
        right = draw.uniform(1, 2, (STATES, len(times)))
        for values, reference in (
            (right * times, right),
            (
                np.array([np.diag(row * times) + 1e9 * (1 - np.eye(len(row))) for row in right]),
                np.array([np.diag(row) for row in right]),
            ),
        ):
            found = entries.unit_ratio(values, reference)
            if not np.isclose(found, ratio, rtol=1e-12):
                yield f"rows {times} times as large: {found}, must be {ratio}"
    for ratio, power in ((900.0, 1000.0), (0.011, 0.01), (1.5, 1.0), (4.0, 10.0)):
        if entries.power_of_ten(ratio) != power:
            yield f"{ratio} counts as {entries.power_of_ten(ratio)}"


GUARDS: dict[str, Callable[[], Iterator[str]]] = {
    "arm": lambda: wrong_arm(tried_arm()),
    "robot": lambda: wrong_robot(tried_robot()),
    "units": wrong_unit_ratios,
}
