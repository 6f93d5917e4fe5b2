"""Errors planted in right equations of robots, by name."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache, lru_cache, partial
from pathlib import Path

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import Placement, Robot, RobotBody, compute_point_inertia
from crosscheck.trial.changes.mistakes import list_body_parts
from crosscheck.trial.changes.numbers import put_value
from crosscheck.trial.input.equations import Coordinates, Equations
from crosscheck.trial.source.libraries import cross_vectors
from tests.robots import chains, two_link
from tests.robots.trials import robot_equations

Vector = np.ndarray
Case = tuple[Robot, Equations]
TWO = two_link.robot()
PRODUCT = np.array([[0, 0, 1], [0, 0, 0], [1, 0, 0]])


# Numbers of a robot that are others.
Change = Callable[[Robot], Robot]


def change_one(group: str, number: int, **changed: Callable[[Vector], object]) -> Change:
    """Other numbers of a body, a rotor or a joint."""

    def change(own: Robot) -> Robot:
        was = getattr(own, group)[number]
        new = {name: function(getattr(was, name)) for name, function in changed.items()}
        return put_value(own, (group, number), replace(was, **new))

    return change


body, rotor, joint = (partial(change_one, group) for group in ("bodies", "rotors", "joints"))


def all_bodies(inertia: Callable[[RobotBody], Vector]) -> Change:
    """Another inertia of every link."""

    def change(own: Robot) -> Robot:
        return replace(own, bodies=tuple(replace(b, inertia=inertia(b)) for b in own.bodies))

    return change


def about_the_joint(own: RobotBody) -> Vector:
    return own.inertia + own.mass * (own.com @ own.com * np.eye(3) - np.outer(own.com, own.com))


def negate_products(own: RobotBody) -> Vector:
    return 2 * np.diag(np.diag(own.inertia)) - own.inertia


def read_as_fullinertia(own: RobotBody) -> Vector:
    """Six numbers in URDF's order, read in that of MJCF."""
    xx, xy, xz, yy, yz, zz = own.inertia[np.triu_indices(3)]
    return np.array([[xx, yy, yz], [yy, xy, zz], [yz, zz, xz]])


def mirror(com: Vector) -> Vector:
    """The largest coordinate has the other sign."""
    return com * np.where(np.arange(3) == np.abs(com).argmax(), -1, 1)


def stretch_all_places(own: Robot) -> Robot:
    """Places of all joints by the golden ratio: no change of one or two of them."""
    joints = [
        replace(j, placement=Placement(j.placement.rotation, 1.618 * j.placement.position))
        for j in own.joints
    ]
    return replace(own, joints=tuple(joints))


@lru_cache
def six_joint_with_turned_products() -> Robot:
    """Out of a URDF: its tool is fixed to its wrist."""
    built_in = load_robot("six-joint")
    text = (Path("models/robots") / "six-joint.urdf").read_text(encoding="utf-8")
    turned = re.sub(
        r'(ix[yz]|iyz)="(-?)([^"]*)"', lambda m: f'{m[1]}="{"" if m[2] else "-"}{m[3]}"', text
    )
    bodies = chains.robot(turned, gravity_m_per_s2=built_in.gravity.tolist()).bodies
    return replace(built_in, bodies=bodies)


@cache
def tree() -> Robot:
    """A trunk with two arms and rotors, no number of it twice."""
    solids = [
        chains.Solid(m, com, (a, 0.1 * a, -0.05 * a, 1.2 * a, 0.07 * a, 1.5 * a))
        for m, com, a in (
            (9.0, (0.02, 0.01, 0.2), 0.3),
            (2.2, (0.01, 0.12, -0.013), 0.02),
            (2.4, (0.012, -0.11, -0.015), 0.023),
        )
    ]
    rotors = {"turn": (100.0, 2e-4), "l": (80.0, 9e-5), "r": (-60.0, 7e-5)}
    return chains.robot(
        chains.urdf(
            chains.link("base"),
            *map(chains.link, ("trunk", "left", "right"), solids),
            chains.joint("turn", "base", "trunk", at=(0.1, 0.05, 0.4)),
            chains.joint("l", "trunk", "left", axis=(0.6, 0, 0.8), at=(0.02, 0.2, 0.35)),
            chains.joint("r", "trunk", "right", axis=(0, 1, 0), at=(0.03, -0.21, 0.36)),
        ),
        {name: chains.geared(*numbers) for name, numbers in rotors.items()},
    )


