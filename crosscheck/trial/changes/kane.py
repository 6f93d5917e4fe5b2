"""The terms of each body that equations are summed up of by Kane's method: each may be wrong.

Of M what a body's translation and rotation make; of gravity its weight; of the bias what each
acceleration asks for, joint by joint and body by body, and the gyroscopic torques. Of an
acceleration what each motor, the weights and each product of two rates make of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot, cross, multiply, project
from crosscheck.models.robot.robot import BASE, Level, Placement, Robot, RobotBody, Rotor
from crosscheck.models.robot.urdf import read_urdf
from crosscheck.trial.changes.numbers import ALIKE, get_link_name
from crosscheck.trial.changes.problem import DynamicsTerms
from crosscheck.trial.robots.judge import RobotProblem
from crosscheck.trial.robots.rates import sample_bias_terms

SLOPE_STEP = 1e-5  # [rad, m], over which slopes of M are taken
LEAST_SHARE = 1e-5  # largest residual of the fitted slopes, over the largest difference
RATIO_POWERS = ("multiplied ", "'s square", 2), ("multiplied ", "", 1), ("divided ", "", -1)
MOST_TOGETHER = 200  # changes of the states that are tried at once
SIZABLE = 1e-9  # smallest piece that can be recognized, relative to an entry's size
USUAL = {0.0: "missing", -1.0: "with the opposite sign", 0.5: "half as large", 2.0: "twice"}
CHRISTOFFEL = {  # factors of M' v and of d(v' M v)/dq
    (1.0, 0.0): "without -1/2 d(v' M v)/dq: M' v alone",
    (1.0, 0.5): "with +1/2 d(v' M v)/dq for -1/2",
    (1.0, -1.0): "with d(v' M v)/dq without its factor 1/2",
    (0.0, -0.5): "without M' v: -1/2 d(v' M v)/dq alone",
    (0.5, -0.5): "with M' v half as large",
    (0.0, 0.5): "+1/2 d(v' M v)/dq alone, as of Christoffel's C transposed",
}
PLACE_INWARD = "the centripetal acceleration w x (w x r) of the place"
PLACE_ALONG = "the acceleration w' x r of the place"
Pieces = Mapping[str, np.ndarray]


class WorldBody(NamedTuple):
    """A body at states, in the base's axes: mass, centre (states, 3) from its origin, inertia."""

    mass: float
    lever: np.ndarray
    inertia: np.ndarray


class BodyPart(NamedTuple):
    """A link of the URDF as a part of a body.

    number: of the body; in_link: in the link's axes; placement: of the link in the body's frame,
    where fixed joints move it; turn (3, 3): of the axes in which the file has its inertia.
    """

    name: str
    number: int
    in_link: RobotBody
    placement: Placement
    turn: np.ndarray

    @property
    def body(self) -> RobotBody:
        """The part in the body's frame."""
        return self.carry(self.in_link)

    def carry(self, body: RobotBody) -> RobotBody:
        """A body in the link's axes, in the frame of the part's body."""
        R, place = self.placement.rotation, self.placement.position
        return RobotBody(body.mass, R @ body.com + place, R @ body.inertia @ R.T)


def list_body_parts(robot: Robot) -> list[BodyPart]:
    """The links of which the bodies are made, each as the URDF has it; else the bodies."""
    parts, made = list[BodyPart](), np.zeros(len(robot.bodies))
    for link in read_urdf(robot.urdf, robot.name).links:
        frame = robot.frames.get(link.name)
        if link.body is not None and frame is not None and frame.body != BASE:
            parts.append(BodyPart(link.name, frame.body, link.body, frame.placement, link.turn))
            made[frame.body] += link.body.mass
    is_whole = np.allclose(made, [body.mass for body in robot.bodies])
    return parts if is_whole else list_whole_bodies(robot)


def list_whole_bodies(robot: Robot) -> list[BodyPart]:
    """Each body as a part of itself."""
    here = Placement(np.eye(3), np.zeros(3))
    return [
        BodyPart(get_link_name(robot, number), number, body, here, np.eye(3))
        for number, body in enumerate(robot.bodies)
    ]


