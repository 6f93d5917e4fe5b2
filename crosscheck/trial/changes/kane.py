"""Kane's sum of a robot's bodies and rotors, in parts, of which each may be wrong.

Of M what a body's translation and rotation make; of gravity its weight; of the bias what each
acceleration asks for, joint by joint and body by body, and the gyroscopic torques.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot, cross, multiply, project
from crosscheck.models.robot.robot import BASE, Robot, RobotBody
from crosscheck.trial.changes.mistakes import BodyPart, list_whole_bodies
from crosscheck.trial.changes.problem import DynamicsTerms

FACTORS = {0: "missing", -1: "with the opposite sign", 0.5: "half as large", 2: "twice as large"}
Pieces = dict[str, dict[str, np.ndarray]]  # by kind and by the body or joint that has them


class WorldBody(NamedTuple):
    """A body at states, in the base's axes: mass, centre (states, 3) from its origin, inertia."""

    mass: float
    lever: np.ndarray
    inertia: np.ndarray


@dataclass(frozen=True)
class BodyMotion:
    """A body at states, in the base's axes, as Kane's sum takes it.

    moving, turning (states, 3, n): velocity of the centre and angular velocity per rate; inertia
    (states, 3, 3); centre, rate, growth (states, 3): its acceleration, w, w' at the rates;
    left_rate: w in w x I w where it is another one than in I w; pull (3,): gravity.
    """

    mass: float
    moving: np.ndarray
    turning: np.ndarray
    inertia: np.ndarray
    centre: np.ndarray
    rate: np.ndarray
    left_rate: np.ndarray
    growth: np.ndarray
    pull: np.ndarray

    def compute_terms(self) -> DynamicsTerms:
        """Contribution of the body to M, bias and gravity."""
        moving, turning = self.moving.swapaxes(1, 2), self.turning.swapaxes(1, 2)
        moment = multiply(self.inertia, self.growth)
        moment = moment + cross(self.left_rate, multiply(self.inertia, self.rate))
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
        self.robot, self.q, self.v = robot, q, v
        self.parts = parts or list_whole_bodies(robot)
        self.poses, self.rates = AnalyticRobot(robot, "links").frames(q, v)
        self.still = np.zeros_like(self.poses[0].position)

    def place_body(self, number: int, body: RobotBody) -> WorldBody:
        """A body with the pose that the body of a number has."""
        R = self.poses[number].rotation
        return WorldBody(body.mass, R @ body.com, R @ body.inertia @ R.swapaxes(1, 2))

    def move_body(self, number: int, body: WorldBody) -> BodyMotion:
        """A body in the place of the one of a number."""
        pose, rate = self.poses[number], self.rates[number]
        centre = rate.acceleration + rotate_point(rate.angular, rate.angular_rate, body.lever)
        return BodyMotion(
            body.mass,
            self.move_point(number, body.lever),
            pose.angular_partials,
            body.inertia,
            centre,
            rate.angular,
            rate.angular,
            rate.angular_rate,
            self.robot.gravity,
        )

    def move_point(self, number: int, lever: np.ndarray) -> np.ndarray:
        """The velocity (states, 3, n) per rate of a point of a body, lever from its origin."""
        pose = self.poses[number]
        return pose.com_partials + cross(pose.angular_partials, lever - pose.com_lever)

    def list_pieces(self, part: str) -> Pieces:
        """Contributions to mass_matrix (states, n, n), or to bias or gravity (states, n)."""
        kinds: Pieces = {}
        for each in self.parts:
            for kind, piece in self._list_body_pieces(part, each):
                kinds.setdefault(kind, {})[each.name] = piece
        for number, joint in enumerate(self.robot.joints if part == "bias" else ()):
            for kind, piece in self._list_joint_pieces(number):
                kinds.setdefault(kind, {})[joint.name] = piece
        return kinds

    def _list_body_pieces(self, part: str, body: BodyPart) -> Iterator[tuple[str, np.ndarray]]:
        number, place = body.number, body.placement.position
        world = self.place_body(number, body.body)
        mass, lever, inertia = world
        turning, moving = self.poses[number].angular_partials, self.move_point(number, lever)
        if part == "mass_matrix":
            yield "the translation m Jv' Jv", mass * moving.swapaxes(1, 2) @ moving
            yield "the rotation Jw' I Jw", turning.swapaxes(1, 2) @ inertia @ turning
            return
        if part == "gravity":
            yield "the weight", self.move_body(number, world).compute_terms().gravity
            return
        rate, moving = self.rates[number], mass * moving
        w, dw = rate.angular, rate.angular_rate
        at = self.poses[number].rotation @ place
        yield "the gyroscopic torque w x I w", project(turning, cross(w, multiply(inertia, w)))
        growing = project(turning, multiply(inertia, dw))
        yield "the torque I w' of the angular acceleration", growing
        centripetal = project(moving, cross(w, cross(w, lever - at)))
        yield "the centripetal acceleration w x (w x c) of the centre", centripetal
        whole = project(moving, rotate_point(w, dw, lever) + rate.acceleration)
        yield "the acceleration of the centre", whole

    def _list_joint_pieces(self, number: int) -> Iterator[tuple[str, np.ndarray]]:
        """Bias caused by the accelerations that a joint adds to all bodies after it."""
        joint, pose = self.robot.joints[number], self.poses[number]
        if joint.parent == BASE:
            return
        under = self.rates[joint.parent]
        at = pose.position - self.poses[joint.parent].position
        if joint.kind == "prismatic":
            extra = self.rates[number].acceleration - under.acceleration
            extra = extra - rotate_point(under.angular, under.angular_rate, at)
            yield "the Coriolis acceleration 2 w x v", self.load_joint(number, extra)
            return
        gained = self.rates[number].angular_rate - under.angular_rate
        yield "the angular acceleration w x z q'", self.load_joint(number, self.still, gained)

    def load_joint(
        self, first: int, linear: np.ndarray, angular: np.ndarray | None = None
    ) -> np.ndarray:
        """The forces (states, n) that accelerations (states, 3) of a joint and all after it take.

        angular: acceleration about the joint's place.
        """
        total = np.zeros_like(self.v)
        for number in sorted(self.list_after(first)):
            mass, lever, inertia = self.place_body(number, self.robot.bodies[number])
            centre = linear
            if angular is not None:
                away = self.poses[number].position - self.poses[first].position + lever
                centre = centre + cross(angular, away)
                turning = self.poses[number].angular_partials
                total += project(turning, multiply(inertia, angular))
            total += mass * project(self.move_point(number, lever), centre)
        return total

    def list_after(self, number: int) -> set[int]:
        """The bodies that a joint moves."""
        after = {number}
        for other, joint in enumerate(self.robot.joints):
            if joint.parent in after:
                after.add(other)
        return after


def rotate_point(w: np.ndarray, dw: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """The acceleration (states, 3) of the end of an arm by turning about its begin."""
    return cross(dw, arm) + cross(w, cross(w, arm))
