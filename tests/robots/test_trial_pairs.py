"""Two errors at once in a robot's equations: both are named, and no pair is where there is none."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.bench_robot_time import try_wrong
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import Placement, Robot
from crosscheck.trial.changes.numbers import put_value
from crosscheck.trial.changes.pairs import rank_pairs
from crosscheck.trial.result import Trial
from tests.robots.trials import robot_equations, run_robot_trial

PUMA, SIX = load_robot("puma560"), load_robot("six-joint")


def set_body(robot: Robot, number: int, **others: object) -> Robot:
    return put_value(robot, ("bodies", number), replace(robot.bodies[number], **others))


def weigh(robot: Robot, number: int, by: float) -> Robot:
    return set_body(robot, number, mass=by * robot.bodies[number].mass)


def mirror(robot: Robot, number: int) -> Robot:
    """The largest coordinate of a centre of mass has the other sign."""
    com = robot.bodies[number].com.copy()
    com[np.abs(com).argmax()] *= -1
    return set_body(robot, number, com=com)


def set_rotor(robot: Robot, number: int, **others: object) -> Robot:
    return put_value(robot, ("rotors", number), replace(robot.rotors[number], **others))


# What is wrong: the robot that has both errors, and words on each.
BOTH: dict[str, tuple[Robot, Callable[[Robot], Robot], tuple[str, str]]] = {
    "a mass, and a sign of a centre": (
        PUMA,
        lambda robot: mirror(weigh(robot, 1, 1.1), 3),
        ("link_2: mass = 19.14 kg", "link_4: its centre of mass with the opposite sign"),
    ),
    "pounds, and a sign": (
        SIX,
        lambda robot: weigh(mirror(robot, 3), 5, 2.20462),
        ("pounds?", "wrist_1: centre of mass, y = 0.012 m"),
    ),
    "a ratio once, and a sign": (
        SIX,
        lambda robot: set_rotor(mirror(robot, 2), 1, inertia=robot.rotors[1].inertia / 100),
        ("forearm: centre of mass, x = -0.171 m", "the ratio once where its square belongs"),
    ),
}


def try_robot(wrong: Robot, robot: Robot, *, in_gravity_alone: bool = False) -> Trial:
    """The trial of the equations of another robot, or of its gravity beside what is right."""
    own = robot_equations(wrong)
    if in_gravity_alone:
        own = replace(robot_equations(robot), gravity=own.gravity)
    return run_robot_trial(own, robot)


@pytest.mark.parametrize("case", BOTH)
def test_both_errors_are_named(case):
    robot, change, words = BOTH[case]
    found = try_robot(change(robot), robot).diagnosis
    assert found.level == "coupled"
    assert found.explanations[0].startswith("two changes: ")
    assert all(each in found.explanations[0] for each in words)


def test_both_errors_of_one_part_are_named():
    wrong = weigh(mirror(SIX, 3), 2, 2.0)
    found = try_robot(wrong, SIX, in_gravity_alone=True).diagnosis
    (words,) = (each for each in found.notes if each.startswith("in gravity alone"))
    assert "two changes: forearm: mass = 5.8 kg (file: 2.9 kg); and wrist_1: centre of" in words


def stretch_all_places(robot: Robot) -> Robot:
    """Places of all joints by the golden ratio: no change of one or two of them."""
    joints = [
        replace(
            joint, placement=Placement(joint.placement.rotation, 1.618 * joint.placement.position)
        )
        for joint in robot.joints
    ]
    return replace(robot, joints=tuple(joints))


NO_PAIR: dict[str, Callable[[], Trial]] = {
    "places of all joints": lambda: try_robot(stretch_all_places(SIX), SIX),
    "three masses": lambda: try_robot(weigh(weigh(weigh(PUMA, 1, 1.1), 2, 1.3), 3, 0.9), PUMA),
    "two odd masses": lambda: try_robot(weigh(weigh(PUMA, 1, 1.13), 3, 1.07), PUMA),
    "a wave in every part": lambda: try_wrong(PUMA, ("mass_matrix", "bias", "gravity")),
}


@pytest.mark.parametrize("case", NO_PAIR)
def test_no_pair_where_there_is_none(case):
    found = NO_PAIR[case]().diagnosis
    assert not [each for each in (*found.explanations, *found.notes) if "two changes" in each]


def test_pairs_of_rows_by_one_matrix():
    """Rows 1 and 3 once, or row 1 and three times the free row 4; and none of one owner."""
    rng = np.random.default_rng(3)
    rows, owners = rng.normal(size=(6, 20)), np.arange(6)
    is_free = np.array([False, False, False, False, True, True])
    pairs = rank_pairs(rows, is_free, rows[1] + rows[3], owners)
    assert [each[:2] for each in pairs] == [(1, 3)]
    ((first, second, times),) = rank_pairs(rows, is_free, rows[1] + 3 * rows[4], owners)
    assert (first, second, times) == (1, 4, pytest.approx(3.0))
    assert rank_pairs(rows, is_free, 2 * rows[4] + 3 * rows[5], owners) == []
    owners[3] = owners[1]
    assert rank_pairs(rows, is_free, rows[1] + rows[3], owners) == []
