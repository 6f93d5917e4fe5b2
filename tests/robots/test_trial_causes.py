"""What a robot's trial says of an error: the cause, only if it holds, and what is right."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robot_states import sample_states
from crosscheck.models.robot.robot import Robot
from crosscheck.trial.changes.kane import KaneSum
from crosscheck.trial.changes.problem import DynamicsTerms
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.result import TrialDiagnosis
from tests.robots import chains, two_link
from tests.robots.test_trial import steiner
from tests.robots.trials import robot_equations, run_robot_trial

OFF = np.array([[0, two_link.J2], [two_link.J2, 0]])


@pytest.fixture(scope="module")
def two() -> Robot:
    return two_link.robot()


def half_a_term(q, v):
    squares = np.array([-v[0] * v[1] - v[1] ** 2, v[0] ** 2])
    return two_link.COUPLED * np.sin(q[1]) * squares


def lopsided(q):
    return two_link.mass_matrix(q) * np.array([[1, 1], [1.5, 1]])


# One part alone is wrong: the wrong entries, and sentences that are said of them.
ALONE: dict[str, tuple[dict[str, Callable[..., object]], list[str], list[str]]] = {
    "lever of a weight": (
        {"gravity": lambda q: two_link.gravity(q, lever=two_link.C2)},
        ["gravity[j1]"],
        [
            "gravity[j1] alone is wrong: yours minus right is -20.58 cos(j1);"
            " mass_matrix and bias are right",
            "in gravity alone, as with joint j2: its place, x = 0.3 m (file: 1 m),"
            " as b: centre of mass, x",
        ],
    ),
    "half a term": (
        {"bias": half_a_term},
        ["bias[j1]"],
        [
            "bias[j1] alone is wrong; mass_matrix and gravity are right",
            "bias does not follow from mass_matrix, which is right: bias[j1]",
            "bias[j1] of j1' j2': half as large; yours minus right is 0.9 sin(j2)",
        ],
    ),
    "sign of an entry": (
        {"bias": lambda q, v: two_link.bias(q, v) * np.array([1, -1])},
        ["bias[j2]"],
        [
            "bias[j2] alone is wrong: with the opposite sign; mass_matrix and gravity are right",
            "bias does not follow from mass_matrix, which is right: bias[j2]",
        ],
    ),
    "an inertia left out of an entry": (
        {"mass_matrix": lambda q: two_link.mass_matrix(q) - OFF},
        ["M[j1, j2]"],
        [
            "M[j1, j2] alone is wrong: yours minus right is -0.2; bias and gravity are right",
            "b: Izz is missing in M[j1, j2]",
        ],
    ),
    "friction in the bias": (
        {"bias": lambda q, v: two_link.bias(q, v) + np.array([[12, 7], [0, 5]]) @ v},
        ["bias[j1]", "bias[j2]"],
        [
            "bias alone is wrong; mass_matrix and gravity are right",
            "bias has a part linear in v, 12 j1' in bias[j1], 7 j2' in bias[j1], 5 j2' in"
            " bias[j2]: friction? State it as viscous_friction.",
        ],
    ),
    "weights in the bias": (
        {"bias": lambda q, v: two_link.bias(q, v) + two_link.gravity(q)},
        ["bias[j1]", "bias[j2]"],
        [
            "bias alone is wrong; mass_matrix and gravity are right",
            "bias at rest is not 0: beside gravity it is Coriolis and centrifugal torques alone",
        ],
    ),
    "a lopsided mass matrix": (
        {"mass_matrix": lopsided},
        ["M[j2, j1]"],
        [
            "mass_matrix is not symmetric: M[j2, j1] differs from M[j1, j2]; M[j1, j2] is right",
            "M[j2, j1] alone is wrong: 1.5 times as large; bias and gravity are right",
        ],
    ),
    "a cubic bias": (
        {"bias": lambda q, v: two_link.bias(q, v) + v**3},
        ["bias[j1]", "bias[j2]"],
        ["bias is no sum of a constant, rates and products of two rates, as it must be"],
    ),
}


@pytest.mark.parametrize("case", ALONE)
def test_one_part_alone_is_wrong(two, case):
    parts, wrong, said = ALONE[case]
    found = run_robot_trial(two_link.right(**parts), two).diagnosis
    assert sorted(entry.name for entry in found.entries) == wrong
    assert found.level == "armature"
    assert [words for words in said if words not in found.notes] == []
    assert found.explanations == ()


def test_beside_a_usual_cause_no_odd_number_of_a_link_is_named(two):
    """The link's mass could be 0.8 kg in gravity alone, but M and bias follow from the file's."""
    own = two_link.right(gravity=lambda q: two_link.gravity(q, lever=two_link.C2))
    notes = run_robot_trial(own, two).diagnosis.notes
    assert notes[-1].startswith("in gravity alone, as with joint j2: its place")
    odd = two_link.right(gravity=lambda q: two_link.gravity(q, lever=0.87))
    notes = run_robot_trial(odd, two).diagnosis.notes
    (others,) = (note for note in notes if note.startswith("gravity would be explained"))
    assert others.count(" or ") == 1


def test_a_difference_that_is_a_number_of_the_file_has_its_name():
    """The tool's mass is left out of the slide's own inertia; or taken off the slide's mass."""
    robot = chains.robot(
        chains.urdf(
            chains.link("base"),
            chains.link("slide", chains.Solid(2.5, (0.1, 0, 0), (0.02, 0, 0, 0.03, 0, 0.04))),
            chains.link("tool", chains.Solid(0.7, (0.3, 0, 0), (0.01, 0, 0, 0.02, 0, 0.05))),
            chains.joint("x", "base", "slide", "prismatic", (1, 0, 0)),
            chains.joint("z", "slide", "tool"),
        )
    )
    right = robot_equations(robot, "links")
    own = replace(right, mass_matrix=lambda q: right.mass_matrix(q) - np.diag([0.7, 0]))
    found = run_robot_trial(own, robot).diagnosis
    words = [*found.explanations, *found.notes]
    assert "slide: mass = 1.8 kg (file: 2.5 kg), less by tool: mass" in words[0]