@dataclass(frozen=True)
class BodyMotion:
    """A body at states, in the base's axes, as Kane's sum takes it.

    moving, turning (states, 3, n): velocity of the centre and angular velocity per rate; inertia
    (states, 3, 3), also apart in I w' and in w x I w; centre, rate, growth (states, 3): its
    acceleration, w, w' at the rates; left_rate: w in w x I w where it is another one than in
    I w; pull (states, 3) or (3,): gravity.
    """

    mass: float
    moving: np.ndarray
    turning: np.ndarray
    inertia: np.ndarray
    growing_inertia: np.ndarray
    spinning_inertia: np.ndarray
    centre: np.ndarray
    rate: np.ndarray
    left_rate: np.ndarray
    growth: np.ndarray
    pull: np.ndarray

    def compute_terms(self) -> DynamicsTerms:
        """Contribution of the body to M, bias and gravity."""
        moving, turning = self.moving.swapaxes(1, 2), self.turning.swapaxes(1, 2)
        moment = multiply(self.growing_inertia, self.growth)
        moment = moment + cross(self.left_rate, multiply(self.spinning_inertia, self.rate))
        return DynamicsTerms(
            self.mass * moving @ self.moving + turning @ self.inertia @ self.turning,
            self.mass * project(self.moving, self.centre) + project(self.turning, moment),
            -self.mass * project(self.moving, np.broadcast_to(self.pull, self.centre.shape)),
        )


