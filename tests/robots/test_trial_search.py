"""What a trial looks for where a robot's entries are wrong, beside closed forms."""

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import sympy as sp

from benchmarks.bench_robot_time import try_wrong
from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robot_states import RandomStates, sample_states
from crosscheck.models.loading import load_arm
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.planar import build_planar_robot
from crosscheck.models.robot.robot import RIGID, Mimic, Robot, RobotBody
from crosscheck.trial.changes.arms import steps
from crosscheck.trial.changes.arms.arm_numbers import list_robot_numbers
from crosscheck.trial.changes.kane import KaneSum
from crosscheck.trial.changes.mistakes import _confuse_mimic, list_body_parts, list_frame_mistakes
from crosscheck.trial.changes.numbers import UNITS, UNITS_OF, is_physical, list_numbers, put_value
from crosscheck.trial.changes.pairs import PairSearch, Single, rank_pairs
from crosscheck.trial.changes.problem import ChangeProblem, DynamicsTerms
from crosscheck.trial.changes.search import (
    Cause,
    CauseSearch,
    describe_inertia,
    find_root,
    solve_step,
)
from crosscheck.trial.changes.steps import StepTable
from crosscheck.trial.changes.table import ChangeTable, ValueSearch
from crosscheck.trial.robots.consistency import BiasTerms, compute_bias_terms, make_rate_states
from tests.loops import require_items
from tests.robots import chains, two_link

LINEAR, SQUARE = np.array([2.0, -1.0, 0.5]), np.array([0.3, 0.7, -0.2])


@pytest.mark.parametrize("x", [0.7, -0.4, 3.0])
def test_a_step_solves_a_difference_of_second_order(x):
    difference = LINEAR * x + SQUARE * x**2
    assert solve_step(LINEAR, SQUARE, difference) == pytest.approx(x, rel=1e-9)
    assert solve_step(LINEAR, 0 * SQUARE, LINEAR * x) == pytest.approx(x, rel=1e-9)
    assert abs(solve_step(0 * LINEAR, SQUARE, SQUARE * x**2)) == pytest.approx(abs(x), rel=1e-6)


def test_of_two_steps_that_do_alike_the_smaller_one_is_taken():
    x, other = 0.5, -3.0  # x^2 - (x + other) x is the same at both
    assert solve_step(-(x + other) * SQUARE, SQUARE, -x * other * SQUARE) == pytest.approx(x)
    assert solve_step(0 * LINEAR, 0 * SQUARE, LINEAR) == 0.0


def test_a_root_is_where_least_is_left():
    def left(value: float) -> np.ndarray:
        return np.array([value - 2.0, 0.1 * (value - 2.0) ** 2])

    assert find_root(left, 1.5, 1.0) == pytest.approx(2.0, rel=1e-9)
    # to all digits, from however near
    cube = find_root(lambda value: np.array([value**3 - 8.0]), 2.0009, 1.0)
    assert cube == pytest.approx(2.0, rel=1e-12)
    # no step is longer than the number's own size, and there are few
    assert find_root(lambda value: np.array([value - 2.0]), -1e3, 1.0) < -900
    assert find_root(lambda value: np.ones(2), 1.0, 1.0) is None
    # nor is one begun that leaves more than most of it
    assert find_root(lambda value: np.array([value, 50.0]), 1.0, 1.0) is None


@pytest.mark.parametrize(
    ("moments", "words"),
    [
        ((5.6e-4, 5.6e-4, 2e-18), ": a slender rod along z"),
        ((1.0, 1.0, -0.98e-9), ": a slender rod along z"),
        ((1.0, 1.0, -1.02e-9), "; no body has these moments: are its six numbers mixed up?"),
        ((1e-4, 2e-4, 3.1e-4), "; no body has these moments: are its six numbers mixed up?"),
        ((0.1, 0.1, 0.21), "Izz = 0.21 kg m^2 (file: 0.1 kg m^2); no body has these moments"),
        ((1e-4, 2e-4, 2.9e-4), "(file: 0.1 kg m^2)"),
    ],
)
def test_a_slender_rod_is_a_body(moments, words):
    file_body = RobotBody(1.0, np.zeros(3), np.diag([0.1, 0.1, 0.1]))
    assert describe_inertia("a", file_body, np.diag(moments), True).endswith(words) or (
        words in describe_inertia("a", file_body, np.diag(moments), True)
    )


