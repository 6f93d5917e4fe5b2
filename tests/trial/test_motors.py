"""Arms with fewer motors than joints; forms of torques are those of tests/robots."""

import numpy as np
import pytest
import sympy as sp

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_scenario
from crosscheck.trial.arms.subject import build_problem
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.input.supplied import bind_equations
from crosscheck.trial.input.symbolic import from_sympy
from crosscheck.trial.request import TrialRequest
from tests.trial.test_dependence import UNLIKE, G, arm_of, bodies_of, pendulum
from tests.trial.test_trial import trial_of

ARM = arm_of(*UNLIKE)


def test_sympy_takes_a_symbol_for_each_motor():
    x, v, (own,) = sp.symbols("x1 x2"), sp.symbols("v1 v2"), sp.symbols("T2,")
    force, torque = sp.Matrix([0, own]), np.array([0.0, 40.0])
    bound = from_sympy(x, v, force=force, torque=(own,), drive=[2]).adapt_to_arm(ARM)
    supplied = bind_equations(bound, ARM, build_frame(bound.coordinates, ARM))
    assert supplied.motors == (1,)
    assert supplied.force(0.0, 0 * torque, 0 * torque, torque).tolist() == torque.tolist()
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


def test_a_scenario_that_drives_a_joint_without_motor_is_refused():
    own = pendulum(bodies_of(ARM), G, driven=False)
    equations = Equations(own.mass_matrix, own.bias, force=lambda torque: torque, drive=[2])
    pd = load_scenario("pd")
    request = TrialRequest("yours", equations, ARM, (pd,))
    with pytest.raises(InputError, match="drives joint 1; the equations take no torque there"):
        build_problem(request)