class KaneSum:
    """Kane's sum of a robot's bodies, in parts, at states q, v (states, n)."""

    def __init__(
        self, robot: Robot, q: np.ndarray, v: np.ndarray, parts: Sequence[BodyPart] = ()
    ) -> None:
        self.robot, self.v = robot, v
        self.parts = parts or list_whole_bodies(robot)
        self.poses, self.rates = AnalyticRobot(robot, "links").frames(q, v)

    def place_body(self, number: int, body: RobotBody) -> WorldBody:
        """A body with the pose that the body of a number has."""
        R = self.poses[number].rotation
        return WorldBody(body.mass, R @ body.com, R @ body.inertia @ R.swapaxes(1, 2))

    def move_body(self, number: int, body: WorldBody) -> BodyMotion:
        """A body in the place of the one of a number."""
        pose, rate = self.poses[number], self.rates[number]
        lever = body.lever
        centre = rate.acceleration + rotate_point(rate.angular, rate.angular_rate, lever)
        return BodyMotion(
            mass=body.mass,
            moving=self.move_point(number, lever),
            turning=pose.angular_partials,
            inertia=body.inertia,
            growing_inertia=body.inertia,
            spinning_inertia=body.inertia,
            centre=centre,
            rate=rate.angular,
            left_rate=rate.angular,
            growth=rate.angular_rate,
            pull=self.robot.gravity,
        )

    def compute_terms(self, number: int, body: WorldBody) -> DynamicsTerms:
        """The terms of a body in the place of the one of a number."""
        return self.move_body(number, body).compute_terms()

    def move_rotor(self, rotor: Rotor, level: Level) -> BodyMotion:
        """A rotor: at the level links without inertia, at armature as on the base."""
        frame, still = self.robot.frames[rotor.stator], np.zeros_like(self.poses[0].position)
        axis, turning = still + rotor.axis, 0 * self.poses[0].angular_partials
        w = dw = still
        if frame.body != BASE:
            pose, rate = self.poses[frame.body], self.rates[frame.body]
            axis = still + pose.rotation @ frame.placement.rotation @ rotor.axis
            if level == "coupled":
                turning, w, dw = pose.angular_partials, rate.angular, rate.angular_rate
        column = axis[:, :, None] * (rotor.ratio * self.robot.joint_map[0][rotor.joint])
        spin = multiply(column, self.v)
        inertia = rotor.inertia * (level != "links") * axis[:, :, None] * axis[:, None]
        return BodyMotion(
            mass=0.0,
            moving=0 * column,
            turning=turning + column,
            inertia=inertia,
            growing_inertia=inertia,
            spinning_inertia=inertia,
            centre=still,
            rate=w + spin,
            left_rate=w + spin,
            growth=dw + cross(w, spin),
            pull=self.robot.gravity,
        )

    def move_point(self, number: int, lever: np.ndarray) -> np.ndarray:
        """The velocity (states, 3, n) per rate of a point of a body, lever from its origin."""
        pose = self.poses[number]
        return pose.origin_partials + cross(pose.angular_partials, lever)

    def list_mass_pieces(self) -> dict[str, dict[str, np.ndarray]]:
        """Contribution of each body to M (states, n, n), by kind and link."""
        moves, turns = dict[str, np.ndarray](), dict[str, np.ndarray]()
        for link, number, body in ((each.name, each.number, each.body) for each in self.parts):
            mass, lever, inertia = self.place_body(number, body)
            moving, turning = self.move_point(number, lever), self.poses[number].angular_partials
            moves[link] = mass * moving.swapaxes(1, 2) @ moving
            turns[link] = turning.swapaxes(1, 2) @ inertia @ turning
        return {"the translation m Jv' Jv": moves, "the rotation Jw' I Jw": turns}

    def list_gravity_pieces(self) -> dict[str, dict[str, np.ndarray]]:
        """Contribution of each body's weight to gravity (states, n)."""
        weights = {
            link: self.compute_terms(number, self.place_body(number, body)).gravity
            for link, number, body in ((each.name, each.number, each.body) for each in self.parts)
        }
        return {"the weight": weights}

    def list_bias_pieces(self) -> dict[str, dict[str, np.ndarray]]:
        """Contribution of each acceleration and torque to the bias (states, n), by kind."""
        kinds: dict[str, dict[str, np.ndarray]] = {}
        for part in self.parts:
            link, number, body, place = part.name, part.number, part.body, part.placement.position
            mass, lever, inertia = self.place_body(number, body)
            rate, turning = self.rates[number], self.poses[number].angular_partials
            w, dw, moving = rate.angular, rate.angular_rate, mass * self.move_point(number, lever)
            at = self.poses[number].rotation @ place
            inward = cross(w, cross(w, lever - at))
            angular, centre = multiply(inertia, dw), project(moving, rotate_point(w, dw, lever))
            pieces = {
                "the gyroscopic torque w x I w": cross(w, multiply(inertia, w)),
                "the torque I w' of the angular acceleration": angular,
            }
            for kind, torque in pieces.items():
                kinds.setdefault(kind, {})[link] = project(turning, torque)
            parent = self.robot.joints[number].parent
            if parent != BASE:
                before = project(moving, self.rates[parent].acceleration)
                kind = "the acceleration that the link before hands on to the centre"
                kinds.setdefault(kind, {})[link] = before
            linear = {
                "the centripetal acceleration w x (w x c) of the centre": project(moving, inward),
                "the acceleration of the centre": centre + project(moving, rate.acceleration),
            }
            if place.any():
                linear[PLACE_INWARD] = project(moving, cross(w, cross(w, at)))
                linear[PLACE_ALONG] = project(moving, cross(dw, at))
            for kind, piece in linear.items():
                kinds.setdefault(kind, {})[link] = piece
        for number, joint in enumerate(self.robot.joints):
            for kind, piece in self._list_joint_pieces(number):
                kinds.setdefault(kind, {})[joint.name] = piece
        return kinds

    def _list_joint_pieces(self, number: int) -> Iterator[tuple[str, np.ndarray]]:
        """Bias caused by the accelerations that a joint adds to all bodies after it."""
        joint, pose = self.robot.joints[number], self.poses[number]
        on_base = joint.parent == BASE
        if on_base:
            return
        under = self.rates[joint.parent]
        at = pose.position - self.poses[joint.parent].position
        inward = cross(under.angular, cross(under.angular, at))
        yield PLACE_INWARD, self.load_joint(number, inward)
        along = cross(under.angular_rate, at)
        yield PLACE_ALONG, self.load_joint(number, along)
        extra = self.rates[number].acceleration - under.acceleration
        extra = extra - rotate_point(under.angular, under.angular_rate, at)
        if joint.kind == "prismatic":
            yield "the Coriolis acceleration 2 w x v", self.load_joint(number, extra)
            return
        gained = self.rates[number].angular_rate - under.angular_rate
        yield "the angular acceleration w x z q'", self.load_joint(number, 0 * gained, gained)

    def load_joint(
        self, first: int, linear: np.ndarray, angular: np.ndarray | None = None
    ) -> np.ndarray:
        """The forces (states, n) that accelerations (states, 3) of a joint and all after it take.

        angular: acceleration about the joint's place.
        """
        total = np.zeros_like(self.v)
        carried = {first}
        for number, body in enumerate(self.robot.bodies):
            if number != first and self.robot.joints[number].parent not in carried:
                continue
            carried.add(number)
            mass, lever, inertia = self.place_body(number, body)
            centre = linear
            if angular is not None:
                away = self.poses[number].position - self.poses[first].position + lever
                centre = centre + cross(angular, away)
                turning = self.poses[number].angular_partials
                total += project(turning, multiply(inertia, angular))
            total += mass * project(self.move_point(number, lever), centre)
        return total


