"""What a sentence on a wrong entry says: one fact once, at its entry, by true angles."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.trial.input.equations import Coordinates, Equations
from tests.trial.test_dependence import UNLIKE, arm_of, bodies_of, pendulum
from tests.trial.test_trial import equations_of, in_frame, trial_of

PAPER = load_arm("paper-labelled")
COUPLED = in_frame("analytic:coupled", Coordinates(), PAPER, load_scenario("pd")).model


def coupling(q: np.ndarray) -> float:
    """m2 L1 d2 cos(theta_2)."""
    first, second = PAPER.links
    return second.mass * first.length_m * second.com_m * float(np.cos(q[1]))


def planets(q: np.ndarray) -> float:
    """N2 m_p2 r_c2^2."""
    joint = PAPER.joints[1]
    radius = joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2
    return float(joint.planet_count * joint.planet_mass_kg * radius**2)


def less(
    term: Callable[[np.ndarray], float], by: float, *entries: tuple[int, int]
) -> Callable[[np.ndarray], np.ndarray]:
    """M without a part of a term in some entries."""

    def mass_matrix(q: np.ndarray) -> np.ndarray:
        mass = np.array(COUPLED.mass_matrix(q))
        for entry in entries:
            mass[entry] -= by * term(q)
        return mass

    return mass_matrix


@pytest.mark.parametrize(
    ("term", "entries", "factor"),
    [(planets, ((1, 1),), "1/N2"), (coupling, ((0, 1), (1, 0)), "0.333333")],
)
def test_a_factor_that_is_a_symbol_and_a_number_is_reported_once(term, entries, factor):
    """By the symbol in a term of gears, of which there are three, and by the number elsewhere."""
    result = trial_of(Equations(less(term, 2 / 3, *entries)), PAPER)
    (error,) = result.diagnosis.notes
    assert f"times {factor}?" in error
    assert "; or" not in error


def test_an_asymmetric_mass_matrix_is_reported_by_both_entries():
    result = trial_of(Equations(less(coupling, 2, (1, 0))), PAPER)
    (symmetric,) = (f for f in result.agreement.findings if f.quantity == "symmetric")
    assert symmetric.note == "wrong: M[theta_1, theta_2], M[theta_2, theta_1]"
    assert {(w.place.row, w.place.column) for w in result.diagnosis.entries} == {(1, 0)}


def test_what_is_zero_in_the_file_and_in_the_equations_makes_no_note():
    def missing_payload_alone(own: Arm) -> Equations:
        return pendulum(bodies_of(own), 9.8, own.payload_mass_kg, elbow=0.5)

    notes = " ".join(trial_of(missing_payload_alone, arm_of(*UNLIKE)).notes)
    assert "nor has this arm" not in notes
    assert "rotor" not in notes


def on_motors(
    own: Arm, scenario: Scenario, weight: Callable[..., np.ndarray], once: bool
) -> Equations:
    """A rigid arm by its motors' angles, with more weight; once: a ratio of M is no square."""
    n = np.array([1 + joint.ring_teeth / joint.sun_teeth for joint in own.joints])
    motors = Coordinates(matrix=np.diag(1 / n), names=("psi_1", "psi_2", "psi_3"))
    still = own.model_copy(update={"gravity_m_per_s2": (0.0, 0.0)})
    right, bare = (
        equations_of(in_frame("analytic:links", motors, arm, scenario)) for arm in (own, still)
    )

    def force(t: float, x: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        whole = np.array(right.force(t, x, v, torque))
        return whole + weight(own, n, x, whole - bare.force(t, x, v, torque))

    def mass_matrix(x: np.ndarray) -> np.ndarray:
        return np.array(right.mass_matrix(x)) * (1 + np.diag([0, 0, n[2] - 1]) * once)

    parts = {"force": force, "mass_matrix": mass_matrix, "acceleration": None}
    return replace(right, **parts, coordinates=motors, level="links")


def drop_elbow(own: Arm, n: np.ndarray, x: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Without the weight of link 2 in its row."""
    angle, (g_x, g_y) = (x / n)[:2].sum(), own.gravity_m_per_s2
    weight = own.links[1].mass * own.links[1].com_m
    return -np.eye(3)[1] * weight * (g_y * np.cos(angle) - g_x * np.sin(angle)) / n[1]


MOTORS = {
    "an angle": (drop_elbow, False, ["missing term: m2 g_y d2/n2 cos(psi_1/n1 + psi_2/n2)"]),
    "weights at the joints": (
        lambda own, n, x, weights: (n - 1) * weights,
        False,
        [f"yours has the weight of every body times n{joint}" for joint in (1, 2, 3)],
    ),
    "a ratio for its square": (
        lambda own, n, x, weights: 0 * weights,
        True,
        ["M[psi_3, psi_3]: yours has (I_l3/n3^2 + m3 d3^2/n3^2 + m_payload L3^2/n3^2) times n3?"],
    ),
}


@pytest.mark.parametrize("slip", MOTORS)
def test_what_motors_turn_is_divided_by_their_ratios(slip):
    weight, once, told = MOTORS[slip]
    trial = trial_of(
        lambda own, scenario: on_motors(own, scenario, weight, once), load_arm("three-unlike")
    )
    errors = trial.diagnosis.notes
    assert all(any(words in error for error in errors) for words in told), errors
