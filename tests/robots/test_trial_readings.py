"""Right equations in other coordinates than the robot's are said to be so, and nothing else is."""

import numpy as np
import pytest

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.models.errors import InputError
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import Level, Robot
from crosscheck.trial.coordinates.readings import JointCoordinates, list_readings
from crosscheck.trial.input.equations import Coordinates, Equations
from crosscheck.trial.robots.readings import describe_coordinates
from tests.robots import chains, two_link
from tests.robots.trials import run_robot_trial

TWO = two_link.robot()
SUMS = np.linalg.inv([[1.0, 0.0], [1.0, 1.0]])
DEGREE = np.pi / 180


def written_in(
    robot: Robot,
    level: Level,
    jacobian: np.ndarray,
    zero: float = 0.0,
    rates: np.ndarray | None = None,
) -> Equations:
    """A robot's equations in x, of which q = jacobian @ x, the first from zero [rad]."""
    model, turned = AnalyticRobot(robot, level), np.array(jacobian)
    moving = turned if rates is None else rates
    offset = zero * np.eye(len(turned))[0]

    def mass_matrix(q: np.ndarray) -> np.ndarray:
        return moving.T @ model.mass_matrix((turned @ q + offset)[None])[0] @ moving

    def bias(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return moving.T @ model.bias((turned @ q + offset)[None], (moving @ v)[None])[0]

    def gravity(q: np.ndarray) -> np.ndarray:
        return moving.T @ model.gravity((turned @ q + offset)[None])[0]

    return Equations(mass_matrix, bias, gravity=gravity)


@pytest.mark.parametrize(
    ("size", "senses", "orders"), [(1, 1, 0), (2, 3, 1), (3, 7, 5), (4, 15, 23), (5, 6, 1)]
)
def test_of_few_coordinates_all_senses_and_orders_are_tried(size, senses, orders):
    joints = JointCoordinates([f"j{n}" for n in range(size)], range(size), {})
    kinds = [each.kind for each in list_readings(joints)]
    assert (kinds.count("sense"), kinds.count("order")) == (senses, orders)
    stated = [each for each in list_readings(joints) if each.statement]
    assert all(("(" in each.described) == (size <= 3) for each in stated)


def accelerated(own: Equations) -> Equations:
    def acceleration(q: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        held = own.bias(q, v) + own.gravity(q)
        return np.linalg.solve(own.mass_matrix(q), torque - held)

    return Equations(acceleration=acceleration)


IN_TWO: dict[str, Equations] = {
    "absolute angles": written_in(TWO, "armature", SUMS),
    "the sense of j2 reversed": written_in(TWO, "coupled", np.diag([1.0, -1.0])),
    "coordinates in the order j2, j1": written_in(TWO, "armature", np.eye(2)[::-1]),
    "angles in degrees": written_in(TWO, "links", DEGREE * np.eye(2), rates=np.eye(2)),
    "angles and rates in degrees": written_in(TWO, "links", DEGREE * np.eye(2)),
    "angles of the motors, before their gears": written_in(TWO, "armature", np.eye(2) / 10),
}


@pytest.mark.parametrize("words", IN_TWO)
@pytest.mark.parametrize("form", ["parts", "acceleration"])
def test_other_coordinates_are_said_first(words, form):
    own = IN_TWO[words] if form == "parts" else accelerated(IN_TWO[words])
    trial = run_robot_trial(own, TWO)
    assert not trial.agrees
    assert words in {reading.partition(" (")[0] for reading in trial.diagnosis.readings}
    assert trial.diagnosis.notes == ()
    assert " is right in " in trial.headline


@pytest.mark.parametrize("words", ["absolute angles", "the sense of j2 reversed"])
@pytest.mark.parametrize("form", ["parts", "acceleration"])
def test_what_is_reported_may_be_stated(words, form):
    """Torques are the joints': of x they are the matrix's transpose times these."""
    matrix = SUMS if words == "absolute angles" else np.diag([1.0, -1.0])
    of_absolute = Coordinates(links="absolute")
    coordinates = of_absolute if words == "absolute angles" else Coordinates(matrix=matrix)
    source = own = IN_TWO[words]
    if form == "acceleration":

        def accelerate(q: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
            held = source.bias(q, v) + source.gravity(q)
            return np.linalg.solve(source.mass_matrix(q), matrix.T @ torque - held)

        own = Equations(acceleration=accelerate)
    trial = run_robot_trial(Equations(**{**vars(own), "coordinates": coordinates}), TWO)
    assert trial.agrees
    assert trial.scope[0].startswith("carried from your coordinates")


def test_coordinates_that_are_of_arms_alone_are_refused():
    stated = Coordinates(gearing="lumped")
    with pytest.raises(
        InputError, match=r"coordinates.*may have matrix, function, order, or links"
    ):
        run_robot_trial(Equations(**{**vars(two_link.right()), "coordinates": stated}), TWO)


def test_of_a_robot_in_space():
    robot = load_robot("six-joint")
    size = len(robot.coordinates)
    trial = run_robot_trial(written_in(robot, "coupled", np.eye(size)[::-1]), robot)
    names = ", ".join(robot.coordinate_names[::-1])
    assert trial.diagnosis.readings == (f"coordinates in the order {names}",)
    assert trial.diagnosis.level == "coupled"


def test_another_zero_is_one_cause_of_wrong_gravity():
    """From the horizontal in place of the vertical: M and bias do not know it."""
    trial = run_robot_trial(written_in(TWO, "armature", np.eye(2), np.pi / 2), TWO)
    assert trial.diagnosis.readings == ()
    assert "the zero of j1 where it is 90 degrees" in trial.diagnosis.explanations
    assert {entry.part for entry in trial.diagnosis.entries} == {"gravity"}


def test_a_wrong_number_is_no_matter_of_coordinates():
    heavier = chains.robot(two_link.URDF.replace(f'"{two_link.M2!r}"', '"4.0"'))
    trial = run_robot_trial(written_in(heavier, "links", np.eye(2)), TWO)
    assert trial.diagnosis.readings == ()


def test_numbers_that_are_rounded_are_no_other_coordinates():
    """The first angle is in neither M nor bias, which are the same whatever its zero is."""
    own = two_link.right(mass_matrix=lambda q: two_link.mass_matrix(q) * (1 + 2e-9))
    trial = run_robot_trial(Equations(**{**vars(own), "gravity": None}), TWO)
    assert not trial.agrees
    assert trial.diagnosis.readings == ()
    rounded = two_link.right(
        mass_matrix=lambda q: two_link.mass_matrix(q) + 7e-8 * np.array([[0, 1], [1, 0]]) * q[1],
    )
    trial = run_robot_trial(rounded, TWO)
    assert trial.diagnosis.notes[-1].startswith("agrees to ")
    assert trial.diagnosis.notes[-1].endswith("rounded to 8 digits?")


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