SOLID = chains.Solid(1.0, (0.1, 0.2, 0.3), (0.05, 0.004, -0.003, 0.04, 0.002, 0.03))
PLAIN = chains.Solid(1.0, (0.1, 0.2, 0.3), (0.05, 0, -0.003, 0.04, 0, 0.03))
OBLIQUE, WITH_ONE_PRODUCT = (
    chains.robot(
        chains.urdf(
            *(chains.link(name, solid) for name in ("base", "a", "b")),
            chains.joint("j1", "base", "a", axis=(0.6, 0, 0.8)),
            chains.joint("j2", "a", "b", axis=(0, 1, 0), at=(0.2, 0, 0.1)),
        )
    )
    for solid in (SOLID, PLAIN)
)
STAGED = chains.robot(
    chains.urdf(
        *(chains.link(n, chains.Solid(com=(0.1, 0.2, 0.3))) for n in ("ground", "ring", "disc")),
        chains.joint("yaw", "ground", "ring"),
        chains.joint("roll", "ring", "disc", axis=(0.6, 0, 0.8)),
    ),
    {"roll": chains.planetary()},
)
SWINGING = chains.robot(chains.BOB, {"swing": chains.geared(-20.0)})
SLIDING, SIX, PUMA = map(load_robot, ("sliding", "six-joint", "puma560"))


def stage(**changed: float) -> Change:
    def change(own: Robot) -> Robot:
        gears = own.stages[0].gears.model_copy(update=changed)
        return replace(own, stages=(replace(own.stages[0], gears=gears),))

    return change


OTHER_ROBOTS: dict[str, tuple[Robot, tuple[Change, ...]]] = {
    "sign of y of the hand's centre of mass": (SLIDING, (body(2, com=lambda c: c * [1, -1, 1]),)),
    "0.3 kg more of the boom": (SLIDING, (body(1, mass=lambda m: m + 0.3),)),
    "Ixz of the hand": (SLIDING, (body(2, inertia=lambda i: i + 0.001 * PRODUCT),)),
    "sign of the tilt's ratio": (SLIDING, (rotor(2, ratio=lambda _: -6.0),)),
    "no rotor of the tilt": (SLIDING, (lambda own: replace(own, rotors=own.rotors[:-1]),)),
    "9.80665 for 9.81": (SLIDING, (partial(replace, gravity=np.array([0, 0, -9.80665])),)),
    "inertia of the hand about its joint": (
        SLIDING,
        (lambda own: body(2, inertia=lambda _: about_the_joint(own.bodies[2]))(own),),
    ),
    "no place of the right arm": (
        tree(),
        (joint(2, placement=lambda at: Placement(at.rotation, 0 * at.position)),),
    ),
    "axis of the tilt the other way": (SLIDING, (joint(2, axis=lambda axis: -axis),)),
    "axis of the tilt along z": (SLIDING, (joint(2, axis=lambda axis: np.eye(3)[2]),)),
    "ratio by its size, whose sign counts nowhere": (SWINGING, (rotor(0, ratio=lambda _: -13.0),)),
    "ratio in turns": (tree(), (rotor(2, ratio=lambda n: n / (2 * np.pi)),)),
    "inertia of the sun": (STAGED, (stage(sun_inertia_kg_m2=2e-4),)),
    "no spin of planets": (STAGED, (stage(planet_inertia_kg_m2=0.0),)),
    "products of every link negated": (OBLIQUE, (all_bodies(negate_products),)),
    "the only product of a link negated": (
        WITH_ONE_PRODUCT,
        (body(0, inertia=lambda i: 2 * np.diag(np.diag(i)) - i),),
    ),
    "a link in pounds": (
        tree(),
        (body(1, mass=lambda m: 2.20462 * m, inertia=lambda inertia: 2.20462 * inertia),),
    ),
    "two motors exchanged": (
        tree(),
        (
            rotor(1, inertia=lambda _: 7e-5, ratio=lambda _: -60.0),
            rotor(2, inertia=lambda _: 9e-5, ratio=lambda _: 80.0),
        ),
    ),
    "inertias in another order": (OBLIQUE, (all_bodies(read_as_fullinertia),)),
    "every inertia about its joint": (OBLIQUE, (all_bodies(about_the_joint),)),
    "products in the axes of the file": (SIX, (lambda own: six_joint_with_turned_products(),)),
    "two: a mass, and a sign of a centre": (
        PUMA,
        (body(1, mass=lambda m: 1.1 * m), body(3, com=mirror)),
    ),
    "two: pounds, and a sign": (SIX, (body(3, com=mirror), body(5, mass=lambda m: 2.20462 * m))),
    "two: a ratio once, and a sign": (
        SIX,
        (body(2, com=mirror), rotor(1, inertia=lambda i: i / 100)),
    ),
    "no pair: places of all joints": (SIX, (stretch_all_places,)),
    "no pair: three masses": (
        PUMA,
        tuple(body(n, mass=lambda m, by=by: by * m) for n, by in ((1, 1.1), (2, 1.3), (3, 0.9))),
    ),
    "no pair: two odd masses": (
        PUMA,
        tuple(body(n, mass=lambda m, by=by: by * m) for n, by in ((1, 1.13), (3, 1.07))),
    ),
}


