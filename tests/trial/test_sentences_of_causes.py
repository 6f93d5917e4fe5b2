"""What a sentence on a wrong entry says: one fact once, at its entry, by true angles."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.report.trials.trial import describe_errors, describe_notes
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
def test_a_factor_that_is_a_symbol_and_a_number_is_told_once(term, entries, factor):
    """By the symbol in a term of gears, of which there are three, and by the number elsewhere."""
    result = trial_of(Equations(less(term, 2 / 3, *entries)), PAPER)
    (error,) = describe_errors(result)
    assert f"times {factor}?" in error
    assert "; or" not in error


def test_an_asymmetric_mass_matrix_is_told_by_both_entries():
    result = trial_of(Equations(less(coupling, 2, (1, 0))), PAPER)
    (symmetric,) = (f for f in result.agreement.findings if f.quantity == "symmetric")
    assert symmetric.note == "wrong: M[theta_1, theta_2], M[theta_2, theta_1]"
    assert {(w.place.row, w.place.column) for w in result.wrong_entries} == {(1, 0)}


def test_what_is_zero_in_the_file_and_in_the_equations_makes_no_note():
    def missing_payload_alone(own: Arm) -> Equations:
        return pendulum(bodies_of(own), 9.8, own.payload_mass_kg, elbow=0.5)

    notes = " ".join(describe_notes(trial_of(missing_payload_alone, arm_of(*UNLIKE))))
    assert "nor has this arm" not in notes
    assert "rotor" not in notes


def test_angles_of_motors_are_divided_by_their_ratios():
    """Of a rigid arm by its motors' angles, an elbow's weight is by the sum of both over n."""

    def factory(own: Arm, scenario: Scenario) -> Equations:
        n = np.array([1 + joint.ring_teeth / joint.sun_teeth for joint in own.joints])
        motors = Coordinates(matrix=np.diag(1 / n), names=("psi_1", "psi_2", "psi_3"))
        right = equations_of(in_frame("analytic:links", motors, own, scenario))

        def force(t: float, x: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
            whole = np.array(right.force(t, x, v, torque))
            angle, (g_x, g_y) = (x / n)[:2].sum(), own.gravity_m_per_s2
            weight = own.links[1].mass * own.links[1].com_m
            whole[1] -= weight * (g_y * np.cos(angle) - g_x * np.sin(angle)) / n[1]
            return whole

        return replace(right, force=force, coordinates=motors)

    (error,) = describe_errors(trial_of(factory, load_arm("three-unlike")))
    assert "m2 g_y d2/n2 cos(psi_1/n1 + psi_2/n2)" in error
    assert "missing term" in error