@pytest.mark.parametrize("count", [2, 3, 4])
def test_few_entries_are_named_and_inertias_need_three(count):
    looking, asked = CauseSearch.__new__(CauseSearch), []

    def find(places: object, *more: object) -> list[Cause]:
        asked.append(places)
        return []

    looking.problem = SimpleNamespace(  # type: ignore[assignment]
        select_part=lambda part: part, select_entries=lambda part, places: tuple(places)
    )
    for name in ("causes", "step_causes", "pair_causes"):
        setattr(looking, f"find_{name}", find)
    looking.find_inertia_causes = lambda places: find("inertia")  # type: ignore[method-assign]
    wrong: Any = {f"M{n}": (n, n) for n in range(count)}
    where = {name for name, _ in looking._generate_within("mass_matrix", wrong, True, True)}
    assert where - {"mass_matrix"} == {
        " and ".join(wrong) if count <= 3 else "the wrong entries of mass_matrix"
    }
    assert ("inertia" in asked) == (count >= 3)


def test_a_unit_is_named_within_its_five_digits_and_nothing_is_ten_reaches_away():
    robot = load_robot("puma560")
    mass = next(each for each in list_numbers(robot) if each.unit == "kg" and each.value)
    for by, words in ((1 + 1.96e-5, "pounds?"), (1 + 2.04e-5, "")):
        assert mass.describe_unit(2.20462 * by * mass.value).endswith(words)
        assert bool(mass.describe_unit(2.20462 * by * mass.value)) == bool(words)
    places = [joint.placement.position for joint in robot.joints] + [b.com for b in robot.bodies]
    reach = max(np.linalg.norm(each) for each in places)
    body = robot.bodies[-1]
    for share, is_near in ((0.98, True), (1.02, False)):
        far = replace(body, com=np.array([share * 10 * reach, 0.0, 0.0]))
        moved = replace(robot, bodies=(*robot.bodies[:-1], far))
        assert is_physical(moved, robot) == is_near


# What a wrong column of a turning joint is: factors on the velocity and on w.
COLUMNS = {"its Jacobian": (0, 0), "its centre's velocity": (0, 1), "its angular velocity": (1, 0)}


@pytest.mark.parametrize("words", COLUMNS)
def test_a_wrong_column_of_a_jacobian_is_what_its_words_say(words):
    """The first joint's, of the second link: its mass matrix by hand."""
    robot, (q, v) = two_link.robot(), np.random.default_rng(0).uniform(-1, 1, (2, 3, 2))
    steps = StepTable(KaneSum(robot, q, v), list_body_parts(robot)).list_steps()
    change = steps[f"joint j1 left out of {words}"]["b"].mass_matrix
    by_velocity, by_w = COLUMNS[words]
    for at, changed in require_items(list(zip(q, change, strict=True))):
        elbow, second = (
            np.array([-np.sin(angle), np.cos(angle), 0.0]) for angle in (at[0], at.sum())
        )
        moving = np.array([two_link.L * elbow + two_link.C2 * second, two_link.C2 * second])
        other = np.array([by_velocity * moving[0], moving[1]])
        turns = np.outer([by_w, 1], [by_w, 1]) - np.ones((2, 2))
        expected = two_link.M2 * (other @ other.T - moving @ moving.T) + two_link.J2 * turns
        np.testing.assert_allclose(changed, expected, atol=1e-12)


