"""The states at which a robot's trial asks equations, found by asking ones that take notes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from crosscheck.models.robot.robot import Robot
from crosscheck.registry import register
from crosscheck.trial.robots.subject import prepare_questions
from crosscheck.trial.tables.state_requests import (
    PARTS,
    AnsweredTrial,
    Call,
    StateRequest,
    build_request,
    name_columns,
)

UNITS = {"revolute": ("rad", "N_m"), "prismatic": ("m", "N")}  # of a coordinate and its torque


class RobotTableTrial(AnsweredTrial):
    """A trial of a robot's answers."""

    usual = (PARTS[:5],)
    most_coordinates = float("inf")
    least_digits = 12  # a robot's entries are judged to 1e-10 of their sizes

    def collect_request(self, groups: Iterable[Sequence[str]], first: int) -> StateRequest:
        """The states at which groups of parts are asked. Raises InputError."""
        notes: dict[Call, None] = {}
        robot: Robot = self.mechanism
        size, name = len(robot.coordinates), "what is asked"
        for parts in groups:
            equations = self.record_equations(parts, size, notes)
            questions = prepare_questions(self.make_request(name, equations))
            with register(name, questions.entry):
                for task in (task for part in parts for task in questions.list_tasks(part)):
                    task.perform()
        joints = [robot.joints[number] for number in robot.coordinates]
        names = tuple(joint.name for joint in joints)
        units = [UNITS[joint.kind] for joint in joints]
        torque = [f"torque_{name}_{unit[1]}" for name, unit in zip(names, units, strict=True)]
        mapped = questions.is_mapped
        names = tuple(f"x_{number + 1}" for number in range(size)) if mapped else names
        columns = name_columns(names, [unit[0] * (not mapped) for unit in units], torque)
        return build_request(robot, names, columns, self.parts, notes, first)
