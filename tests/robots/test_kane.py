"""Kane's sum, link by link: against Pinocchio's frames, and against the robot's equations."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robot_states import sample_states
from crosscheck.models.robot.file import load_robot
from crosscheck.trial.changes.kane import KaneSum
from crosscheck.trial.changes.mistakes import list_body_parts
from crosscheck.trial.changes.problem import DynamicsTerms
from tests.robots import chains

FILES = Path("models/robots")


def test_the_centripetal_term_of_a_fixed_link_is_about_that_link_s_own_origin():
    """m Jv' (w x (w x c)), c from the origin of the link of the file, by Pinocchio's frames."""
    robot, link = load_robot("six-joint"), "tool"
    rng = np.random.default_rng(5)
    q, v = rng.uniform(-1, 1, (2, 1, 6))
    pieces = KaneSum(robot, q, v, list_body_parts(robot)).list_pieces("bias")
    centripetal = pieces["the centripetal acceleration w x (w x c) of the centre"][link]

    model = pin.buildModelFromUrdf(str(FILES / "six-joint.urdf"))
    data, frame = model.createData(), model.getFrameId(link, pin.FrameType.BODY)
    pose = pin.integrate(model, pin.neutral(model), q[0])  # a joint without limits has two numbers
    J = pin.computeFrameJacobian(model, data, pose, frame, pin.LOCAL_WORLD_ALIGNED)
    (part,) = [each for each in list_body_parts(robot) if each.name == link]
    c = pin.updateFramePlacement(model, data, frame).rotation @ part.in_link.com
    w = J[3:] @ v[0]
    moving = J[:3] + np.cross(J[3:], c, axis=0)
    right = part.in_link.mass * moving.T @ np.cross(w, np.cross(w, c))
    # Both are sums of some twenty products of order 1.
    np.testing.assert_allclose(centripetal[0], right, rtol=0, atol=1e-14)
    assert np.abs(right).max() > 1e-4


@pytest.mark.parametrize("seed", range(4))
def test_bodies_terms_sum_up_to_the_robots(seed):
    """Kane's sum body by body is the project's M, bias and weights; its pieces are the bias."""
    own = chains.random_chain(seed)
    states = sample_states(own, 3, seed)
    kane, model = KaneSum(own, states.q, states.v), AnalyticRobot(own, "links")
    moved = (kane.move_body(k, kane.place_body(k, body)) for k, body in enumerate(own.bodies))
    placed = (each.compute_terms() for each in moved)
    right = DynamicsTerms(*model.terms(states.q, states.v))
    for got, expected in zip(map(sum, zip(*placed, strict=True)), right, strict=True):
        assert np.abs(got - expected).max() <= 1e-12 * np.abs(expected).max() + 1e-14
    kinds = kane.list_pieces("bias")
    whole = sum(
        sum(kinds[kind].values(), np.zeros_like(right.bias))
        for kind in (
            "the acceleration of the centre",
            "the torque I w' of the angular acceleration",
            "the gyroscopic torque w x I w",
        )
    )
    assert np.abs(whole - right.bias).max() <= 1e-12 * np.abs(right.bias).max() + 1e-14
