"""Errors planted in right equations of arms, by name: pieces of a text that others stand for."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from crosscheck.cli.files.template import make_plain_arm
from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.trial.input.equations import Coordinates, Equations
from crosscheck.trial.result import Trial
from crosscheck.trial.trial import run_trial
from tests.trial.mistakes.equations import written
from tests.trial.mistakes.score import supplied
from tests.trial.robot_errors import accelerate, written_in
from tests.trial.test_gravity import UNLIKE, Lifted, SecondForgotten, WeightTwice
from tests.trial.test_trial import equations_of, in_frame, trial_of

Pieces = tuple[tuple[str, str], ...]
ENTRY, SQUARE = "m2*L1*d2*c + mp*L1*L2*c", "s2*v[0]**2"
WAVE = "m2*L1*d2*c +"
WEIGHT = "g*(m1*d1 + m2*L1 + mp*L1)*cos(x[0])"
TO_DEGREES = 180 / np.pi
ABSOLUTE: dict[str, Pieces] = {
    "a centre of mass where a length belongs": (("mp*L1*L2*c", "mp*L1*d2*c"),),
    "a term with the opposite sign": ((WAVE, f"-{WAVE}"),),
    "a term twice": ((WAVE, f"2*{WAVE}"),),
    "half a term": ((WAVE, f"0.5*{WAVE}"),),
    "a term three times": ((WAVE, f"3*{WAVE}"),),
    "a third of a term": ((WAVE, f"{WAVE[:-2]}/3 +"),),
    "a term left out": ((WAVE, ""),),
    "another angle": ((WAVE, "m2*L1*d2*cos(x[0]) +"),),
    "a sum of angles": ((WAVE, "m2*L1*d2*cos(2*x[0] + x[1]) +"),),
    "no angle": ((WAVE, "m2*L1*d2 +"),),
    "a whole entry with the opposite sign": ((ENTRY, f"-({ENTRY})"),),
    "a whole entry by a factor": ((ENTRY, f"1.5*({ENTRY})"),),
    "a term too many": ((ENTRY, f"{ENTRY} + I2"),),
    "two terms of two waves": ((ENTRY, "2*m2*L1*d2*c - mp*L1*L2*c"),),
    "a payload left out": ((" + mp*L1**2\n", "\n"),),
    "a power too few of a length": (("mp*L2**2", "mp*L2"),),
    "one of two levers": (("m2*L1**2", "m2*L1*d1"),),
    "one side with the opposite sign": (("M[1, 0] = M[0, 1]", "M[1, 0] = -M[0, 1]"),),
    "all of the bias twice": (("h[0] = (", "h[0] = 2*("), ("h[1] = -(", "h[1] = -2*(")),
}
RELATIVE: dict[str, Pieces] = {
    "a sine for a cosine": (("m2*(d2**2 + L1*d2*c2)", "m2*(d2**2 + L1*d2*s2)"),),
    "a length in millimetres": ((WEIGHT, WEIGHT.replace("L1", "1000*L1")),),
    "9.8 for 9.81": ((" - g*", " - 9.8*"),),
    "a cosine in degrees": (("2*L1*d2*c2", f"2*L1*d2*cos({TO_DEGREES!r}*x[1])"),),
    "a sine by pi/180, and a product of rates for a square": (
        ("mp*L2)*cos(x[0] + x[1])\nf[1]", f"mp*L2)*cos((x[0] + x[1])/{TO_DEGREES!r})\nf[1]"),
        ("2*v[0]*v[1] + v[1]**2", "3*v[0]*v[1]"),
    ),
    "M' v alone": ((SQUARE, "s2*-v[0]*v[1]"),),
    "Christoffel's symbols without the 1/2": ((SQUARE, "s2*(2*v[0]**2 + v[0]*v[1])"),),
    "Christoffel's symbols, the last with the other sign": (
        (SQUARE, "s2*-(v[0]**2 + 2*v[0]*v[1])"),
    ),
    "the rates of C's upper right entry in the lower left one": (
        (SQUARE, "s2*v[0]*(v[0] + v[1])"),
    ),
    "half of the bias": (("h[0] = -(", "h[0] = -0.5*("), ("h[1] = (", "h[1] = 0.5*(")),
    "a lever of one of two reactions": (
        (SQUARE, f"{SQUARE}\nh[0] += (m2*d2 + mp*L2)*(d1 - L1)*{SQUARE}"),
    ),
    "the inertia of a rod about its end": (("I2", "(m2*L2**2/3)"),),
    "weights of the other sign": (("f[0] -= g", "f[0] += g"), ("v[1] - g*", "v[1] + g*")),
    "no weight of the payload at the elbow": (
        ("f[1] = T[1] - k2*v[1] - g*(m2*d2 + mp*L2)", "f[1] = T[1] - k2*v[1] - g*m2*d2"),
    ),
    "a length for a power of another": (
        ("mp*(L2**2 + L1*L2*c2)\nM[1, 0]", "mp*(L1*L2 + L1*L2*c2)\nM[1, 0]"),
    ),
    "an inertia missing in the first row": (
        ("M[0, 0] = I1 + m1*d1**2 + I2", "M[0, 0] = I1 + m1*d1**2"),
        ("M[0, 1] = I2 +", "M[0, 1] ="),
    ),
    "no torque of the elbow": (("f[1] = T[1]", "f[1] = 0*T[1]"),),
}


def of_text(kind: str, replaced: Pieces) -> Callable[[], Trial]:
    """The trial of the equations of a text with other pieces."""
    return lambda: run_trial(supplied(kind, replaced))


# Rigid arms by the angles of their motors, of which a sun turns n times as far as its carrier.
Weight = Callable[[Arm, np.ndarray, np.ndarray, np.ndarray], np.ndarray]


def on_motors(weight: Weight, once: bool) -> Callable[[], Trial]:
    """weight: what is too much in the force; once: a ratio of M is no square."""

    def factory(own: Arm, scenario: Scenario) -> Equations:
        n = np.array([1 + joint.ring_teeth / joint.sun_teeth for joint in own.joints])
        motors = Coordinates(matrix=np.diag(1 / n), names=("psi_1", "psi_2", "psi_3"))
        still = own.model_copy(update={"gravity_m_per_s2": (0.0, 0.0)})
        right, bare = (
            equations_of(in_frame("analytic:links", motors, arm, scenario)) for arm in (own, still)
        )

        def force(t: float, x: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
            whole = np.array(right.force(t, x, v, torque))
            return whole + weight(own, n, x, whole - bare.force(t, x, v, torque))

        def mass_matrix(x: np.ndarray) -> np.ndarray:
            return np.array(right.mass_matrix(x)) * (1 + np.diag([0, 0, n[2] - 1]) * once)

        return Equations(mass_matrix, right.bias, force=force, coordinates=motors, level="links")

    return lambda: trial_of(factory, load_arm("three-unlike"))


def drop_elbow(own: Arm, n: np.ndarray, x: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Without the weight of link 2 in its row."""
    angle, (g_x, g_y) = (x / n)[:2].sum(), own.gravity_m_per_s2
    weight = own.links[1].mass * own.links[1].com_m
    return -np.eye(3)[1] * weight * (g_y * np.cos(angle) - g_x * np.sin(angle)) / n[1]