def list_unturned_bodies(pose_rotation: np.ndarray, body: RobotBody) -> dict[str, WorldBody]:
    """A body whose numbers are not carried to the base's axes as they must be, by words."""
    R, back = pose_rotation, pose_rotation.swapaxes(1, 2)
    centre, inertia = R @ body.com, R @ body.inertia @ back
    fixed_centre = np.broadcast_to(body.com, centre.shape)
    fixed_inertia = np.broadcast_to(body.inertia, inertia.shape)
    carried = {
        "its inertia not turned with the link": (centre, fixed_inertia),
        "its inertia turned the other way, R' I R": (centre, back @ body.inertia @ R),
        "its inertia turned from one side alone, R I": (centre, R @ body.inertia),
        "its centre of mass not turned with the link": (fixed_centre, inertia),
        "its centre of mass turned the other way, R' c": (back @ body.com, inertia),
        "its centre of mass and inertia not turned with the link": (fixed_centre, fixed_inertia),
    }
    return {words: WorldBody(body.mass, *pair) for words, pair in carried.items()}


def describe_wrong_piece(difference: np.ndarray, pieces: Pieces, size: float, most: int) -> str:
    """The fewest pieces, at most `most`, that all are wrong by one factor, in words; '' for none.

    difference (k,): yours less right, at all states; pieces: what is right of each, alike.
    """
    there = {name: p for name, p in pieces.items() if np.abs(p).max() > SIZABLE * size}
    for count in range(1, most + 1):
        for names in combinations(there, count):
            total = sum((there[name] for name in names), np.zeros_like(difference))
            share = float(total @ difference / (total @ total)) if total.any() else 0.0
            left = np.abs(difference - share * total).max()
            if left <= ALIKE * np.abs(difference).max():
                return _describe_factor(names, 1 + share)
    return ""


def _describe_factor(names: Sequence[str], factor: float) -> str:
    makes = "makes" if len(names) == 1 else "make"
    return f"what {' and '.join(names)} {makes}: {_format_factor(factor)}"


def _format_factor(factor: float) -> str:
    usual = [words for by, words in USUAL.items() if abs(factor - by) < ALIKE]
    return usual[0] if usual else f"{factor:.6g} times as large"


def find_factors(difference: np.ndarray, pieces: Pieces, size: float) -> dict[str, float]:
    """Factors of pieces that are wrong, of all alike, of one, or of some; {} for none.

    difference (k,): yours less right, at all states; pieces: what is right of each.
    """
    there = {name: p.ravel() for name, p in pieces.items() if np.abs(p).max() > SIZABLE * size}
    names, allowed = list(there), ALIKE * np.abs(difference).max()
    groups = [names, *([name] for name in names)]
    for group in groups if names else ():
        total = np.sum([there[name] for name in group], axis=0)
        share = float(total @ difference / (total @ total))
        if np.abs(difference - share * total).max() <= allowed:
            return dict.fromkeys(group, 1 + share)
    if len(names) < 3:
        return {}
    columns = np.stack(list(there.values()), axis=1)
    fit, _, rank, _ = np.linalg.lstsq(columns, difference, rcond=1e-10)
    if rank < len(names) or np.abs(difference - columns @ fit).max() > allowed:
        return {}
    return {name: 1 + float(by) for name, by in zip(names, fit, strict=True) if abs(by) > ALIKE}


def describe_wrong_kinds(
    difference: np.ndarray, kinds: Mapping[str, Pieces], size: float, *, are_usual: bool
) -> Iterator[str]:
    """Kinds of pieces that, scaled by one common factor, explain the difference.

    All pieces of a kind come first, then the kinds with the fewest wrong pieces.
    are_usual: whether only usual factors count, since pieces that do not depend on the rates are
    often equal by chance.
    """
    described: list[tuple[int, str]] = []
    for kind, pieces in kinds.items():
        factors = find_factors(difference, pieces, size)
        names, factor = list(factors), next(iter(factors.values()), 1.0)
        unusual = all(abs(factor - by) > ALIKE for by in USUAL)
        if not names or np.ptp(list(factors.values())) > ALIKE or (are_usual and unusual):
            continue
        sizable = [name for name, p in pieces.items() if np.abs(p).max() > SIZABLE * size]
        whole = len(names) == len(sizable) > 1
        which = "every one" if whole else " and ".join(names)
        words = _describe_factor([f"{kind} of {which}"], factor)
        described.append((0 if whole else len(names), words))
    fewest = min((count for count, _ in described), default=0)
    yield from (words for count, words in described if count == fewest)


