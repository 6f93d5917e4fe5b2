"""Slips in numbers as the file has them: of links that are merged, and of a rotor's usual place."""

import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import Robot, RobotBody, compute_point_inertia
from crosscheck.trial.changes.kane import KaneSum
from crosscheck.trial.changes.mistakes import list_body_parts
from crosscheck.trial.changes.numbers import put_value
from crosscheck.trial.result import TrialDiagnosis
from tests.robots import chains
from tests.robots.trials import robot_equations, run_robot_trial

FILES = Path("models/robots")


def six_joint(folder: Path, change: Callable[[str], str]) -> Robot:
    """The robot of six joints, whose tool is fixed to its wrist, out of a changed URDF."""
    shutil.copy(FILES / "six-joint.toml", folder)
    (folder / "six-joint.urdf").write_text(change((FILES / "six-joint.urdf").read_text()))
    return load_robot(str(folder / "six-joint.toml"))


def diagnosis_of(robot: Robot, used: Robot) -> TrialDiagnosis:
    """Of the equations of another robot."""
    return run_robot_trial(robot_equations(used), robot).diagnosis


def turn_products(text: str) -> str:
    return re.sub(
        r'(ix[yz]|iyz)="(-?)([^"]*)"', lambda m: f'{m[1]}="{"" if m[2] else "-"}{m[3]}"', text
    )


def test_products_of_inertia_in_the_axes_of_the_file_are_named(tmp_path):
    diagnosis = diagnosis_of(load_robot("six-joint"), six_joint(tmp_path, turn_products))
    words = "every link: all products of inertia with the opposite sign"
    assert any(words in each for each in diagnosis.explanations)
    assert diagnosis.level == "coupled"


TURNED = chains.urdf(
    chains.link("base"),
    chains.link("a", chains.Solid(2.0, (0.05, 0.02, 0.1), (0.03, 0.002, 0, 0.035, 0, 0.015))),
    chains.link(
        "b",
        chains.Solid(
            1.5, (0.1, 0.01, 0.03), (0.01, 0, 0.001, 0.02, 0, 0.018), rpy=(-0.7, 0.5, 0.2)
        ),
    ),
    chains.link("tool", chains.Solid(0.4, (0.0, 0.0, 0.04), (4e-4, 0, 0, 4e-4, 0, 3e-4))),
    chains.joint("j1", "base", "a", at=(0, 0, 0.3)),
    chains.joint("j2", "a", "b", at=(0, 0.05, 0.2), rpy=(0.9, 0.4, -0.3)),
    chains.joint("flange", "b", "tool", "fixed", at=(0.02, 0, 0.107)),
)


def replace_link(robot: Robot, name: str, **others: object) -> Robot:
    """The robot with other numbers of a link in its own frame."""
    here = list_body_parts(robot)
    (part,) = (each for each in here if each.name == name)
    (rest,) = (each for each in here if each.number == part.number and each.name != name)
    parts = part._replace(in_link=replace(part.in_link, **others)).body, rest.body
    mass = sum(each.mass for each in parts)
    com = sum(each.mass * each.com for each in parts) / mass
    inertia = sum(each.inertia + compute_point_inertia(each.mass, each.com - com) for each in parts)
    return put_value(robot, ("bodies", part.number), RobotBody(mass, com, inertia))


def test_a_centre_counted_from_the_flange_is_named():
    robot = chains.robot(TURNED)
    (b,) = (each.in_link for each in list_body_parts(robot) if each.name == "b")
    wrong = replace_link(robot, "b", com=b.com + np.array([0.02, 0, 0.107]))
    found = diagnosis_of(robot, wrong)
    assert "b: its centre of mass counted from tool" in found.explanations


@pytest.mark.parametrize("side", ["R I", "I R'"])
def test_an_inertia_that_is_turned_once_is_named(side):
    """Which is no tensor: M is not symmetric."""
    robot = chains.robot(TURNED)
    (b,) = (each for each in list_body_parts(robot) if each.name == "b")
    stated = b.turn.T @ b.in_link.inertia @ b.turn
    once = b.turn @ stated if side == "R I" else stated @ b.turn.T
    found = diagnosis_of(robot, replace_link(robot, "b", inertia=once))
    assert any("turned once by the rpy" in each and side in each for each in found.explanations)
    assert found.notes[0].startswith("mass_matrix is not symmetric")


TREE = [chains.link("base")] + [
    chains.link(name, chains.Solid(mass, (0.1, 0.02, 0.03), (0.02, 0, 0, 0.03, 0, 0.025)))
    for name, mass in (("trunk", 3.0), ("left", 1.1), ("right", 1.4))
]


def tree(parent: str) -> Robot:
    """A trunk with a left arm and a right one, which stands on a parent."""
    joints = (
        chains.joint("turn", "base", "trunk"),
        chains.joint("l", "trunk", "left", axis=(0, 1, 0), at=(0, 0.2, 0.4)),
        chains.joint("r", parent, "right", axis=(0, 1, 0), at=(0, -0.2, 0.4)),
    )
    return chains.robot(chains.urdf(*TREE, *joints), {}, gravity_m_per_s2=[0.0, 0.0, -9.81])


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