def of_another(robot: Robot, changes: tuple[Change, ...]) -> Case:
    """The equations of a robot that differs in what was changed."""
    used = robot
    for change in changes:
        used = change(used)
    return robot, robot_equations(used)


# Terms of the double pendulum with rotors, each written wrong.
def half_a_term(q: Vector, v: Vector) -> Vector:
    squares = np.array([-v[0] * v[1] - v[1] ** 2, v[0] ** 2])
    return two_link.COUPLED * np.sin(q[1]) * squares


def turned_gravity(q: Vector) -> Vector:
    return two_link.gravity(q) + two_link.gravity(q - [np.pi / 2, 0]) * [0, 1]


def reflect(inertia: float) -> Callable[[Vector], Vector]:
    return lambda q: two_link.mass_matrix(q, inertia)


def mass_by(factors: object) -> Callable[[Vector], Vector]:
    return lambda q: two_link.mass_matrix(q) * np.array(factors)


def mass_less(matrix: object) -> Callable[[Vector], Vector]:
    return lambda q: two_link.mass_matrix(q) - np.array(matrix)


def bias_with(more: Callable[[Vector, Vector], Vector]) -> Callable[[Vector, Vector], Vector]:
    return lambda q, v: two_link.bias(q, v) + more(q, v)


def other_ratio_in_one_row(q: Vector, v: Vector, torque: Vector) -> Vector:
    load = torque - two_link.bias(q, v) - two_link.gravity(q)
    more = np.diag([0.0, (12.0**2 - two_link.N**2) * two_link.ROTOR])
    first = np.linalg.solve(two_link.mass_matrix(q), load)[0]
    return np.array([first, np.linalg.solve(two_link.mass_matrix(q) + more, load)[1]])


