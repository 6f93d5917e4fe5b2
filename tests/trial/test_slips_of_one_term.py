"""Slips of one term that no other term makes: an angle in degrees, and rates of another product."""

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.trial.input.equations import Equations
from tests.trial.test_dependence import UNLIKE, arm_of, bodies_of
from tests.trial.test_trial import trial_of

Wave = Callable[[float], float]


def two_links(
    arm: Arm,
    elbow: Wave = np.cos,
    weight: Wave = np.sin,
    rates: Callable[[np.ndarray], float] = lambda v: 2 * v[0] * v[1] + v[1] ** 2,
    elbow_rates: Callable[[np.ndarray], float] = lambda v: v[0] ** 2,
) -> Equations:
    """The textbook arm hanging along x; elbow: in M11; weight: of link 2, in row 1."""
    (m1, l1, d1, i1), (m2, _, d2, i2) = bodies_of(arm)
    g = arm.gravity_m_per_s2[0]

    def mass_matrix(q: np.ndarray) -> np.ndarray:
        fore = i2 + m2 * d2**2
        both = fore + m2 * l1 * d2 * np.cos(q[1])
        first = i1 + m1 * d1**2 + fore + m2 * (l1**2 + 2 * l1 * d2 * elbow(q[1]))
        return np.array([[first, both], [both, fore]])

    def bias(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        wave = m2 * l1 * d2 * np.sin(q[1])
        return np.array([-wave * rates(v), wave * elbow_rates(v)])

    def force(q: np.ndarray, torque: np.ndarray) -> np.ndarray:
        whole = q[0] + q[1]
        first = (m1 * d1 + m2 * l1) * np.sin(q[0]) + m2 * d2 * weight(whole)
        return torque - g * np.array([first, m2 * d2 * np.sin(whole)])

    return Equations(mass_matrix, bias, force=force)


def exchange_masses(arm: Arm) -> Arm:
    first, second = arm.links
    links = (
        first.model_copy(update={"mass_kg": second.mass_kg}),
        second.model_copy(update={"mass_kg": first.mass_kg}),
    )
    return arm.model_copy(update={"links": links})


def replace_inertia(arm: Arm) -> Arm:
    first, second = arm.links
    rod = second.mass_kg * second.length_m**2 / 3
    return arm.model_copy(
        update={"links": (first, second.model_copy(update={"inertia_kg_m2": rod}))}
    )


IN_DEGREES = "its angle in degrees, where"
SLIPS: dict[str, tuple[Callable[[Arm], Equations], list[str]]] = {
    "a cosine in degrees": (
        lambda arm: two_links(arm, elbow=lambda angle: np.cos(np.degrees(angle))),
        [
            f"M[theta_1, theta_1]: yours has cos(theta_2), {IN_DEGREES} cos(theta_2) belongs,"
            " in 2 m2 L1 d2 cos(theta_2)?"
        ],
    ),
    "a sine by pi/180, and a product of rates for a square": (
        lambda arm: two_links(
            arm,
            weight=lambda angle: np.sin(np.radians(angle)),
            rates=lambda v: 3 * v[0] * v[1],
        ),
        [
            "theta_1' theta_2' where theta_2'^2 belongs, in -m2 L1 d2 sin(theta_2)?; also in bias",
            "force[theta_1]: yours has sin(theta_1 + theta_2), its angle times pi/180, where"
            " sin(theta_1 + theta_2) belongs, in -m2 g_x d2 sin(theta_1 + theta_2)?",
        ],
    ),
    "Christoffel's symbols without the 1/2": (
        lambda arm: two_links(arm, elbow_rates=lambda v: 2 * v[0] ** 2 + v[0] * v[1]),
        ["joint 2: d(v' M v)/dq without its factor 1/2?"],
    ),
    "Christoffel's symbols with the other sign of the last term": (
        lambda arm: two_links(arm, elbow_rates=lambda v: -(v[0] ** 2) - 2 * v[0] * v[1]),
        ["joint 2: +1/2 d(v' M v)/dq for -1/2?"],
    ),
    "the rates of C's upper right entry in the lower left one, a sum of two terms": (
        lambda arm: two_links(arm, elbow_rates=lambda v: v[0] * (v[0] + v[1])),
        [
            "bias[theta_2] of theta_1' theta_2': extra term: m2 L1 d2 sin(theta_2),"
            " which stands in bias[theta_2] of theta_1'^2?"
        ],
    ),
    "the rows of the bias exchanged": (
        lambda arm: two_links(
            arm,
            rates=lambda v: -(v[0] ** 2),
            elbow_rates=lambda v: -2 * v[0] * v[1] - v[1] ** 2,
        ),
        ["bias: the rows of theta_1 and theta_2 are exchanged in it?"],
    ),
    "the masses of both links exchanged": (
        lambda arm: two_links(exchange_masses(arm)),
        [
            "link 1 and link 2: mass exchanged?; also in M[theta_2, theta_1]",
            "follows from the wrong M",
        ],
    ),
    "the inertia of a rod about its end for that about its centre": (
        lambda arm: two_links(replace_inertia(arm)),
        ["m2 L2^2/3 where I_l2 belongs, in I_l2?; also in M[theta_1, theta_2]"],
    ),
    "half of the bias": (
        lambda arm: two_links(
            arm,
            rates=lambda v: v[0] * v[1] + v[1] ** 2 / 2,
            elbow_rates=lambda v: v[0] ** 2 / 2,
        ),
        ["bias: all of it half as large?; also in bias"],
    ),
    "a rate without its square, which at rates of 1 is right": (
        lambda arm: two_links(arm, rates=lambda v: 2 * v[0] * v[1] + v[1]),
        ["theta_2' where theta_2'^2 belongs, in -m2 L1 d2 sin(theta_2)?"],
    ),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_of_one_term_is_named(slip):
    factory, told = SLIPS[slip]
    lines = trial_of(factory, arm_of(*UNLIKE)).diagnosis.notes
    assert len(lines) == len(told)
    assert all(words in line for words, line in zip(told, lines, strict=True))


@pytest.mark.parametrize(("by", "told"), [(-1, "missing"), (1, "twice")])
def test_one_component_of_a_velocity_in_a_kinetic_energy(by, told):
    def factory(arm: Arm) -> Equations:
        right, (first, fore) = two_links(arm), arm.links

        def mass_matrix(q: np.ndarray) -> np.ndarray:
            own = fore.com_m * np.cos(q[0] + q[1])
            slopes = np.array([first.length_m * np.cos(q[0]) + own, own])
            return right.mass_matrix(q) + by * fore.mass_kg * np.outer(slopes, slopes)

        return Equations(mass_matrix)

    (line,) = trial_of(factory, arm_of(*UNLIKE)).diagnosis.notes
    assert f"link 2: y'^2 of its velocity {told}, in its kinetic energy?" in line
    assert line.count("M[") == 4


ACCELERATIONS: dict[str, tuple[Callable[..., np.ndarray], str]] = {
    "a weight": (
        lambda weight, wave, v: np.array([0.0, weight]),
        "missing term: -m2 g_x d2 sin(theta_1 + theta_2), in force[theta_2], which M x'' shows?",
    ),
    "a product of rates": (
        lambda weight, wave, v: np.array([0.0, wave * v[0] ** 2]),
        "missing term: m2 L1 d2 sin(theta_2), in bias[theta_2] of theta_1'^2, which M x'' shows?",
    ),
}


@pytest.mark.parametrize("slip", ACCELERATIONS)
def test_what_an_acceleration_alone_leaves_out_is_named(slip):
    """Every row of the acceleration is wrong by it; M times that is wrong in one row."""
    left_out, told = ACCELERATIONS[slip]

    def factory(arm: Arm) -> Equations:
        right, (first, fore), g = two_links(arm), arm.links, arm.gravity_m_per_s2[0]

        def accelerate(q: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
            weight = fore.mass_kg * g * fore.com_m * np.sin(q[0] + q[1])
            wave = fore.mass_kg * first.length_m * fore.com_m * np.sin(q[1])
            balance = right.force(q, torque) - right.bias(q, v) + left_out(weight, wave, v)
            return np.linalg.solve(right.mass_matrix(q), balance)

        return Equations(acceleration=accelerate)

    (line,) = trial_of(factory, arm_of(*UNLIKE)).diagnosis.notes
    assert told in line


@pytest.mark.parametrize(
    ("solve", "told"),
    [
        (
            lambda mass, load, inertia: np.linalg.solve(mass - inertia * np.diag([1, 0]), load),
            "missing term: I_l2, in M[theta_1, theta_1], which M x'' shows?",
        ),
        (lambda mass, load, inertia: mass @ load, "yours is by M where M^-1 belongs?"),
    ],
)
def test_a_mass_matrix_that_an_acceleration_alone_shows(solve, told):
    """M without the inertia of a link in one entry, or M for its inverse, in no other part."""

    def factory(arm: Arm) -> Equations:
        right, inertia = two_links(arm), arm.links[1].inertia_kg_m2

        def accelerate(q: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
            load = right.force(q, torque) - right.bias(q, v)
            return solve(right.mass_matrix(q), load, inertia)

        return Equations(acceleration=accelerate)

    (line,) = trial_of(factory, arm_of(*UNLIKE)).diagnosis.notes
    assert told in line


def test_an_inertia_about_the_centre_behind_accelerations_of_one_link():
    """Without m1 d1^2 they are nearer to a level without the rotor, which is not theirs."""

    def accelerate(arm: Arm, q: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        (link,), (joint,) = arm.links, arm.joints
        weight = link.mass_kg * arm.gravity_m_per_s2[0] * link.com_m * np.sin(q)
        balance = torque - joint.friction_N_m_s_per_rad * v - weight
        return balance / (link.inertia_kg_m2 + joint.rotor_inertia_kg_m2)

    arm = arm_of((2.3, 0.58, 0.23, 0.064))
    numbers = {"rotor_inertia_kg_m2": 0.014, "friction_N_m_s_per_rad": 0.41}
    geared = arm.model_copy(update={"joints": (arm.joints[0].model_copy(update=numbers),)})
    trial = trial_of(lambda arm: Equations(acceleration=partial(accelerate, arm)), geared)
    (line,) = trial.diagnosis.notes
    assert trial.level == "carriers"
    assert "missing term: m1 d1^2, in M[theta_1, theta_1]" in line


def test_weights_of_the_other_sign_are_no_other_coordinates():
    """Of accelerations alone they are right, too, with all senses reversed: no usual mistake."""

    def factory(arm: Arm) -> Equations:
        lifting = tuple(-each for each in arm.gravity_m_per_s2)
        wrong = two_links(arm.model_copy(update={"gravity_m_per_s2": lifting}))

        def accelerate(q: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
            return np.linalg.solve(wrong.mass_matrix(q), wrong.force(q, torque) - wrong.bias(q, v))

        return Equations(acceleration=accelerate)

    (line,) = trial_of(factory, arm_of(*UNLIKE)).diagnosis.notes
    assert "every link: its weight with the opposite sign" in line
