"""What a number of a mechanism may be taken for: values that are possible, and usual mistakes."""

from __future__ import annotations

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robot_states import TOLERANCE
from crosscheck.models.errors import InputError
from crosscheck.models.robot.robot import Robot
from crosscheck.trial.changes.numbers import ALIKE, RobotNumber, is_physical, list_equal_numbers
from crosscheck.trial.changes.problem import ChangeProblem
from crosscheck.trial.changes.table import ChangeTable

POSITIVE = ("kg",)  # units of numbers of which none is below 0


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
        """The number of the file that a value is, or is more or less by, in words; '' for none."""
        is_opposite = abs(value + number.value) < ALIKE * number.step
        if abs(value) < ALIKE * number.step or is_opposite or not number.unit or number.factor:
            return ""
        others = [each for each in self.table.numbers if each.path != number.path]
        if equal := list_equal_numbers(others, number.unit, value):
            return f"as {equal[0].name}"
        step = value - number.value
        if number.has_usual_factor(value):
            return ""
        equal = list_equal_numbers(others, number.unit, abs(step))
        return f"{'less' if step < 0 else 'more'} by {equal[0].name}" if equal else ""