J2, ROTOR, N = two_link.J2, two_link.ROTOR, two_link.N
PENDULUM: dict[str, Equations] = {
    name: two_link.right(**parts)
    for name, parts in {
        "lever of a weight": {"gravity": lambda q: two_link.gravity(q, lever=two_link.C2)},
        "odd lever of a weight": {"gravity": lambda q: two_link.gravity(q, lever=0.87)},
        "weights of the other sign": {"gravity": lambda q: -two_link.gravity(q)},
        "a sine for a cosine in a weight": {"gravity": turned_gravity},
        "half a term": {"bias": half_a_term},
        "a rate twice": {"bias": lambda q, v: two_link.bias(q, v * [1, 2])},
        "sign of an entry of the bias": {"bias": lambda q, v: two_link.bias(q, v) * [1, -1]},
        "an inertia left out of an entry": {"mass_matrix": mass_less([[0, J2], [J2, 0]])},
        "friction in the bias": {"bias": bias_with(lambda q, v: np.array([[12, 7], [0, 5]]) @ v)},
        "Coulomb": {"bias": bias_with(lambda q, v: -9 * np.sign(v)), "coulomb_friction": [9, 9]},
        "weights in the bias, too": {"bias": bias_with(lambda q, v: two_link.gravity(q))},
        "a cubic bias": {"bias": bias_with(lambda q, v: v**3)},
        "a lopsided mass matrix": {"mass_matrix": mass_by([[1, 1], [1.5, 1]])},
        "the upper triangle alone": {"mass_matrix": lambda q: np.triu(two_link.mass_matrix(q))},
        "the lower triangle alone": {"mass_matrix": lambda q: np.tril(two_link.mass_matrix(q))},
        "the diagonal alone": {"mass_matrix": mass_by(np.eye(2))},
        "no positive mass matrix, as no body has": {"mass_matrix": mass_less(np.diag([20.0, 0]))},
        "both by one cause": {
            "mass_matrix": lambda q: (
                two_link.mass_matrix(q) + np.cos(q[1]) * np.array([[1, 0.5], [0.5, 0]])
            ),
            "bias": lambda q, v: (1 + 0.5 / two_link.COUPLED) * two_link.bias(q, v),
        },
        "weights that are no gradient": {"gravity": lambda q: two_link.gravity(q) * [1, 0.8]},
        "the ratio once in every rotor": {"mass_matrix": reflect(N * ROTOR)},
        "every rotor twice": {"mass_matrix": reflect(2 * N**2 * ROTOR)},
        "every rotor half": {"mass_matrix": reflect(N**2 * ROTOR / 2)},
        "every rotor without its ratio": {"mass_matrix": reflect(ROTOR)},
        "force beside right parts": {"force": lambda q, torque: two_link.force(q, torque) + 1e3},
        "inverse dynamics beside right parts": {
            "inverse_dynamics": lambda q, v, a: two_link.inverse_dynamics(q, v, a) + 1e3
        },
        "acceleration beside right parts": {
            "acceleration": lambda q, v, torque: two_link.acceleration(q, v, torque) + 1e3
        },
        "no weights in the acceleration, beside a wrong entry of M": {
            "mass_matrix": mass_less(np.diag([0, 1e-3])),
            "acceleration": lambda q, v, torque: two_link.acceleration(
                q, v, torque + two_link.gravity(q)
            ),
        },
        "weights in the force of one joint alone": {
            "force": lambda q, torque: torque - two_link.gravity(q) * [1, 0]
        },
    }.items()
} | {
    "a wrong C": Equations(
        two_link.mass_matrix, gravity=two_link.gravity, coriolis=lambda q, v: 1e3 * np.ones((2, 2))
    ),
    "a ratio in one acceleration alone": Equations(acceleration=other_ratio_in_one_row),
    "wrong weights in nonlinear effects": Equations(
        two_link.mass_matrix, lambda q, v: two_link.bias(q, v) - two_link.gravity(q)
    ),
    "a level that is not theirs": replace(two_link.right(), level="links"),
}


# Terms of a tree whose numbers are alike, derived wrong.
ALIKE = [chains.link("base")] + [
    chains.link(name, chains.Solid(mass, (0.1, 0.02, 0.03), (0.02, 0, 0, 0.03, 0, 0.025)))
    for name, mass in (("trunk", 3.0), ("left", 1.1), ("right", 1.4))
]
TRUNK = chains.robot(
    chains.urdf(
        *ALIKE,
        chains.joint("turn", "base", "trunk"),
        chains.joint("l", "trunk", "left", axis=(0, 1, 0), at=(0, 0.2, 0.4)),
        chains.joint("r", "trunk", "right", axis=(0, 1, 0), at=(0, -0.2, 0.4)),
    ),
    {},
    gravity_m_per_s2=[0.0, 0.0, -9.81],
)
STEP, KANE = 1e-5, AnalyticRobot(TRUNK, "links")
RIGHT = robot_equations(TRUNK, "links")
mass, bias, gravity = RIGHT.mass_matrix, RIGHT.bias, RIGHT.gravity


def change_of_mass(q: Vector, v: Vector) -> Vector:
    """M' v, by differences."""
    return (mass(q + STEP * v) - mass(q - STEP * v)) @ v / (2 * STEP)


def without_arms_in_the_first_entry(q: Vector) -> Vector:
    bodies = [replace(TRUNK.bodies[0], mass=0.0, inertia=np.zeros((3, 3))), *TRUNK.bodies[1:]]
    arms = AnalyticRobot(replace(TRUNK, bodies=tuple(bodies)), "links").mass_matrix(q[None])[0]
    return mass(q) - arms * np.diag([1.0, 0, 0])


def without_own_columns(q: Vector) -> Vector:
    """M in which the angular velocity of a link is without its own joint's."""
    total = mass(q)
    for number, pose in enumerate(KANE.frames(q[None], np.zeros((1, 3)))[0]):
        R, turning = pose.rotation[0], pose.angular_partials[0]
        less = turning * (np.arange(3) != number)
        inertia = R @ TRUNK.bodies[number].inertia @ R.T
        total = total + less.T @ inertia @ less - turning.T @ inertia @ turning
    return total


