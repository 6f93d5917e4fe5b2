"""Mistakes of a derivation are named by what they change, against a derivation of the tests."""

from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.trial.changes.arms.comparison import EntryComparison
from crosscheck.trial.changes.arms.steps import find_steps
from crosscheck.trial.changes.arms.term_words import describe_term_error
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.judge.entries import Part
from tests.trial.planted import RELATIVE
from tests.trial.test_dependence import arm_of

BODIES = (1.3, 0.5, 0.23, 0.03), (0.9, 0.4, 0.17, 0.012), (0.6, 0.31, 0.14, 0.007)
OTHERS = (2.1, 0.7, 0.31, 0.05), (1.7, 0.55, 0.2, 0.03), (0.8, 0.42, 0.25, 0.01)
ARMS = [arm_of(*BODIES, payload=0.35), arm_of(*OTHERS, payload=0.81)]
X, RATES = np.random.default_rng(4).uniform(-3, 3, (2, 12, 3))


class Point(NamedTuple):
    """A mass on levers along links: each with its angle and rate as sums of those of joints."""

    mass: float
    levers: np.ndarray
    angles: np.ndarray
    rates: np.ndarray
    inertia: float
    turn: np.ndarray

    def push(self, q: np.ndarray) -> np.ndarray:
        """d(x, y)/dq (2, n)."""
        a = self.angles @ q
        return np.array([-self.levers * np.sin(a), self.levers * np.cos(a)]) @ self.rates


SUMS = np.tril(np.ones((3, 3)))


def points_of(arm: Arm) -> list[Point]:
    """The three links, then the payload."""
    lengths = np.array([link.length_m for link in arm.links])
    points = []
    for i, link in enumerate(arm.links):
        levers = np.where(np.arange(3) < i, lengths, 0.0) + np.eye(3)[i] * link.com_m
        points.append(Point(link.mass_kg, levers, SUMS, SUMS, link.inertia_kg_m2, SUMS[i]))
    return [*points, Point(arm.payload_mass_kg, lengths, SUMS, SUMS, 0.0, SUMS[2])]


def mass_of(points: list[Point], q: np.ndarray) -> np.ndarray:
    """M (n, n)."""
    total = np.zeros((3, 3), dtype=q.dtype)
    for point in points:
        push = point.push(q)
        total = (
            total + point.mass * push.T @ push + point.inertia * np.outer(point.turn, point.turn)
        )
    return total


def slopes_of(points: list[Point], q: np.ndarray) -> np.ndarray:
    """dM_ij/dq_k by complex steps, (n, n, n)."""
    along = 1e-30j * np.eye(3)
    return np.stack([mass_of(points, q + each).imag / 1e-30 for each in along], axis=2)


def terms_of(raw: np.ndarray) -> np.ndarray:
    """Coefficients of v_j v_k, j <= k, of a bias (n, n, n)."""
    return np.array([np.triu(each + each.T) - np.diag(np.diag(each)) for each in raw])


def bias_of(points: list[Point], q: np.ndarray) -> np.ndarray:
    slopes = slopes_of(points, q)
    return terms_of(slopes - np.einsum("jki->ijk", slopes) / 2)


RULES = {
    "every joint: M' v alone, without -1/2 d(v' M v)/dq": lambda p, q: terms_of(slopes_of(p, q)),
    "joint 3: -1/2 d(v' M v)/dq alone, without M' v": lambda points, q: terms_of(
        slopes_of(points, q) * [1, 1, 0] - np.einsum("jki->ijk", slopes_of(points, q)) / 2
    ),
}


def compare(arm: Arm, part: Part, difference: np.ndarray, level: str = "links") -> EntryComparison:
    """A comparison of a part with this difference (K, ...) at the states."""
    size = np.ones(difference.shape[1:])
    quantity = "rate_terms" if part == "bias" else part
    made: Any = SimpleNamespace(
        frame=build_frame(RELATIVE, arm),
        problem=SimpleNamespace(case=SimpleNamespace(arm=arm)),
        level=level,
        angles=X,
        rates=RATES,
        sizes=SimpleNamespace(entry_sizes=lambda quantity: size, tolerance=lambda quantity: 0.0),
        user_values={quantity: difference},
        reference_values={quantity: 0 * difference},
    )
    return made


def told_of(part: Part, differences: list[np.ndarray]) -> list[str]:
    """What is told of differences (K, ...) on both arms."""
    arms = [compare(*each) for each in zip(ARMS, (part, part), differences, strict=True)]
    return [describe_term_error(error) for error in find_steps(arms, part)]


@pytest.mark.parametrize("rule", RULES)
def test_a_mistake_in_how_a_bias_is_made_is_named(rule):
    points = [points_of(arm) for arm in ARMS]
    off = [np.array([RULES[rule](each, q) - bias_of(each, q) for q in X]) for each in points]
    assert any(rule in told for told in told_of("bias", off)[:7])
