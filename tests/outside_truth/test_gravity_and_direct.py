"""One link on a direct joint, in every model that simulates, against closed forms of its motion."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from crosscheck import registry
from crosscheck.models.arm.arm import Arm
from tests.mixed_arms import NONE, arm_of, direct
from tests.mixed_arms import scenario as scenario_of

LENGTH, COM, MASS, PAYLOAD, ROTOR, MOTOR = 0.6, 0.35, 8.1, 2.0, 0.13, 3.0
GRAVITY = 1.703, -9.661  # tilted
LINKS = {
    "rod": {"cross_section_m2": 0.005, "density_kg_per_m3": 2700.0},
    "body": {"mass_kg": MASS, "inertia_kg_m2": 0.31},
}
ABOUT_COM = {"rod": MASS * LENGTH**2 / 12, "body": 0.31}
WITHOUT_ROTOR = registry.find_level_models(registry.RIGID_LEVELS[0])
SWINGING = registry.select_with_method(
    "simulate", (*registry.model_names("geared"), *registry.model_names("rigid"))
)
# Of an oscillation of rate w by a step h, over w t: what RK4's and the trapezoidal rule's phases
# are behind, and how short a step shows that without rounding.
LAG = {4: (4, 120), 2: (2, 12)}
TURN = {4: 0.05, 2: 0.01, None: 0.05}
ADAPTIVE = 1e-11  # two orders above what it asks of a step

every_model = pytest.mark.parametrize("name", SWINGING)


class Swing(NamedTuple):
    """A run's time [s], angle [rad] and rate [rad/s], each (times,)."""

    time: np.ndarray
    theta: np.ndarray
    theta_dot: np.ndarray


def one_link(link: str, friction: float = 0.0, gravity: tuple[float, float] = NONE) -> Arm:
    motor = {"motor_mass_kg": MOTOR, "rotor_inertia_kg_m2": ROTOR}
    return arm_of(
        direct(**motor, friction_N_m_s_per_rad=friction),
        links=[{"length_m": LENGTH, "com_m": COM, **LINKS[link]}],
        payload_kg=PAYLOAD,
        gravity=gravity,
    )


def inertia(name: str, link: str) -> float:
    """About the joint [kg m^2]: the first rigid level has no rotor."""
    rotor = 0.0 if name in WITHOUT_ROTOR else ROTOR
    return ABOUT_COM[link] + MASS * COM**2 + PAYLOAD * LENGTH**2 + rotor


def swing(
    name: str, arm: Arm, drive: dict[str, object], duration: float, steps: int, **start: float
) -> Swing:
    grid = {"duration_s": duration, "step_s": duration / steps, "record_every": 1}
    scenario = scenario_of(**grid, start=start, drive=drive)
    run = registry.build(name, arm, scenario).simulate()
    return Swing(run.time.values, run.theta.values[:, 0], run.theta_dot.values[:, 0])


def constant(torque: float) -> dict[str, object]:
    return {"kind": "constant", "torque_N_m": torque}


def steps_of(name: str, rate: float, duration: float) -> int:
    """As many as the model's order needs."""
    return int(np.ceil(rate * duration / TURN[registry.MODELS[name].order]))


def limit(name: str, rate: float, duration: float, steps: int) -> float:
    """Of the error over the motion's size, from the order of the model's integrator."""
    order = registry.MODELS[name].order
    if order is None:
        return ADAPTIVE
    power, divisor = LAG[order]
    return rate * duration * (rate * duration / steps) ** power / divisor


def pendulum(rate: float, amplitude: float, time: np.ndarray) -> np.ndarray:
    """Angle from the hanging link, let go at the amplitude: 2 asin(k cd(w t, k^2)), k its sine."""
    k = np.sin(amplitude / 2)
    _, cn, dn, _ = ellipj(rate * time, k**2)
    return 2 * np.arcsin(k * cn / dn)


@pytest.mark.parametrize("link", LINKS)
@every_model
def test_link_swings_as_the_elliptic_pendulum(name, link):
    pull, amplitude = np.hypot(*GRAVITY), 2.0
    hanging = np.arctan2(GRAVITY[1], GRAVITY[0])
    rate = np.sqrt((MASS * COM + PAYLOAD * LENGTH) * pull / inertia(name, link))
    period = 4 * ellipk(np.sin(amplitude / 2) ** 2) / rate
    errors = []
    for finer in (1, 2):
        steps = finer * steps_of(name, rate, period)
        run = swing(
            name,
            one_link(link, gravity=GRAVITY),
            constant(0.0),
            period,
            steps,
            theta_rad=hanging + amplitude,
        )
        exact = hanging + pendulum(rate, amplitude, run.time)
        errors.append(abs(run.theta - exact).max())
        allowed = amplitude * limit(name, rate, period, steps)
        assert errors[-1] < allowed
        # Back where it was let go, at rest.
        assert abs(run.theta[-1] - run.theta[0]) < allowed
        assert abs(run.theta_dot[-1]) < rate * allowed
    order = registry.MODELS[name].order
    if order is not None:
        assert errors[0] / errors[1] == pytest.approx(2**order, rel=0.1)


@every_model
def test_constant_torque_against_friction(name):
    """theta = (T / c) (t - (1 - exp(-c t / J)) J / c): the rate tends to T / c."""
    torque, friction, link = 35.0, 2.3, "rod"
    rate = friction / inertia(name, link)
    duration = 4 / rate
    steps = steps_of(name, rate, duration)
    run = swing(name, one_link(link, friction), constant(torque), duration, steps)
    exact = torque / friction * (run.time + np.expm1(-rate * run.time) / rate)
    size = torque / friction * duration
    assert abs(run.theta - exact).max() < size * limit(name, rate, duration, steps)
    final = torque / friction * -np.expm1(-4.0)
    assert run.theta_dot[-1] == pytest.approx(final, rel=limit(name, rate, duration, steps))


@every_model
def test_controlled_joint_is_the_linear_oscillator(name):
    """J theta'' = P (target - theta) - (D + c) theta', from an angle and a rate."""
    target, gain, rate_gain, friction = 0.4, 320.0, 7.0, 1.9
    theta_0, rate_0, own = -0.3, 1.1, inertia(name, "body")
    decay, fast = (rate_gain + friction) / (2 * own), np.sqrt(gain / own)
    ringing = np.sqrt(fast**2 - decay**2)
    duration = 3 / decay
    steps = steps_of(name, fast, duration)
    drive = {
        "kind": "pd",
        "target_rad": target,
        "proportional_N_m_per_rad": gain,
        "derivative_N_m_s_per_rad": rate_gain,
    }
    start = {"theta_rad": theta_0, "theta_dot_rad_per_s": rate_0}
    run = swing(name, one_link("body", friction), drive, duration, steps, **start)
    away = theta_0 - target
    sine = (rate_0 + decay * away) / ringing
    shape = away * np.cos(ringing * run.time) + sine * np.sin(ringing * run.time)
    exact = target + np.exp(-decay * run.time) * shape
    size = np.hypot(away, sine)
    assert abs(run.theta - exact).max() < size * limit(name, fast, duration, steps)
