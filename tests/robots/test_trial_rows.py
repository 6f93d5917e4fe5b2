"""Rows and columns that are right, by which a slip of Newton and Euler's two ways is found."""

import numpy as np

from crosscheck.models.robot.robot import Robot
from crosscheck.trial.input.equations import Equations
from tests.robots import chains
from tests.robots.trials import run_robot_trial

NAMES = "a", "b", "c", "d"
CHAIN = chains.robot(
    chains.urdf(
        chains.link("base"),
        *(
            chains.link(
                name,
                chains.Solid(
                    4.0 - k, (0.1, 0.02 * k, -0.05), (0.03 + 0.01 * k, 0.002, 0, 0.04, 0, 0.05)
                ),
            )
            for k, name in enumerate(NAMES)
        ),
        *(
            chains.joint(f"j{k + 1}", before, name, axis=axis, at=(0.3, 0.1, 0.2), rpy=(0.4, k, 1))
            for k, (before, name, axis) in enumerate(
                zip(
                    ("base", *NAMES),
                    NAMES,
                    ((0, 0, 1), (0, 1, 0), (1, 0, 0), (0, 1, 0)),
                    strict=False,
                )
            )
        ),
    )
)


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    skew = np.cross(np.eye(3), axis)
    return np.eye(3) + np.sin(angle) * skew + (1 - np.cos(angle)) * skew @ skew


def balance(robot: Robot, slip: str, q, v, a, down) -> np.ndarray:
    """Newton and Euler's torques, each link in its own frame; slip: at the third link."""
    count, w, dw, pull = len(robot.joints), np.zeros(3), np.zeros(3), -down
    turns, forces, moments = [], [], []
    for k, (joint, body) in enumerate(zip(robot.joints, robot.bodies, strict=True)):
        R, p = joint.placement.rotation @ turn(joint.axis, q[k]), joint.placement.position
        if slip == "out" and k == 2:
            p = robot.bodies[1].com
        pull = R.T @ (pull + np.cross(dw, p) + np.cross(w, np.cross(w, p)))
        w, dw = R.T @ w, R.T @ dw
        dw = dw + joint.axis * a[k] + np.cross(w, joint.axis * v[k])
        w = w + joint.axis * v[k]
        at_centre = pull + np.cross(dw, body.com) + np.cross(w, np.cross(w, body.com))
        turns.append(R)
        forces.append(body.mass * at_centre)
        moments.append(body.inertia @ dw + np.cross(w, body.inertia @ w))
    force, moment, torques = np.zeros(3), np.zeros(3), np.zeros(count)
    for k in reversed(range(count)):
        body = robot.bodies[k]
        if k + 1 < count:
            R = turns[k + 1].T if slip == "back" and k == 1 else turns[k + 1]
            force = R @ force
            moment = R @ moment + np.cross(robot.joints[k + 1].placement.position, force)
        force = force + forces[k]
        moment = moment + moments[k] + np.cross(body.com, forces[k])
        torques[k] = robot.joints[k].axis @ moment
    return torques


def newton_euler(robot: Robot, slip: str = "") -> Equations:
    still, none = np.zeros(len(robot.joints)), np.zeros(3)

    def mass_matrix(q):
        return np.stack(
            [balance(robot, slip, q, still, each, none) for each in np.eye(len(still))], axis=1
        )

    return Equations(
        mass_matrix=mass_matrix,
        bias=lambda q, v: balance(robot, slip, q, v, still, none),
        gravity=lambda q: balance(robot, slip, q, still, still, robot.gravity),
    )


def notes(slip: str) -> tuple[str, ...]:
    return run_robot_trial(newton_euler(CHAIN, slip), CHAIN).diagnosis.notes


def test_newton_and_euler_agree():
    assert run_robot_trial(newton_euler(CHAIN), CHAIN).agrees


def test_a_slip_on_the_way_back_leaves_the_last_rows_right():
    (first,) = (each for each in notes("back") if "symmetric" in each)
    assert "in 5 pairs; its rows 3 and 4 are right, rows 1 and 2 wrong" in first
    assert first.endswith("from c to b")


def test_a_slip_on_the_way_out_leaves_the_last_columns_right():
    (first,) = (each for each in notes("out") if "symmetric" in each)
    assert "its columns 3 and 4 are right, columns 1 and 2 wrong" in first
    assert first.endswith("accelerations go wrong on their way out, from b to c")