def opposite_product_of_rates(q: Vector, v: Vector) -> Vector:
    mixed = bias(q, v) - bias(q, v * [1, -1, 1])  # products of the first two rates, twice
    return bias(q, v) - mixed * [1, 0, 0]


def gyroscopic_torques(q: Vector, v: Vector) -> Vector:
    pose, rate = KANE.frames(q[None], v[None])
    gyroscopic = np.zeros(3)
    for number, own in enumerate(TRUNK.bodies):
        R, w = pose[number].rotation[0], rate[number].angular[0]
        moment = np.cross(w, R @ own.inertia @ R.T @ w)
        gyroscopic += pose[number].angular_partials[0].T @ moment
    return gyroscopic


def without_gyroscopic_torques(q: Vector, v: Vector, torque: Vector) -> Vector:
    return np.linalg.solve(mass(q), torque - bias(q, v) + gyroscopic_torques(q, v) - gravity(q))


DAMPING = np.array([0.3, 0.0, 0.2])
DERIVED = {
    "M' v alone": replace(RIGHT, bias=change_of_mass),
    "C transposed": replace(RIGHT, bias=lambda q, v: change_of_mass(q, v) - bias(q, v)),
    "a branch left out": replace(RIGHT, mass_matrix=without_arms_in_the_first_entry),
    "own columns of w": replace(RIGHT, mass_matrix=without_own_columns),
    "sign of one product of rates": replace(RIGHT, bias=opposite_product_of_rates),
    "gyroscopic torques halved": replace(
        RIGHT, bias=lambda q, v: bias(q, v) - gyroscopic_torques(q, v) / 2
    ),
    "no gyroscopic torques": Equations(acceleration=without_gyroscopic_torques),
    "friction of the other sign": Equations(
        force=lambda t, q, v, torque: torque - gravity(q) - DAMPING * v * [1, 1, -1],
        viscous_friction=DAMPING,
    ),
}


# Numbers of links as the file has them.
TURNED = chains.robot(
    chains.urdf(
        chains.link("base"),
        chains.link("a", chains.Solid(2.0, (0.05, 0.02, 0.1), (0.03, 0.002, 0, 0.035, 0, 0.015))),
        chains.link(
            "b",
            chains.Solid(
                1.5, (0.1, 0.01, 0.03), (0.01, 0, 0.001, 0.02, 0, 0.018), rpy=(-0.7, 0.5, 0.2)
            ),
        ),
        chains.link("tool", chains.Solid(0.4, (0.0, 0.0, 0.04), (4e-4, 0, 0, 4e-4, 0, 3e-4))),
        chains.joint("j1", "base", "a", at=(0, 0, 0.3)),
        chains.joint("j2", "a", "b", at=(0, 0.05, 0.2), rpy=(0.9, 0.4, -0.3)),
        chains.joint("flange", "b", "tool", "fixed", at=(0.02, 0, 0.107)),
    )
)
(PART_B,) = (each for each in list_body_parts(TURNED) if each.name == "b")
STATED = PART_B.turn.T @ PART_B.in_link.inertia @ PART_B.turn


def other_link_b(**others: object) -> Equations:
    """Of the robot with other numbers of link b in its own frame."""
    (rest,) = (
        each
        for each in list_body_parts(TURNED)
        if each.number == PART_B.number and each.name != "b"
    )
    parts = PART_B._replace(in_link=replace(PART_B.in_link, **others)).body, rest.body
    whole = sum(each.mass for each in parts)
    com = sum(each.mass * each.com for each in parts) / whole
    inertia = sum(each.inertia + compute_point_inertia(each.mass, each.com - com) for each in parts)
    merged = RobotBody(whole, com, inertia)
    return robot_equations(put_value(TURNED, ("bodies", PART_B.number), merged))


# Newton and Euler's two ways along a chain, a slip at the third link.
NAMES = "a", "b", "c", "d"
AXES = (0, 0, 1), (0, 1, 0), (1, 0, 0), (0, 1, 0)
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
                zip(("base", *NAMES), NAMES, AXES, strict=False)
            )
        ),
    )
)


def turn(axis: Vector, angle: float) -> Vector:
    x, y, z = axis
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * skew + (1 - np.cos(angle)) * skew @ skew


