"""Arms with fewer motors than joints: pendubot and acrobot in the forms that authors give them."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.loading import load_scenario
from crosscheck.trial.arms.subject import build_problem
from crosscheck.trial.changes.arms.arm_numbers import replace_numbers
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.input.supplied import bind_equations
from crosscheck.trial.input.symbolic import from_sympy
from crosscheck.trial.request import TrialRequest
from tests.trial.test_dependence import UNLIKE, G, arm_of, bodies_of, pendulum
from tests.trial.test_trial import trial_of

ARM = arm_of(*UNLIKE)
X, V, TORQUE = np.array([[0.3, -0.4], [1.0, 2.0], [0.0, 40.0]])
FORMS: dict[str, Callable[..., object]] = {
    "a number for each joint": lambda q, torque: [0 * q[0], torque[1]],
    "a number for each motor": lambda q, torque: [0, torque[0]],
    "a column of the motors": lambda q, tau: np.array([[0.0], [1.0]]) @ tau,
    "one number": lambda q, torque: np.array([0, torque]),
    "u": lambda q, qd, u: np.array([0, u]),
    "all joints' torques": lambda torque: torque,
}


def force_of(equations: Equations) -> np.ndarray:
    bound = equations.adapt_to_arm(ARM)
    supplied = bind_equations(bound, ARM, build_frame(bound.coordinates, ARM))
    assert supplied.motors == (1,)
    return supplied.force(0.0, X, V, TORQUE)


@pytest.mark.parametrize("form", FORMS)
def test_a_torque_comes_in_its_authors_form(form):
    equations = Equations(force=FORMS[form], drive=["theta_2"])
    np.testing.assert_array_equal(force_of(equations), TORQUE)


def test_sympy_takes_a_symbol_for_each_motor():
    x, v, (own,) = sp.symbols("x1 x2"), sp.symbols("v1 v2"), sp.symbols("T2,")
    force = sp.Matrix([0, own])
    np.testing.assert_array_equal(
        force_of(from_sympy(x, v, force=force, torque=(own,), drive=[2])), TORQUE
    )
    with pytest.raises(InputError, match="torque: has 1; must be one for each of 2 joints"):
        from_sympy(x, v, force=force, torque=(own,)).adapt_to_arm(ARM)


def test_an_acrobot_agrees():
    def factory(arm: Arm) -> Equations:
        own = pendulum(bodies_of(arm), arm.gravity_m_per_s2[0], driven=False)

        def force(q: np.ndarray, tau: np.ndarray) -> np.ndarray:
            return own.force(q) + np.array([0, tau[0]])

        return Equations(own.mass_matrix, own.bias, force=force, drive=[2])

    trial = trial_of(factory, ARM)
    assert (trial.exit_code, trial.diagnosis.entries, trial.diagnosis.hidden) == (0, (), ())
    assert "motors: at theta_2 alone" in trial.scope


def test_equations_that_read_motors_are_of_a_level_that_has_them():
    """Links are nearer, of which M lacks nothing but the motors that the equations have."""
    motors = {"joints[1].motor_mass_kg": 3.0, "joints[1].rotor_inertia_kg_m2": 0.4}

    def factory(arm: Arm) -> Equations:
        own = pendulum(bodies_of(arm), arm.gravity_m_per_s2[0])

        def mass_matrix(q: np.ndarray) -> np.ndarray:
            return own.mass_matrix(q) + np.diag([0, arm.joints[1].rotor_inertia_kg_m2])

        return replace(own, mass_matrix=mass_matrix)

    levels = [each.level for each in trial_of(factory, replace_numbers(ARM, motors)).distances]
    assert "carriers" in levels
    assert "links" not in levels


@pytest.mark.parametrize("drive", [1, [0], [3], ["theta_3"], [1, 1], [True], [None]])
def test_joints_that_are_none_are_refused(drive):
    with pytest.raises(InputError, match=r"drive.*must be a list of joints, each once, of 1 to 2"):
        force_of(Equations(force=lambda torque: torque, drive=drive))


def test_a_scenario_that_drives_a_joint_without_motor_is_refused():
    own = pendulum(bodies_of(ARM), G, driven=False)
    equations = Equations(own.mass_matrix, own.bias, force=FORMS["one number"], drive=[2])
    pulse = [[0.0, 2.0, 0.0], [0.0, 0.0, 0.0]]
    table = {"kind": "table", "time_s": [0.0, 0.5, 9.0], "torque_N_m": pulse}
    pulsed = Scenario.model_validate({**load_scenario("pd").model_dump(), "drive": table})
    for scenario in (load_scenario("pd"), pulsed):
        request = TrialRequest("yours", equations, ARM, (scenario,))
        with pytest.raises(InputError, match="drives joint 1; the equations take no torque there"):
            build_problem(request)
    gains = {"proportional_N_m_per_rad": (0.0, 9.0), "derivative_N_m_s_per_rad": (0.0, 1.0)}
    second = load_scenario("pd").drive.model_copy(update=gains)
    held = load_scenario("pd").model_copy(update={"drive": second})
    assert build_problem(TrialRequest("yours", equations, ARM, (held,)))
