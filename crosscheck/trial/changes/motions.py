"""Kane's sum with one thing taken for another in one place: for each body, joint, rotor, or some.

A part of the equations is a sum over bodies, each contributing by its motion. So a mistake is
identified by the bodies at which it is made: their contributions add up to the difference.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace

import numpy as np

from crosscheck.analytic.robot.model import cross
from crosscheck.models.robot.robot import BASE, Joint, Level
from crosscheck.trial.changes.exchanges import list_spinners
from crosscheck.trial.changes.kane import (
    USUAL,
    BodyMotion,
    BodyPart,
    DynamicsTerms,
    KaneSum,
    WorldBody,
    rotate_point,
)
from crosscheck.trial.changes.numbers import AXES

BOTH = "", " in its Jacobian alone", " in its acceleration alone"
MOST_PLACES = 8  # joints, about whose places each column of a Jacobian is tried
SLIDES = {  # whether a joint that slides turns w, and w'
    "its z q' added to w and w x z q' to w', as of a joint that turns": (True, True),
    "its z q' added to w, as of a joint that turns": (True, False),
    "its w x z q' added to w', as of a joint that turns": (False, True),
}
TORQUES = " in I w' alone", " in w x I w alone"


Changes = Iterator[tuple[str, BodyMotion]]
ByPlace = Mapping[str, DynamicsTerms]  # changes of the terms by the body or joint that has them


class MotionTable:
    """Effect of every mistake in Kane's sum of a robot, by the body or joint where it is made.

    changed_bodies: by name a link and what its numbers may be taken for; only: the mistakes in
    words that are asked for, None for all.
    """

    def __init__(
        self,
        kane: KaneSum,
        changed_bodies: Mapping[str, tuple[BodyPart, Mapping[str, WorldBody]]],
        only: Collection[str] | None,
    ) -> None:
        self.kane, self.robot = kane, kane.robot
        self._changed_bodies, self._only = changed_bodies, only
        self._still = np.zeros_like(kane.poses[0].position)

    def list_changes(self) -> Iterator[tuple[str, ByPlace]]:
        """Each mistake in words, with what it changes at each body or joint."""
        kinds: dict[str, dict[str, DynamicsTerms]] = {}
        for name, (part, changed) in self._changed_bodies.items():
            body = self.kane.place_body(part.number, part.body)
            right = self.kane.move_body(part.number, body)
            terms = right.compute_terms()
            for words, motion in self._list_body_changes(part, body, right, changed):
                self._add(kinds, words, name, motion, terms)
        yield from kinds.items()
        yield from self._list_joint_changes()
        yield from self._list_column_changes(
            {name: part for name, (part, _) in self._changed_bodies.items()}
        )

    def list_rotor_changes(self, level: Level) -> dict[str, dict[str, DynamicsTerms]]:
        """The same of rotors at a level."""
        kinds: dict[str, dict[str, DynamicsTerms]] = {}
        for name, rotor in list_spinners(self.robot) if level != "links" else ():
            number = self.robot.frames[rotor.stator].body
            motion = self.kane.move_rotor(rotor, level)
            terms = motion.compute_terms()
            for words, changed_motion in (
                *_list_factors(motion),
                *self._list_rate_changes(number, motion, self._still),
                *self._list_spin_changes(number, motion, level),
            ):
                self._add(kinds, words, f"rotor of {name}", changed_motion, terms)
        return kinds

    def _add(
        self,
        kinds: dict[str, dict[str, DynamicsTerms]],
        words: str,
        name: str,
        motion: BodyMotion,
        right: DynamicsTerms,
    ) -> None:
        """Add what a motion changes of the right terms, if its words are asked for."""
        if self._only is None or words in self._only:
            kinds.setdefault(words, {})[name] = motion.compute_terms().minus(right)

    def _list_body_changes(
        self, part: BodyPart, body: WorldBody, right: BodyMotion, changed: Mapping[str, WorldBody]
    ) -> Changes:
        yield from _list_factors(right)
        number = part.number
        joint, pose = self.robot.joints[number], self.kane.poses[number]
        under = self.kane.poses[joint.parent].rotation if joint.parent != BASE else np.eye(3)
        before, lever = self._before(number), body.lever
        turned = under @ joint.placement.rotation
        levers = {
            "its centre of mass without the place of its joint": lever - pose.position + before[0],
            "its centre of mass in the axes of the link before": self._still
            + under @ part.body.com,
            "its centre of mass not turned by its joint": self._still + turned @ part.body.com,
            "its centre of mass at its joint": self._still,
        }
        for name, axis in zip(AXES, np.eye(3), strict=True):
            mirrored = replace(part.in_link, com=part.in_link.com * (1 - 2 * axis))
            words = f"{name} of its centre of mass with the opposite sign"
            levers[words] = self.kane.place_body(number, part.carry(mirrored)).lever
        for words, at in levers.items():
            yield from self._place(words, number, right, at, BOTH)
        for by, words in ((by, USUAL[by]) for by in (-1.0, 0.5)):
            scaled = WorldBody(by * body.mass, lever, by * body.inertia)
            yield f"what it makes {words}", self.kane.move_body(number, scaled)
        for words, other in changed.items():
            yield words, self.kane.move_body(number, other)
            if not np.array_equal(other.lever, lever):
                yield from self._place(words, number, right, other.lever, BOTH[1:])
        for other_number, other_joint in enumerate(self.robot.joints):
            if other_number == joint.parent or other_joint.parent == number:
                beside = self.robot.bodies[other_number]
                motion = self.kane.move_body(
                    other_number, self.kane.place_body(other_number, beside)
                )
                words = f"its mass at the centre of {self._link(other_number)}"
                yield words, replace(right, moving=motion.moving, centre=motion.centre)
        link_inertia, axis = part.body.inertia, pose.rotation @ joint.axis
        square = body.mass * (lever * lever).sum(axis=1)[:, None, None] * np.eye(3)
        about = np.einsum("si,sij,sj->s", axis, body.inertia, axis)[:, None, None]
        inertias = {
            "its inertia in the axes of the link before": under
            @ link_inertia
            @ np.swapaxes(under, -1, -2),
            "its inertia not turned by its joint": turned
            @ link_inertia
            @ np.swapaxes(turned, -1, -2),
            "m |c|^2 added to its inertia about every axis": body.inertia + square,
            "m |c|^2 taken from its inertia about every axis": body.inertia - square,
            "its inertia about its joint's axis alone": about * axis[:, :, None] * axis[:, None],
        }
        for words, inertia in inertias.items():
            yield words, _put_inertia(right, np.broadcast_to(inertia, body.inertia.shape))
        inertias |= {w: b.inertia for w, b in changed.items() if b.mass == body.mass}
        bodies = self.robot.bodies
        for words, neighbour in (("before", number - 1), ("after", (number + 1) % len(bodies))):
            # By an index that is one off, with that of the last link before the first one.
            inertias[f"the inertia of the link {words} it"] = (
                pose.rotation @ bodies[neighbour].inertia @ pose.rotation.swapaxes(1, 2)
            )
        for words, inertia in inertias.items():
            yield f"{words}{TORQUES[0]}", replace(right, growing_inertia=inertia)
            yield f"{words}{TORQUES[1]}", replace(right, spinning_inertia=inertia)
        yield from self._list_rate_changes(number, right, lever)
        R, g = pose.rotation, self.robot.gravity
        for words, pull in (
            ("in the link's own axes, not turned", R @ g),
            ("turned the other way", R @ R @ g),
            ("turned as from the link's axes to the base's", R.swapaxes(1, 2) @ g),
        ):
            yield f"gravity's direction {words}", replace(right, pull=pull)

    def _place(
        self, words: str, number: int, right: BodyMotion, lever: np.ndarray, places: tuple[str, ...]
    ) -> Changes:
        """A centre of mass that is another one in Jacobian, acceleration or both."""
        rate = self.kane.rates[number]
        centre = rate.acceleration + rotate_point(rate.angular, rate.angular_rate, lever)
        moving = self.kane.move_point(number, lever)
        for place in places:
            changed = right
            if place != BOTH[2]:
                changed = replace(changed, moving=moving)
            if place != BOTH[1]:
                changed = replace(changed, centre=centre)
            yield words + place, changed

    def _before(self, number: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Place, w, w' and acceleration (states, 3) of the link before a body."""
        parent = self.robot.joints[number].parent if number != BASE else BASE
        if parent == BASE:
            return (self._still,) * 4
        return self.kane.poses[parent].position, *self.kane.rates[parent]

    def _link(self, number: int) -> str:
        return next(name for name, frame in self.robot.frames.items() if frame.body == number)

    def _list_rate_changes(self, number: int, right: BodyMotion, lever: np.ndarray) -> Changes:
        """Other rates of a body in its acceleration, in its torque, or in both."""
        _, before, growth_before, place_before = self._before(number)
        w, dw = right.rate, right.growth
        first = self.kane.rates[0].angular
        base = right.centre - rotate_point(w, dw, lever)
        at = replace(right, centre=right.centre - base + place_before)
        yield "the acceleration of the place of the joint before for that of its own", at
        for words, rate, growth in (
            ("w and w' of the link before", before, growth_before),
            ("w of the link before", before, dw),
            ("w' of the link before", w, growth_before),
            ("its joint's own rate for w", w - before, dw),
            ("w of the first link", first, dw),
            ("w' left out", w, 0 * dw),
            ("w left out", 0 * w, dw),
        ):
            centre = base + rotate_point(rate, growth, lever)
            torque = replace(right, rate=rate, left_rate=rate, growth=growth)
            yield words, replace(torque, centre=centre)
            yield f"{words}, in the acceleration of its centre alone", replace(right, centre=centre)
            if not words.endswith("left out"):  # which is a torque that is missing
                yield f"{words}, in its torque alone", torque
        gyroscopic = "in the gyroscopic torque w x I w"
        for words, rate in (
            ("w of the first link", first),
            ("the joint's own rate", w - before),
            ("w of the link before", before),
        ):
            yield f"{gyroscopic}: {words} in both places", replace(right, rate=rate, left_rate=rate)
            yield f"{gyroscopic}: {words} on the left", replace(right, left_rate=rate)
            yield f"{gyroscopic}: {words} on the right, in I w", replace(right, rate=rate)

    def _list_spin_changes(self, number: int, right: BodyMotion, level: Level) -> Changes:
        """A rotor whose own turning, per rate, is another joint's, or is not what it must be."""
        still = 0 * right.turning
        if level == "coupled" and number != BASE:
            still = self.kane.poses[number].angular_partials
        column = right.turning - still
        place = int(np.abs(column).max(axis=(0, 1)).argmax())
        for other, name in enumerate(self.robot.coordinate_names):
            if other != place:
                moved = still.copy()
                moved[:, :, other] += column[:, :, place]
                yield f"turned by {name}", replace(right, turning=moved)
        for words, turning in (
            ("left out", still),
            ("alone", column),
            ("the other way", still - column),
        ):
            yield f"its own turning {words} in its Jacobian", replace(right, turning=turning)

    def _list_joint_changes(self) -> Iterator[tuple[str, ByPlace]]:
        """Accelerations that joints add, by other rates or about another axis."""
        kinds: dict[str, dict[str, DynamicsTerms]] = {}
        kane = self.kane
        for number, joint in enumerate(self.robot.joints):
            for words, turned in SLIDES.items() if joint.kind == "prismatic" else ():
                load = self._turn_slide(number, *turned)
                kinds.setdefault(words, {})[f"joint {joint.name}"] = _make_bias(load)
            if joint.parent == BASE:
                continue
            pose, rate, under = kane.poses[number], kane.rates[number], kane.rates[joint.parent]
            at = pose.position - kane.poses[joint.parent].position
            right = rotate_point(under.angular, under.angular_rate, at)
            place = "the acceleration of the joint's place by"
            loads: dict[str, tuple[np.ndarray, np.ndarray | None]] = {}
            for words, w, dw in (
                ("w and w' of the link after it", rate.angular, rate.angular_rate),
                ("w of the link after it", rate.angular, under.angular_rate),
                ("w' of the link after it", under.angular, rate.angular_rate),
                ("w of the first link", kane.rates[0].angular, under.angular_rate),
            ):
                loads[f"{place} {words}"] = rotate_point(w, dw, at) - right, None
            spin = rate.angular - under.angular
            if joint.kind == "revolute":
                gained = cross(under.angular, spin)
                before = self._before(joint.parent)[1]
                for words, other in (
                    ("w of the first link for w", cross(kane.rates[0].angular, spin)),
                    ("w of two links before for w", cross(before, spin)),
                    ("the joint's own rate before for w", cross(under.angular - before, spin)),
                ):
                    kind = f"the angular acceleration w x z q': {words}"
                    loads[kind] = self._still, other - gained
            for words, (linear, angular) in loads.items():
                load = kane.load_joint(number, linear, angular)
                kinds.setdefault(words, {})[f"joint {joint.name}"] = _make_bias(load)
        yield from kinds.items()

    def _turn_slide(self, slide: int, by_rate: bool, by_growth: bool) -> np.ndarray:
        """Extra bias if a sliding joint's z q' is taken for a rotation of all that it carries.

        by_rate: whether w has it; by_growth: whether w' has w x z q'.
        """
        kane, rates, load = self.kane, list(self.kane.rates), np.zeros_like(self.kane.v)
        for number in sorted(self._list_after(slide)):
            joint, pose = self.robot.joints[number], kane.poses[number]
            _, w, dw, acceleration = self._before(number)
            at, right = pose.position, kane.rates[number]
            if joint.parent != BASE:
                w, dw, acceleration = rates[joint.parent]
                at = at - kane.poses[joint.parent].position
            spin = pose.rotation @ joint.axis
            spin = spin * (kane.v @ self.robot.joint_map[0][number])[:, None]
            turned, turns = cross(w, spin), joint.kind == "revolute"
            acceleration = acceleration + rotate_point(w, dw, at) + 2 * turned * (not turns)
            w = w + spin * (turns or (by_rate and number == slide))
            dw = dw + turned * (turns or (by_growth and number == slide))
            rates[number] = right._replace(angular=w, angular_rate=dw, acceleration=acceleration)
            motion = kane.move_body(number, kane.place_body(number, self.robot.bodies[number]))
            lever = kane.poses[number].rotation @ self.robot.bodies[number].com
            centre = acceleration + rotate_point(w, dw, lever)
            changed = replace(motion, rate=w, left_rate=w, growth=dw, centre=centre)
            load += changed.compute_terms().bias - motion.compute_terms().bias
        return load

    def _list_column_changes(self, parts: Mapping[str, BodyPart]) -> Iterator[tuple[str, ByPlace]]:
        """Columns of Jacobians that are wrong: a joint's for bodies after it, or each body's own.

        A body's terms are no sum over its columns, so that of these all are wrong or one is.
        """
        last_columns: dict[str, dict[str, DynamicsTerms]] = {}
        whole: dict[str, dict[str, BodyMotion]] = {}
        rights = {}
        for name, part in parts.items():
            motion = self.kane.move_body(part.number, self.kane.place_body(part.number, part.body))
            rights[name] = motion, motion.compute_terms()
        share, of_joint = self.robot.joint_map[0], "its Jacobian's column of"
        for number, joint in enumerate(self.robot.joints):
            kinds: dict[str, dict[str, DynamicsTerms]] = {}
            after = self._list_after(number)
            for name, part in parts.items():
                if part.number not in after:
                    continue
                right, terms = rights[name]
                lever = self.kane.place_body(part.number, part.body).lever
                point = self.kane.poses[part.number].position + lever
                for words, moving, turning in self._list_columns(number, joint, point):
                    by = share[number]
                    changed = replace(
                        right,
                        moving=right.moving + moving[:, :, None] * by,
                        turning=right.turning + turning[:, :, None] * by,
                    )
                    self._add(kinds, f"{of_joint} {joint.name}, {words}", name, changed, terms)
                    if part.number == number:
                        last = f"{of_joint} its own joint, {words}"
                        self._add(last_columns, last, name, changed, terms)
                    sum_of = whole.setdefault(words, {}).get(name, right)
                    whole[words][name] = replace(
                        sum_of,
                        moving=sum_of.moving + changed.moving - right.moving,
                        turning=sum_of.turning + changed.turning - right.turning,
                    )
            yield from kinds.items()
        yield from last_columns.items()
        kinds = {}
        for words, motions in whole.items():
            for name, motion in motions.items():
                every = f"every column of its Jacobian, {words}"
                self._add(kinds, every, name, motion, rights[name][1])
        yield from kinds.items()

    def _list_after(self, number: int) -> set[int]:
        """The bodies that a joint moves."""
        after = {number}
        for other, joint in enumerate(self.robot.joints):
            if joint.parent in after:
                after.add(other)
        return after

    def _list_columns(
        self, number: int, joint: Joint, point: np.ndarray
    ) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
        """Changes (states, 3) of the velocity of a point and of w, per rate of a joint."""
        pose, still = self.kane.poses[number], self._still
        axis, arm = pose.rotation @ joint.axis, point - pose.position
        is_turning = joint.kind == "revolute"
        moving, turning = (cross(axis, arm), axis) if is_turning else (axis, still)
        yield "left out of velocity and w", -moving, -turning
        if is_turning:
            yield "left out of the velocity", -moving, still
            yield "left out of w", still, -turning
            yield "taken for one that slides", axis - moving, -turning
            yield "with the opposite sign in w alone", still, -2 * turning
            yield "with the opposite sign in the velocity alone", -2 * moving, still
            for other, other_joint in enumerate(self.robot.joints):
                is_beside = other == joint.parent or other_joint.parent == number
                if is_beside or (other != number and len(self.robot.joints) <= MOST_PLACES):
                    shift = pose.position - self.kane.poses[other].position
                    yield f"about the place of joint {other_joint.name}", cross(axis, shift), still
        else:
            yield "taken for one that turns, in w as well", still, axis
        yield "with the opposite sign", -2 * moving, -2 * turning
        rotation = pose.rotation
        axes = {
            "its axis not turned to the base's axes": still + joint.axis,
            "its axis turned the other way": rotation.swapaxes(1, 2) @ joint.axis,
            "along z of its own frame": rotation @ np.array([0.0, 0.0, 1.0]),
        }
        if joint.parent != BASE:
            parent = self.robot.joints[joint.parent]
            axes["along the axis of the joint before"] = (
                self.kane.poses[joint.parent].rotation @ parent.axis
            )
        for words, other_axis in axes.items():
            if is_turning:
                yield words, cross(other_axis - axis, arm), other_axis - axis
                yield f"{words}, in w alone", still, other_axis - axis
            else:
                yield words, other_axis - axis, still
        if joint.mimic is not None and joint.mimic.multiplier:
            by = joint.mimic.multiplier
            yield "its multiplier left out", (1 / by - 1) * moving, (1 / by - 1) * turning
            yield "its multiplier twice", (by - 1) * moving, (by - 1) * turning
            if by > 0:  # what is asked of one entry, M's of the joint that it follows
                once = by**-0.5 - 1
                yield "its multiplier once for its square", once * moving, once * turning


def _list_factors(right: BodyMotion) -> Changes:
    """A body whose weight or torque has another factor than 1."""
    for by, words in USUAL.items():
        inertia = by * right.inertia
        yield f"its weight {words}", replace(right, pull=by * right.pull)
        yield f"its torque I w' {words}", replace(right, growing_inertia=inertia)
        yield f"its gyroscopic torque w x I w {words}", replace(right, spinning_inertia=inertia)


def _make_bias(load: np.ndarray) -> DynamicsTerms:
    """A change (states, n) of the bias alone."""
    return DynamicsTerms(np.zeros((*load.shape, load.shape[1])), load, np.zeros_like(load))


def _put_inertia(right: BodyMotion, inertia: np.ndarray) -> BodyMotion:
    return replace(right, inertia=inertia, growing_inertia=inertia, spinning_inertia=inertia)