def test_differences_are_taken_over_sizes_of_their_number():
    """A point mass of 3 kg, 0.2 m away, has inertias of the size of m c^2; a body its trace."""
    point = chains.Solid(3.0, (0.2, -0.1, 0.0), 6 * (0.0,))
    links = [chains.link("world"), chains.link("a", chains.Solid()), chains.link("b", point)]
    parts = [*links, chains.joint("j", "world", "a"), chains.joint("k", "a", "b")]
    robot = chains.robot(chains.urdf(*parts))
    steps = {each.path: each.step for each in list_numbers(robot)}
    assert steps["bodies.1.inertia.xy"] == pytest.approx(3.0 * 0.2**2)
    assert steps["bodies.0.inertia.xy"] == pytest.approx(0.03)
    assert steps["bodies.1.mass"] == 3.0


def test_nothing_impossible_is_a_cause():
    robot = load_robot("examples/robots/planetary-arm.toml")
    assert is_physical(robot, robot)
    of_stages = [each for each in list_numbers(robot) if each.name.startswith("stage of")]
    for number in require_items(of_stages):
        assert not is_physical(number.put(-0.1 * number.value), robot)
        assert is_physical(number.put(3 * number.value), robot)
    places = [each for each in list_numbers(robot) if each.name.endswith(": its place, x")]
    for number in require_items(places):
        assert not is_physical(number.put(781.0), robot)
        assert is_physical(number.put(number.value + 0.3), robot)


@pytest.mark.parametrize("turns", [None, [[1, 0, 0], [-1, 1, 0], [0.5, 0, -1]]])
@pytest.mark.parametrize("parts", [["mass_matrix"], ["bias", "gravity"], ["acceleration"]])
def test_a_difference_that_no_judge_has_found_is_explained(parts, turns):
    """In the joints' own coordinates q, and in x where q = turns x."""
    robot, own = load_robot("sliding"), np.eye(3) if turns is None else np.array(turns)
    states, wrong = sample_states(robot, 6, 3), put_value(robot, ("bodies", 1, "mass"), 7.5)

    def answer(robot: Robot) -> dict[str, np.ndarray]:
        model = AnalyticRobot(robot, "links")
        moved = model.forward_dynamics(states.q, states.v, states.torques)
        made = {
            "mass_matrix": own.T @ model.mass_matrix(states.q) @ own,
            "bias": model.bias(states.q, states.v) @ own,
            "gravity": model.gravity(states.q) @ own,
            "acceleration": np.linalg.solve(own, moved.T).T,
        }
        return {part: made[part] for part in parts}

    values, right = answer(wrong), answer(robot)
    alike = {part: np.ones_like(each) for part, each in ({"mass_matrix": own} | right).items()}
    tolerances = dict.fromkeys(parts, 1e-10)
    turned = {"turns": None if turns is None else own}
    problem = ChangeProblem(robot, "links", states, values, right, alike, tolerances, **turned)
    causes = CauseSearch(problem).find_causes()
    assert [each.words for each in causes] == ["boom: mass = 7.5 kg (file: 7.2 kg)"]


def test_no_mass_of_a_gear_is_below_zero():
    """The body that it is part of would still have mass."""
    arm = load_arm("paper-labelled")
    robot = build_planar_robot(arm)
    search = ValueSearch(SimpleNamespace(robot=robot, level="carriers", parts=()), None)
    numbers = {each.name: each for each in list_robot_numbers(arm, has_gears=True)}
    sun = numbers["m_s2"]
    values = (-1.3 * sun.value, 0.0, 1.3 * sun.value)
    assert [search.is_possible(sun, value) for value in values] == [False, True, True]