def list_acceleration_pieces(problem: RobotProblem, level: Level) -> dict[str, np.ndarray]:
    """Contribution of each motor, the weights and each product of rates to the accelerations."""
    states, names = problem.states, problem.names
    model = AnalyticRobot(problem.robot, level)
    inverse = np.linalg.inv(model.mass_matrix(states.q))
    forces = {"the weights": -model.gravity(states.q), "the springs": -problem.spring_torques}
    for number, name in enumerate(names):
        torque = np.zeros_like(states.torques)
        torque[:, number] = states.torques[:, number]
        forces[f"the torque of {name}"] = torque
    products = sample_bias_terms(model.bias, states).products
    for j, k in zip(*np.triu_indices(len(names)), strict=True):
        rates = f"{names[j]}'^2" if j == k else f"{names[j]}' {names[k]}'"
        forces[rates] = -products[:, :, j, k] * (states.v[:, j] * states.v[:, k])[:, None]
    return {name: np.einsum("sij,sj->si", inverse, each) for name, each in forces.items()}


def describe_pieces(
    problem: RobotProblem, level: Level, part: str, *, are_usual: bool = True
) -> Iterator[str]:
    """Sentences on terms of Kane's sum that are wrong in M, the bias or gravity.

    Of an acceleration, in the bias that it comes from.

    are_usual: whether by usual factors alone.
    """
    difference = problem.answers.values[part] - problem.reference_values[level][part]
    if part == "acceleration":
        mass = AnalyticRobot(problem.robot, level).mass_matrix(problem.states.q)
        difference, part = -np.einsum("sij,sj->si", mass, difference), "bias"
    robot, size = problem.robot, float(getattr(problem.sizes[level], part).max())
    described, parts, bodies = list[str](), list_body_parts(robot), list_whole_bodies(robot)
    merged = len(parts) > len(bodies) or any(part.placement.position.any() for part in parts)
    for each in (parts, bodies) if merged else (parts,):
        if described:
            break
        kane = KaneSum(robot, *problem.states[:2], each)
        kinds = {
            "mass_matrix": kane.list_mass_pieces,
            "bias": kane.list_bias_pieces,
            "gravity": kane.list_gravity_pieces,
        }[part]()
        described += describe_wrong_kinds(difference.ravel(), kinds, size, are_usual=are_usual)
    yield from (f"{part}, {words}" for words in described)


def describe_christoffel(problem: RobotProblem, level: Level) -> Iterator[str]:
    """The sentence on a bias that is M' v and d(v' M v)/dq with other factors than 1 and -1/2."""
    q, v = problem.states[:2]
    model = AnalyticRobot(problem.robot, level)
    slopes = np.stack(
        [
            (model.mass_matrix(q + step) - model.mass_matrix(q - step)) / (2 * SLOPE_STEP)
            for step in SLOPE_STEP * np.eye(q.shape[1])
        ]
    )
    user_values = problem.answers.values["bias"]
    wrong = np.abs(user_values - problem.reference_values[level]["bias"]).max(axis=0)
    allowed = LEAST_SHARE * wrong.max()
    columns = [
        np.einsum("ksij,sk,sj->si", slopes, v, v),
        np.einsum("isjk,sj,sk->si", slopes, v, v),
        np.einsum("jsij,sj->si", slopes, v**2),  # the same of squares of one rate
        np.einsum("isjj,sj->si", slopes, v**2),
    ]
    # Of one row alone that is wrong its products of rates say more.
    for count in (2, 4) if (wrong > allowed).sum() > 1 else (2,):
        matrix = np.stack([each.ravel() for each in columns[:count]], axis=1)
        fit, _, rank, _ = np.linalg.lstsq(matrix, user_values.ravel(), rcond=1e-8)
        factors = np.pad(np.rint(4 * fit) / 4, (0, 4 - count))  # as sums of Christoffel's are
        left = np.abs(matrix @ factors[:count] - user_values.ravel()).max()
        if rank == count and left <= allowed:
            products, squares = factors[:2], factors[:2] + factors[2:]
            words = CHRISTOFFEL.get(tuple(products), _describe_factors(products))
            if not np.array_equal(products, squares):
                right = "right" if tuple(squares) == (1.0, -0.5) else _describe_factors(squares)
                words = (
                    f"{_describe_factors(products)} in products of two rates, {right} in squares"
                )
            yield f"bias is M' v - 1/2 d(v' M v)/dq; yours is {words}"
            return


