"""Mistakes of a derivation are named by what they change, against a derivation of the tests."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.models.loading import load_arm
from crosscheck.trial.changes.arms.comparison import EntryComparison
from crosscheck.trial.changes.arms.letters import collect_arm_values
from crosscheck.trial.changes.arms.steps import find_steps
from crosscheck.trial.changes.arms.term_words import describe_term_error
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.judge.entries import Part
from tests.loops import require_items
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


Change = Callable[[list[Point]], list[Point]]
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


def swing_of(points: list[Point], q: np.ndarray, rates: np.ndarray = SUMS) -> np.ndarray:
    """Coefficients of a bias from link to link: centripetal accelerations by these rates."""
    total = np.zeros((3, 3, 3))
    for point in points:
        right = point._replace(rates=SUMS).push(q)
        for lever, angle, rate in zip(point.levers, SUMS @ q, rates, strict=True):
            inwards = -point.mass * lever * np.array((np.cos(angle), np.sin(angle)))
            total += np.einsum("i,j,k->ijk", inwards @ right, rate, rate)
    return terms_of(total)


def turn_centres(points: list[Point], q: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Coefficients of a bias whose links' centres turn about their joints with this rate."""
    total = bias_of(points, q)
    for place, point in enumerate(points[:3]):
        rates = np.where(np.arange(3)[:, None] == place, rate, SUMS)
        total += swing_of([point], q, rates) - swing_of([point], q)
    return total


def put_row(number: int, field: str, place: Any, row: list[float]) -> Change:
    def apply(points: list[Point]) -> list[Point]:
        rows = getattr(points[number], field).copy()
        rows[place] = row
        return [*points[:number], points[number]._replace(**{field: rows}), *points[number + 1 :]]

    return apply


TURN = "theta_3' where theta_1' + theta_2' + theta_3' belongs, in the angular velocity"
MISTAKES: dict[str, Change] = {
    "theta_2' where theta_1' + theta_2' belongs, in the velocity along link 2": put_row(
        1, "rates", 1, [0, 1, 0]
    ),
    "theta_1 + theta_3 where theta_1 + theta_2 + theta_3": put_row(2, "angles", 2, [1, 0, 1]),
    "every link: each joint's own rate where the sum of them belongs, in the velocity": (
        lambda points: [p._replace(rates=np.eye(3)) for p in points]
    ),
    f"link 3: {TURN}": put_row(2, "turn", ..., [0, 0, 1]),
}
RULES = {
    "every joint: M' v alone, without -1/2 d(v' M v)/dq": lambda p, q: terms_of(slopes_of(p, q)),
    "joint 3: -1/2 d(v' M v)/dq alone, without M' v": lambda points, q: terms_of(
        slopes_of(points, q) * [1, 1, 0] - np.einsum("jki->ijk", slopes_of(points, q)) / 2
    ),
    "every link: every centripetal acceleration by w of the first link": (
        lambda points, q: swing_of(points, q, np.array([[1.0, 0, 0]] * 3))
    ),
    "link 2 and link 3: w of the first link": lambda points, q: turn_centres(points, q, SUMS[0]),
    "link 2 and link 3: its centre of mass at its joint in its acceleration alone": (
        lambda points, q: turn_centres(points, q, np.zeros(3))
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


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_in_a_kinetic_energy_is_named_by_m_and_by_the_bias(mistake):
    rights = [points_of(arm) for arm in ARMS]
    pairs = [(MISTAKES[mistake](right), right) for right in rights]
    for part, entries in (("mass_matrix", mass_of), ("bias", bias_of)):
        off = [np.array([entries(a, q) - entries(b, q) for q in X]) for a, b in pairs]
        is_right = np.abs(off[0]).max() <= 1e-9
        assert is_right or any(mistake in told for told in told_of(part, off)[:7])


@pytest.mark.parametrize("rule", RULES)
def test_a_mistake_in_how_a_bias_is_made_is_named(rule):
    points = [points_of(arm) for arm in ARMS]
    off = [np.array([RULES[rule](each, q) - bias_of(each, q) for q in X]) for each in points]
    assert any(rule in told for told in told_of("bias", off)[:7])


def test_centripetal_accelerations_are_the_bias():
    """From link to link, and by Lagrange: two ways that share nothing."""
    points = points_of(ARMS[0])
    for q in require_items(X):
        np.testing.assert_allclose(swing_of(points, q), bias_of(points, q), rtol=0, atol=1e-12)


def test_gravity_along_the_other_axis_is_named():
    """By hand: one link of mass m, d from its joint, pulled by g_x sin and g_y cos."""
    arm = ARMS[0].model_copy(update={"gravity_m_per_s2": (3.0, -9.0)})
    points, off = points_of(arm), []
    for q in X:
        weigh = [sum(p.mass * np.array(g) @ p.push(q) for p in points) for g in ((-9, 3), (3, -9))]
        off.append(weigh[0] - weigh[1])
    (error, *_) = find_steps([compare(arm, "force", np.array(off))], "force")
    assert describe_term_error(error) == "x and y of gravity exchanged"


@pytest.mark.parametrize(
    ("gear", "wrong", "told"),
    [
        ("sun", lambda s, p, r: r / s, "its ratio z_r / z_s, that of a carrier held"),
        ("sun", lambda s, p, r: 1 + r // s, "its sun's ratio rounded down"),
        ("planet", lambda s, p, r: r / p, "its planets turning as on the carrier"),
    ],
)
def test_a_gear_that_spins_by_another_ratio_is_named(gear, wrong, told):
    """A sun turns by z_r / z_s + 1 of its carrier, its planets by z_r / z_p - 1."""
    arm = load_arm("three-unlike")
    values = collect_arm_values(arm)
    s, p, r = (values[f"z_{each}1"] for each in "spr")
    right, count = (1 + r / s, 1) if gear == "sun" else (r / p - 1, values["N1"])
    inertia = count * values[f"M_{gear[0]}1"] * values[f"r_{gear[0]}1"] ** 2
    off = np.zeros((12, 3, 3))
    off[:, 0, 0] = inertia * (wrong(s, p, r) ** 2 - right**2)
    (error,) = find_steps([compare(arm, "mass_matrix", off, "armature")], "mass_matrix")
    assert f"stage of joint 1: {told}" in describe_term_error(error)
