"""Equations of an arm that are right in other coordinates: said first, in place of all else."""

from collections.abc import Callable

import numpy as np
import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.trial.input.equations import Coordinates, Equations
from tests.arms import PAPER
from tests.trial.test_dependence import UNLIKE, arm_of, bodies_of, pendulum
from tests.trial.test_trial import in_frame, trial_of

ARM = arm_of(*UNLIKE)
SUMS = np.linalg.inv([[1.0, 0.0], [1.0, 1.0]])


def written_in(own: Equations, jacobian: np.ndarray) -> Equations:
    """Equations of q as those of x, of which q = jacobian @ x; torques are those of x."""
    J = np.array(jacobian)
    assert own.mass_matrix is not None
    assert own.bias is not None
    assert own.force is not None
    mass, bias, weight = own.mass_matrix, own.bias, own.force
    return Equations(
        lambda q: J.T @ mass(J @ q) @ J,
        lambda q, v: J.T @ bias(J @ q, J @ v),
        force=lambda q, torque: torque + J.T @ weight(J @ q, 0 * torque),
    )


def right(arm: Arm) -> Equations:
    return pendulum(bodies_of(arm), arm.gravity_m_per_s2[0])


CASES: dict[str, tuple[Callable[[Arm], Equations], str]] = {
    "absolute angles": (
        lambda arm: written_in(right(arm), SUMS),
        'absolute angles (coordinates=Coordinates(links="absolute"))',
    ),
    "relative angles": (
        lambda arm: Equations(**{**vars(right(arm)), "coordinates": Coordinates(links="absolute")}),
        "relative angles (coordinates=Coordinates(matrix=[[1.0, 0.0], [0.0, 1.0]]))",
    ),
    "the sense of theta_2 reversed": (
        lambda arm: written_in(right(arm), np.diag([1.0, -1.0])),
        "the sense of theta_2 reversed (coordinates=Coordinates(matrix=[[1.0, 0.0], [0.0, -1.0]]))",
    ),
}


def test_a_wrong_sign_of_weights_is_no_matter_of_coordinates():
    def factory(arm: Arm) -> Equations:
        return pendulum(bodies_of(arm), -arm.gravity_m_per_s2[0])

    trial = trial_of(factory, ARM)
    assert trial.diagnosis.readings == ()
    assert all("opposite sign" in line for line in trial.diagnosis.notes)


@pytest.mark.parametrize("words", CASES)
def test_other_coordinates_are_said_first(words):
    factory, told = CASES[words]
    trial = trial_of(factory, ARM)
    assert trial.exit_code == 1
    readings = [reading.partition(" (")[0] for reading in trial.diagnosis.readings]
    assert words in readings  # of the senses of two joints each is as good as the other
    assert len(readings) == (2 if "sense" in words else 1)
    assert told in trial.headline
    assert trial.diagnosis.notes == ()


def test_angles_of_suns_are_those_of_motors():
    """A sun turns 1 + z_r / z_s times as far as its carrier."""
    ratios = [1 + joint.ring_teeth / joint.sun_teeth for joint in PAPER.joints]
    of_suns = Coordinates(matrix=np.diag(1 / np.array(ratios)))

    def factory(arm: Arm, scenario: Scenario) -> Equations:
        moved = in_frame("analytic:coupled", of_suns, arm, scenario)
        return Equations(moved.mass_matrix, lambda x, v: moved.bias(x, v))

    readings = trial_of(factory, PAPER).diagnosis.readings
    assert [each.partition(" (")[0] for each in readings] == [
        "angles of the motors, before their gears"
    ]
