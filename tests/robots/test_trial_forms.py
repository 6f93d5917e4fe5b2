"""A robot's equations by SymPy, with friction, and in a test by assert_agrees."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import switches
from crosscheck.testing import assert_agrees, from_sympy, try_equations
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.result import Trial
from crosscheck.trial.robots.answers import Friction, read_friction
from crosscheck.trial.robots.consistency import BiasTerms
from crosscheck.trial.robots.explain import _linear_notes
from tests.robots import two_link

TWO = two_link.robot()
q, v, T = sp.symbols("q1 q2"), sp.symbols("v1 v2"), sp.symbols("T1 T2")
m2, g, shoulder, elbow = sp.symbols("m2 g shoulder elbow")
L, C2, FIRST = two_link.L, two_link.C2, two_link.M1 * two_link.C1
WAVE = m2 * L * C2 * sp.cos(q[1])
MASS = sp.Matrix([[shoulder + elbow + 2 * WAVE, elbow + WAVE], [elbow + WAVE, elbow]])
BIAS = m2 * L * C2 * sp.sin(q[1]) * sp.Matrix([-2 * v[0] * v[1] - v[1] ** 2, v[0] ** 2])
LAST = m2 * C2 * g * sp.cos(q[0] + q[1])
GRAVITY = sp.Matrix([(FIRST + m2 * L) * g * sp.cos(q[0]) + LAST, LAST])
VALUES: dict[object, float | str] = {
    "m2": two_link.M2,
    g: two_link.G,
    shoulder: two_link.SHOULDER,
    "elbow": two_link.ELBOW,
}
VISCOUS, COULOMB = np.array([12.0, 3.0]), np.array([0.7, 0.2])
WAYS = {
    "parts": {"bias": BIAS, "gravity": GRAVITY},
    "nonlinear effects": {"bias": BIAS + GRAVITY},
    "forcing": {"forcing": sp.Matrix(T) - BIAS - GRAVITY, "torque": T},
}


@pytest.mark.parametrize("way", WAYS)
def test_sympy(way):
    own = from_sympy(q, v, mass_matrix=MASS, values=VALUES, **WAYS[way])
    trial = assert_agrees(own, TWO)
    assert isinstance(trial, Trial)
    assert "links" in {each.level for each in trial.distances if not each.entries}
    judged = {f.quantity for f in trial.agreement.findings if f.about.key.family == "trial-states"}
    assert judged == {"mass_matrix", "bias", "force" if way == "forcing" else "gravity"}


def test_a_symbol_without_number_is_named():
    own = from_sympy(q, v, mass_matrix=MASS, values={g: 9.81})
    with pytest.raises(InputError, match=r"mass_matrix: elbow.*needs a number in values"):
        assert_agrees(own, TWO)


def test_an_assertion_tells_what_is_wrong():
    wrong = two_link.right(gravity=lambda q: -two_link.gravity(q))
    with pytest.raises(AssertionError, match="gravity alone is wrong"):
        assert_agrees(lambda robot: wrong, TWO)

    def my_robot(robot):
        return wrong

    with pytest.raises(AssertionError, match=r"^gravity\[j1\]: yours are .* with gravity"):
        assert_agrees(my_robot, TWO)
    with pytest.raises(InputError, match="scenarios: is for arms"):
        assert_agrees(wrong, TWO, scenarios=["pd"])
    with pytest.raises(AssertionError, match="not with links"):
        assert_agrees(two_link.right(), TWO, level="links")


def test_a_file_states_its_friction(tmp_path):
    file = tmp_path / "rubbed.py"
    file.write_text(
        "from tests.robots import two_link\n"
        "from tests.robots.two_link import gravity, mass_matrix\n\n"
        "viscous_friction = [12.0, 3.0]\n\n"
        "def bias(q, v):\n    return two_link.bias(q, v) + viscous_friction * v\n"
    )
    assert try_equations(f"{file}", TWO, quick=True).agrees


def rubbed(v: np.ndarray) -> np.ndarray:
    return VISCOUS * v + COULOMB * np.sign(v)


def accelerate(q: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
    return two_link.acceleration(q, v, torque - rubbed(v))


FORMS: dict[str, dict[str, Callable[..., object]]] = {
    "in the bias": {"bias": lambda q, v: two_link.bias(q, v) + rubbed(v)},
    "in the force": {"force": lambda q, v, torque: two_link.force(q, torque) - rubbed(v)},
    "in the bias, beside force": {
        "bias": lambda q, v: two_link.bias(q, v) + rubbed(v),
        "force": two_link.force,
    },
    "in inverse dynamics": {
        "inverse_dynamics": lambda q, v, a: two_link.inverse_dynamics(q, v, a) + rubbed(v)
    },
    "in the acceleration": {"acceleration": accelerate},
}


@pytest.mark.parametrize("form", FORMS)
def test_friction_that_is_stated_is_no_error(form):
    own = two_link.right(**FORMS[form])
    stated = Equations(
        **{**vars(own), "viscous_friction": VISCOUS, "coulomb_friction": list(COULOMB)}
    )
    assert_agrees(stated, TWO)


def test_friction_that_is_another_than_stated_is_seen():
    own = two_link.right(**FORMS["in the force"])
    stated = Equations(**{**vars(own), "viscous_friction": 1.01 * VISCOUS})
    with pytest.raises(AssertionError, match="force alone is wrong"):
        assert_agrees(stated, TWO)


def test_friction_of_one_joint_or_of_one_kind_is_friction():
    none, one, v = np.zeros(2), np.array([0.0, 2.0]), np.array([[3.0, -5.0]])
    assert Friction(one, none).is_stated
    assert Friction(none, one).is_stated
    assert not Friction(none, none).is_stated
    assert Friction(one, none).torques(v).tolist() == [[0.0, -10.0]]
    assert Friction(none, one).torques(v).tolist() == [[0.0, -2.0]]


def test_friction_of_the_robots_file_is_asked_for():
    """In whichever part, without a statement; another statement than the file's is one line."""
    joints = tuple(replace(j, friction=c) for j, c in zip(TWO.joints, VISCOUS, strict=True))
    rubbing, own = replace(TWO, joints=joints), two_link.right()
    viscous = {**vars(own), "bias": lambda q, v: two_link.bias(q, v) + VISCOUS * v}
    assert_agrees(Equations(**viscous), rubbing)
    assert_agrees(Equations(**{**viscous, "viscous_friction": VISCOUS}), rubbing)
    force = Equations(**{**vars(own), "force": two_link.force})
    with pytest.raises(AssertionError, match="friction"):
        assert_agrees(force, rubbing)
    near, other = (
        Equations(**{**viscous, "viscous_friction": (1 + off) * VISCOUS})
        for off in (0.98e-9, 1.02e-9)
    )
    assert read_friction(near, rubbing, "yours").is_stated
    with pytest.raises(InputError, match=r"viscous_friction.*as the robot's file has it"):
        assert_agrees(other, rubbing)


def test_friction_has_a_number_for_each_coordinate():
    stated = Equations(**{**vars(two_link.right()), "viscous_friction": [1.0]})
    with pytest.raises(InputError, match=r"viscous_friction.*must be \(2,\).*each of j1, j2"):
        assert_agrees(stated, TWO)


def test_switches_of_meshes_are_refused_of_a_robot():
    with pytest.raises(InputError, match="switches: is for arms"):
        assert_agrees(two_link.right(), TWO, switches=switches())


def test_a_part_linear_in_rates_is_friction_where_its_factor_is_a_number():
    for factors, is_friction in ((np.full(5, 2.0), True), (np.linspace(1.0, 2.0, 5), False)):
        linear, products = np.zeros((5, 2, 2)), np.zeros((5, 2, 2, 2))
        linear[:, 0, 0] = factors
        terms = BiasTerms(np.zeros((5, 2)), linear, products)
        (note,) = _linear_notes(terms, np.ones((5, 2)), ["j1", "j2"], ())
        assert ("friction?" in note) is is_friction
