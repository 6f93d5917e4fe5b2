"""Robots with fewer motors than joints, as textbooks write them: never blamed, and reported."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from crosscheck.models.errors import InputError
from crosscheck.models.robot.robot import Robot
from crosscheck.trial.input.equations import Coordinates, Equations
from crosscheck.trial.result import Trial
from tests.robots import chains, two_link
from tests.robots.trials import run_robot_trial

CART, POLE, LENGTH, G = 1.4, 0.3, 0.7, 9.81
CART_POLE = chains.urdf(
    chains.link("ground"),
    chains.link("cart", chains.Solid(CART, (0, 0, 0), (0.1, 0, 0, 0.1, 0, 0.1))),
    chains.link("pole", chains.Solid(POLE, (0, 0, -LENGTH), (0, 0, 0, 0, 0, 0))),
    chains.joint("slide", "ground", "cart", kind="prismatic", axis=(1, 0, 0)),
    chains.joint("swing", "cart", "pole", axis=(0, -1, 0)),
)


def cart_pole() -> Robot:
    return chains.robot(CART_POLE, {}, gravity_m_per_s2=[0.0, 0.0, -G])


def mass_matrix(q: np.ndarray) -> np.ndarray:
    wave = POLE * LENGTH * np.cos(q[1])
    return np.array([[CART + POLE, wave], [wave, POLE * LENGTH**2]])


def coriolis(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.array([[0, -POLE * LENGTH * v[1] * np.sin(q[1])], [0, 0]])


def weight(q: np.ndarray) -> np.ndarray:
    return np.array([0, -POLE * G * LENGTH * np.sin(q[1])])


def accelerate(q: np.ndarray, qd: np.ndarray, u: float) -> np.ndarray:
    """By the usual text: the force u on the cart, a massless rod, no friction."""
    s, c = np.sin(q[1]), np.cos(q[1])
    under = CART + POLE * s**2
    slide = (u + POLE * s * (LENGTH * qd[1] ** 2 + G * c)) / under
    swing = -u * c - POLE * LENGTH * qd[1] ** 2 * c * s - (CART + POLE) * G * s
    return np.array([slide, swing / (LENGTH * under)])


PUSH = np.array([[1.0], [0.0]])
CART_POLES: dict[str, Equations] = {
    "acceleration by the cart's force": Equations(acceleration=accelerate, drive=["slide"]),
    "M, C, weight and B u": Equations(
        mass_matrix, coriolis=coriolis, force=lambda q, tau: weight(q) + PUSH @ tau, drive=[1]
    ),
    "without a motor": Equations(mass_matrix, coriolis=coriolis, force=lambda q: weight(q)),
    "no motor is stated": Equations(acceleration=lambda q, v: accelerate(q, v, 0.0), drive=[]),
}


@pytest.mark.parametrize("form", CART_POLES)
def test_a_cart_pole_agrees_in_its_authors_form(form):
    trial = run_robot_trial(CART_POLES[form], cart_pole())
    assert trial.agrees
    none = "no torque of a motor is in the equations"
    is_driven = "B u" in form or "cart's" in form
    motors = "motors: at slide alone" if is_driven else f"{none}, so motors are not judged"
    assert motors in trial.scope


def driven(force: Callable[..., np.ndarray], drive: list[int | str] | None) -> Trial:
    def accelerated(q: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        return np.linalg.solve(two_link.mass_matrix(q), force(q, torque) - two_link.bias(q, v))

    own = Equations(two_link.mass_matrix, two_link.bias, force=force, acceleration=accelerated)
    return run_robot_trial(Equations(**{**vars(own), "drive": drive}), two_link.robot())


def test_an_acrobot_agrees_with_the_torque_of_its_only_motor():
    """In whatever form that comes: forms are those of tests/trial/test_motors."""
    assert driven(lambda q, torque: np.array([0, torque]) - two_link.gravity(q), [2]).agrees


def push_second(q: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """The last of the torques, at the second joint."""
    return np.array([0, torque[-1]]) - two_link.gravity(q)


def test_a_torque_on_the_wrong_joint_is_seen():
    trial = driven(push_second, [1])
    assert {entry.name for entry in trial.diagnosis.entries} >= {"force[j1]", "force[j2]"}


def test_a_torque_that_is_nowhere_is_reported_with_what_to_state():
    trial = driven(push_second, None)
    assert not trial.agrees
    assert [e.name for e in trial.diagnosis.entries if e.part == "force"] == ["force[j1]"]
    note = "missing: the torque of j1; where there is no motor, state drive = ['j2']"
    assert note in trial.notes


@pytest.mark.parametrize("holds_weights", [False, True])
def test_beside_gravity_only_the_wrong_row_of_a_force_is_wrong(holds_weights):
    """Whether it holds the weights too is read from what it is nearer to."""

    def push(q: np.ndarray, torque: np.ndarray) -> np.ndarray:
        return torque * [1, 1.3] - two_link.gravity(q) * holds_weights

    trial = run_robot_trial(two_link.right(force=push), two_link.robot())
    assert [entry.name for entry in trial.diagnosis.entries] == ["force[j2]"]


def test_a_function_of_one_number_finds_its_motor():
    """The cart's force alone, as textbooks write it: no drive needs to be stated."""
    trial = run_robot_trial(
        Equations(acceleration=lambda q, v, u: accelerate(q, v, float(u))), cart_pole()
    )
    assert trial.agrees
    assert trial.scope[1] == "motors: at slide alone"


