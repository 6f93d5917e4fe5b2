"""A robot's bias term by term, and what its answers owe to slopes: of M and of gravity."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from crosscheck.checks.first_principles.slopes import christoffel_force
from crosscheck.checks.robot_states import RandomStates, RobotSizes
from crosscheck.models.robot.robot import Robot
from crosscheck.runner.outcomes import Failure
from crosscheck.trial.coordinates.differences import CENTRAL, TURN_RAD

FEW_STATES = 4  # number of states, the first ones
# Step of a sliding joint [m]; M and gravity are quadratic in it, so differences are exact.
SHIFT_M = 0.01
REACH = 4  # steps to either side of a state, of differences of order 8
# Truncation error of order 8, as a share of its distance from the differences of order 6.
TRUNCATED = 0.1
# Two sides that are equal, one by slopes of answers, and the doubt of these (states, ...).
SlopeSides = tuple[np.ndarray, np.ndarray, np.ndarray]
SOURCES = ("mass_matrix", "gravity")  # parts whose slopes are taken
MOST_CALLS, LEAST_STATES = 600, 3


def make_slope_states(robot: Robot, states: RandomStates) -> list[RandomStates]:
    """The first states, changed along each coordinate by -4 to 4 steps; itself is left out."""
    few, moved = states.first(FEW_STATES), []
    for number, step in enumerate(_steps(robot)):
        for far in range(-REACH, REACH + 1):
            if far:
                q = few.q.copy()
                q[:, number] += far * step
                moved.append(few._replace(q=q))
    return moved


def _steps(robot: Robot) -> np.ndarray:
    """By which each coordinate changes: no joint that follows it turns further than TURN_RAD."""
    factors = np.abs(robot.joint_map[0])
    slides = np.isin(np.arange(factors.shape[1]) + 1, robot.slides)
    is_alone = np.count_nonzero(factors, axis=0) == 1
    return np.where(slides & is_alone, SHIFT_M, TURN_RAD) / factors.sum(axis=0)


def compare_with_itself(
    robot: Robot,
    states: RandomStates,
    values: Mapping[str, np.ndarray],
    answers: Mapping[str, np.ndarray | Failure],
) -> dict[str, SlopeSides]:
    """Bias and what M demands, gravity's slopes and their mirror images, of what is there.

    values: answers at the states; answers: of mass_matrix and gravity at make_slope_states.
    """
    slopes = {
        part: _slopes(robot, answer)
        for part, answer in answers.items()
        if part in SOURCES and isinstance(answer, np.ndarray)
    }
    differences = dict[str, SlopeSides]()
    if "mass_matrix" in slopes and "bias" in values:
        v, (slope, uncertain) = states.v[:FEW_STATES], slopes["mass_matrix"]
        fast, expected = np.abs(v), christoffel_force(slope, v)
        doubt = christoffel_force(uncertain, fast)  # whose terms all count with one sign
        doubt += np.einsum("isjk,sj,sk->si", uncertain, fast, fast)
        differences["bias"] = values["bias"][:FEW_STATES], expected, TRUNCATED * doubt
    if "gravity" in slopes:
        slope, uncertain = (each.swapaxes(0, 1) for each in slopes["gravity"])
        doubt = uncertain + uncertain.swapaxes(1, 2)
        differences["gravity"] = slope, slope.swapaxes(1, 2), TRUNCATED * doubt
    return differences


def _slopes(robot: Robot, answer: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Slopes (n, states, ...) along each coordinate, and how far two methods are apart."""
    steps = _steps(robot)
    moved = answer.reshape(len(steps), 2 * REACH, -1, *answer.shape[1:])
    high, low = (
        np.tensordot(np.delete(weights, REACH), moved, axes=(0, 1)) for weights in CENTRAL[1]
    )
    by_step = steps.reshape(-1, *[1] * (high.ndim - 1))
    return high / by_step, np.abs(high - low) / by_step


@dataclass(frozen=True)
class BiasTerms:
    """h(q, v) = rest + linear v + the sum of products[:, :, j, k] v_j v_k over j <= k.

    rest (states, n); linear (states, n, n); products (states, n, n, n).
    """

    rest: np.ndarray
    linear: np.ndarray
    products: np.ndarray

    def evaluate(self, v: np.ndarray) -> np.ndarray:
        """The sum of the terms at rates v (states, n), shape (states, n)."""
        quadratic = np.einsum("sijk,sj,sk->si", self.products, v, v)
        return self.rest + np.einsum("sij,sj->si", self.linear, v) + quadratic


def select_rate_states(states: RandomStates) -> RandomStates:
    """The first states, so many that their terms take some MOST_CALLS answers; a few at least."""
    size = states.q.shape[1]
    count = max(LEAST_STATES, MOST_CALLS // (1 + size * (size + 3) // 2))
    return states.first(count)


def make_rate_states(states: RandomStates) -> list[RandomStates]:
    """The states at the rates that terms_of needs: none, each alone both ways, two together."""
    size = states.q.shape[1]
    units = np.eye(size)
    rates = [np.zeros(size), *(sign * unit for unit in units for sign in (1, -1))]
    rates += [units[j] + units[k] for j, k in combinations(range(size), 2)]
    still = 0 * states.a
    return [states._replace(v=np.tile(rate, (len(states.q), 1)), a=still) for rate in rates]


def compute_bias_terms(answers: Sequence[np.ndarray]) -> BiasTerms:
    """The terms of a bias (states, n) that answered at each of rate_states."""
    rest, *moving = answers
    states, size = rest.shape
    linear, products = np.zeros((states, size, size)), np.zeros((states, size, size, size))
    for j in range(size):
        forward, backward = moving[2 * j : 2 * j + 2]
        linear[:, :, j] = (forward - backward) / 2
        products[:, :, j, j] = (forward + backward) / 2 - rest
    for (j, k), together in zip(combinations(range(size), 2), moving[2 * size :], strict=True):
        alone = sum(linear[:, :, each] + products[:, :, each, each] for each in (j, k))
        products[:, :, j, k] = together - rest - alone
    return BiasTerms(rest, linear, products)


def sample_bias_terms(
    bias: Callable[[np.ndarray, np.ndarray], np.ndarray], states: RandomStates
) -> BiasTerms:
    """The terms of a function of q and v, (states, n) each."""
    at_rates = make_rate_states(states)
    q, v = (np.concatenate(rows) for rows in list(zip(*at_rates, strict=True))[:2])
    begins = range(0, len(q), MOST_CALLS)  # all at once would take gigabytes of 40 joints
    rows = [slice(begin, begin + MOST_CALLS) for begin in begins]
    answers = np.concatenate([bias(q[some], v[some]) for some in rows])
    return compute_bias_terms(np.split(answers, len(at_rates)))


def term_sizes(sizes: RobotSizes, *, with_weights: bool) -> np.ndarray:
    """Natural sizes of products (states, n, n, n): of the bias at the rates that they come from.

    with_weights: whether the bias is inverse dynamics less the weights, and has their rounding.
    """
    root = np.sqrt(np.diagonal(sizes.mass_matrix, axis1=1, axis2=2))
    pairs = 2 * (root[:, :, None] + root[:, None, :])
    product_sizes = root[:, :, None, None] * pairs[:, None]
    return product_sizes + sizes.gravity[:, :, None, None] if with_weights else product_sizes