def _describe_factors(factors: np.ndarray) -> str:
    """Factors of M' v and d(v' M v)/dq in words."""
    named = zip(factors, ("M' v", "d(v' M v)/dq"), strict=True)
    return " and ".join(f"{by:g} {what}" for by, what in named if by) or "missing"


def describe_friction(
    problem: RobotProblem, level: Level, part: str, difference: np.ndarray
) -> Iterator[tuple[str, list[int]]]:
    """Sentences on friction that a force or bias has wrong, and the rows that it makes wrong.

    difference (states, n): yours less right, at the first states.
    """
    first = slice(len(difference))
    where, v = problem.answers.sources[part], problem.states.v[first]
    size = np.broadcast_to(problem.sizes[level].entry_sizes(part, where), problem.states.v.shape)
    # What is right of a bias that seems to have none has none either.
    is_there = part == "force" or where == "inverse_dynamics" or problem.answers.friction_in_bias
    ratios = {each.joint: each.ratio for each in problem.robot.rotors}
    rows_by_factor: dict[str, list[int]] = {}
    for row, name in enumerate(problem.names):
        friction, wrong = problem.friction[first, row], difference[:, row]
        friction = -friction if part == "force" else friction
        least = SIZABLE * float(size[:, row].max())
        if np.abs(wrong).max() <= least or np.abs(friction).max() <= least:
            continue
        share = float(wrong @ friction / (friction @ friction))
        if np.abs(wrong - share * friction).max() <= ALIKE * np.abs(wrong).max():
            ratio = abs(ratios.get(problem.robot.coordinates[row], 1.0))
            near = [
                f", {how}by its ratio{power}"
                for how, power, by in RATIO_POWERS
                if ratio != 1 and abs((is_there + share) / ratio**by - 1) < ALIKE
            ]
            factor = f"{_format_factor(is_there + share)}{''.join(near)}"
            rows_by_factor.setdefault(factor, []).append(row)
            continue
        laws = np.stack([v[:, row], np.sign(v[:, row])], axis=1)
        kinds = laws * np.linalg.lstsq(laws, friction, rcond=None)[0]
        for kind, taken in zip(("viscous", "Coulomb"), kinds.T, strict=True):
            for other, other_name in enumerate(problem.names):
                rate = v[:, other] if kind == "viscous" else np.sign(v[:, other])
                share = float((wrong + taken) @ rate / (rate @ rate))
                left = np.abs(wrong + taken - share * rate).max()
                if other != row and left <= ALIKE * np.abs(wrong).max():
                    law = f"its {kind} friction goes by the rate of {other_name}"
                    yield f"{where}[{name}]: {law}", [row]
    for factor, rows in rows_by_factor.items():
        names = [problem.names[row] for row in rows]
        entry = f"{where}[{names[0]}]" if len(names) == 1 else where
        yield f"{entry}, the friction of {' and '.join(names)}: {factor}", rows


def describe_coordinates(problem: RobotProblem, level: Level, part: str) -> Iterator[str]:
    """Sentences on a coordinate, or its rate, that M, bias or gravity takes for another one."""
    changes = list(_list_coordinate_changes(problem, by_rates=part == "bias"))
    q, v = (np.stack(each) for each in list(zip(*changes, strict=True))[1:])
    yield from (f"{part}: {changes[n][0]}" for n in _find_equals(problem, level, part, q, v))
    if part == "gravity":
        yield from _describe_small_angles(problem, level)
    yield from _describe_exchanges(problem, level, part)