def test_a_function_that_always_fails_finds_no_motor():
    def fail(q: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        raise ArithmeticError("none")

    trial = run_robot_trial(replace(two_link.right(), force=fail), two_link.robot())
    assert list(trial.failures) == ["force"]
    assert not any(line.startswith("motors: at") for line in trial.scope)


# Elastic joints by Spong's model: link angles, then motors' on the output side.
RADIUS, TOOTH_K = 0.01, 1e6
SPRING = TOOTH_K * (RADIUS * two_link.N) ** 2
MESHED = {
    joint: chains.geared(two_link.N, two_link.ROTOR, mesh=chains.teeth(RADIUS, TOOTH_K))
    for joint in ("j1", "j2")
}
ELASTIC = chains.robot(two_link.URDF, MESHED, gravity_m_per_s2=[0.0, -two_link.G, 0.0])
ORDER = ("j1", "motor_j1", "j2", "motor_j2")


def elastic_mass(x: np.ndarray) -> np.ndarray:
    mass = np.diag([0.0, 0.0, two_link.REFLECTED, two_link.REFLECTED])
    mass[:2, :2] = two_link.mass_matrix(x[:2], 0.0)
    return mass


def elastic_bias(x: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.append(two_link.bias(x[:2], v[:2]), [0.0, 0.0])


def elastic_hold(x: np.ndarray, spring: float = SPRING) -> np.ndarray:
    wound = spring * (x[:2] - x[2:])
    return np.append(two_link.gravity(x[:2]) + wound, -wound)


def elastic_acceleration(x: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
    left = np.append([0.0, 0.0], torque) - elastic_bias(x, v) - elastic_hold(x)
    return np.linalg.solve(elastic_mass(x), left)


def in_order(function: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
    """The function of coordinates joint by joint; rows of its answer likewise."""
    there, back = [0, 2, 1, 3], [0, 2, 1, 3]

    def ordered(x: np.ndarray, v: np.ndarray | None = None) -> np.ndarray:
        answer = function(*(each[back] for each in (x, v) if each is not None))[there]
        return answer[:, there] if answer.ndim == 2 else answer

    return ordered


PARTS = {"mass_matrix": elastic_mass, "bias": elastic_bias, "gravity": elastic_hold}
ELASTIC_FORMS: dict[str, Equations] = {
    "parts": Equations(level="elastic", **PARTS),
    "acceleration": Equations(acceleration=elastic_acceleration, level="elastic"),
    "joint by joint": Equations(
        mass_matrix=lambda x: in_order(elastic_mass)(x),
        bias=lambda x, v: in_order(elastic_bias)(x, v),
        gravity=lambda x: in_order(elastic_hold)(x),
        coordinates=Coordinates(order=ORDER),
        level="elastic",
    ),
}


@pytest.mark.parametrize("form", ELASTIC_FORMS)
def test_elastic_joints_agree(form):
    """With the project's derivation, Pinocchio and Exudyn, in any order of coordinates."""
    trial = run_robot_trial(ELASTIC_FORMS[form], ELASTIC)
    assert (trial.agrees, trial.level) == (True, "elastic")
    assert "agrees with elastic" in trial.headline


def test_the_ratio_once_in_elastic_joints_is_named():
    def mass_matrix(x: np.ndarray) -> np.ndarray:
        return elastic_mass(x) - np.diag([0, 0, 1.8, 1.8])

    own = Equations(level="elastic", **(PARTS | {"mass_matrix": mass_matrix}))
    words = "every rotor: the ratio once where its square belongs"
    causes = run_robot_trial(own, ELASTIC).causes
    assert f"yours are the equations of elastic with {words}" in causes


@pytest.mark.parametrize("more", [{"damping": 2.0}, {"play": 1e-5}])
def test_springs_that_lose_energy_or_have_play_are_not_elastic(more):
    mesh = chains.teeth(RADIUS, TOOTH_K, **more)
    joints = MESHED | {"j2": chains.geared(two_link.N, two_link.ROTOR, mesh=mesh)}
    with pytest.raises(InputError, match=r"springs alone; the mesh of j2 has backlash or damping"):
        run_robot_trial(Equations(level="elastic", **PARTS), chains.robot(two_link.URDF, joints))


FOLLOWING = '<mimic joint="j1"/></joint>'
NOT_ELASTIC = {
    "no springs": two_link.robot(),
    "a stage": chains.robot(two_link.URDF, MESHED | {"j1": chains.planetary()}),
    "a mimic": chains.robot(
        FOLLOWING.join(two_link.URDF.rsplit("</joint>", 1)), {"j1": MESHED["j1"]}
    ),
}


@pytest.mark.parametrize("kind", NOT_ELASTIC)
def test_a_robot_without_springs_or_with_more_than_springs_is_not_elastic(kind):
    with pytest.raises(InputError, match=r"level.*is of robots with a mesh at a rotor"):
        run_robot_trial(Equations(level="elastic", **PARTS), NOT_ELASTIC[kind])


def test_motors_are_places_of_free_joints_behind_one_that_follows():
    own = chains.random_chain(9)  # the second joint follows the first
    joints = tuple(replace(each, has_motor=n != 2) for n, each in enumerate(own.joints))
    own = replace(own, joints=joints)
    assert [own.coordinate_names[n] for n in own.motors] == [joints[0].name, joints[3].name]
    assert [own.coordinate_names[n] for n in own.passive] == [joints[2].name]
