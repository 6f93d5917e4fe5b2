"""What holds the weights as a part of its own: M q'' + C q' + g = tau, as courses write it."""

import json
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.report.trials.output import format_trial_json
from crosscheck.trial.input.equations import Coordinates, Equations
from crosscheck.trial.input.symbolic import from_sympy
from tests.trial.test_dependence import UNLIKE as BODIES
from tests.trial.test_dependence import arm_of, bodies_of, pendulum
from tests.trial.test_trial import FramedModel, equations_of, in_frame, trial_of

UNLIKE = arm_of(*BODIES)


class TwoLinks:
    """M, C and g of two links with functions as methods, for an arm that hangs along x."""

    def __init__(self, arm: Arm) -> None:
        self.bodies = bodies_of(arm)
        self.own = pendulum(self.bodies, arm.gravity_m_per_s2[0], driven=False)

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        return self.own.mass_matrix(q)

    def coriolis(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        (_, l1, _, _), (m2, _, d2, _) = self.bodies
        wave = m2 * l1 * d2 * np.sin(q[1])
        return np.array([[-wave * v[1], -wave * (v[0] + v[1])], [wave * v[0], 0.0]])

    def gravity(self, q: np.ndarray) -> np.ndarray:
        return -self.own.force(q)


class InverseDynamicsAlone:
    """Newton and Euler's answer in gravity, or without."""

    def __init__(self, parts: TwoLinks, *, holds_weights: bool) -> None:
        self.parts, self.holds_weights = parts, holds_weights

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        moving = self.parts.mass_matrix(q) @ a + self.parts.coriolis(q, v) @ v
        return moving + self.parts.gravity(q) if self.holds_weights else moving


class SecondForgotten(TwoLinks):
    """Link 2 weighs nothing at its own joint."""

    def gravity(self, q: np.ndarray) -> np.ndarray:
        return super().gravity(q) * (1, 0)


class Lifted(TwoLinks):
    """The weights with the opposite sign."""

    def gravity(self, q: np.ndarray) -> np.ndarray:
        return -super().gravity(q)


class WithForce(TwoLinks):
    """Torques beside gravity, without the weights."""

    def force(self, torque: np.ndarray) -> np.ndarray:
        return torque


class WeightTwice(TwoLinks):
    """The weights in the force as well."""

    def force(self, q: np.ndarray, torque: np.ndarray) -> np.ndarray:
        return torque - self.gravity(q)


@pytest.mark.parametrize("source", [TwoLinks, WithForce, lambda arm: TwoLinks(arm)])
def test_mass_matrix_coriolis_and_gravity_agree_as_a_class_or_what_a_factory_returns(source):
    result = trial_of(source, UNLIKE)
    assert result.exit_code == 0
    assert "not judged" not in repr(result)
    judged = {f.quantity for f in result.agreement.findings if f.about.key.family == "trial-states"}
    assert judged == {"mass_matrix", "bias", "gravity", "force", "acceleration"}


def test_a_gravity_alone_is_judged_alone():
    result = trial_of(lambda arm: Equations(gravity=TwoLinks(arm).gravity), UNLIKE)
    assert result.exit_code == 0
    for part in ("mass_matrix", "bias", "force", "acceleration"):
        assert f"{part} (not supplied)" in result.scope[-1]


def test_an_entry_of_gravity_just_beyond_its_tolerance_differs():
    weigh = TwoLinks(UNLIKE).gravity
    verdicts = [
        trial_of(Equations(gravity=lambda q, by=by: weigh(q) * (1, 1 + by)), UNLIKE).exit_code
        for by in (3e-10, 3e-11)
    ]
    assert verdicts == [1, 0]


@pytest.mark.parametrize("coordinates", [Coordinates("free"), Coordinates("lumped", "absolute")])
def test_geared_equations_have_their_weights_apart_too(coordinates):
    def factory(arm: Arm, scenario: Scenario) -> Equations:
        moved = in_frame("analytic:physical", coordinates, arm, scenario)
        still = arm.model_copy(update={"gravity_m_per_s2": (0.0, 0.0)})
        light = in_frame("analytic:physical", coordinates, still, scenario)
        apart = FramedModel(moved.model, moved.frame, light.model)
        whole, bare = equations_of(moved), equations_of(light)
        return replace(
            whole,
            gravity=lambda x: apart.gravity(x),
            force=bare.force,
            acceleration=None,
            coordinates=coordinates,
        )

    probe = load_arm("probe")
    one = {"joints": probe.joints[:1], "links": probe.links[:1]}
    result = trial_of(factory, probe.model_copy(update={"gravity_m_per_s2": (1.7, -9.7), **one}))
    assert result.exit_code == 0
    assert "gravity" in result.relative_errors


def test_sympys_gravity_is_bound_to_the_arm():
    q1, q2, v1, v2 = sp.symbols("q1 q2 v1 v2")
    m1, m2, payload, l1, l2, d1, d2, g = sp.symbols("m1 m2 m_payload L1 L2 d1 d2 g_x")
    second = g * (m2 * d2 + payload * l2) * sp.sin(q1 + q2)
    first = g * (m1 * d1 + (m2 + payload) * l1) * sp.sin(q1) + second
    arm = arm_of(*BODIES, payload=0.4)
    for row, entries in ((second, set()), (2 * second, {"gravity[q2]"})):
        equations = from_sympy([q1, q2], [v1, v2], gravity=sp.Matrix([first, row]))
        result = trial_of(equations, arm)
        wrong = json.loads(format_trial_json(result))["wrong"]
        assert {each["name"] for each in wrong} == entries
        assert all("times 2" in each["cause"] for each in wrong)


def test_a_run_goes_by_gravity_as_well():
    scenario = load_scenario("pd").model_copy(update={"duration_s": 2e-3, "step_s": 1e-4})
    right, wrong = (trial_of(s, UNLIKE, scenarios=(scenario,)) for s in (TwoLinks, Lifted))
    assert right.exit_code == 0
    runs = [f.verdict for f in wrong.agreement.findings if f.about.key.family == "trial-run"]
    assert "differ" in runs


@pytest.mark.parametrize("holds_weights", [True, False])
def test_inverse_dynamics_of_an_arm_may_hold_the_weights(holds_weights):
    """Then gravity is judged too; a weight that is wrong in it is a wrong gravity."""
    right = InverseDynamicsAlone(TwoLinks(UNLIKE), holds_weights=holds_weights)
    trial = trial_of(Equations(inverse_dynamics=right.inverse_dynamics), UNLIKE)
    assert trial.agrees
    assert any("read as M a + bias + gravity" in line for line in trial.scope) == holds_weights
    wrong = InverseDynamicsAlone(SecondForgotten(UNLIKE), holds_weights=holds_weights)
    trial = trial_of(Equations(inverse_dynamics=wrong.inverse_dynamics), UNLIKE)
    parts = {entry.place.part for entry in trial.diagnosis.entries}
    assert ("gravity" in parts, "bias" in parts, "mass_matrix" in parts) == (
        holds_weights,
        False,
        False,
    )
