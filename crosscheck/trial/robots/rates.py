"""A robot's bias term by term: what does not depend on the rates, what is linear, each product."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from crosscheck.checks.robot_states import RandomStates, RobotSizes

MOST_CALLS, LEAST_STATES = 600, 3


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
        total: np.ndarray = self.rest + np.einsum("sij,sj->si", self.linear, v) + quadratic
        return total


def select_rate_states(states: RandomStates) -> RandomStates:
    """The first states, so many that their terms take some MOST_CALLS answers; a few at least."""
    size = states.q.shape[1]
    count = max(LEAST_STATES, MOST_CALLS // (1 + size * (size + 3) // 2))
    return RandomStates(*(each[:count] for each in states))


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