def _find_equals(
    problem: RobotProblem, level: Level, part: str, q: np.ndarray, v: np.ndarray
) -> list[int]:
    """Numbers of the changed states (changes, states, n) that give the user's values of a part."""
    user_values = problem.answers.values[part]
    least = ALIKE * np.abs(user_values - problem.reference_values[level][part]).max()
    model, places = AnalyticRobot(problem.robot, level), list(range(len(q)))
    for states in (slice(1), slice(None)):
        equal = list[int]()
        for begin in range(0, len(places), MOST_TOGETHER):
            some = places[begin : begin + MOST_TOGETHER]
            rows = [each[some, states].reshape(-1, q.shape[2]) for each in (q, v)]
            values = model.bias(*rows) if part == "bias" else getattr(model, part)(rows[0])
            left = values.reshape(len(some), -1, *user_values.shape[1:]) - user_values[states]
            left += problem.spring_torques[states] if part == "gravity" else 0.0
            equal += [n for n, each in zip(some, left, strict=True) if np.abs(each).max() <= least]
        places = equal
    return places


def _list_coordinate_changes(
    problem: RobotProblem, *, by_rates: bool
) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Sentences' ends on one coordinate that is another, with q and v (states, n) so."""
    robot, names, (q, v) = problem.robot, problem.names, problem.states[:2]
    turning = [robot.joints[number].kind == "revolute" for number in robot.coordinates]
    for j, name in enumerate(names):
        old, rate = q[:, j], v[:, j]
        others = {"is left out in it": 0 * old, "is with the opposite sign in it": -old}
        others |= {"is twice in it": 2 * old, "is half in it": old / 2}
        if turning[j]:
            others |= {
                "is in degrees in it, read as radians": np.degrees(old),
                "is taken for degrees in it": np.radians(old),
                "is a quarter turn more in it": old + np.pi / 2,
                "is a quarter turn less in it": old - np.pi / 2,
                "is the opposite of itself, and a quarter turn more": np.pi / 2 - old,
                "is the opposite of itself, and a quarter turn less": -np.pi / 2 - old,
                "is half a turn more in it": old + np.pi,
            }
        for other, other_name in enumerate(names):
            if other != j and turning[other] == turning[j]:
                others |= {f"has {other_name} added in it": old + q[:, other]}
                others |= {f"has {other_name} taken from it in it": old - q[:, other]}
                others |= {f"is taken for {other_name} in it": q[:, other]}
        for words, values in others.items():
            changed = q.copy()
            changed[:, j] = values
            yield f"{name} {words}", changed, v
        rates = {"in degrees": 180 / np.pi, "taken for degrees": np.pi / 180}
        for words, by in rates.items() if by_rates and turning[j] else ():
            changed = v.copy()
            changed[:, j] = by * rate
            yield f"the rate of {name} is {words} in it", q, changed


def _describe_small_angles(problem: RobotProblem, level: Level) -> Iterator[str]:
    """Sentences on a gravity in which sines of one angle, or of all, are the angles."""
    robot, q = problem.robot, problem.states.q
    gravity = AnalyticRobot(robot, level).gravity
    user_values = problem.answers.values["gravity"] - problem.spring_torques
    least = ALIKE * np.abs(user_values - gravity(q)).max()
    # Gravity is a sum of waves of each angle, so that four angles determine its slope at 0.
    turning = [n for n, c in enumerate(robot.coordinates) if robot.joints[c].kind == "revolute"]

    def put(values: np.ndarray, angles: Sequence[int], by: float) -> np.ndarray:
        changed = values.copy()
        changed[:, angles] = by
        return changed

    still, linear = put(q, turning, 0.0), 0 * q
    constant = gravity(still)
    for j in turning:
        slopes = []
        for base in (put(q, [j], 0.0), still):
            turns = [put(base, [j], by) for by in (np.pi / 2, -np.pi / 2, 0.0, np.pi)]
            at = np.split(gravity(np.concatenate(turns)), len(turns))
            slopes.append((at[0] - at[1]) / 2 * q[:, [j]])
            if base is not still:
                middle, wave = (at[2] + at[3]) / 2, (at[2] - at[3]) / 2
                for words, cosine in (("1", 1.0), ("1 - x^2/2", 1 - q[:, [j]] ** 2 / 2)):
                    if np.abs(middle + wave * cosine + slopes[0] - user_values).max() <= least:
                        name = problem.names[j]
                        yield f"gravity: the sine of {name} is {name} and its cosine {words}"
        linear += slopes[1]
    if np.abs(constant + linear - user_values).max() <= least:
        yield "gravity: linear in the angles, as it is near 0 alone"


