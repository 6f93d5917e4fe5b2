"""Momentum of a whole robot: that of the joints on its base, by M, and what weights take of it.

Of a robot that floats without weight it is conserved, in so many directions as the ground leaves.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from crosscheck.checks.answers import ask, gravity, momentum
from crosscheck.checks.robot_states import TOLERANCE
from crosscheck.checks.sampled import RobotLevel, Subjects
from crosscheck.checks.scales import check_share, share_of
from crosscheck.checks.simulations import make_scenario
from crosscheck.findings import Finding, Subject
from crosscheck.models.errors import Diverged
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import BASE, Placement, Robot
from crosscheck.models.robot.tree import HOME, compose, rotate_about
from crosscheck.planning.comparison import Comparison

DRIFT_STEPS = 20  # of a run with coarse steps, in which momenta are conserved; fine: twice as many
CONSERVED = 1e-12  # largest part of a conserved direction in which the ground may push


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
        if joint.mimic is not None:
            leader = joint.mimic.joint
            if roots[leader] != roots[number] or leader in roots:
                crossing |= {roots[number], roots[leader]}
    return [n for n in robot.coordinates if robot.joints[n].parent == BASE and n not in crossing]


def _root(robot: Robot, number: int) -> int:
    """The joint on the base that carries a joint, or is it."""
    while robot.joints[number].parent != BASE:
        number = robot.joints[number].parent
    return number


def _carried(robot: Robot, base: int) -> np.ndarray:
    """Mask (n,) of the coordinates of a joint on the base and of all joints it carries."""
    return np.array([_root(robot, number) == base for number in robot.coordinates], dtype=float)


def momentum_drifts(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Changes of the conserved momenta in a run by coarse and by fine steps (2, records, k).

    Over the most that the kinetic energy allows; infinite where a run diverged.
    """
    directions, scenario, drifts = find_conserved_directions(case.robot), make_scenario(case), []
    factors = np.abs(directions) @ (case.sizes.momentum[0] / case.sizes.motion[0])
    for steps in (DRIFT_STEPS, 2 * DRIFT_STEPS):
        step, stride = case.run_s / steps, steps // DRIFT_STEPS
        try:
            update = {"step_s": step, "record_every": stride}
            q, v = model.integrate(scenario.model_copy(update=update))
        except Diverged:
            return np.full((2, 1, 1), np.inf)
        momenta = ask(model, "momentum", (len(q), 6), q, v) @ directions.T
        motion = np.sqrt(2 * ask(model, "energy", (len(q),), q, v)).max()
        drifts.append((momenta - momenta[0]) / (motion * factors))
    return np.array(drifts)


def find_conserved_directions(robot: Robot) -> np.ndarray:
    """Orthonormal directions (k, 6) of linear and angular momentum about the base's origin.

    In these the ground exerts no force or moment on a robot without weight, whatever its motors do:
    at any state, joints without motor and friction before the first mass let it move in each.
    """
    chain = _list_root_chain(robot) if not robot.gravity.any() else []
    pushes = list[np.ndarray]()
    for coordinates in np.random.default_rng(0).uniform(-1, 1, (2, len(chain))):
        pose, twists = HOME, list[np.ndarray]()
        for number, x in zip(chain, coordinates, strict=True):
            joint = robot.joints[number]
            pose = compose(pose, joint.placement)
            axis = pose.rotation @ joint.axis
            if joint.kind == "revolute":
                twists.append(np.hstack([np.cross(pose.position, axis), axis]))
                pose = Placement(rotate_about(axis, x) @ pose.rotation, pose.position)
            else:
                twists.append(np.hstack([axis, 0 * axis]))
                pose = Placement(pose.rotation, pose.position + x * axis)
        basis = np.linalg.qr(np.reshape(twists, (-1, 6)).T)[0]
        pushes.append(np.eye(6) - basis @ basis.T)
    _, sizes, rows = np.linalg.svd(np.vstack(pushes))
    return rows[sizes < CONSERVED]


def _list_root_chain(robot: Robot) -> list[int]:
    """Joints without motor and friction from the ground to the first body with mass, if alone."""
    chain, parent = list[int](), BASE
    leaders = {joint.mimic.joint for joint in robot.joints if joint.mimic}
    stators = {robot.frames[rotor.stator].body for rotor in robot.rotors}
    while True:
        children = [n for n, joint in enumerate(robot.joints) if joint.parent == parent]
        joint = robot.joints[children[0]] if len(children) == 1 else None
        if joint is None or joint.has_motor or joint.friction or joint.armature or joint.mimic:
            return chain
        (parent,) = children
        if parent in leaders:
            return chain
        chain.append(parent)
        body = robot.bodies[parent]
        if body.mass or body.inertia.any() or parent in stators:
            return chain


def plan(subjects: Subjects) -> Iterator[Comparison | str]:
    """Comparisons of each model's momentum with its M, where no rotor spins beside the links."""
    for sampled in subjects.robots:
        if sampled.setting.level == "links" and find_base_joints(sampled.setting.robot):
            yield sampled.plan_law("base-momentum", [base_momenta], _check_momenta)
        if sampled.setting.robot.gravity.any():
            yield sampled.plan_law("linear-momentum", (gravity, momentum), _check_momentum)
        # Of geared robots contacts spoil the order of steps.
        has_runs = sampled.setting.has_runs and sampled.setting.level != "geared"
        if has_runs and find_conserved_directions(sampled.setting.robot).size:
            yield sampled.plan_law("conserved-momentum", [momentum_drifts], _check_drifts)
    if subjects.robots and not subjects.robots[0].setting.robot.gravity.any():
        yield "without gravity: no weights to hold against energy and linear momentum"
    if subjects.robots and not find_base_joints(subjects.robots[0].setting.robot):
        yield "momentum is not compared with M: a joint on the base leads or follows another"


def _check_momenta(about: Subject, momenta: np.ndarray, case: RobotLevel) -> Finding:
    robot, worst = case.robot, 0.0
    v = np.abs(case.states.v)
    pairs = zip(find_base_joints(robot), momenta.swapaxes(0, 1), strict=True)
    for number, (conjugate, whole) in pairs:
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


def _check_drifts(about: Subject, drifts: np.ndarray, case: RobotLevel) -> Finding:
    """Momenta are conserved but for the steps' error, of fourth order, which two runs show."""
    if not np.isfinite(drifts).all():
        return check_share(about, np.inf, TOLERANCE, "the run diverged")
    coarse, fine = drifts
    tolerance = TOLERANCE + float(np.abs(coarse - fine).max()) / 4
    basis = f"{TOLERANCE:g} of the momenta, and a fourth of what halving the steps changes"
    return check_share(about, share_of((16 * fine - coarse) / 15, np.ones(1)), tolerance, basis)
