"""Momentum of a whole robot: that of the joints on its base, by M, and what weights take of it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from crosscheck.checks.engines import gravity, momentum
from crosscheck.checks.robot_states import TOLERANCE
from crosscheck.checks.sampled import RobotLevel, Subjects, ask
from crosscheck.checks.scales import check_share, share_of
from crosscheck.findings import Finding, Subject
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import BASE, Robot
from crosscheck.planning.comparison import Comparison


def base_momenta(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Momentum conjugate to each joint on the base (2, joints, states), nothing else moving.

    First by M, then by the whole robot's linear and angular momentum.
    """
    robot, (q, v, *_), pairs = case.robot, case.states, []
    matrices = ask(model, "mass_matrix", (*q.shape, q.shape[1]), q)
    for number in find_base_joints(robot):
        column, moving = robot.coordinates.index(number), v * _carried(robot, number)
        whole = ask(model, "momentum", (len(q), 6), q, moving)
        joint = robot.joints[number]
        axis, place = joint.placement.rotation @ joint.axis, joint.placement.position
        along = whole[:, :3]
        if joint.kind == "revolute":
            along = whole[:, 3:] - np.cross(place, whole[:, :3])
        pairs.append([np.einsum("sj,sj->s", matrices[:, column], moving), along @ axis])
    return np.array(pairs).swapaxes(0, 1)


def find_base_joints(robot: Robot) -> list[int]:
    """Numbers of free joints on the base, whose branches no joint of another branch leads."""
    roots = [_root(robot, number) for number in range(len(robot.joints))]
    crossing = set()
    for number, joint in enumerate(robot.joints):
        if joint.mimic is not None and (
            roots[joint.mimic.joint] != roots[number] or joint.mimic.joint in roots
        ):
            crossing |= {roots[number], roots[joint.mimic.joint]}
    return [
        number
        for number in robot.coordinates
        if robot.joints[number].parent == BASE and number not in crossing
    ]


def _root(robot: Robot, number: int) -> int:
    """The joint on the base that carries a joint, or is it."""
    while robot.joints[number].parent != BASE:
        number = robot.joints[number].parent
    return number


def _carried(robot: Robot, base: int) -> np.ndarray:
    """Mask (n,) of the coordinates of a joint on the base and of all joints it carries."""
    return np.array([_root(robot, number) == base for number in robot.coordinates], dtype=float)


def plan(subjects: Subjects) -> Iterator[Comparison | str]:
    """Comparisons of each model's momentum with its M, where no rotor spins beside the links."""
    for sampled in subjects.robots:
        if sampled.case.level == "links" and find_base_joints(sampled.case.robot):
            yield sampled.plan_case_law("base-momentum", [base_momenta], _check_momenta)
        if sampled.case.robot.gravity.any():
            questions = gravity, momentum
            yield sampled.plan_case_law("linear-momentum", questions, _check_momentum)
    if subjects.robots and not subjects.robots[0].case.robot.gravity.any():
        yield "without gravity: no weights to hold against energy and linear momentum"
    if subjects.robots and not find_base_joints(subjects.robots[0].case.robot):
        yield "momentum is not compared with M: a joint on the base leads or follows another"


def _check_momenta(about: Subject, momenta: np.ndarray, case: RobotLevel) -> Finding:
    robot, worst = case.robot, 0.0
    v = np.abs(case.states.v)
    for number, (conjugate, whole) in zip(
        find_base_joints(robot), momenta.swapaxes(0, 1), strict=True
    ):
        roots = case.sizes.mass_matrix[:, robot.coordinates.index(number)]
        size = (roots * v * _carried(robot, number)).sum(axis=1)
        away = float(np.linalg.norm(robot.joints[number].placement.position))
        size = size + away * case.sizes.momentum[:, 0]
        worst = max(worst, share_of(conjugate - whole, size))
    return check_share(about, worst, TOLERANCE, f"{TOLERANCE:g} of the momenta that are summed")


def _check_momentum(
    about: Subject, given: np.ndarray, moving: np.ndarray, case: RobotLevel
) -> Finding:
    """Weights take the power -g . P from the motion, P the linear momentum."""
    pull, sizes = case.robot.gravity, case.sizes
    power = (given * case.states.v).sum(axis=1) + moving[:, :3] @ pull
    size = sizes.momentum[:, 0] * np.linalg.norm(pull)
    size = size + (np.abs(given) * np.abs(case.states.v)).sum(axis=1)
    basis = f"{TOLERANCE:g} of the powers that are summed"
    return check_share(about, share_of(power, size), TOLERANCE, basis)
