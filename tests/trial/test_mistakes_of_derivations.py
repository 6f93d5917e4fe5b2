"""Mistakes of a derivation are named by what they change, against a derivation of the tests."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.loading import load_arm
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.diagnose.mistake_search import PartDifference, find_mistakes
from crosscheck.trial.diagnose.mistakes import Derivation, _change_row, _multiply_levers
from crosscheck.trial.diagnose.terms.candidates import find_reflecting_joint
from crosscheck.trial.diagnose.terms.harmonic_fit import evaluate_entry
from crosscheck.trial.diagnose.terms.messages import describe_term_error
from crosscheck.trial.diagnose.terms.reference_terms import build_reference_terms
from crosscheck.trial.diagnose.terms.values import collect_arm_values
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.judge.entries import EntryPlace, Part
from tests.loops import require_items
from tests.trial.planted import GEARS, LUMPED, RELATIVE
from tests.trial.test_dependence import arm_of

BODIES = (1.3, 0.5, 0.23, 0.03), (0.9, 0.4, 0.17, 0.012), (0.6, 0.31, 0.14, 0.007)
OTHERS = (2.1, 0.7, 0.31, 0.05), (1.7, 0.55, 0.2, 0.03), (0.8, 0.42, 0.25, 0.01)
ARMS = [arm_of(*BODIES, payload=0.35), arm_of(*OTHERS, payload=0.81)]
X = np.random.default_rng(4).uniform(-3, 3, (12, 3))
UNLIKE = load_arm("three-unlike")


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


Change = Callable[[Point], Point]
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


def replace_body(number: int, change: Change) -> Callable[[Arm, list[Point]], list[Point]]:
    def apply(arm: Arm, points: list[Point]) -> list[Point]:
        return [change(p) if place == number else p for place, p in enumerate(points)]

    return apply


def with_row(field: str, place: int, row: list[float]) -> Change:
    def change(point: Point) -> Point:
        rows = getattr(point, field).copy()
        rows[place] = row
        return point._replace(**{field: rows})

    return change


CENTRES = "the centripetal acceleration of every link's centre about its joint"
MISTAKES = {
    "theta_2' where theta_1' + theta_2' belongs, in the velocity of d2 of link 2": replace_body(
        1, with_row("rates", 1, [0, 1, 0])
    ),
    "theta_1 + theta_3 where theta_1 + theta_2 + theta_3 belongs": replace_body(
        2, with_row("angles", 2, [1, 0, 1])
    ),
    "each joint's own rate where the sum of rates belongs, in the velocity of every body": (
        lambda arm, points: [p._replace(rates=np.eye(3)) for p in points]
    ),
    "missing term: L1 of link 3": replace_body(
        2, lambda p: p._replace(levers=p.levers * [0, 1, 1])
    ),
    "d3 where L3 belongs, in the payload": (
        lambda arm, points: [
            *points[:3],
            points[3]._replace(levers=points[3].levers * [1, 1, 0] + points[2].levers * [0, 0, 1]),
        ]
    ),
    "yours has 1/2 I_l2 (theta_1' + theta_2')^2 of link 2, in its kinetic energy times 2": (
        replace_body(1, lambda p: p._replace(inertia=2 * p.inertia))
    ),
    "theta_3' where theta_1' + theta_2' + theta_3' belongs, in the angular velocity of link 3": (
        replace_body(2, lambda p: p._replace(turn=np.eye(3)[2]))
    ),
    "yours has 1/2 m3 v^2 of link 3, in its kinetic energy times 0.5": replace_body(
        2, lambda p: p._replace(mass=p.mass / 2)
    ),
}
RULES = {
    "missing term: -1/2 dM_jk/dx_i v_j v_k": lambda points, q: terms_of(slopes_of(points, q)),
    "missing term: dM_ij/dtheta_3 v_j theta_3'": lambda points, q: terms_of(
        slopes_of(points, q) * [1, 1, 0] - np.einsum("jki->ijk", slopes_of(points, q)) / 2
    ),
    "yours has all of the products of two rates in the bias times 0.5": lambda points, q: (
        bias_of(points, q) * (1 + np.eye(3)) / 2
    ),
    "theta_1' where the sum of rates belongs, in every centripetal acceleration": (
        lambda points, q: swing_of(points, q, np.array([[1.0, 0, 0]] * 3))
    ),
    f"theta_1' where the sum of rates belongs, in {CENTRES}": lambda points, q: turn_centres(
        points, q, SUMS[0]
    ),
    f"missing term: {CENTRES}": lambda points, q: turn_centres(points, q, np.zeros(3)),
}


def derivation_of(arm: Arm, coordinates: Coordinates, level: str, x: np.ndarray) -> Derivation:
    return Derivation(build_frame(coordinates, arm), arm, level, collect_arm_values(arm), x)


def told_of(part: Part, differences: list[np.ndarray]) -> list[str]:
    """What is told of differences (K, ...) on both arms."""
    arms = []
    for arm, difference in zip(ARMS, differences, strict=True):
        derivation = derivation_of(arm, RELATIVE, "links", X)
        arms.append(PartDifference(derivation, difference, np.ones(difference.shape[1:]), 0.0))
    wrong = np.abs(differences[0]).max(axis=0) > 1e-9
    found = find_mistakes(arms, wrong, (part,))
    return [describe_term_error(each.error) for each in found if each.is_whole]


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_in_a_kinetic_energy_is_named_by_m_and_by_the_bias(mistake):
    rights = [points_of(arm) for arm in ARMS]
    wrongs = [MISTAKES[mistake](arm, right) for arm, right in zip(ARMS, rights, strict=True)]
    pairs = list(zip(wrongs, rights, strict=True))
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


@pytest.mark.parametrize(
    "coordinates", [RELATIVE, LUMPED, GEARS], ids=["rigid", "lumped", "angles"]
)
def test_a_derivation_without_a_mistake_is_the_reference(coordinates):
    """The bias of its bodies is what the terms of the waves say."""
    chosen = usual_switches(UNLIKE, **({"planets": "lumped"} if coordinates != RELATIVE else {}))
    frame, values = build_frame(coordinates, UNLIKE), collect_arm_values(UNLIKE)
    known = build_reference_terms(frame, UNLIKE, chosen)
    x = np.random.default_rng(1).uniform(-3, 3, (5, len(frame.names)))
    derivation = derivation_of(UNLIKE, coordinates, "", x)
    angles = (x @ derivation.columns.T)[:, frame.layout.theta]
    whole = ("(dM_ij/dx_k - 1/2 dM_jk/dx_i) v_j v_k, the whole bias", "", "")
    (bias,) = derivation.predict([(*whole, None)], slice(None), ("bias",))["bias"]
    of_bias = [(place, place.rates) for place in known.entries if place.rates is not None]
    for place, rates in require_items(of_bias):
        right = evaluate_entry(known.entries[place], values, angles)
        size = np.abs(bias[:, place.row]).max()
        np.testing.assert_allclose(bias[:, place.row, *rates], right, atol=1e-11 * size)


@pytest.mark.parametrize(
    ("turned", "told"),
    [
        ({2: 3, 3: 2}, "joint 2 and the reflected inertia of joint 3 are exchanged"),
        ({2: 3}, "joint 3 where the reflected inertia of joint 2 belongs, in M"),
    ],
)
def test_reflected_inertia_of_another_joint(turned, told):
    known = build_reference_terms(
        build_frame(Coordinates(), UNLIKE), UNLIKE, usual_switches(UNLIKE), "armature"
    )
    values, off = collect_arm_values(UNLIKE), np.zeros((12, 3, 3))
    entries = {j: known.entry(EntryPlace("mass_matrix", j - 1, j - 1)) for j in (2, 3)}
    reflected = {
        j: evaluate_entry([p for p in own if find_reflecting_joint(p)], values, X[:1])
        for j, own in entries.items()
    }
    for j in (2, 3):
        off[:, j - 1, j - 1] = reflected[turned.get(j, j)] - reflected[j]
    derivation = derivation_of(UNLIKE, RELATIVE, "armature", X)
    arms = [PartDifference(derivation, off, np.ones((3, 3)), 0.0)]
    (found, *_) = find_mistakes(arms, np.abs(off).max(axis=0) > 0, ("mass_matrix",))
    assert found.is_whole
    assert told in describe_term_error(found.error)


def test_gravity_is_turned_over_by_one_axis_or_laid_along_the_other():
    arm = UNLIKE.model_copy(update={"gravity_m_per_s2": (3.0, -9.0)})
    made = derivation_of(arm, Coordinates(), "coupled", X)
    found = {
        (each.yours, each.right): (each.gravity, each.parts)
        for each in made._list_gravities()
        if each.gravity is not None
    }
    added = {
        ("-g_x", "g_x"): [-6.0, 0.0],
        ("-g_y", "g_y"): [0.0, 18.0],
        ("g along the other axis", "g"): [-12.0, 12.0],
        ("-g along the other axis", "g"): [6.0, 6.0],
    }
    assert {words: gravity.tolist() for words, (gravity, _) in found.items()} == added
    assert {parts for _, parts in found.values()} == {("force",)}


def test_products_of_two_levers_are_all_of_them_without_each_alone():
    _, motion = derivation_of(UNLIKE, Coordinates(), "links", X).pairs[-1]
    assert (motion.levers[:2] > 0).all()
    parts = _multiply_levers(motion, [0, 1])
    first, second = np.diag(motion.levers)[:2]
    assert [(by, body.levers.tolist()) for by, body in parts] == [
        (1.0, (first + second).tolist()),
        (-1.0, first.tolist()),
        (-1.0, second.tolist()),
    ]
    assert {body.inertia for _, body in parts} == {0.0}


@pytest.mark.parametrize("parts", [("force",), ("mass_matrix", "force"), ("bias",)])
def test_mistakes_behind_accelerations_change_a_force_less_m_a_and_bias(parts):
    rng = np.random.default_rng(3)
    mass, bias = rng.normal(size=(2, 4, 3, 3)), rng.normal(size=(2, 4, 3, 3, 3))
    changes = {"mass_matrix": mass, "bias": bias, "force": rng.normal(size=(2, 4, 3))}
    made: Any = SimpleNamespace(predict=lambda chosen, states, parts: changes)
    a, u = rng.normal(size=(2, 4, 3))
    behind = PartDifference(made, np.zeros((4, 3)), np.ones(3), 1e-9, a, u)
    expected = np.zeros((2, 4, 3))
    for n, k in np.ndindex(2, 4):
        expected[n, k] += ("force" in parts) * changes["force"][n, k]
        expected[n, k] -= ("mass_matrix" in parts) * mass[n, k] @ a[k]
        expected[n, k] -= ("bias" in parts) * (bias[n, k] @ u[k]) @ u[k]
    found = behind.predict([("", "", "", None)] * 2, slice(None), parts)
    assert found == pytest.approx(expected)
    alone = PartDifference(
        SimpleNamespace(predict=lambda *given: {"bias": bias}), bias[0], np.ones(3), 1e-9
    )
    assert alone.predict([], slice(None), ("bias",)) is bias


@pytest.mark.parametrize("turns", [True, False])
@pytest.mark.parametrize("lever", [0.4, 0.0])
def test_another_row_of_a_link_is_where_the_mistake_has_it(turns, lever):
    _, motion = derivation_of(UNLIKE, Coordinates(), "links", X).pairs[-1]
    motion = motion._replace(levers=np.array([0.5, lever, 0.2]))
    row = np.array([7.0, 8.0, 9.0])
    changed = _change_row(motion, 1, row, turns=turns)
    where = {"turn": {"turn"}, "rates": {"rates"}, "places": {"places"}}
    where["both"] = {"places", "rates", "pulls"}
    where["all"] = where["both"] | {"turn"}
    fields = {"turn", "places", "rates", "pulls"}
    fields -= set() if turns else {"turn"}
    fields -= set() if lever else where["both"]
    kinds = {kind for kind, names in where.items() if names & fields}
    assert changed.keys() == (kinds if lever else kinds & {"turn", "all"})
    for name, body in changed.items():
        for field in ("turn", "places", "rates", "pulls"):
            expected = getattr(motion, field).copy()
            if field in where[name] & fields:
                expected[... if field == "turn" else 1] = row
            assert getattr(body, field).tolist() == expected.tolist(), (name, field)