def test_terms_of_a_bias_are_read_out_of_its_answers():
    rng = np.random.default_rng(5)
    rest, linear = rng.normal(size=(2, 3)), rng.normal(size=(2, 3, 3))
    products = rng.normal(size=(2, 3, 3, 3)) * np.triu(np.ones((3, 3)))
    right = BiasTerms(rest, linear, products)
    still = np.zeros((2, 3))
    asked = make_rate_states(RandomStates(still, still, still + 1, still))
    assert len(asked) == 1 + 2 * 3 + 3
    assert not any(each.a.any() for each in asked)
    found = compute_bias_terms([right.evaluate(each.v) for each in asked])
    for name in ("rest", "linear", "products"):
        assert getattr(found, name) == pytest.approx(getattr(right, name), abs=1e-12)
    v = np.array([[1.0, -2.0, 3.0], [0.5, 0.0, 2.0]])
    expected = [
        sum(products[s, 1, j, k] * v[s, j] * v[s, k] for j in range(3) for k in range(j, 3))
        + rest[s, 1]
        + linear[s, 1] @ v[s]
        for s in range(2)
    ]
    assert right.evaluate(v)[:, 1] == pytest.approx(expected)


def test_no_pair_explains_a_wave_in_every_part():
    found = try_wrong(load_robot("puma560"), ("mass_matrix", "bias", "gravity")).diagnosis
    assert not [each for each in (*found.explanations, *found.notes) if "two changes" in each]


def test_pairs_of_rows_by_one_matrix():
    """Rows 1 and 3 once, or row 1 and three times the free row 4; and none of one owner."""
    rng = np.random.default_rng(3)
    rows, owners = rng.normal(size=(6, 20)), np.arange(6)
    is_free = np.array([False, False, False, False, True, True])
    pairs = rank_pairs(rows, is_free, rows[1] + rows[3], owners)
    assert [each[:2] for each in pairs] == [(1, 3)]
    ((first, second, times),) = rank_pairs(rows, is_free, rows[1] + 3 * rows[4], owners)
    assert (first, second, times) == (1, 4, pytest.approx(3.0))
    assert rank_pairs(rows, is_free, 2 * rows[4] + 3 * rows[5], owners) == []
    owners[3] = owners[1]
    assert rank_pairs(rows, is_free, rows[1] + rows[3], owners) == []


def test_two_values_of_one_number_have_one_owner():
    mass = SimpleNamespace(value=2.0)
    values = [Single("", np.ones(3), number=mass, value=value) for value in (0.0, 4.0)]
    singles = [*values, Single("", np.ones(3))]
    twice, none, other = PairSearch.owners.fget(SimpleNamespace(singles=singles))
    assert twice == none != other


def test_of_pairs_of_changes_those_of_two_usual_ones_come_first():
    pairs = SimpleNamespace(find_pairs=lambda _: {"a and b": False, "c and d": True}.items())
    causes = CauseSearch.find_pair_causes(pairs)
    assert [cause.usual for cause in causes] == [True, False]


def test_a_number_of_an_arms_file_left_out_is_named_once(monkeypatch):
    causes = [Cause("link 2: left out", True), Cause("link 2: mass, 0 kg", True, path="mass_kg")]
    monkeypatch.setattr(steps, "find_explanations", lambda *_: ("links", causes))
    assert steps.find_changes({}, [], lambda _: []).words == ["link 2: mass, 0 kg"]


@pytest.mark.parametrize("seed", [5, 9])
def test_a_table_has_what_another_robot_changes(seed):
    """Of bodies, joints, rotors and stages taken for others, at every level: to rounding."""
    robot, rng = chains.random_chain(seed), np.random.default_rng(seed)
    states = sample_states(robot, 3, seed)
    table = ChangeTable(SimpleNamespace(robot=robot, states=states))
    changed = [each.put(each.value + each.step / 2) for each in table.numbers]
    for level in require_items(RIGID):
        mistakes = list(list_frame_mistakes(robot, level))
        robots = [*changed, *(each.robot for each in mistakes)]
        together, base = table.compute_changes(robots, level), table.compute_base(level)
        for number in require_items(rng.choice(len(robots), 40, replace=False)):
            exact = AnalyticRobot(robots[number], level).terms(*states[:2])
            for change, right, other in require_items(zip(together, base, exact, strict=True)):
                np.testing.assert_allclose(right + change[number], other, rtol=1e-9, atol=1e-10)


