"""The drive law that all models share, against its closed form: sizes, rates, arguments, tables."""

from typing import Any

import numpy as np
import pytest

from crosscheck.analytic.kernel.program import LOOK_UP
from crosscheck.checks.arm_data import drive_torques
from crosscheck.models.experiment.drive import drive_data, joint_torque, torques_along
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.loading import load_arm
from crosscheck.registry import build
from tests.mixed_arms import scenario as scenario_of

TIME = np.array([0.0, 0.07, 0.31, 0.9, 1.6])
THETA, RATES = np.array([0.4, -1.1]), np.array([-0.7, 1.9])


def scenario(**drive: Any) -> Scenario:
    return scenario_of(duration_s=2.0, step_s=1e-3, drive=drive)


def sine(argument: str) -> Scenario:
    both = {"amplitude_N_m": [30.0, -12.0], "rate_rad_per_s": [3.0, 7.5]}
    return scenario(kind="sinusoid", argument=argument, **both)


LAWS = {
    "constant": (scenario(kind="constant", torque_N_m=[5.0, -2.5]), lambda t: [5.0, -2.5]),
    "pd": (
        scenario(
            kind="pd",
            target_rad=[1.0, 0.25],
            proportional_N_m_per_rad=[40.0, 9.0],
            derivative_N_m_s_per_rad=[6.0, 2.0],
        ),
        lambda t: [40 * (1 - 0.4) - 6 * -0.7, 9 * (0.25 + 1.1) - 2 * 1.9],
    ),
    "sine of time": (sine("time"), lambda t: [30 * np.sin(3 * t), -12 * np.sin(7.5 * t)]),
    "sine of the root of time": (
        sine("sqrt_time"),
        lambda t: [30 * np.sin(3 * t**0.5), -12 * np.sin(7.5 * t**0.5)],
    ),
    "table": (
        scenario(
            kind="table", time_s=[0.0, 0.5, 2.0], torque_N_m=[[0.0, 8.0, 2.0], [1.0, 1.0, -3]]
        ),
        lambda t: [16 * t if t < 0.5 else 10 - 4 * t, 1 if t < 0.5 else (7 - 8 * t) / 3],
    ),
}


@pytest.mark.parametrize("law", LAWS)
def test_torques_are_those_of_the_law(law):
    """By data and formula of all models, and by two engines that may turn them into their own."""
    experiment, closed = LAWS[law]
    expected, data = np.array([closed(t) for t in TIME]), drive_data(experiment, 2)
    rows = [
        [
            joint_torque(
                data.code,
                data.gains[k],
                data.table_time,
                data.table_torque[k],
                t,
                THETA[k],
                RATES[k],
            )
            for k in range(2)
        ]
        for t in TIME
    ]
    assert np.array(rows) == pytest.approx(expected, rel=1e-14, abs=1e-13)
    angles, rates = (np.tile(each, (TIME.size, 1)) for each in (THETA, RATES))
    checked = drive_torques(experiment, TIME, angles, rates)  # of the checks' own
    assert checked == pytest.approx(expected, rel=1e-14, abs=1e-13)
    along = torques_along(data, TIME, angles, rates)
    assert along == pytest.approx(expected, rel=1e-14, abs=1e-13)
    for name in ("analytic:links", "pinocchio:links"):
        model = build(name, load_arm("paper-labelled"), experiment)
        forces = [model.generalized_force(t, THETA, RATES) for t in TIME]
        assert np.array(forces) == pytest.approx(expected, rel=1e-12, abs=1e-12), name


@pytest.mark.parametrize(("motors", "right"), [(None, [5, 5]), ((1,), [0, 5]), ((), [0, 0])])
def test_joints_without_a_motor_have_no_torque(motors, right):
    data = drive_data(scenario(kind="constant", torque_N_m=5.0), 2, motors)
    assert data.gains[:, 0].tolist() == right


def test_a_kernels_text_holds_the_ends_of_a_table_and_is_straight_between():
    times, torques = np.array([0.0, 0.5, 2.0]), np.array([[0.0, 8.0, 2.0], [1.0, 1.5, -3.0]])
    text: dict[str, Any] = {"array": np.ndarray, "fma": lambda a, b, c: a * b + c}
    exec(LOOK_UP, text)
    for t in (-1.0, 0.0, 0.2, 0.5, 1.9, 2.0, 3.0):
        table = np.zeros(2)
        text["look_up"](t, times, torques.ravel(), 3, 2, table)
        assert table == pytest.approx([np.interp(t, times, row) for row in torques], abs=1e-14)
