"""Right equations in coordinates that are hard on numbers: never blamed; errors still are."""

from dataclasses import replace

import numpy as np
import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.models.loading import load_arm
from crosscheck.planning.sizing import make_unequal_gains_scenario
from crosscheck.trial.coordinates.build import LAYOUTS
from crosscheck.trial.input.equations import Coordinates, Equations
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.result import Trial
from crosscheck.trial.trial import run_trial
from tests.arms import random_arm
from tests.trial.test_judge_table import two_link
from tests.trial.test_trial import equations_of, in_frame, trial_of, two_links

pytestmark = pytest.mark.slow


def in_coordinates(model: str, coordinates: Coordinates, arm: Arm) -> Equations:
    """Of this arm alone, so that no probe is asked."""
    moved = in_frame(model, coordinates, arm, make_unequal_gains_scenario(arm))
    return replace(equations_of(moved), coordinates=coordinates)


def judged(equations: Equations, arm: Arm) -> Trial:
    return run_trial(TrialRequest("yours", equations, arm, quick=True))


def assert_never_blamed(equations: Equations, arm: Arm) -> None:
    trial = judged(equations, arm)
    assert [finding.id for finding in trial.agreement.disagreeing] == []
    assert trial.diagnosis.entries == ()


def turned(n: int, seed: int, condition: float) -> np.ndarray:
    """A full matrix (n, n) of this condition."""
    draw = np.random.default_rng(seed).normal(size=(2, n, n))
    left, right = (np.linalg.qr(each)[0] for each in draw)
    return left * np.geomspace(1, 1 / condition, n) @ right


def lengths(arm: Arm, gearing: str) -> np.ndarray:
    """Displacements by radii of 5 cm, rows (n, 1)."""
    return np.where(LAYOUTS[gearing](arm).angular, 1.0, 0.05)[:, None]


def test_in_coordinates_that_hardly_tell_the_links_apart():
    arm = random_arm(33, most_joints=2)
    matrix = lengths(arm, "lumped") * turned(len(LAYOUTS["lumped"](arm)), 33, 2e4)
    own = in_coordinates("pinocchio:gears", Coordinates("lumped", matrix=matrix), arm)
    assert_never_blamed(own, arm)


@pytest.mark.parametrize("model", ["analytic:coupled", "pinocchio:links"])
def test_in_units_of_a_millionth_and_of_a_million(model):
    """Where the rates' share in a bias differs by twelve orders."""
    arm = load_arm("three-unlike")
    units = np.tril(turned(3, 1, 2.0)) + 2 * np.eye(3)
    coordinates = Coordinates(matrix=units * np.array([1e6, 1e-6, 1.0]))
    assert_never_blamed(in_coordinates(model, coordinates, arm), arm)


def test_where_a_function_bends_gear_angles(labelled):
    bends = lengths(labelled, "lumped")[:, 0]
    coordinates = Coordinates("lumped", function=lambda x: bends * (x + 0.5 * np.sin(x)))
    assert_never_blamed(in_coordinates("pinocchio:gears", coordinates, labelled), labelled)


def test_where_a_function_reaches_half_of_all_poses(labelled):
    """The elbow by an actuator's length, 0.1 m to 0.7 m; and an error is seen there as well."""
    by_actuator = Coordinates(
        function=lambda x: np.array([x[0], np.arccos((0.3**2 + 0.4**2 - x[1] ** 2) / 0.24)])
    )
    own = in_coordinates("pinocchio:links", by_actuator, labelled)
    assert_never_blamed(own, labelled)
    wrong_equations = replace(own, bias=lambda x, v: (1 + 1e-8) * own.bias(x, v))
    assert judged(wrong_equations, labelled).exit_code == 1


def test_the_level_is_that_of_the_fewest_wrong_entries_of_all_parts():
    """The elbow's rotor turns with joint 2 alone: of M alone links would be wrong in fewer."""
    arm = two_link()
    moved = in_frame("pinocchio:carriers", Coordinates(), arm, make_unequal_gains_scenario(arm))
    right = equations_of(moved)
    missing = arm.joints[1].rotor_inertia_kg_m2 * np.array([[1.0, 1.0], [1.0, 0.0]])
    wrong = replace(right, mass_matrix=lambda x: moved.model.mass_matrix(x) - missing)
    trial = judged(replace(wrong, acceleration=None), arm)
    assert trial.level == "carriers"
    assert {each.place.part for each in trial.diagnosis.entries} == {"mass_matrix"}


def test_equations_that_know_one_arm_alone_are_judged_on_that(labelled):
    def only(arm: Arm) -> Equations:
        assert arm == labelled
        return two_links(arm)

    assert trial_of(only, labelled).exit_code == 0
