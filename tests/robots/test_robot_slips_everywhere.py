"""Slips of every rotor or stage, of a link's centre and of a coordinate: the cause and the level.

Each is planted into the numbers that the project's own derivation takes, or into its coordinates.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import Robot
from crosscheck.planning.springs import stage_rotors
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.robots.explain import RobotDiagnosis
from crosscheck.trial.robots.trial import run_robot_trial


def diagnosis_of(robot: Robot, used: Robot, hold: Callable = lambda q: q) -> RobotDiagnosis:
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
