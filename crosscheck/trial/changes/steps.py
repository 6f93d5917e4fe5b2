"""Kane's sum with one thing taken for another in one place: for each body, joint, rotor, or some.

A part of the equations is a sum over bodies, each contributing by its motion. So a mistake is
identified by the bodies at which it is made: their contributions add up to the difference.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from crosscheck.analytic.robot.model import cross
from crosscheck.models.robot.robot import BASE, Joint, Level, RobotBody
from crosscheck.trial.changes.kane import (
    FACTORS,
    BodyMotion,
    KaneSum,
    WorldBody,
    list_spinners,
    rotate_point,
)
from crosscheck.trial.changes.levers import FormatRow, LeverTable
from crosscheck.trial.changes.mistakes import BodyPart, list_part_mistakes
from crosscheck.trial.changes.numbers import AXES, get_link_name
from crosscheck.trial.changes.problem import DynamicsTerms

BOTH = "", " in its Jacobian alone", " in its acceleration alone"
TORQUES = " in I w' alone", " in w x I w alone"
MOST_PLACES = 8  # joints, of whose places and levers each is tried by itself
SLIDES = {  # whether a joint that slides turns w, and w'
    "its z q' added to w and w x z q' to w', as of a joint that turns": (True, True),
    "its z q' added to w, as of a joint that turns": (True, False),
    "its w x z q' added to w', as of a joint that turns": (False, True),
}
# A body without all columns of its Jacobian in words, by what these are left out of.
WITHOUT = {
    "left out of velocity and w": "left out",
    "left out of the velocity": "its mass left out, not its inertia about its centre",
    "left out of w": "its inertia about its centre left out",
}
Steps = dict[str, dict[str, DynamicsTerms]]  # changes of the terms, by words and what has them
Changes = Iterator[tuple[str, BodyMotion]]


class StepTable:
    """Effect of every mistake in Kane's sum of a robot, by the body or joint where it is made.

    parts: links, or bodies of several links fixed together, in whose names suffix is appended;
    format_row: words for a row over the coordinates.
    """

    def __init__(
        self, kane: KaneSum, parts: Sequence[BodyPart], format_row: FormatRow, suffix: str = ""
    ) -> None:
        self.format_row = format_row
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
                terms = self.kane.compute_terms(self.parts[name].number, body)
                steps.setdefault(words, {})[name] = terms.minus(self._terms[name])
        return steps

    def list_steps(self) -> Steps:
        """All that may be mistaken in one place of the sum alone."""
        steps: Steps = {}
        for name, part in self.parts.items():
            for words, motion in self._list_motions(part, self._rights[name], self._changed[name]):
                terms = motion.compute_terms().minus(self._terms[name])
                steps.setdefault(words, {})[name] = terms
        self._add_joint_steps(steps)
        self._add_column_steps(steps)
        if len(self.robot.joints) <= MOST_PLACES:
            levers = LeverTable(self.kane, self.format_row)
            for name, part in self.parts.items():
                for words, terms in levers.list_changes(part, self._rights[name]):
                    steps.setdefault(words, {})[name] = terms
        return steps

    def list_rotor_steps(self, level: Level) -> Steps:
        """The same of rotors at a level."""
        steps: Steps = {}
        for name, rotor in list_spinners(self.robot) if level != "links" else ():
            number = self.robot.frames[rotor.stator].body
            right = self.kane.move_rotor(rotor, level)
            terms = right.compute_terms()
            for words, motion in (
                *_list_factors(right),
                *self._list_rate_changes(number, right, self.still),
                *self._list_spin_changes(number, right, level),
            ):
                terms_by_rotor = steps.setdefault(words, {})
                terms_by_rotor[f"rotor of {name}"] = motion.compute_terms().minus(terms)
        return steps

    def _list_changed(self, part: BodyPart) -> dict[str, WorldBody]:
        """By words, what a part may be taken for, or what of it is not turned as it must be."""
        number, link, axes = part.number, part.in_link, part.turn
        changed = {
            words: self.kane.place_body(number, body)
            for words, body in list_part_mistakes(self.robot, part).items()
        }
        pose = self.kane.poses[number].rotation
        turn, shift = pose @ part.placement.rotation, pose @ part.placement.position
        unturned = _list_unturned(turn, link)
        if not np.allclose(axes, np.eye(3), rtol=0.0, atol=1e-6):
            stated = RobotBody(link.mass, axes.T @ link.com, axes.T @ link.inertia @ axes)
            unturned |= {
                f"{words}, by the axes of its inertial frame": body
                for words, body in _list_unturned(turn @ axes, stated).items()
                if words.startswith("its inertia")
            }
        return changed | {w: b._replace(lever=b.lever + shift) for w, b in unturned.items()}

    def _list_motions(
        self, part: BodyPart, right: BodyMotion, changed: Mapping[str, WorldBody]
    ) -> Changes:
        yield from _list_factors(right)
        number, kane = part.number, self.kane
        joint, pose = self.robot.joints[number], kane.poses[number]
        under = kane.poses[joint.parent].rotation if joint.parent != BASE else np.eye(3)
        turned, body = under @ joint.placement.rotation, kane.place_body(number, part.body)
        lever = body.lever
        levers = {
            "its centre of mass without the place of its joint": lever
            - pose.position
            + self._before(number)[0],
            "its centre of mass in the axes of the link before": self.still + under @ part.body.com,
            "its centre of mass not turned by its joint": self.still + turned @ part.body.com,
            "its centre of mass at its joint": self.still,
        }
        for name, axis in zip(AXES, np.eye(3), strict=True):
            mirrored = replace(part.in_link, com=part.in_link.com * (1 - 2 * axis))
            words = f"{name} of its centre of mass with the opposite sign"
            levers[words] = kane.place_body(number, part.carry(mirrored)).lever
        for words, at in levers.items():
            yield from self._place(words, number, right, at, BOTH)
        for words, other in changed.items():
            if not np.array_equal(other.lever, lever):
                yield from self._place(words, number, right, other.lever, BOTH[1:])
        for beside, other_joint in enumerate(self.robot.joints):
            if beside == joint.parent or other_joint.parent == number:
                motion = kane.move_body(beside, kane.place_body(beside, self.robot.bodies[beside]))
                words = f"its mass at the centre of {get_link_name(self.robot, beside)}"
                yield words, replace(right, moving=motion.moving, centre=motion.centre)
        yield from self._list_inertia_changes(part, right, changed, under, turned)
        yield from self._list_rate_changes(number, right, lever)
        R, g = pose.rotation, self.robot.gravity
        for words, pull in (
            ("in the link's own axes, not turned", R @ g),
            ("turned the other way", R @ R @ g),
            ("turned as from the link's axes to the base's", R.swapaxes(1, 2) @ g),
        ):
            yield f"gravity's direction {words}", replace(right, pull=pull)

    def _list_inertia_changes(
        self,
        part: BodyPart,
        right: BodyMotion,
        changed: Mapping[str, WorldBody],
        under: np.ndarray,
        turned: np.ndarray,
    ) -> Changes:
        number, pose = part.number, self.kane.poses[part.number]
        in_link, axis = part.body.inertia, pose.rotation @ self.robot.joints[number].axis
        body = self.kane.place_body(number, part.body)
        square = body.mass * (body.lever**2).sum(axis=1)[:, None, None] * np.eye(3)
        about = np.einsum("si,sij,sj->s", axis, body.inertia, axis)[:, None, None]
        inertias = {
            "its inertia in the axes of the link before": _turn(under, in_link),
            "its inertia not turned by its joint": _turn(turned, in_link),
            "m |c|^2 added to its inertia about every axis": body.inertia + square,
            "m |c|^2 taken from its inertia about every axis": body.inertia - square,
            "its inertia about its joint's axis alone": about * axis[:, :, None] * axis[:, None],
        }
        inertias = {w: np.broadcast_to(i, body.inertia.shape) for w, i in inertias.items()}
        for words, i in inertias.items():
            yield words, replace(right, inertia=i, growing_inertia=i, spinning_inertia=i)
        inertias |= {w: b.inertia for w, b in changed.items() if b.mass == body.mass}
        bodies = self.robot.bodies
        for words, neighbour in (("before", number - 1), ("after", (number + 1) % len(bodies))):
            # By an index that is one off, with that of the last link before the first one.
            inertia = _turn(pose.rotation, bodies[neighbour].inertia)
            inertias[f"the inertia of the link {words} it"] = inertia
        for words, inertia in inertias.items():
            yield f"{words}{TORQUES[0]}", replace(right, growing_inertia=inertia)
            yield f"{words}{TORQUES[1]}", replace(right, spinning_inertia=inertia)

    def _place(
        self, words: str, number: int, right: BodyMotion, lever: np.ndarray, places: Sequence[str]
    ) -> Changes:
        """A centre of mass that is another one in Jacobian, acceleration or both."""
        rate = self.kane.rates[number]
        centre = rate.acceleration + rotate_point(rate.angular, rate.angular_rate, lever)
        moving = self.kane.move_point(number, lever)
        for place in places:
            yield (
                words + place,
                replace(
                    right,
                    moving=right.moving if place == BOTH[2] else moving,
                    centre=right.centre if place == BOTH[1] else centre,
                ),
            )

    def _before(self, number: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Place, w, w' and acceleration (states, 3) of the link before a body."""
        parent = self.robot.joints[number].parent if number != BASE else BASE
        if parent == BASE:
            return (self.still,) * 4
        return self.kane.poses[parent].position, *self.kane.rates[parent]

    def _list_rate_changes(self, number: int, right: BodyMotion, lever: np.ndarray) -> Changes:
        """Other rates of a body in its acceleration, in its torque, or in both."""
        _, before, growth_before, place_before = self._before(number)
        w, dw, first = right.rate, right.growth, self.kane.rates[0].angular
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
        """A rotor that another joint turns."""
        still = 0 * right.turning
        if level == "coupled" and number != BASE:
            still = self.kane.poses[number].angular_partials
        column = right.turning - still
        place = int(np.abs(column).max(axis=(0, 1)).argmax())
        for other, name in enumerate(self.robot.coordinate_names):
            if other != place:
                turning = still + np.roll(column, other - place, axis=2)
                yield f"turned by {name}", replace(right, turning=turning)

    def _add_joint_steps(self, steps: Steps) -> None:
        """Add accelerations that joints add, by other rates or about another axis."""
        kane = self.kane
        for number, joint in enumerate(self.robot.joints):
            loads: dict[str, np.ndarray] = {}
            for words, turned in SLIDES.items() if joint.kind == "prismatic" else ():
                loads[words] = self._turn_slide(number, *turned)
            if joint.parent != BASE:
                rate, under, first = kane.rates[number], kane.rates[joint.parent], kane.rates[0]
                at = kane.poses[number].position - kane.poses[joint.parent].position
                right = rotate_point(under.angular, under.angular_rate, at)
                for words, w, dw in (
                    ("w and w' of the link after it", rate.angular, rate.angular_rate),
                    ("w of the link after it", rate.angular, under.angular_rate),
                    ("w' of the link after it", under.angular, rate.angular_rate),
                    ("w of the first link", first.angular, under.angular_rate),
                ):
                    load = kane.load_joint(number, rotate_point(w, dw, at) - right)
                    loads[f"the acceleration of the joint's place by {words}"] = load
                if joint.kind == "revolute":
                    gained = cross(first.angular - under.angular, rate.angular - under.angular)
                    words = "the angular acceleration w x z q': w of the first link for w"
                    loads[words] = kane.load_joint(number, self.still, gained)
            for words, load in loads.items():
                terms = DynamicsTerms(np.zeros((*load.shape, load.shape[1])), load, 0 * load)
                steps.setdefault(words, {})[f"joint {joint.name}"] = terms

    def _turn_slide(self, slide: int, by_rate: bool, by_growth: bool) -> np.ndarray:
        """Extra bias if a sliding joint's z q' is taken for a rotation of all that it carries.

        by_rate: whether w has it; by_growth: whether w' has w x z q'.
        """
        kane, rates, load = self.kane, list(self.kane.rates), np.zeros_like(self.kane.v)
        for number in sorted(kane.list_after(slide)):
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
            body = kane.place_body(number, self.robot.bodies[number])
            motion = kane.move_body(number, body)
            centre = acceleration + rotate_point(w, dw, body.lever)
            changed = replace(motion, rate=w, left_rate=w, growth=dw, centre=centre)
            load += changed.compute_terms().bias - motion.compute_terms().bias
        return load

    def _add_column_steps(self, steps: Steps) -> None:
        """Add columns of Jacobians that are wrong: a joint's for bodies after it, or a body's own.

        A body's terms are no sum over its columns, so that of these all are wrong or one is.
        """
        whole: dict[str, dict[str, BodyMotion]] = {}
        last_columns: Steps = {}
        share, of_joint = self.robot.joint_map[0], "its Jacobian's column of"
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
                    steps.setdefault(f"{of_joint} {joint.name}, {words}", {})[name] = changed
                    if part.number == number:
                        last = f"{of_joint} its own joint, {words}"
                        last_columns.setdefault(last, {})[name] = changed
                    motions = whole.setdefault(words, {})
                    motions[name] = _add_columns(motions.get(name, right), *columns)
        steps |= last_columns
        slides = any(joint.kind != "revolute" for joint in self.robot.joints)
        without = {} if slides else WITHOUT  # a joint that slides has no column in w
        for words, motions in whole.items():
            steps[without.get(words, f"every column of its Jacobian, {words}")] = {
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
            "along z of its own frame": rotation @ np.array([0.0, 0.0, 1.0]),
        }
        if joint.parent != BASE:
            before = self.kane.poses[joint.parent].rotation @ self.robot.joints[joint.parent].axis
            axes["along the axis of the joint before"] = before
        for words, other_axis in axes.items():
            change = other_axis - axis
            yield (words, cross(change, arm), change) if is_turning else (words, change, still)
            if is_turning:
                yield f"{words}, in w alone", still, change
        by = joint.mimic.multiplier if joint.mimic else 1.0
        if by > 0 and by != 1:  # what is asked of one entry, M's of the joint that it follows
            once = by**-0.5 - 1
            yield "its multiplier once for its square", once * moving, once * turning


def _list_factors(right: BodyMotion) -> Changes:
    """Each body whose weight or torque has a factor other than 1."""
    for by, words in FACTORS.items():
        inertia = by * right.inertia
        yield f"its weight {words}", replace(right, pull=by * right.pull)
        yield f"its torque I w' {words}", replace(right, growing_inertia=inertia)
        yield f"its gyroscopic torque w x I w {words}", replace(right, spinning_inertia=inertia)


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
    turned: np.ndarray = rotation @ inertia @ np.swapaxes(rotation, -1, -2)
    return turned


def _add_columns(motion: BodyMotion, moving: np.ndarray, turning: np.ndarray) -> BodyMotion:
    return replace(motion, moving=motion.moving + moving, turning=motion.turning + turning)
