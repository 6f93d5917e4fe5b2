"""The rigid arm's runs against closed forms; and both readings of Table I."""

import numpy as np
import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import Diverged
from crosscheck.models.loading import Case, load_arm, load_case
from crosscheck.models.pinocchio.arm import (
    PinocchioArmature,
    PinocchioCarriers,
    PinocchioCoupled,
    PinocchioLinks,
)
from tests.loops import require_items

LEVELS = [PinocchioLinks, PinocchioCarriers, PinocchioArmature, PinocchioCoupled]


def paper_case(scenario: str, *more: str) -> Case:
    return load_case("paper-labelled", scenario, settings=["scenario.duration_s=0.5", *more])


def single_joint(*more: str) -> Case:
    """The shoulder alone, as a rod with the payload."""
    case = load_case("paper-labelled", "constant-torque", settings=more)
    return case._replace(arm=shortened(case.arm, 1))


def shortened(arm: Arm, joints: int) -> Arm:
    return arm.model_copy(update={"joints": arm.joints[:joints], "links": arm.links[:joints]})


def test_both_readings_load_and_differ():
    labelled, swapped = (load_arm(f"paper-{name}").joints[0] for name in ("labelled", "swapped"))
    for part in require_items(("sun", "planet", "carrier")):
        mass = getattr(labelled, f"{part}_mass_kg")
        assert mass == getattr(swapped, f"{part}_equivalent_mass_kg")


def test_a_short_pulse_in_a_table_is_not_leapt_over():
    """One joint at rest until 1 ms of torque at 0.3 s: theta is a cubic spline in closed form."""
    case = single_joint("scenario.step_s=1e-3", "scenario.record_every=1")
    corners = np.array([0.3, 0.3005, 0.301])
    pulse = {"time_s": (0.0, *corners, 0.5), "torque_N_m": ((0.0, 0.0, 50.0, 0.0, 0.0),)}
    experiment = {**case.scenario.model_dump(), "drive": {"kind": "table", **pulse}}
    run = PinocchioLinks(case.arm, type(case.scenario).model_validate(experiment)).simulate()
    slopes = 50 / 5e-4 * np.array([1, -2, 1])
    since = np.maximum(run.time.values[:, None] - corners, 0)
    theta = since**3 @ slopes / 6 / (27 / 3 + 10)
    # Interpolation inside the long last step rounds to 2e-15 rad; a missed pulse loses 3e-4 rad.
    np.testing.assert_allclose(run.theta.values[:, 0], theta, rtol=0, atol=1e-14)


def test_square_root_of_time_costs_no_accuracy():
    """One joint under A sin(w sqrt(t)): its rate in closed form."""
    case = single_joint()
    scenario = load_case("paper-labelled", "back-and-forth").scenario
    run = PinocchioLinks(case.arm, scenario).simulate()
    w, s = 62.83185307179586, np.sqrt(run.time.values)
    rate = 2000 / (27 / 3 + 10) * 2 * (np.sin(w * s) - w * s * np.cos(w * s)) / w**2
    # Rates of up to 5 rad/s, to the tolerance of the run, interpolation included.
    np.testing.assert_allclose(run.theta_dot.values[:, 0], rate, rtol=0, atol=2e-11)


def test_tolerance_can_be_changed_to_estimate_the_error():
    model = PinocchioCoupled(*paper_case("constant-torque"))
    fine = model.simulate()
    difference = np.abs(model.reference(1e-9).theta - fine.theta).max()
    assert 1e-13 < difference < 1e-7


def test_recording_grid_is_the_scenarios():
    run = PinocchioLinks(
        *paper_case("pd", "scenario.duration_s=0.05", "scenario.record_every=7")
    ).simulate()
    # 5000 steps and 7 have no common divisor but 1.
    np.testing.assert_array_equal(run.time, np.arange(5001) * 1e-5)


TORQUE = "constant-torque", "scenario.drive.torque_N_m=1e9"
GAIN = "pd", "scenario.drive.derivative_N_m_s_per_rad=-40000.0"


@pytest.mark.parametrize(
    ("scenario", "setting", "level"),
    [(*away, level) for away, level in zip((TORQUE, GAIN) * 2, LEVELS, strict=True)],
)
def test_a_run_away_is_reported_as_divergence(scenario, setting, level):
    with pytest.raises(Diverged, match=f"{level.name}: diverged at t ="):
        level(*paper_case(scenario, setting)).simulate()