def without_two_thirds_of_the_orbit() -> Trial:
    """Of a term of gears in M; so of planets, of which there are three."""
    arm = load_arm("paper-labelled")
    joint = arm.joints[1]
    radius = joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2
    orbit = joint.planet_count * joint.planet_mass_kg * radius**2
    model = in_frame("analytic:coupled", Coordinates(), arm, load_scenario("pd"))
    missing = np.diag([0.0, 2 / 3 * orbit])
    return trial_of(Equations(lambda q: model.mass_matrix(q) - missing), arm)


def reflected_inertia_by_the_ratio_twice(own: Arm, scenario: Scenario) -> Equations:
    """Of the last joint, where only armature and what is above it have any."""
    with_it, without = (
        in_frame(f"analytic:{level}", Coordinates(), own, scenario)
        for level in ("armature", "carriers")
    )
    last = own.joints[-1]
    share = 1 - (1 + last.ring_teeth / last.sun_teeth) ** -2

    def mass_matrix(x: np.ndarray) -> np.ndarray:
        mass = np.array(with_it.mass_matrix(x))
        mass[-1, -1] -= share * (mass[-1, -1] - without.mass_matrix(x)[-1, -1])
        return mass

    return Equations(mass_matrix, level="armature")


def by_hand(kind: str, replaced: Pieces, make: Callable[[Equations], Equations]) -> Trial:
    """Of what is made of the equations of a text."""
    right = supplied(kind, replaced)
    arm = right.mechanism
    assert isinstance(arm, Arm)
    return trial_of(lambda own: make(written(kind, replaced, own)), arm)