def test_a_wrong_coriolis_is_a_wrong_bias(two):
    parts = {"mass_matrix": two_link.mass_matrix, "gravity": two_link.gravity}
    own = Equations(**parts, coriolis=lambda q, v: 1e3 * np.ones((2, 2)))
    found = run_robot_trial(own, two).diagnosis
    assert {entry.part for entry in found.entries} == {"bias"}
    assert "bias alone is wrong; mass_matrix and gravity are right" in found.notes


@pytest.mark.parametrize("part", ["force", "inverse_dynamics", "acceleration"])
def test_a_wrong_part_beside_right_ones_is_blamed_alone(two, part):
    right = getattr(two_link, part)
    wrong = {
        "force": lambda q, torque: right(q, torque) + 1e3,
        "inverse_dynamics": lambda q, v, a: right(q, v, a) + 1e3,
        "acceleration": lambda q, v, torque: right(q, v, torque) + 1e3,
    }
    found = run_robot_trial(two_link.right(**{part: wrong[part]}), two).diagnosis
    assert {entry.part for entry in found.entries} == {part}
    assert found.notes[0] == f"{part} alone is wrong; mass_matrix and bias and gravity are right"


@pytest.mark.parametrize(
    ("reflected", "words"),
    [
        (two_link.N * two_link.ROTOR, "every rotor: the ratio once where its square belongs"),
        (2 * two_link.REFLECTED, "every rotor's inertia twice"),
        (0.5 * two_link.REFLECTED, "every rotor's inertia half"),
        (two_link.ROTOR, "every rotor: its ratio left out"),
    ],
)
def test_the_same_error_in_every_rotor(two, reflected, words):
    own = two_link.right(mass_matrix=lambda q: two_link.mass_matrix(q, reflected))
    found = run_robot_trial(own, two).diagnosis
    assert found.level == "armature"
    assert found.explanations[0] == words


def products_negated(own: Robot, number: int) -> np.ndarray:
    inertia = own.bodies[number].inertia
    return 2 * np.diag(np.diag(inertia)) - inertia


def about_origin(own: Robot, number: int) -> np.ndarray:
    return own.bodies[number].inertia + steiner(own, number)


@pytest.mark.parametrize(
    ("inertia", "words"),
    [
        (products_negated, "every link: all products of inertia with the opposite sign"),
        (
            about_origin,
            "every link: its inertia about the joint, taken for that about the centre of mass",
        ),
    ],
)
def test_the_same_error_in_every_link(inertia, words):
    solid = chains.Solid(1.0, (0.1, 0.2, 0.3), (0.05, 0.004, -0.003, 0.04, 0.002, 0.03))
    own = chains.robot(
        chains.urdf(
            *(chains.link(name, solid) for name in ("base", "a", "b")),
            chains.joint("j1", "base", "a", axis=(0.6, 0, 0.8)),
            chains.joint("j2", "a", "b", axis=(0, 1, 0), at=(0.2, 0, 0.1)),
        )
    )
    changed = [replace(b, inertia=inertia(own, n)) for n, b in enumerate(own.bodies)]
    wrong = replace(own, bodies=tuple(changed))
    assert run_robot_trial(robot_equations(wrong), own).diagnosis.explanations == (words,)


def test_right_closed_forms_are_never_blamed(two):
    assert run_robot_trial(two_link.right(), two).diagnosis == TrialDiagnosis("armature")


@pytest.mark.parametrize("seed", range(4))
def test_bodies_terms_sum_up_to_the_robots(seed):
    """Kane's sum body by body is the project's M, bias and weights; its pieces are the bias."""
    own = chains.random_chain(seed)
    states = sample_states(own, 3, seed)
    kane, model = KaneSum(own, states.q, states.v), AnalyticRobot(own, "links")
    placed = (kane.compute_terms(k, kane.place_body(k, body)) for k, body in enumerate(own.bodies))
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