def balance(slip: str, q: Vector, v: Vector, a: Vector, down: Vector) -> Vector:
    """Torques, each link in its own frame."""
    w, dw, pull = np.zeros(3), np.zeros(3), -down
    turns, forces, moments = [], [], []
    for k, (own, solid) in enumerate(zip(CHAIN.joints, CHAIN.bodies, strict=True)):
        R, p = own.placement.rotation @ turn(own.axis, q[k]), own.placement.position
        if slip == "out" and k == 2:
            p = CHAIN.bodies[1].com
        pull = R.T @ (pull + cross_vectors(dw, p) + cross_vectors(w, cross_vectors(w, p)))
        w, dw = R.T @ w, R.T @ dw
        dw = dw + own.axis * a[k] + cross_vectors(w, own.axis * v[k])
        w = w + own.axis * v[k]
        at_centre = (
            pull + cross_vectors(dw, solid.com) + cross_vectors(w, cross_vectors(w, solid.com))
        )
        turns.append(R)
        forces.append(solid.mass * at_centre)
        moments.append(solid.inertia @ dw + cross_vectors(w, solid.inertia @ w))
    force, moment, torques = np.zeros(3), np.zeros(3), np.zeros(len(q))
    for k in reversed(range(len(q))):
        if k + 1 < len(q):
            R = turns[k + 1].T if slip == "back" and k == 1 else turns[k + 1]
            force = R @ force
            moment = R @ moment + cross_vectors(CHAIN.joints[k + 1].placement.position, force)
        force = force + forces[k]
        moment = moment + moments[k] + cross_vectors(CHAIN.bodies[k].com, forces[k])
        torques[k] = CHAIN.joints[k].axis @ moment
    return torques


def newton_euler(slip: str = "") -> Equations:
    still, none = np.zeros(4), np.zeros(3)
    return Equations(
        mass_matrix=lambda q: np.stack(
            [balance(slip, q, still, each, none) for each in np.eye(4)], axis=1
        ),
        bias=lambda q, v: balance(slip, q, v, still, none),
        gravity=lambda q: balance(slip, q, still, still, CHAIN.gravity),
    )


def without_a_mass_in_one_entry() -> Case:
    """The tool's mass is left out of the slide's own inertia; or taken off the slide's mass."""
    robot = chains.robot(
        chains.urdf(
            chains.link("base"),
            chains.link("slide", chains.Solid(2.5, (0.1, 0, 0), (0.02, 0, 0, 0.03, 0, 0.04))),
            chains.link("tool", chains.Solid(0.7, (0.3, 0, 0), (0.01, 0, 0, 0.02, 0, 0.05))),
            chains.joint("x", "base", "slide", "prismatic", (1, 0, 0)),
            chains.joint("z", "slide", "tool"),
        )
    )
    right = robot_equations(robot, "links")
    own = right.mass_matrix
    return robot, replace(right, mass_matrix=lambda q: own(q) - np.diag([0.7, 0]))


def gravity_of_two_changes() -> Case:
    changes = body(3, com=mirror), body(2, mass=lambda m: 2.0 * m)
    wrong = of_another(SIX, changes)[1]
    return SIX, replace(robot_equations(SIX), gravity=wrong.gravity)


def noisy_gravity(noise: Callable[[Vector], Vector], level: str = "coupled") -> Case:
    right = robot_equations(SLIDING, level)
    own = right.gravity
    return SLIDING, replace(right, gravity=lambda q: own(q) + noise(q))


# Right equations in other coordinates.
SUMS = np.linalg.inv([[1.0, 0.0], [1.0, 1.0]])
DEGREES = np.pi / 180 * np.eye(2)


def written_in(
    own: Equations, jacobian: object, zero: float = 0.0, rates: object = None, rows: object = None
) -> Equations:
    """Equations of q as those of x, of which q = jacobian @ x, the first from zero [rad].

    rates: of q' = rates @ x', if not the same; rows: likewise, whose transpose turns the torques.
    """
    J = np.array(jacobian, dtype=float)
    moving, offset = (J if rates is None else np.array(rates)), zero * np.eye(len(J))[0]
    mass, bias, turned = own.mass_matrix, own.bias, (moving if rows is None else np.array(rows)).T
    written = Equations(
        lambda x: turned @ mass(J @ x + offset) @ moving,
        lambda x, v: turned @ bias(J @ x + offset, moving @ v),
    )
    if own.gravity is None:
        force = own.force

        def carried(x: Vector, v: Vector, torque: Vector) -> Vector:
            return torque + J.T @ force(J @ x, J @ v, 0 * torque)

        return replace(written, force=carried)
    weights = own.gravity
    return replace(written, gravity=lambda x: turned @ weights(J @ x + offset))


