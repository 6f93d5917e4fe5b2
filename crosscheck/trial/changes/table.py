"""Effect of each change of a robot on its terms at the states; values that a number may have."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot, multiply
from crosscheck.checks.first_principles.slopes import compute_slopes, make_smooth_rule
from crosscheck.checks.robot_states import TOLERANCE
from crosscheck.models.errors import InputError
from crosscheck.models.robot.robot import Level, Robot
from crosscheck.trial.changes.kane import KaneSum
from crosscheck.trial.changes.mistakes import (
    BodyPart,
    list_all_numbers,
    list_body_parts,
    list_whole_bodies,
)
from crosscheck.trial.changes.numbers import (
    ALIKE,
    FIXED,
    RobotNumber,
    is_physical,
    list_equal_numbers,
)
from crosscheck.trial.changes.problem import ChangeProblem, DynamicsTerms
from crosscheck.trial.changes.steps import Steps, StepTable
from crosscheck.trial.coordinates.differences import TURN_RAD

RULES = {  # of the bias M' v - 1/2 d(v' M v)/dq: factors of M' v and of d(v' M v)/dq
    "M' v alone, without -1/2 d(v' M v)/dq": (1.0, 0.0),
    "+1/2 d(v' M v)/dq for -1/2": (1.0, 0.5),
    "d(v' M v)/dq without its factor 1/2": (1.0, -1.0),
    "-1/2 d(v' M v)/dq alone, without M' v": (0.0, -0.5),
    "+1/2 d(v' M v)/dq alone, as of Christoffel's C transposed": (0.0, 0.5),
}
LEAST_ROWS = 12  # rows of one part at which robots are screened
# Entries of M, at all states, of each step of Kane's sum; and fewest states.
MOST_ENTRIES, LEAST_STATES = 600, 3
POSITIVE = ("kg",)  # units of numbers of which none is below 0


class ChangeTable:
    """Effect of each change of a robot on its terms at the states, for all levels.

    numbers: those that may be wrong, where they are not the robot's own, as those of an arm's file.
    """

    def __init__(
        self, problem: ChangeProblem, numbers: Sequence[RobotNumber] | None = None
    ) -> None:
        self.problem, self.robot, self.states = problem, problem.robot, problem.states
        self.numbers = list(list_all_numbers(self.robot) if numbers is None else numbers)
        count, size = self.states.q.shape
        self.few = slice(min(count, -(-LEAST_ROWS // size)))  # states at which all are screened
        # States of steps of Kane's sum, which are many: fewer of large robots.
        self.several = slice(min(count, max(LEAST_STATES, MOST_ENTRIES // size**2)))
        self.kane = KaneSum(self.robot, self.states.q, self.states.v)
        self._bases: dict[Level, DynamicsTerms] = {}

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
        base, (q, v) = self.compute_base(level), (each[states] for each in self.states[:2])
        changes = [np.zeros((len(robots), *term[states].shape)) for term in base]
        for number, robot in enumerate(robots):
            for change, term, right in zip(
                changes, AnalyticRobot(robot, level).terms(q, v), base, strict=True
            ):
                change[number] = term - right[states]
        return DynamicsTerms(*changes)

    def select_numbers(self, level: Level) -> list[RobotNumber]:
        """The numbers that may change something at a level, by their square at most."""
        rotors = ("rotors", "stages") if level == "links" else ()
        return [each for each in self.numbers if not each.path.startswith(rotors)]

    def compute_number_effects(self, level: Level) -> tuple[DynamicsTerms, DynamicsTerms]:
        """First- and second-order effects (numbers, states, ...) of the numbers of a level.

        By steps upwards alone, since an arm's file has no mass and no inertia below zero.
        """
        numbers = self.select_numbers(level)
        robots = [each.put(each.value + by * each.step) for by in (1, 2) for each in numbers]
        changes = self.compute_changes(robots, level)
        pairs = [(term[: len(numbers)], term[len(numbers) :]) for term in changes]
        linear = DynamicsTerms(*(2 * once - twice / 2 for once, twice in pairs))
        return linear, DynamicsTerms(*(twice / 2 - once for once, twice in pairs))

    @cached_property
    def part_lists(self) -> list[list[BodyPart]]:
        """The links of the URDF, then bodies of several links fixed together, if there are any."""
        parts, bodies = list_body_parts(self.robot), list_whole_bodies(self.robot)
        return [parts, bodies] if len(parts) > len(bodies) else [parts]

    def _list_step_tables(self, kane: KaneSum) -> list[StepTable]:
        pairs = zip(self.part_lists, ("", FIXED), strict=False)
        return [StepTable(kane, parts, suffix) for parts, suffix in pairs]

    @cached_property
    def body_steps(self) -> list[Steps]:
        """What numbers of links may be taken for; then of bodies of several links."""
        return [each.list_body_steps() for each in self._list_step_tables(self.kane)]

    def list_steps(self, level: Level) -> list[Steps]:
        """Mistakes in Kane's sum at several states, with what each changes by what has it."""
        return [*self._steps, self._list_rule_steps(level)]

    def _list_rule_steps(self, level: Level) -> Steps:
        """Lagrange's rule for the bias of M with other factors, by the coordinate of a slope."""
        q, v = (each[self.several] for each in self.states[:2])
        model, steps = AnalyticRobot(self.robot, level), Steps()
        turned = TURN_RAD / np.maximum(1.0, np.abs(self.robot.joint_map[0]).sum(axis=0))
        slopes = compute_slopes(model.mass_matrix, q, make_smooth_rule(turned))
        names, units, still = self.robot.coordinate_names, np.eye(len(turned)), np.zeros_like(v)
        for name, unit, slope in zip(names, units, slopes, strict=True):
            growth = multiply(slope, v) * (v @ unit)[:, None]
            energy = np.einsum("sij,si,sj->s", slope, v, v)
            for rule, (by_growth, by_energy) in RULES.items():
                bias = (by_growth - 1) * growth + (by_energy + 0.5) * np.outer(energy, unit)
                terms = DynamicsTerms(np.zeros((*still.shape, len(unit))), bias, still)
                steps.setdefault(rule, {})[f"joint {name}"] = terms
        return steps

    @cached_property
    def _steps(self) -> list[Steps]:
        q, v = (each[self.several] for each in self.states[:2])
        tables = self._list_step_tables(KaneSum(self.robot, q, v))
        return [each.list_body_steps() | each.list_steps() for each in tables]


