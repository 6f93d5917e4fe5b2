"""A body's centre at the end of a chain of levers, any of which may turn otherwise than its link.

A lever goes from joint to joint, the last one to the centre. A mistake is in its velocity, in its
direction or in both; the bias is Lagrange's, of the kinetic energy that has the mistake.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot, cross, multiply, project
from crosscheck.models.robot.robot import BASE
from crosscheck.trial.changes.kane import FACTORS, BodyMotion, KaneSum
from crosscheck.trial.changes.mistakes import BodyPart
from crosscheck.trial.changes.numbers import AXES, get_link_name
from crosscheck.trial.changes.problem import DynamicsTerms

VELOCITY, DIRECTION, BOTH = "the velocity", "the direction alone", "direction and rate"
SPIN, MOTION = "the angular velocity", "all motion"
ALONE = {
    what: f"each joint's own {quantity} where the sum of them belongs, in {what}"
    for what, quantity in (
        (VELOCITY, "rate"),
        (DIRECTION, "angle"),
        (BOTH, "angle and rate"),
        (MOTION, "angle and rate"),
    )
}
ENERGIES = {by: words for by, words in FACTORS.items() if by >= 0}
FormatRow = Callable[[np.ndarray, str], str]  # of a row over coordinates, and what follows a name


class Turning(NamedTuple):
    """How a link turns, or is taken to turn, at states.

    rotation (states, 3, 3); partials (states, 3, n): of its angular velocity, rate (states, 3),
    by each rate; growth (states, 3, n): their derivative by time; slopes (states, 3, n): of the
    rate by each coordinate.
    """

    rotation: np.ndarray
    partials: np.ndarray
    rate: np.ndarray
    growth: np.ndarray
    slopes: np.ndarray


class LeverMotion(NamedTuple):
    """A lever's velocity per rate (states, 3, n), and the acceleration of its end (states, 3).

    excess (states, 3, n): the derivative of the velocities per rate by time, less the slopes of
    the velocity by each coordinate; 0 of what moves as it can.
    """

    moving: np.ndarray
    acceleration: np.ndarray
    excess: np.ndarray

    def minus(self, other: LeverMotion) -> LeverMotion:
        """The differences from another motion."""
        return LeverMotion(*(left - right for left, right in zip(self, other, strict=True)))


class LeverChange(NamedTuple):
    """A mistake in levers, in words, the change of motion, and whether it is in the weight too."""

    words: str
    motion: LeverMotion
    weighs: bool = True


class OtherTurning(NamedTuple):
    """A link turned otherwise: rows over the coordinates as they are taken, and as they belong.

    rates: by other rates about the right axes; angles: by other angles, and their rates.
    """

    yours: np.ndarray
    right: np.ndarray
    rates: Turning
    angles: Turning


class LeverTable:
    """What levers and links that turn otherwise change of a robot's terms.

    format_row: words for a row over the coordinates.
    """

    def __init__(self, kane: KaneSum, format_row: FormatRow) -> None:
        self.kane, self.robot, self.v = kane, kane.robot, kane.v
        self.format_row, self.shares = format_row, kane.robot.joint_map[0]
        self.turnings = self._turn_links(kane.q, kane.v)
        self._scaled: dict[bytes, tuple[list[Turning], list[Turning]]] = {}
        self._place_changes: dict[tuple[int, int], list[LeverChange]] = {}

    def list_changes(
        self, part: BodyPart, right: BodyMotion
    ) -> Iterator[tuple[str, DynamicsTerms]]:
        """Words on each mistake in a part's levers or its turning, and its terms' changes."""
        number, chain = part.number, self._list_chain(part.number)
        levers = [(link, self._find_lever(link, after)) for link, after in pairwise(chain)]
        changes = [each for pair in pairwise(chain) for each in self._change_place(*pair)]
        levers.append((number, self.kane.still + part.body.com))
        changes += self._change_lever(*levers[-1])
        motions = [self._move_lever(lever, *[self.turnings[link]] * 2) for link, lever in levers]
        whole = add_motions(motions)
        changes += [*self._change_components(whole, ""), *self._change_swings(levers)]
        changes += self._turn_alone(levers, whole)
        stacked = zip(*(change.motion for change in changes), strict=True)
        weighs = np.array([change.weighs for change in changes])
        made = self._compute_terms(right, LeverMotion(*map(np.array, stacked)), weighs)
        terms = {
            each.words: DynamicsTerms(*term) for each, *term in zip(changes, *made, strict=True)
        }
        joint_alone, _ = self._scale(number, self._joint_factors(number))
        turns = {self._describe(other, SPIN): other.rates for other in self._other_turnings[number]}
        spins = {
            words: self._turn(right, turning, number)
            for words, turning in (*turns.items(), (MOTION, joint_alone))
        }
        both = zip(terms[ALONE[BOTH]], spins.pop(MOTION), strict=True)
        spins[ALONE[MOTION]] = DynamicsTerms(*(a + b for a, b in both))
        yield from (terms | spins).items()

    def _turn_links(self, q: np.ndarray, v: np.ndarray) -> list[Turning]:
        """How each link turns at q, v (states, n)."""
        turnings = list[Turning]()
        frames = zip(*AnalyticRobot(self.robot, "links").frames(q, v), strict=True)
        for number, (pose, rate) in enumerate(frames):
            joint, w, partials = self.robot.joints[number], rate.angular, pose.angular_partials
            growth = turnings[joint.parent].growth if joint.parent != BASE else 0 * partials
            if joint.kind == "revolute":
                turned = cross(w, self.kane.still + pose.rotation @ joint.axis)
                growth = growth + turned[:, :, None] * self.shares[number]
            slopes = growth + cross(partials, w)
            turnings.append(Turning(pose.rotation, partials, w, growth, slopes))
        return turnings

    def _scale(self, link: int, factors: np.ndarray) -> tuple[Turning, Turning]:
        """A link turned by coordinates times factors (n,): by their rates alone; by all of them."""
        key = factors.tobytes()
        if key not in self._scaled:
            moved = (
                self._turn_links(q, self.v * factors) for q in (self.kane.q, self.kane.q * factors)
            )
            self._scaled[key] = next(moved), next(moved)
        right, (of_rates, of_angles) = self.turnings[link], self._scaled[key]
        rates, angles = of_rates[link], of_angles[link]
        slopes = rates.growth + cross(right.partials, rates.rate)
        scaled = right.partials * factors, rates.rate, right.growth * factors, slopes
        partials, growth, slopes = (
            each * factors for each in (angles.partials, angles.growth, angles.slopes)
        )
        return (
            Turning(right.rotation, *scaled),
            Turning(angles.rotation, partials, angles.rate, growth, slopes),
        )

    @cached_property
    def _other_turnings(self) -> list[list[OtherTurning]]:
        """Of each link other turnings: by fewer angles, or one reversed; as the link after it."""
        every = [self._list_scaled(link) for link in range(len(self.turnings))]
        others = [list(each) for each in every]
        for after, joint in enumerate(self.robot.joints):
            if joint.parent != BASE and joint.kind == "revolute":
                factors = self._joint_factors(after)
                row, right = self._row(after), self._row(joint.parent)
                turning = self.turnings[after]
                others[joint.parent] += [
                    OtherTurning(row, right, turning, turning),
                    OtherTurning(row * factors, right, *self._scale(after, factors)),
                ]
        return others

    def _list_scaled(self, link: int) -> list[OtherTurning]:
        """A link turned by its coordinates times factors, each once."""
        right, size = self._row(link), self.v.shape[1]
        chain = [n for n in self._list_chain(link) if self.robot.joints[n].kind == "revolute"]
        places = [int(np.abs(self.shares[n]).argmax()) for n in chain]
        factors = [np.zeros(size), np.full(size, 2.0)]
        for count, place in enumerate(places):
            unit = np.eye(size)[place]
            factors += [1 - unit, 1 - 2 * unit]
            for some in (places[: count + 1], places[count:]):
                factors.append(np.isin(np.arange(size), some).astype(float))
        rows = {tuple(right * each): each for each in factors}
        rows.pop(tuple(right), None)
        return [
            OtherTurning(right * each, right, *self._scale(link, each)) for each in rows.values()
        ]

    def _joint_factors(self, link: int) -> np.ndarray:
        """By which coordinates a link turns by its own joint alone (n,)."""
        return (self.shares[link] != 0).astype(float)

    def _row(self, link: int) -> np.ndarray:
        """How often each coordinate turns a link (n,)."""
        kinds = self.robot.joints
        row: np.ndarray = np.sum(
            [self.shares[n] * (kinds[n].kind == "revolute") for n in self._list_chain(link)], axis=0
        )
        return row

    def _list_chain(self, link: int) -> list[int]:
        """Joints from the base to a link."""
        chain = list[int]()
        while link != BASE:
            chain.insert(0, link)
            link = self.robot.joints[link].parent
        return chain

    def _find_lever(self, link: int, after: int) -> np.ndarray:
        """The place (states, 3) of the joint after a link, in the link's axes."""
        poses = self.kane.poses
        shift = poses[after].position - poses[link].position
        return multiply(poses[link].rotation.swapaxes(1, 2), shift)

    def _move_lever(self, lever: np.ndarray, rates: Turning, angles: Turning) -> LeverMotion:
        """The motion of a lever (states, 3) in its link's axes by some rates, along some angles."""
        along = multiply(angles.rotation, lever)
        moving, bent = cross(rates.partials, along), cross(angles.partials, along)
        growth = cross(rates.growth, along) + cross(rates.partials, cross(angles.rate, along))
        slopes = cross(rates.slopes, along) - cross(bent, rates.rate)
        return LeverMotion(moving, multiply(growth, self.v), growth - slopes)

    def _change_place(self, link: int, after: int) -> list[LeverChange]:
        """Mistakes in the lever from a link's joint to the next one, the same for all after it."""
        if (link, after) not in self._place_changes:
            changes = list(self._change_lever(link, self._find_lever(link, after)))
            self._place_changes[link, after] = changes
        return self._place_changes[link, after]

    def _change_lever(self, link: int, lever: np.ndarray) -> Iterator[LeverChange]:
        """Mistakes in one lever: what turns it, and components of its velocity."""
        right, along = self.turnings[link], f" along {get_link_name(self.robot, link)}"
        motion = self._move_lever(lever, right, right)
        for other in self._other_turnings[link] if lever.any() else ():
            for what, rates, angles in (
                (VELOCITY, other.rates, right),
                (DIRECTION, right, other.angles),
                (BOTH, other.angles, other.angles),
            ):
                change = self._move_lever(lever, rates, angles).minus(motion)
                words = f"{self._describe(other, what)}{along}"
                yield LeverChange(words, change, what != VELOCITY)
        yield from self._change_components(motion, along)

    def _describe(self, other: OtherTurning, what: str) -> str:
        rate = "'" if what in (VELOCITY, SPIN) else ""
        yours, right = (self.format_row(each, rate) for each in (other.yours, other.right))
        return f"{yours} where {right} belongs, in {what}"

    def _change_components(self, motion: LeverMotion, along: str) -> Iterator[LeverChange]:
        """Components of a velocity with another sign, or another one; their energies."""
        velocity, there = f"its velocity{along}", np.flatnonzero(motion.moving.any(axis=(0, 2)))

        def put(axis: int, other: int, by: float) -> LeverMotion:
            change = LeverMotion(*(np.zeros_like(each) for each in motion))
            for changed, given in zip(change[:2], motion[:2], strict=True):
                changed[:, axis] = by * given[:, other] - given[:, axis]
            return change

        for axis, other in product(there.tolist(), repeat=2):
            name = AXES[axis]
            for sign, by in (("", 1.0), ("-", -1.0)) if other != axis else ():
                words = f"{velocity}, {sign}{AXES[other]} for {name}"
                yield LeverChange(words, put(axis, other, by))
            if other == axis:
                yield LeverChange(f"{velocity}, {name} with the opposite sign", put(axis, axis, -1))
                for by, words in ENERGIES.items():
                    energy = f"{name}'^2 of {velocity} {words}, in its kinetic energy"
                    yield LeverChange(energy, put(axis, axis, by**0.5), weighs=False)

    def _change_swings(self, levers: Sequence[tuple[int, np.ndarray]]) -> Iterator[LeverChange]:
        """Centripetal accelerations of all levers by other rates, or with other factors."""
        first, rows = self.turnings[0].rate, list[tuple[np.ndarray, ...]]()
        for link, lever in levers:
            parent, turning = self.robot.joints[link].parent, self.turnings[link]
            before = self.turnings[parent].rate if parent != BASE else 0 * first
            arm = multiply(turning.rotation, lever)
            rates = turning.rate, turning.rate - before, first
            rows.append(tuple(cross(w, cross(w, arm)) for w in rates))
        right, of_joint, of_first = np.sum(rows, axis=0)
        every, still = "every centripetal acceleration", np.zeros_like(self.turnings[0].partials)
        changes = {words: (by - 1) * right for by, words in FACTORS.items()}
        changes |= {
            "by its joint's own rate": of_joint - right,
            "by w of the first link": of_first - right,
        }
        for words, change in changes.items():
            yield LeverChange(f"{every} {words}", LeverMotion(still, change, still))

    def _turn_alone(
        self, levers: Sequence[tuple[int, np.ndarray]], whole: LeverMotion
    ) -> Iterator[LeverChange]:
        """Each joint's own rate, or angle, or both, where the sums of them belong."""
        moved: dict[str, list[LeverMotion]] = {VELOCITY: [], DIRECTION: [], BOTH: []}
        for link, lever in levers:
            right, (rates, both) = self.turnings[link], self._scale(link, self._joint_factors(link))
            moved[VELOCITY].append(self._move_lever(lever, rates, right))
            moved[DIRECTION].append(self._move_lever(lever, right, both))
            moved[BOTH].append(self._move_lever(lever, both, both))
        for what, motions in moved.items():
            change = add_motions(motions).minus(whole)
            yield LeverChange(ALONE[what], change, what != VELOCITY)

    def _compute_terms(
        self, right: BodyMotion, change: LeverMotion, weighs: np.ndarray
    ) -> DynamicsTerms:
        """What changes of a centre's motion (changes, states, ...) make of a body's terms."""
        moving, centre = right.moving + change.moving, right.centre + change.acceleration
        mass = moving.swapaxes(-1, -2) @ moving - right.moving.swapaxes(1, 2) @ right.moving
        bias = (centre[..., None, :] @ moving)[..., 0, :] - project(right.moving, right.centre)
        bias += (multiply(moving, self.v)[..., None, :] @ change.excess)[..., 0, :]
        weight = np.einsum("i,csin->csn", self.robot.gravity, change.moving)
        weight = weight * weighs[:, None, None]
        return DynamicsTerms(right.mass * mass, right.mass * bias, -right.mass * weight)

    def _turn(self, right: BodyMotion, by: Turning, link: int) -> DynamicsTerms:
        """What it makes of a body's terms that it turns otherwise, but for its inertia's axes."""
        axes, inertia = self.turnings[link], right.inertia
        growth = multiply(by.growth, self.v) - cross(axes.rate, by.rate)
        excess = by.growth - by.slopes + cross(by.partials, axes.rate)
        excess = excess + cross(axes.partials, by.rate)
        bias = project(by.partials, multiply(inertia, growth))
        bias += project(excess, multiply(inertia, by.rate))
        turning, w = axes.partials, axes.rate
        moment = multiply(inertia, right.growth) + cross(w, multiply(inertia, w))
        mass = by.partials.swapaxes(1, 2) @ inertia @ by.partials
        mass = mass - turning.swapaxes(1, 2) @ inertia @ turning
        return DynamicsTerms(mass, bias - project(turning, moment), np.zeros_like(bias))


def add_motions(motions: Sequence[LeverMotion]) -> LeverMotion:
    """The sum of the motions of levers."""
    return LeverMotion(*(np.sum(each, axis=0) for each in zip(*motions, strict=True)))
