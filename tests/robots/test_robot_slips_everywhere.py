"""Slips of every rotor or stage, of a link's centre and of a coordinate: the cause and the level.

Each is planted into the numbers that the project's own derivation takes, or into its coordinates.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.bench_trial import LINKS
from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.analytic.robot.springs import stage_rotors
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import Placement, Robot
from crosscheck.trial.changes.numbers import put_value
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.result import TrialDiagnosis
from tests.robots import chains
from tests.robots.trials import run_robot_trial


def diagnosis_of(robot: Robot, used: Robot, hold: Callable = lambda q: q) -> TrialDiagnosis:
    """Of the equations of another robot; hold: what M takes for q."""
    model = AnalyticRobot(used, "coupled")
    own = Equations(
        mass_matrix=lambda q: model.mass_matrix(hold(q)[None])[0],
        bias=lambda q, v: model.bias(q[None], v[None])[0],
        gravity=lambda q: model.gravity(q[None])[0],
    )
    return run_robot_trial(own, robot).diagnosis


@pytest.mark.parametrize(
    ("words", "count", "by_sun"),
    [("one planet for all", 3, False), ("its planets rolling by the sun's teeth", 1, True)],
)
def test_of_every_stage(words, count, by_sun):
    """Which at the level armature leaves as many entries wrong, and smaller ones."""
    robot = load_robot("examples/robots/planetary-arm.toml")
    rotors = []
    for stage in robot.stages:
        sun, planets = stage_rotors(robot, stage)
        ratio = 1 - stage.gears.sun_teeth / stage.gears.planet_teeth if by_sun else planets.ratio
        rotors += [sun, replace(planets, inertia=planets.inertia / count, ratio=ratio)]
    found = diagnosis_of(robot, replace(robot, rotors=tuple(rotors), stages=()))
    assert (found.level, found.explanations) == ("coupled", (f"every stage: {words}",))


def test_signs_of_all_ratios():
    robot = load_robot("six-joint")
    rotors = tuple(replace(each, ratio=abs(each.ratio)) for each in robot.rotors)
    found = diagnosis_of(robot, replace(robot, rotors=rotors))
    assert found.explanations == ("every rotor: the sign of its ratio left out",)


def test_two_coordinates_of_a_centre():
    robot = load_robot("puma560")
    body = robot.bodies[1]
    bodies = list(robot.bodies)
    bodies[1] = replace(body, com=body.com[[0, 2, 1]])
    found = diagnosis_of(robot, replace(robot, bodies=tuple(bodies)))
    assert found.explanations == ("link_2: y and z of its centre of mass exchanged",)


def test_a_coordinate_that_one_part_leaves_out():
    robot = load_robot("sliding")
    found = diagnosis_of(robot, robot, lambda q: q * np.array([1, 0, 1]))
    assert "mass_matrix: slide is left out in it" in found.notes


def frames_of(robot, q, order):
    """Each link's rotation and origin; order: whether a joint turns before its own transform."""
    R, p, frames = np.eye(3), np.zeros(3), []
    for joint, angle in zip(robot.joints, q, strict=True):
        own = Rotation.from_rotvec(angle * joint.axis).as_matrix()
        turn, place = joint.placement.rotation, joint.placement.position
        if order == "classic":
            axis, origin = R @ joint.axis, p
            R = R @ own
            p, R = p + R @ place, R @ turn
        else:
            p, R = p + R @ place, R @ turn
            axis, origin = R @ joint.axis, p
            R = R @ own
        frames.append((R, p, axis, origin))
    return frames


def kane_gravity_and_mass(robot, q, order):
    """M and gravity by Jacobians of each link's centre."""
    frames, size = frames_of(robot, q, order), len(robot.joints)
    mass_matrix, gravity = np.zeros((size, size)), np.zeros(size)
    for k, body in enumerate(robot.bodies):
        R, p, *_ = frames[k]
        centre = p + R @ body.com
        turning, moving = np.zeros((2, 3, size))
        for i, (_, _, axis, origin) in enumerate(frames[: k + 1]):
            turning[:, i], moving[:, i] = axis, np.cross(axis, centre - origin)
        mass_matrix += body.mass * moving.T @ moving
        mass_matrix += turning.T @ R @ body.inertia @ R.T @ turning
        gravity -= body.mass * moving.T @ robot.gravity
    return mass_matrix, gravity


@pytest.mark.parametrize("order", ["modified", "classic"])
def test_a_table_of_modified_dh_multiplied_as_classic_dh(order):
    """As if every joint turned before its constant transform."""
    robot = chains.robot(LINKS)
    own = Equations(
        mass_matrix=lambda q: kane_gravity_and_mass(robot, q, order)[0],
        gravity=lambda q: kane_gravity_and_mass(robot, q, order)[1],
    )
    trial = run_robot_trial(own, robot)
    assert trial.agrees == (order == "modified")
    words = "every joint: turned before its constant transform"
    assert [each.startswith(words) for each in trial.diagnosis.explanations] == [True] * (
        order == "classic"
    )


def change_joint(robot, number, **others):
    return put_value(robot, ("joints", number), replace(robot.joints[number], **others))


def test_a_quaternion_in_another_order():
    robot = chains.robot(LINKS)
    joint = robot.joints[1]
    x, y, z, w = Rotation.from_matrix(joint.placement.rotation).as_quat()
    read = Placement(Rotation.from_quat([w, x, y, z]).as_matrix(), joint.placement.position)
    found = diagnosis_of(robot, change_joint(robot, 1, placement=read))
    assert "joint j2: its quaternion w, x, y, z read as x, y, z, w" in found.explanations


def test_an_integer_division_of_a_ratio():
    ratios = {"j1": chains.geared(-40.0), "j2": chains.geared(4 + 2 / 3, 0.02)}
    robot = chains.robot(LINKS, ratios)
    wrong = put_value(robot, ("rotors", 1), replace(robot.rotors[1], ratio=4.0))
    found = diagnosis_of(robot, wrong)
    words = "rotor of j2: its ratio rounded down, as by integer division"
    assert words in found.explanations
    robot = load_robot("examples/robots/planetary-arm.toml")
    sun, planets = stage_rotors(robot, robot.stages[0])
    rounded = replace(robot, rotors=(replace(sun, ratio=4.0), planets), stages=robot.stages[1:])
    assert sun.ratio == pytest.approx(1 + 99 / 27)
    found = diagnosis_of(robot, rounded)
    assert "integer division" in found.explanations[0]


def test_a_joint_on_another_link_than_its_parent():
    """Both arms stand on the turning base; the second one is put on the first one's link."""
    body = chains.Solid(2.0, (0.1, 0.05, 0.2), (0.03, 0.001, 0.002, 0.04, 0.003, 0.02))
    robot = chains.robot(
        chains.urdf(
            *(chains.link(name, body if name != "base" else None) for name in ("base", *"tabc")),
            chains.joint("turn", "base", "t"),
            chains.joint("left", "t", "a", axis=(0, 1, 0), at=(0.0, 0.3, 0.4)),
            chains.joint("bend", "a", "b", axis=(0, 1, 0), at=(0.4, 0.0, 0.1)),
            chains.joint("right", "t", "c", axis=(1, 0, 0), at=(0.0, -0.3, 0.4)),
        )
    )
    wrong = change_joint(robot, 3, parent=1)
    found = diagnosis_of(robot, wrong)
    assert found.explanations[0] == "joint right: on a instead of t"