def accelerate(own: Equations) -> Equations:
    """The accelerations of M, bias and gravity, or force, alone."""

    def acceleration(q: Vector, v: Vector, torque: Vector) -> Vector:
        load = own.force(q, v, torque) if own.force else torque - own.gravity(q)
        return np.linalg.solve(own.mass_matrix(q), load - own.bias(q, v))

    return Equations(acceleration=acceleration)


IN_TWO = {
    name: written_in(robot_equations(TWO, level), *how)
    for name, (level, *how) in {
        "absolute angles": ("armature", SUMS),
        "the sense of j2 reversed": ("coupled", np.diag([1.0, -1.0])),
        "the order j2, j1": ("armature", np.eye(2)[::-1]),
        "angles in degrees": ("links", DEGREES, 0.0, np.eye(2)),
        "angles and rates in degrees": ("links", DEGREES),
        "angles of the motors": ("armature", np.eye(2) / 10),
    }.items()
}
VISCOUS = np.array([12.0, 3.0])
RUBBING = replace(
    TWO, joints=tuple(replace(j, friction=c) for j, c in zip(TWO.joints, VISCOUS, strict=True))
)


def held(factor: float) -> Equations:
    """Torques of a motion with so much of the file's friction."""
    return Equations(
        inverse_dynamics=lambda q, v, a: two_link.inverse_dynamics(q, v, a) + factor * VISCOUS * v
    )


RIGHT_ONES: dict[str, Case] = {
    "a double pendulum": (TWO, two_link.right()),
    "Newton and Euler's chain": (CHAIN, newton_euler()),
    "a stage": (STAGED, robot_equations(STAGED)),
    "absolute angles, as stated": (
        TWO,
        replace(IN_TWO["absolute angles"], coordinates=Coordinates(links="absolute")),
    ),
}
OF_TWO = {
    **PENDULUM,
    **{f"{name}, parts": own for name, own in IN_TWO.items()},
    **{f"{name}, acceleration": accelerate(own) for name, own in IN_TWO.items()},
}
CASES: dict[str, Callable[[], Case]] = {
    **{name: partial(of_another, *given) for name, given in OTHER_ROBOTS.items()},
    **{name: lambda own=own: (TWO, own) for name, own in OF_TWO.items()},
    **{name: lambda own=own: (TRUNK, own) for name, own in DERIVED.items()},
    "the order of six coordinates": lambda: (
        SIX,
        written_in(robot_equations(SIX), np.eye(6)[::-1]),
    ),
    "another zero": lambda: (
        TWO,
        written_in(robot_equations(TWO, "armature"), np.eye(2), np.pi / 2),
    ),
    "degrees but for torques": lambda: (
        TWO,
        written_in(robot_equations(TWO, "links"), DEGREES, rows=np.eye(2)),
    ),
    "another mass, no other coordinates": lambda: of_another(TWO, (body(1, mass=lambda m: 4.0),)),
    "two changes of the gravity alone": gravity_of_two_changes,
    "a mass left out of an entry": without_a_mass_in_one_entry,
    "what fits nothing": lambda: noisy_gravity(lambda q: 0.1 * np.sin(7 * q)),
    **{
        f"one large error, {level}": partial(noisy_gravity, lambda q: np.array([0, 1e4, 0]), level)
        for level in ("links", "armature", "coupled")
    },
    "a centre counted from the flange": lambda: (
        TURNED,
        other_link_b(com=PART_B.in_link.com + np.array([0.02, 0, 0.107])),
    ),
    "a mass of a link to which another is fixed": lambda: (TURNED, other_link_b(mass=2.9)),
    "R I": lambda: (TURNED, other_link_b(inertia=PART_B.turn @ STATED)),
    "I R'": lambda: (TURNED, other_link_b(inertia=STATED @ PART_B.turn.T)),
    "a slip on the way out": lambda: (CHAIN, newton_euler("out")),
    "a slip on the way back": lambda: (CHAIN, newton_euler("back")),
    "no friction": lambda: (RUBBING, held(0.0)),
    "friction that drives": lambda: (RUBBING, held(-1.0)),
    "friction twice": lambda: (RUBBING, held(2.0)),
}