def test_a_follower_may_be_taken_for_another_in_five_ways():
    mistakes = _confuse_mimic(SimpleNamespace(mimic=Mimic(0, -3.0, 0.5)))
    assert [(each.multiplier, each.offset) for _, each in mistakes] == [
        *((3.0, 0.5), (1.0, 0.5), (9.0, 0.5), (-3.0, 0.0), (-3.0, -0.5))
    ]


def test_a_factor_between_units_is_the_number_that_its_words_say():
    """Twice: as a number before `times as large` or `of it`, and by the units named behind."""
    words_by_factor = [
        *UNITS.items(),
        *(each for table in UNITS_OF.values() for each in table.items()),
    ]
    for factor, words in require_items(words_by_factor):
        said = re.split(" times as large| of it", words)[0].replace("2 pi", "2*pi")
        assert float(sp.sympify(said)) == pytest.approx(factor, rel=1e-12), words
    meant = {"degrees taken for radians": np.pi / 180, "turns taken for radians": 0.5 / np.pi}
    for text, factor in require_items(meant.items()):
        assert any(text in words for own, words in UNITS.items() if own == pytest.approx(factor))


FILES = Path("models/robots")


def test_the_centripetal_term_of_a_fixed_link_is_about_that_link_s_own_origin():
    """m Jv' (w x (w x c)), c from the origin of the link of the file, by Pinocchio's frames."""
    robot, link = load_robot("six-joint"), "tool"
    rng = np.random.default_rng(5)
    q, v = rng.uniform(-1, 1, (2, 1, 6))
    pieces = KaneSum(robot, q, v, list_body_parts(robot)).list_pieces("bias")
    centripetal = pieces["the centripetal acceleration w x (w x c) of the centre"][link]

    model = pin.buildModelFromUrdf(str(FILES / "six-joint.urdf"))
    data, frame = model.createData(), model.getFrameId(link, pin.FrameType.BODY)
    pose = pin.integrate(model, pin.neutral(model), q[0])  # a joint without limits has two numbers
    J = pin.computeFrameJacobian(model, data, pose, frame, pin.LOCAL_WORLD_ALIGNED)
    (part,) = [each for each in list_body_parts(robot) if each.name == link]
    c = pin.updateFramePlacement(model, data, frame).rotation @ part.in_link.com
    w = J[3:] @ v[0]
    moving = J[:3] + np.cross(J[3:], c, axis=0)
    right = part.in_link.mass * moving.T @ np.cross(w, np.cross(w, c))
    # Both are sums of some twenty products of order 1.
    np.testing.assert_allclose(centripetal[0], right, rtol=0, atol=1e-14)
    assert np.abs(right).max() > 1e-4


@pytest.mark.parametrize("seed", range(4))
def test_bodies_terms_sum_up_to_the_robots(seed):
    """Kane's sum body by body is the project's M, bias and weights; its pieces are the bias."""
    own = chains.random_chain(seed)
    states = sample_states(own, 3, seed)
    kane, model = KaneSum(own, states.q, states.v), AnalyticRobot(own, "links")
    moved = (kane.move_body(k, kane.place_body(k, body)) for k, body in enumerate(own.bodies))
    placed = (each.compute_terms() for each in moved)
    right = DynamicsTerms(*model.terms(states.q, states.v))
    for got, expected in zip(map(sum, zip(*placed, strict=True)), right, strict=True):
        assert np.abs(got - expected).max() <= 1e-12 * np.abs(expected).max() + 1e-14
    kinds = kane.list_pieces("bias")
    whole = sum(
        sum(kinds[kind].values(), np.zeros_like(right.bias))
        for kind in (
            "the acceleration of the centre",
            "the torque I w' of the angular acceleration",
            "the gyroscopic torque w x I w",
        )
    )
    assert np.abs(whole - right.bias).max() <= 1e-12 * np.abs(right.bias).max() + 1e-14
