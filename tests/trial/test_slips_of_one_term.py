"""Slips of one term that no other term makes: an angle in degrees, and rates of another product."""

from collections.abc import Callable

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
            "m2 L1 d2 sin(theta_2)",  # times 1.5, and missing: whichever is worse at the states
            "m2 L1 d2 sin(theta_2)",
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
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_of_one_term_is_named(slip):
    factory, told = SLIPS[slip]
    lines = trial_of(factory, arm_of(*UNLIKE)).diagnosis.notes
    assert len(lines) == len(told)
    assert all(words in line for words, line in zip(told, lines, strict=True))


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
