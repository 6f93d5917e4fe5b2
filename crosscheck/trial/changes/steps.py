"""Kane's sum with one thing taken for another in one place: for each body, joint, rotor, or some.

A part of the equations is a sum over bodies, each contributing by its motion. So a mistake is
identified by the bodies at which it is made: their contributions add up to the difference.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from crosscheck.analytic.robot.model import cross
from crosscheck.models.robot.robot import BASE, Joint, RobotBody
from crosscheck.trial.changes.kane import FACTORS, BodyMotion, KaneSum, WorldBody
from crosscheck.trial.changes.mistakes import BodyPart, list_part_mistakes
from crosscheck.trial.changes.problem import DynamicsTerms

ITS_JOINT = "its own joint"
# A joint left out of a body's motion, and what a body is without all of them.
WITHOUT = {
    "{} left out of its Jacobian": "left out",
    "{} left out of its centre's velocity": "left out, but for its inertia about its centre",
    "{} left out of its angular velocity": "its inertia about its centre left out",
}
Steps = dict[str, dict[str, DynamicsTerms]]  # changes of the terms, by words and what has them


class StepTable:
    """Effect of every mistake in Kane's sum of a robot, by the body or joint where it is made.

    parts: links, or bodies of several links fixed together, in whose names suffix is appended.
    """

    def __init__(self, kane: KaneSum, parts: Sequence[BodyPart], suffix: str = "") -> None:
        self.kane, self.robot, self.still = kane, kane.robot, kane.still
        self.parts = {f"{part.name}{suffix}": part for part in parts}
        self._rights = {
            name: kane.move_body(part.number, kane.place_body(part.number, part.body))
            for name, part in self.parts.items()
        }
        self._terms = {name: motion.compute_terms() for name, motion in self._rights.items()}
        self._changed = {name: self._list_changed(part) for name, part in self.parts.items()}

    def list_body_steps(self) -> Steps:
        """What the numbers of a link may be taken for, wherever they stand."""
        steps: Steps = {}
        for name, changed in self._changed.items():
            for words, body in changed.items():
                motion = self.kane.move_body(self.parts[name].number, body)
                steps.setdefault(words, {})[name] = motion.compute_terms().minus(self._terms[name])
        return steps

    def list_steps(self) -> Steps:
        """All that may be mistaken in one place of the sum alone."""
        steps: Steps = {}
        for name, part in self.parts.items():
            right = self._rights[name]
            for words, changed in (*_list_weights(right), *self._list_rates(part, right)):
                steps.setdefault(words, {})[name] = changed.compute_terms().minus(self._terms[name])
        self._add_column_steps(steps)
        return steps

    def _list_changed(self, part: BodyPart) -> dict[str, WorldBody]:
        """By words, what a part may be taken for, or what of it is not turned as it must be."""
        changed = {
            words: self.kane.place_body(part.number, body)
            for words, body in list_part_mistakes(self.robot, part).items()
        }
        pose = self.kane.poses[part.number].rotation
        turn, shift = pose @ part.placement.rotation, pose @ part.placement.position
        unturned = _list_unturned(turn, part.in_link).items()
        return changed | {w: b._replace(lever=b.lever + shift) for w, b in unturned}

    def _list_rates(self, part: BodyPart, right: BodyMotion) -> Iterator[tuple[str, BodyMotion]]:
        """Other rates than w of a part in its gyroscopic torque."""
        rates, parent = self.kane.rates, self.robot.joints[part.number].parent
        before = self.still if parent == BASE else rates[parent].angular
        torque = "gyroscopic torque w x I w"
        yield f"its {torque} missing", replace(right, rate=self.still)
        for words, rate in (
            ("w of the first link", rates[0].angular),
            ("the joint's own rate", right.rate - before),
            ("w of the link before", before),
        ):
            of = f"in the {torque}: {words}"
            yield f"{of} in both places", replace(right, rate=rate, left_rate=rate)
            yield f"{of} on the left", replace(right, left_rate=rate)
            yield f"{of} on the right, in I w", replace(right, rate=rate)

    def _add_column_steps(self, steps: Steps) -> None:
        """Add columns of Jacobians that are wrong: a joint's for bodies after it, or a body's own.

        A body's terms are no sum over its columns, so that of these all are wrong or one is.
        """
        whole: dict[str, dict[str, BodyMotion]] = {}
        last_columns: Steps = {}
        share = self.robot.joint_map[0]
        for number, joint in enumerate(self.robot.joints):
            after = self.kane.list_after(number)
            for name, part in self.parts.items():
                if part.number not in after:
                    continue
                right, terms = self._rights[name], self._terms[name]
                lever = self.kane.place_body(part.number, part.body).lever
                point = self.kane.poses[part.number].position + lever
                for words, moving, turning in self._list_columns(number, joint, point):
                    columns = [each[:, :, None] * share[number] for each in (moving, turning)]
                    changed = _add_columns(right, *columns).compute_terms().minus(terms)
                    steps.setdefault(words.format(f"joint {joint.name}"), {})[name] = changed
                    if part.number == number:
                        last_columns.setdefault(words.format(ITS_JOINT), {})[name] = changed
                    motions = whole.setdefault(words, {})
                    motions[name] = _add_columns(motions.get(name, right), *columns)
        steps |= last_columns
        slides = any(joint.kind != "revolute" for joint in self.robot.joints)
        without = {} if slides else WITHOUT  # a joint that slides has no column in w
        for words, motions in whole.items():
            steps[without.get(words, words.format("every joint"))] = {
                name: motion.compute_terms().minus(self._terms[name])
                for name, motion in motions.items()
            }

    def _list_columns(
        self, number: int, joint: Joint, point: np.ndarray
    ) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
        """Changes (states, 3) of the velocity of a point and of w, per rate of a joint."""
        pose, still = self.kane.poses[number], self.still
        axis, arm = pose.rotation @ joint.axis, point - pose.position
        is_turning = joint.kind == "revolute"
        moving, turning = (cross(axis, arm), axis) if is_turning else (axis, still)
        whole, centre, spin = WITHOUT
        yield whole, -moving, -turning
        if is_turning:
            yield centre, -moving, still
            yield spin, still, -turning
        off = still + joint.axis - axis
        changes = (cross(off, arm), off) if is_turning else (off, still)
        yield "the axis of {} in its Jacobian not turned to the base's axes", *changes


def _list_weights(right: BodyMotion) -> Iterator[tuple[str, BodyMotion]]:
    """Each body whose weight has a factor other than 1."""
    for by, words in FACTORS.items():
        yield f"its weight {words}", replace(right, pull=by * right.pull)


def _list_unturned(R: np.ndarray, body: RobotBody) -> dict[str, WorldBody]:
    """A body whose numbers are not carried to the base's axes as they must be, by words."""
    back, c = R.swapaxes(1, 2), body.com
    centre, inertia = R @ c, _turn(R, body.inertia)
    fixed_centre = np.broadcast_to(c, centre.shape)
    fixed = np.broadcast_to(body.inertia, inertia.shape)
    carried = {
        "its inertia not turned with the link": (centre, fixed),
        "its inertia turned the other way, R' I R": (centre, _turn(back, body.inertia)),
        "its inertia turned from one side alone, R I": (centre, R @ body.inertia),
        "its centre of mass not turned with the link": (fixed_centre, inertia),
        "its centre of mass turned the other way, R' c": (back @ c, inertia),
        "its centre of mass and inertia not turned with the link": (fixed_centre, fixed),
    }
    return {words: WorldBody(body.mass, *pair) for words, pair in carried.items()}


def _turn(rotation: np.ndarray, inertia: np.ndarray) -> np.ndarray:
    """R I R'."""
    return rotation @ inertia @ np.swapaxes(rotation, -1, -2)


def _add_columns(motion: BodyMotion, moving: np.ndarray, turning: np.ndarray) -> BodyMotion:
    return replace(motion, moving=motion.moving + moving, turning=motion.turning + turning)