SENSE = np.diag([1.0, -1.0])


def in_angles_of_suns(own: Arm, scenario: Scenario) -> Equations:
    """A sun turns 1 + z_r / z_s times as far as its carrier."""
    ratios = [1 + joint.ring_teeth / joint.sun_teeth for joint in own.joints]
    of_suns = Coordinates(matrix=np.diag(1 / np.array(ratios)))
    moved = in_frame("analytic:coupled", of_suns, own, scenario)
    return Equations(moved.mass_matrix, lambda x, v: moved.bias(x, v))


def forgetful(arm: Arm) -> Equations:
    """The payload weighs nothing at joint 2, so both entries are wrong; gravity is a number."""
    one, two = arm.links
    first = one.mass * one.com_m + (two.mass + arm.payload_mass_kg) * one.length_m

    def gravity(q: np.ndarray) -> list[float]:
        second = 9.81 * two.mass * two.com_m * np.cos(q[0] + q[1])
        return [9.81 * first * np.cos(q[0]) + second, second]

    return Equations(gravity=gravity)


CASES: dict[str, Callable[[], Trial]] = {
    **{name: of_text("absolute", replaced) for name, replaced in ABSOLUTE.items()},
    **{name: of_text("relative", replaced) for name, replaced in RELATIVE.items()},
    "a radius by another": of_text("angles", (("s.N*s.M_p*s.r_p**2", "s.N*s.M_p*s.r_p*s.r_s"),)),
    "a ratio of whole numbers": of_text(
        "displacements", (("T[j]/s.n*", "T[j]/(1 + s.z_r//s.z_s)*"),)
    ),
    "a reflected inertia divided by its ratio twice": lambda: trial_of(
        reflected_inertia_by_the_ratio_twice, load_arm("three-unlike")
    ),
    "absolute angles": lambda: by_hand(
        "absolute", (), lambda own: replace(own, coordinates=Coordinates())
    ),
    "relative angles": lambda: by_hand(
        "relative", (), lambda own: replace(own, coordinates=Coordinates(links="absolute"))
    ),
    "the sense of theta_2 reversed": lambda: by_hand(
        "relative", (), lambda own: written_in(own, SENSE)
    ),
    "angles of suns": lambda: trial_of(in_angles_of_suns, load_arm("paper-labelled")),
    "weights of the other sign in accelerations alone": lambda: by_hand(
        "relative", RELATIVE["weights of the other sign"], accelerate
    ),
    "friction in accelerations, and no force": lambda: by_hand(
        "relative",
        (),
        lambda own: Equations(
            own.mass_matrix,
            own.bias,
            gravity=lambda q: -np.array(own.force(q, 0 * q, 0 * q)),
            acceleration=accelerate(own).acceleration,
        ),
    ),
    "half of the bias, and accelerations by torques alone": lambda: by_hand(
        "relative",
        RELATIVE["half of the bias"],
        lambda own: replace(
            own, acceleration=lambda q, torque: np.linalg.solve(own.mass_matrix(q), torque)
        ),
    ),
    "gravity, no weight of link 2 at its joint": lambda: trial_of(SecondForgotten, UNLIKE),
    "gravity with the opposite sign": lambda: trial_of(Lifted, UNLIKE),
    "gravity, and weights in the force as well": lambda: trial_of(WeightTwice, UNLIKE),
    "gravity by a number, without the payload": lambda: trial_of(
        forgetful, make_plain_arm("mine", 2)
    ),
    "two thirds of the planets' orbit missing": without_two_thirds_of_the_orbit,
    "no weight of link 2, by motors' angles": on_motors(drop_elbow, False),
    "weights at the joints, by motors' angles": on_motors(
        lambda own, n, x, weights: (n - 1) * weights, False
    ),
    "a ratio for its square, by motors' angles": on_motors(
        lambda own, n, x, weights: 0 * weights, True
    ),
}
