"""Effect of each change of a robot on its terms at the states, for all levels.

Terms are a linear sum over ten parameters of each body (mass, first moments, inertia about the
joint), so that whatever is wrong in bodies is a change of these. Rotors add up one by one. Where
joints or gravity are others, robots are computed side by side.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot, multiply
from crosscheck.models.robot.robot import Level, Robot, RobotBody, Rotor, compute_point_inertia
from crosscheck.trial.changes.kane import KaneSum, list_spinners
from crosscheck.trial.changes.mistakes import (
    UPPER,
    BodyPart,
    list_body_parts,
    list_whole_bodies,
)
from crosscheck.trial.changes.numbers import RobotNumber, list_numbers, set_entry
from crosscheck.trial.changes.problem import ChangeProblem, DynamicsTerms
from crosscheck.trial.changes.steps import Steps, StepTable
from crosscheck.trial.coordinates.differences import CENTRAL, TURN_RAD

BODY_SIZE = 10  # parameters of a body
RULES = {  # of the bias M' v - 1/2 d(v' M v)/dq: factors of M' v and of d(v' M v)/dq
    "M' v alone, without -1/2 d(v' M v)/dq": (1.0, 0.0),
    "+1/2 d(v' M v)/dq for -1/2": (1.0, 0.5),
    "d(v' M v)/dq without its factor 1/2": (1.0, -1.0),
    "-1/2 d(v' M v)/dq alone, without M' v": (0.0, -0.5),
    "M' v half as large": (0.5, -0.5),
    "M' v twice": (2.0, -0.5),
    "+1/2 d(v' M v)/dq alone, as of Christoffel's C transposed": (0.0, 0.5),
    "half as large": (0.5, -0.25),
    "without every derivative of M": (0.0, 0.0),
}
LEAST_ROWS = 12  # rows of one part at which robots are screened
# Entries of M, at all states, of each step of Kane's sum; and fewest states.
MOST_ENTRIES, LEAST_STATES = 600, 3


class NumberEffect(NamedTuple):
    """First- and second-order effect of one step of a number on all terms."""

    linear: DynamicsTerms
    square: DynamicsTerms


class ChangeTable:
    """Effect of each change of a robot on its terms at the states, for all levels."""

    def __init__(self, problem: ChangeProblem) -> None:
        self.problem, self.robot, self.states = problem, problem.robot, problem.states
        self.numbers = list(list_numbers(self.robot))
        count, size = self.states.q.shape
        self.few = slice(min(count, -(-LEAST_ROWS // size)))  # states at which all are screened
        # States of steps of Kane's sum, which are many: fewer of large robots.
        self.several = slice(min(count, max(LEAST_STATES, MOST_ENTRIES // size**2)))
        self.kane = KaneSum(self.robot, self.states.q, self.states.v)
        self._spinners = [each.rotor for each in list_spinners(self.robot)]
        self._bases: dict[Level, DynamicsTerms] = {}
        self._effects: dict[Level, DynamicsTerms] = {}

    def compute_base(self, level: Level) -> DynamicsTerms:
        """The robot's own terms."""
        if level not in self._bases:
            terms = AnalyticRobot(self.robot, level).terms(*self.states[:2])
            self._bases[level] = DynamicsTerms(*terms)
        return self._bases[level]

    def compute_changes(
        self, robots: Sequence[Robot], level: Level, states: slice = slice(None)
    ) -> DynamicsTerms:
        """Changes of the terms (robots, states, ...) for other robots."""
        moved = [n for n, robot in enumerate(robots) if self._moves_otherwise(robot)]
        still = [n for n in range(len(robots)) if n not in set(moved)]
        parts = []
        if still:
            vectors = np.array([self.find_parameters(robots[n]) for n in still])
            parts.append((still, self.combine(vectors, level, states)))
        if moved:
            q, v = (each[states] for each in self.states[:2])
            each = (AnalyticRobot(robots[n], level).terms(q, v) for n in moved)
            others = DynamicsTerms(*map(np.array, zip(*each, strict=True)))
            base = DynamicsTerms(*(term[states] for term in self.compute_base(level)))
            parts.append((moved, others.minus(base)))
        base = self.compute_base(level)
        whole = [np.zeros((len(robots), *term[states].shape)) for term in base]
        for numbers, part in parts:
            for total, term in zip(whole, part, strict=True):
                total[numbers] = term
        for n in still if level != "links" else ():
            for sign, rotor in self._list_other_rotors(robots[n]):
                terms = self.kane.move_rotor(rotor, level).compute_terms()
                for total, term in zip(whole, terms, strict=True):
                    total[n] += sign * term[states]
        return DynamicsTerms(*whole)

    def _moves_otherwise(self, robot: Robot) -> bool:
        """Whether joints or gravity of another robot are others."""
        return robot.joints is not self.robot.joints or robot.gravity is not self.robot.gravity

    def _list_other_rotors(self, robot: Robot) -> list[tuple[int, Rotor]]:
        """The rotors of another robot that this one has not, and with -1 those that it lacks."""
        if robot.rotors is self.robot.rotors and robot.stages is self.robot.stages:
            return []
        stages = robot.stages is self.robot.stages
        others = [*robot.rotors, *self._spinners[len(self.robot.rotors) :]]
        others = others if stages else [each.rotor for each in list_spinners(robot)]
        before, after = ({id(each) for each in some} for some in (self._spinners, others))
        added = [(1, each) for each in others if id(each) not in before]
        return added + [(-1, each) for each in self._spinners if id(each) not in after]

    def combine(
        self, vectors: np.ndarray, level: Level, states: slice = slice(None)
    ) -> DynamicsTerms:
        """What changes of the parameters (changes, parameters) make of the terms."""
        effects = self.compute_parameter_effects(level)
        return DynamicsTerms(*(np.tensordot(vectors, term[:, states], axes=1) for term in effects))

    def compute_parameter_effects(self, level: Level) -> DynamicsTerms:
        """Effect of each parameter of a body on the terms (parameters, states, ...)."""
        if level not in self._effects:
            kane, effects = self.kane, list[DynamicsTerms]()
            for number in range(len(self.robot.bodies)):
                first, *others = (
                    kane.compute_terms(number, kane.place_body(number, body))
                    for body in list_unit_bodies()
                )
                effects += [first, *(each.minus(first) for each in others)]
            self._effects[level] = DynamicsTerms(*map(np.array, zip(*effects, strict=True)))
        return self._effects[level]

    def find_parameters(self, robot: Robot) -> np.ndarray:
        """Changes of the bodies' parameters for another robot."""
        change = np.zeros(BODY_SIZE * len(robot.bodies))
        for number, (body, right) in enumerate(zip(robot.bodies, self.robot.bodies, strict=True)):
            if body is not right:
                start = BODY_SIZE * number
                own = list_parameters(body) - list_parameters(right)
                change[start : start + BODY_SIZE] = own
        return change

    def select_numbers(self, level: Level) -> list[RobotNumber]:
        """The numbers that may change something at a level, by their square at most."""
        rotors = ("rotors", "stages") if level == "links" else ()
        return [each for each in self.numbers if not (each.curved or each.path.startswith(rotors))]

    def compute_number_effects(self, level: Level) -> NumberEffect:
        """The effects (numbers, states, ...) of the numbers of a level."""
        numbers = self.select_numbers(level)
        robots = [each.put(each.value + by * each.step) for by in (1, -1) for each in numbers]
        changes = self.compute_changes(robots, level)
        pairs = [(term[: len(numbers)], term[len(numbers) :]) for term in changes]
        linear, square = ([(a + sign * b) / 2 for a, b in pairs] for sign in (-1, 1))
        return NumberEffect(DynamicsTerms(*linear), DynamicsTerms(*square))

    @cached_property
    def part_lists(self) -> list[list[BodyPart]]:
        """The links of the URDF, then bodies of several links fixed together, if there are any."""
        parts, bodies = list_body_parts(self.robot), list_whole_bodies(self.robot)
        return [parts, bodies] if len(parts) > len(bodies) else [parts]

    def _list_step_tables(self, states: slice) -> list[StepTable]:
        kane = self.kane
        if states.stop < len(self.states.q):
            kane = KaneSum(self.robot, self.states.q[states], self.states.v[states])
        suffixes = "", ", with what is fixed to it"
        pairs = zip(self.part_lists, suffixes, strict=False)
        return [StepTable(kane, parts, suffix) for parts, suffix in pairs]

    @cached_property
    def body_steps(self) -> list[Steps]:
        """What numbers of links may be taken for; then of bodies of several links."""
        tables = self._list_step_tables(slice(len(self.states.q)))
        return [each.list_body_steps() for each in tables]

    def list_steps(self, level: Level) -> list[tuple[str, dict[str, DynamicsTerms]]]:
        """Mistakes in Kane's sum at several states, with what each changes by what has it."""
        steps = [pair for of_bodies in self._steps for pair in of_bodies.items()]
        return [*steps, *self._list_rule_steps(level).items()]

    def _list_rule_steps(self, level: Level) -> Steps:
        """Lagrange's rule for the bias of M with other factors, by the coordinate of a slope."""
        q, v = (each[self.several] for each in self.states[:2])
        model, steps = AnalyticRobot(self.robot, level), Steps()
        still, (weights, _) = np.zeros_like(v), CENTRAL[1]
        far = np.arange(len(weights)) - len(weights) // 2
        turned = TURN_RAD / np.maximum(1.0, np.abs(self.robot.joint_map[0]).sum(axis=0))
        for place, name in enumerate(self.robot.coordinate_names):
            unit = np.eye(len(turned))[place]
            moved = [model.mass_matrix(q + by * turned[place] * unit) for by in far]
            slope = np.tensordot(weights, moved, 1) / turned[place]
            rate = v[:, place, None]
            for squares, words in (False, ""), (True, ", in products of two rates alone"):
                of = v - squares * v * unit  # the square in dM/dq_k q_k' v is that of q_k'
                growth = multiply(slope, of) * rate
                energy = np.einsum("sij,si,sj->s", slope, v, v)
                energy -= squares * np.einsum("sii,si->s", slope, v**2)
                for rule, (by_growth, by_energy) in RULES.items():
                    bias = (by_growth - 1) * growth + (by_energy + 0.5) * np.outer(energy, unit)
                    terms = DynamicsTerms(np.zeros((*still.shape, len(unit))), bias, still)
                    steps.setdefault(f"{rule}{words}", {})[f"joint {name}"] = terms
        return steps

    @cached_property
    def _steps(self) -> list[Steps]:
        tables = self._list_step_tables(self.several)
        return [each.list_body_steps() | each.list_steps() for each in tables]


def list_unit_bodies() -> Iterator[RobotBody]:
    """Bodies whose parameters add up with any factors to those of every body.

    Each is of mass 1 (for 0 has no centre), so that a parameter's effect is one less the first's.
    """
    yield RobotBody(1.0, np.zeros(3), np.zeros((3, 3)))
    for com in np.eye(3):
        yield RobotBody(1.0, com, -compute_point_inertia(1.0, com))
    for i, j in zip(*UPPER, strict=True):
        yield RobotBody(1.0, np.zeros(3), set_entry(np.zeros((3, 3)), (int(i), int(j)), 1.0))


def list_parameters(body: RobotBody) -> np.ndarray:
    """Mass, first moments and inertia about the joint (10,), on which terms depend linearly."""
    about = body.inertia + compute_point_inertia(body.mass, body.com)
    return np.array([body.mass, *body.mass * body.com, *about[UPPER]])
