"""Rotors on meshes that give way: closed forms, a bounce, and the limit of a rigid gear."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest

from crosscheck.cost.shortcuts import QUICK, compute_costs
from crosscheck.models.errors import InputError
from crosscheck.models.robot.integration import integrate
from crosscheck.models.robot.robot import Robot
from crosscheck.registry import build_robot_model
from tests.robots import chains

RATIO, SPIN, RADIUS, STIFFNESS, DAMPING, PLAY = -3.0, 2e-4, 0.02, 1e6, 60.0, 1e-4
MASS, LENGTH = chains.MASS, chains.LENGTH
LINK = chains.INERTIA + MASS * LENGTH**2


def pendulum(weight: float = 9.81, damping: float = DAMPING) -> Robot:
    """A bob on an axis along y, its rotor on a mesh with the stator on the ground."""
    given = chains.geared(RATIO, SPIN, mesh=chains.teeth(RADIUS, STIFFNESS, damping, PLAY))
    return chains.robot(chains.BOB, {"swing": given}, gravity_m_per_s2=[0.0, 0.0, -weight])


@pytest.mark.parametrize(("x", "pressed"), [(3e-4, 2e-4), (-2.5e-4, -1.5e-4), (0.9e-4, 0.0)])
@pytest.mark.parametrize("engine", chains.ENGINES)
def test_two_inertias_on_a_spring(engine, x, pressed):
    """J phi'' = T / N - r F and I theta'' = N r F - m g l sin(theta), x = r (phi - N theta)."""
    q, v, torque = np.array([[0.9, x]]), np.array([[2.0, 0.3]]), 7.0
    force = STIFFNESS * pressed + DAMPING * 0.3 if pressed else 0.0
    rotor = (torque / RATIO - RADIUS * force) / SPIN
    bob = (RATIO * RADIUS * force - MASS * 9.81 * LENGTH * sin(0.9)) / LINK
    model = build_robot_model(engine, pendulum(), "geared")
    found = model.forward_dynamics(q, v, np.array([[torque]]))[0]
    assert found == pytest.approx([bob, RADIUS * (rotor - RATIO * bob)], rel=1e-12)
    spun = SPIN / RADIUS
    mass = np.array([[LINK + SPIN * RATIO**2, spun * RATIO], [spun * RATIO, spun / RADIUS]])
    assert model.mass_matrix(q)[0] == pytest.approx(mass, rel=1e-13)
    needed = model.inverse_dynamics(q, v, found[None])[0]
    assert needed == pytest.approx([torque, torque / RATIO / RADIUS], rel=1e-10)


@pytest.mark.parametrize("engine", chains.ENGINES)
def test_teeth_fly_over_their_play_and_bounce(engine):
    """No force in the gap; on the flank half a swing, then back as fast; momentum stays.

    The mass that swings is 1 / (r^2 / J + N^2 r^2 / I). Steps that pass a change of contact err
    by the square of the step: 200 of them, by some 1e-4 of the backlash.
    """
    model = build_robot_model(engine, pendulum(weight=0.0, damping=0.0), "geared")
    fast, start = 0.5, 0.0
    swing = sqrt(STIFFNESS * (RADIUS**2 / SPIN + (RATIO * RADIUS) ** 2 / LINK))
    hit = (PLAY - start) / fast
    time = hit + pi / swing + 1.5 * PLAY / fast
    q, v = np.array([[0.2, start]]), np.array([[0.1, fast]])
    ends = integrate(model, q, v, lambda t: np.zeros((1, 1)), time, 200)[0][0]
    assert ends[1] == pytest.approx(-0.5 * PLAY, abs=1e-3 * PLAY)
    early = integrate(model, q, v, lambda t: np.zeros((1, 1)), hit / 2, 3)[0][0]
    assert early[1] == pytest.approx(PLAY / 2, rel=1e-12)
    share = np.array([LINK + SPIN * RATIO**2, SPIN * RATIO / RADIUS])
    assert share @ (ends - q[0]) == pytest.approx(share @ v[0] * time, rel=1e-11)


def gimbal(stiffness: float) -> Robot:
    """Two joints at an angle, the second one's rotor across both; without backlash."""
    text = chains.urdf(
        chains.link("ground"),
        chains.link("ring", chains.Solid(2.0, (0.1, 0, 0), (0.1, 0, 0, 0.2, 0, 0.3))),
        chains.link("disc", chains.Solid(1.0, (0.2, 0, 0.1), (0.1, 0, 0, 0.1, 0, 0.2))),
        chains.joint("yaw", "ground", "ring", axis=(0, 0.6, 0.8)),
        chains.joint("roll", "ring", "disc", axis=(1, 0, 0), at=(0.2, 0.1, 0)),
    )
    damping = 1.4 * sqrt(stiffness * 3e-3 / 0.02**2)
    yaw = chains.geared(6.0, 3e-3, mesh=chains.teeth(0.02, stiffness, damping))
    roll = chains.geared(-8.0, 3e-3, stator="disc", rotor_axis=[0.0, 1.0, 0.0])
    return chains.robot(
        text, {"yaw": yaw, "roll": roll | {"mesh": chains.teeth(0.02, stiffness, damping)}}
    )


@pytest.mark.parametrize("engine", chains.ENGINES)
def test_stiff_teeth_are_a_rigid_gear(engine):
    """What is left of the difference falls with the stiffness: to a quarter at four times."""
    q, v, torques = np.array([[0.4, -0.7]]), np.array([[0.5, 0.8]]), np.array([[3.0, -2.0]])

    def end(level: str, stiffness: float) -> np.ndarray:
        model = build_robot_model(engine, gimbal(stiffness), level)
        none = np.zeros((1, 2 if level == "geared" else 0))
        start = np.hstack([q, none]), np.hstack([v, none])
        return integrate(model, *start, lambda t: torques * cos(9 * t), 0.1, 100)[0][0]

    rigid = end("coupled", 1.0)
    apart = [np.abs(end("geared", k)[:2] - rigid).max() for k in (1e5, 4e5, 1.6e6)]
    assert apart[0] < 0.02 * np.abs(rigid - q).max()
    assert apart[1] < 0.35 * apart[0]
    assert apart[2] < 0.35 * apart[1]


def test_inertias_too_unlike_for_the_digits_are_one_line():
    given = chains.geared(-1e6, 1e15, mesh=chains.teeth(1e-5))
    with pytest.raises(InputError, match="M cannot be inverted"):
        compute_costs(chains.robot(chains.BOB, {"swing": given}), 0, QUICK, lambda *doing: None)
