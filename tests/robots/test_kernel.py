"""The kernel of robots: rigid-body algorithms traced to text, against engines and exact numbers."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from benchmarks.suite.robot_states import RobotStates
from crosscheck.analytic.kernel import expressions
from crosscheck.analytic.kernel.expressions import ExpressionGraph, evaluate_constants, write_lines
from crosscheck.analytic.robot.algorithms import MovingTree
from crosscheck.analytic.robot.mechanism import build_mechanism, name_numbers, replace_names
from crosscheck.analytic.robot.structure import trace_forward_dynamics
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import Robot
from crosscheck.provenance import ROOT
from crosscheck.registry import build_robot_model
from tests.faults.robots import ROBOTS
from tests.loops import require_items
from tests.robots import chains
from tests.robots.traced import CIRCLE, equations, random_state, run_text

PLANETARY = str(ROOT / "examples" / "robots" / "planetary-arm.toml")
# M a - (what accelerates): rounding of some thousand operations on terms as large as |M| |a|.
TOLERANCE = 1e-12


def off(robot: Robot, level: str, engine: str, lanes: int) -> float:
    """By how much M times the difference of accelerations exceeds rounding, in parts of |M| |a|."""
    q, v, torques = random_state(robot, level, 3, states=5)
    model = build_robot_model(engine, robot, level)
    expected, mass = model.forward_dynamics(q, v, torques), model.mass_matrix(q)
    found = RobotStates(robot, level, lanes).forward_dynamics(q, v, torques)
    missed = np.einsum("sij,sj->si", mass, found - expected)
    size = np.einsum("sij,sj->si", np.abs(mass), np.abs(expected))
    return float((np.abs(missed).max(axis=1) / size.max(axis=1)).max())


@pytest.mark.parametrize("seed", range(8))
def test_every_engine_agrees_on_random_robots(seed):
    robot = chains.random_chain(seed, most_joints=4)
    for engine in require_items(chains.ENGINES):
        assert off(robot, robot.levels[-1], engine, lanes=8) < 100 * TOLERANCE  # M ill-conditioned


@pytest.mark.parametrize("level", ["links", "coupled"])
def test_mass_matrix_is_that_of_every_engine(level):
    unlike = ROBOTS["unlike"]()
    joints = [replace(joint, armature=0.2 * k) for k, joint in enumerate(unlike.joints)]
    for robot in (load_robot("puma560"), unlike, replace(unlike, joints=tuple(joints))):
        q, _, _ = random_state(robot, level, 1, states=9)
        found = RobotStates(robot, level).mass_matrix(q)
        for engine in require_items(chains.ENGINES):
            expected = build_robot_model(engine, robot, level).mass_matrix(q)
            assert found == pytest.approx(expected, abs=1e-14 * np.abs(expected).max())


@pytest.mark.parametrize("lanes", [2, 8])
def test_bits_do_not_depend_on_lanes(lanes):
    robot = load_robot("sliding")
    state = random_state(robot, "geared", 2, states=11)
    alone = RobotStates(robot, "geared", 1).forward_dynamics(*state)
    assert (RobotStates(robot, "geared", lanes).forward_dynamics(*state) == alone).all()


@pytest.mark.parametrize("name", ["unlike", "all sprung"])
def test_text_is_exactly_what_the_algorithms_do(name, monkeypatch):
    """In fractions, nothing is rounded: folds, signs, shared expressions, order of operands."""
    functions = {
        function: lambda name, turns, f=function: [f"{name} = {f}_of[{turns.split(' * ')[0]}]"]
        for function in ("cos", "sin")
    }
    monkeypatch.setattr(expressions, "FUNCTIONS", functions)
    s = equations(ROBOTS[name](), "geared").structure
    named, numbers = name_numbers(build_mechanism(ROBOTS[name](), "geared"))
    exact = {key: Fraction(value).limit_denominator(997) for key, value in numbers.items()}
    own = replace_names(named, exact.__getitem__)
    text = trace_forward_dynamics.__wrapped__(s)
    given = iter(Fraction(k, 7) for k in range(2, 60, 3))
    names = (
        *(f"{kind}_{x}" for kind in "qv" for x in s.coordinates),
        *(f"T{j}" for j in s.driven_joints),
        *(f"push_{x}" for x in s.displacements),
    )
    state = dict(zip(names, given, strict=False))
    q, v = ([state[f"{kind}_theta{j}"] for j in s.driven_joints] for kind in "qv")
    values = [joint.factor * q[joint.coordinate] + joint.offset for joint in own.joints]
    turned = dict(zip(values, CIRCLE, strict=False))
    tables = {
        f"{f}_of": {x: pair[k] for x, pair in turned.items()} for k, f in enumerate(("cos", "sin"))
    }
    constants = evaluate_constants(text.constants, exact)
    found = run_text(text.lines, {**constants, **state, **tables}, Fraction)
    expected = MovingTree(own, values, list(turned.values())).forward_dynamics(
        [joint.factor * v[joint.coordinate] for joint in own.joints],
        [state[f"v_{x}"] for x in s.displacements],
        [state[f"T{j}"] for j in s.driven_joints],
        [state[f"push_{x}"] for x in s.displacements],
        [0] * len(own.joints),
    )
    assert [found[f"a_{x}"] for x in s.coordinates] == expected
    assert all(isinstance(each, Fraction) for each in expected)


def test_a_planar_chain_folds_to_its_planar_equations():
    """M of two links: three entries from one cosine; gravity along the axes leaves nothing."""
    s = equations(load_robot(PLANETARY), "links").structure
    text = trace_forward_dynamics(s)
    cosines = sum(" = 0.25 - abs(" in line for line in text.lines)
    assert cosines == 2  # cosine and sine of the elbow; the shoulder's angle does not matter
    assert sum(line.partition("=")[2].count(f" {o} ") for o in "+-*/" for line in text.lines) < 90
    assert not any("q_theta1" in line for line in text.lines)


def test_whole_numbers_fold_and_floats_do_not():
    graph = ExpressionGraph()
    x, y, c = graph.variable("x"), graph.variable("y"), graph.constant("c")
    assert (x * 0, 0 * x, x - x, 0 / x) == (0, 0, 0, 0)
    assert x * 1 is x
    assert 0 + x is x
    assert x - 0 is x
    assert x * -1 is -x
    opposite = -x
    assert -opposite is x
    assert 0 - x is -x
    assert x + y is y + x
    assert x * y is y * x
    assert x - y is not y - x
    assert -(x - y) is y - x
    assert x + -y is x - y
    assert x - opposite is x + x
    assert (-x) * y is -(x * y)
    assert x / y is not y / x
    assert (c * 2).is_constant
    assert not (c * x).is_constant
    assert graph.variable("x") is x
    assert x * 2 is not x * 3


def test_constants_are_worked_out_beforehand_and_products_stand_in_sums():
    graph = ExpressionGraph()
    x, y, c, d = graph.variable("x"), graph.variable("y"), graph.constant("c"), graph.constant("d")
    text = write_lines({"out": (c * d - 2) * x + y * x, "none": 0})
    ((name, _),) = text.constants.items()
    *_, last, none = text.lines
    assert len(text.lines) == 3
    assert none == "none = 0.0"
    assert f"({name} * x)" in text.lines[0].replace(f"(x * {name})", f"({name} * x)")
    assert last.startswith("out = e")
    assert evaluate_constants(text.constants, {"c": 3.0, "d": np.array([1.0, 2.0])})[
        name
    ].tolist() == [1, 4]


def test_numbers_are_by_name_and_zeros_are_structure():
    """Another payload is another number of one structure; a lost one is another structure."""
    own = equations(load_robot("puma560"), "coupled")
    mechanism = build_mechanism(own.robot, "coupled")
    body = mechanism.bodies[-1]
    heavier = mechanism._replace(bodies=(*mechanism.bodies[:-1], body._replace(mass=2 * body.mass)))
    lost = mechanism._replace(bodies=(*mechanism.bodies[:-1], body._replace(mass=0)))
    assert name_numbers(heavier)[0] == own.structure.mechanism
    assert name_numbers(lost)[0] != own.structure.mechanism
    assert name_numbers(heavier)[1]["bodies_5_mass"] == 2 * body.mass
