"""Right equations in other coordinates than the robot's are said to be so, and nothing else is."""

import numpy as np
import pytest

from crosscheck.trial.coordinates.readings import JointCoordinates, list_readings
from crosscheck.trial.coordinates.robots import build_robot_frame
from crosscheck.trial.input.equations import Coordinates, Equations
from crosscheck.trial.robots.readings import describe_coordinates
from tests.robots import chains, two_link
from tests.robots.trials import run_robot_trial

TWO = two_link.robot()


@pytest.mark.parametrize(
    ("size", "senses", "orders"), [(1, 1, 0), (2, 3, 1), (3, 7, 5), (4, 15, 23), (5, 6, 1)]
)
def test_of_few_coordinates_all_senses_and_orders_are_tried(size, senses, orders):
    joints = JointCoordinates([f"j{n}" for n in range(size)], range(size), {})
    kinds = [each.kind for each in list_readings(joints)]
    assert (kinds.count("sense"), kinds.count("order")) == (senses, orders)
    stated = [each for each in list_readings(joints) if each.statement]
    assert all(("(" in each.described) == (size <= 3) for each in stated)


def test_numbers_that_are_rounded_are_no_other_coordinates():
    """The first angle is in neither M nor bias, which are the same whatever its zero is."""
    own = two_link.right(mass_matrix=lambda q: two_link.mass_matrix(q) * (1 + 2e-9))
    trial = run_robot_trial(Equations(**{**vars(own), "gravity": None}), TWO)
    assert not trial.agrees
    assert trial.diagnosis.readings == ()
    rounded = two_link.right(
        mass_matrix=lambda q: two_link.mass_matrix(q) + 7e-8 * np.array([[0, 1], [1, 0]]) * q[1]
    )
    trial = run_robot_trial(rounded, TWO)
    assert trial.diagnosis.notes[-1].startswith("agrees to ")
    assert trial.diagnosis.notes[-1].endswith("rounded to 8 digits?")


def test_of_readings_that_nothing_distinguishes_those_of_fewest_coordinates_are_said():
    turned = Equations(mass_matrix=lambda q: two_link.mass_matrix(q - [0, np.pi / 2]))
    words = "is right in coordinates with j2 measured from -90 degrees, and not in j1, j2"
    assert words in run_robot_trial(turned, TWO).headline


def test_coordinates_are_counted_without_the_joints_that_follow_others():
    """Of a, b, the slide c that follows b, and d behind it: all three coordinates are angles."""
    slides = chains.LIMIT + '<mimic joint="b" multiplier="0.5"/>'
    parts = [chains.link("world"), *(chains.link(name, chains.Solid()) for name in "ABCD")]
    parts += [chains.joint("a", "world", "A"), chains.joint("b", "A", "B")]
    parts += [chains.joint("c", "B", "C", "prismatic", more=slides), chains.joint("d", "C", "D")]
    motor = {"d": chains.geared(7.0)}
    found = describe_coordinates(chains.robot(chains.urdf(*parts), motor))
    assert (found.turning, found.names) == ([0, 1, 2], ["a", "b", "d"])
    assert found.before == {0: [], 1: [0], 2: [0, 1]}
    assert found.ratios.tolist() == [1.0, 1.0, 7.0]
    frame = build_robot_frame(Coordinates(), chains.robot(chains.urdf(*parts), motor))
    assert frame.jacobian(np.zeros(3)).tolist() == np.eye(3).tolist()