class ValueSearch:
    """A search among values of the numbers in a table of changes."""

    def __init__(self, problem: ChangeProblem, table: ChangeTable) -> None:
        self.problem, self.level, self.table = problem, problem.level, table

    def is_possible(self, number: RobotNumber, value: float) -> bool:
        """Whether such a robot is possible, or the value is what omitting or doubling it gives."""
        try:
            robot = number.put(value)
        except InputError:  # an arm's, which is read from a file of such numbers
            return False
        is_negative = number.unit in POSITIVE and value < -ALIKE * number.step
        if is_negative and not number.has_usual_factor(value):
            return False
        usual = number.has_usual_factor(value, above=0)
        usual |= value * number.value > 0 and bool(number.describe_unit(value))
        if not (usual or is_physical(robot, self.problem.robot)):
            return False
        return "acceleration" not in self.problem.parts or self._is_regular(robot)

    def _is_regular(self, robot: Robot) -> bool:
        """Whether a robot's M can be inverted: without accelerations every balance would hold."""
        mass = AnalyticRobot(robot, self.level).mass_matrix(self.problem.states.q)
        scaled = mass / self.problem.sizes["mass_matrix"]
        return bool((np.linalg.eigvalsh(scaled)[:, 0] > TOLERANCE).all())

    def describe_value(self, number: RobotNumber, value: float) -> str:
        """The number with a value, in words that complete `with ...`."""
        same = self._equal_number_name(number, value)
        return number.words(value) + (f", {same}" if same else "")

    def is_usual(self, number: RobotNumber, value: float) -> bool:
        """Whether a value is one that a person may well have written by mistake."""
        usual = number.has_usual_factor(value) or bool(number.describe_unit(value))
        return usual or bool(self._equal_number_name(number, value))

    def _equal_number_name(self, number: RobotNumber, value: float) -> str:
        """The file's number that a value is, or has added to its own, in words; '' for none."""
        is_opposite = abs(value + number.value) < ALIKE * number.step
        if abs(value) < ALIKE * number.step or is_opposite or not number.unit or number.factor:
            return ""
        others = [each for each in self.table.numbers if each.path != number.path]
        others = [each for each in others if each.quantity == number.quantity]
        if equal := list_equal_numbers(others, value):
            return f"as {equal[0].name}"
        step = value - number.value
        if number.has_usual_factor(value):
            return ""
        equal = list_equal_numbers(others, abs(step))
        return f"with {equal[0].name} {'subtracted' if step < 0 else 'added'}" if equal else ""
