"""Equations held against the project's own model of an arm, in the equations' coordinates."""

import numpy as np

from crosscheck.checks.answers import sample_states
from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import ConstantDrive, Scenario, switches
from crosscheck.models.loading import load_scenario
from crosscheck.registry import build
from crosscheck.trial.input.supplied import SuppliedEquations


def experiment(joints: int) -> tuple[Scenario, np.ndarray]:
    """Constant torques [N m], each joint another, as a scenario and as numbers."""
    torque = 37.0 - 11.0 * np.arange(joints)
    drive = ConstantDrive(kind="constant", torque_N_m=tuple(torque))
    return load_scenario("constant-torque").model_copy(update={"drive": drive}), torque


def worst(supplied: SuppliedEquations, arm: Arm, count: int = 10) -> dict[str, float]:
    """By part, the largest difference from the reference over its largest entry."""
    scenario, torque = experiment(len(arm.joints))
    name = f"analytic:{supplied.equations.level or 'physical'}"
    chosen = switches(planets="free" if supplied.frame.layout.free else "lumped")
    model, found = build(name, arm, scenario, chosen), dict.fromkeys(supplied.has, 0.0)
    for t, *state in zip(*sample_states(supplied.frame.layout, arm, count, 7), strict=True):
        x = supplied.frame.place(state[0])
        q, jacobian = supplied.frame.position(x), supplied.frame.jacobian(x)
        u = np.linalg.solve(jacobian, state[1])
        v, drift = jacobian @ u, supplied.frame.drift(x, u)
        mass, h, f = model.mass_matrix(q), model.bias(q, v), model.generalized_force(t, q, v)
        expected = {
            "mass_matrix": jacobian.T @ mass @ jacobian,
            "bias": jacobian.T @ (h + mass @ drift),
            "force": jacobian.T @ f,
            "acceleration": np.linalg.solve(jacobian, np.linalg.solve(mass, f - h) - drift),
        }
        expected["inverse_dynamics"] = expected["mass_matrix"] @ u + expected["bias"]
        answers = {
            "mass_matrix": lambda x=x: supplied.mass_matrix(x),
            "bias": lambda x=x, u=u: supplied.bias(x, u),
            "force": lambda t=t, x=x, u=u: supplied.force(t, x, u, torque),
            "acceleration": lambda t=t, x=x, u=u: supplied.acceleration(t, x, u, torque),
            "inverse_dynamics": lambda x=x, u=u: supplied.inverse_dynamics(x, u, u),
        }
        for part in supplied.has - {"coriolis"}:
            apart = np.abs(answers[part]() - expected[part]) / np.abs(expected[part]).max()
            found[part] = max(found[part], float(apart.max()))
    return found