def _describe_exchanges(problem: RobotProblem, level: Level, part: str) -> Iterator[str]:
    """Sentences on two coordinates whose rows, or whose values, a part has exchanged."""
    right, user_values = problem.reference_values[level][part], problem.answers.values[part]
    q, v = problem.states[:2]
    least = ALIKE * np.abs(user_values - right).max()
    pairs = list(combinations(range(len(problem.names)), 2))
    orders = np.tile(np.arange(len(problem.names)), (len(pairs), 1))
    for order, (i, j) in zip(orders, pairs, strict=True):
        order[[i, j]] = j, i
    moved, kept = q[:, orders].swapaxes(0, 1), np.broadcast_to(q, (len(pairs), *q.shape))
    rates = np.broadcast_to(v, kept.shape)
    equal = {"coordinates": _find_equals(problem, level, part, moved, rates)}
    if part == "bias":
        equal["rates"] = _find_equals(problem, level, part, kept, v[:, orders].swapaxes(0, 1))
    for number, (order, (i, j)) in enumerate(zip(orders, pairs, strict=True)):
        rows = right[:, order]
        exchanged = {"rows": rows}
        if part == "mass_matrix":
            exchanged |= {"columns": right[:, :, order], "rows and columns": rows[:, :, order]}
        exchanged |= {what: user_values for what, numbers in equal.items() if number in numbers}
        for what, values in exchanged.items():
            if np.abs(values - user_values).max() <= least:
                pair = f"{problem.names[i]} and {problem.names[j]}"
                yield f"{part}: the {what} of {pair} are exchanged in it"


def describe_solution(problem: RobotProblem, level: Level) -> Iterator[str]:
    """Sentences on accelerations of the right M, bias and gravity that are put together wrongly."""
    q, v, _, torques = problem.states
    model, user_values = AnalyticRobot(problem.robot, level), problem.answers.values["acceleration"]
    mass, bias, gravity = model.terms(q, v)
    gravity = gravity + problem.spring_torques
    load = torques - bias - gravity
    diagonal = np.einsum("sii->si", mass)
    with np.errstate(divide="ignore", invalid="ignore"):
        entries = multiply(np.where(mass, 1 / mass, 0.0), load)
    inverse = np.linalg.inv(mass)
    least = ALIKE * np.abs(user_values - problem.reference_values[level]["acceleration"]).max()
    for words, values in (
        ("by M's diagonal alone, without coupling", load / diagonal),
        ("by the diagonal of M^-1 alone", np.einsum("sii->si", inverse) * load),
        ("by the inverse of each entry of M", entries),
        ("without M^-1", load),
        ("by M where M^-1 belongs", multiply(mass, load)),
        ("with M's lower triangle alone", multiply(np.linalg.inv(np.tril(mass)), load)),
        ("with M's upper triangle alone", multiply(np.linalg.inv(np.triu(mass)), load)),
        ("with gravity outside M^-1", multiply(inverse, load + gravity) - gravity),
        ("with the bias outside M^-1", multiply(inverse, load + bias) - bias),
        ("with the torques outside M^-1", multiply(inverse, load - torques) + torques),
        ("with the opposite sign", -multiply(inverse, load)),
    ):
        if np.abs(values - user_values).max() <= least:
            yield f"acceleration is M^-1 (torques - bias - gravity); yours is {words}"


def describe_accelerations(
    problem: RobotProblem, level: Level, rows: Sequence[int]
) -> Iterator[str]:
    """Sentences on rows of an acceleration in which one or two pieces are wrong by a factor."""
    user_values, right = (
        values["acceleration"]
        for values in (problem.answers.values, problem.reference_values[level])
    )
    difference = user_values - right
    pieces, sizes = list_acceleration_pieces(problem, level), problem.sizes[level].acceleration
    described = False
    for row in rows:
        of_row = {name: piece[:, row] for name, piece in pieces.items()}
        words = describe_wrong_piece(difference[:, row], of_row, float(sizes[:, row].max()), 2)
        if words:
            described = True
            yield f"acceleration[{problem.names[row]}], {words}"
    ratios = user_values / right
    if not described and len(rows) > 1 and np.ptp(ratios, axis=1).max() <= ALIKE * ratios.max():
        yield (
            "acceleration: at each state all rows are wrong by the same factor, from"
            f" {ratios.min():.4g} to {ratios.max():.4g}: their common denominator, M's determinant"
        )


def rotate_point(w: np.ndarray, dw: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """The acceleration (states, 3) of the end of an arm by turning about its begin."""
    turned: np.ndarray = cross(dw, arm) + cross(w, cross(w, arm))
    return turned
