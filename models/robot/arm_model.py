"""A planar arm's model by an engine's model of the robot that the arm is."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import geared_layout, rigid_layout
from crosscheck.models.experiment.drive import drive_data
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.robot.driven import DrivenRobot
from crosscheck.models.robot.planar import build_level_robots
from crosscheck.models.robot.robot import Level, Robot
from crosscheck.models.robot.start import start_state


class ArmModel(DrivenRobot):
    """The arm as a robot in the layout's coordinates; level: one of ``build_level_robots``."""

    level: ClassVar[str]

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        super().__init__(arm, scenario, chosen_switches)
        is_geared = self.level == "geared"
        self.layout = geared_layout(arm, self.switches) if is_geared else rigid_layout(arm)
        displaced = [not coordinate.is_angle for coordinate in self.layout.coordinates]
        self.order = np.argsort(displaced, kind="stable")
        self._drive = drive_data(scenario, len(arm.joints))

    def find_robot(self) -> tuple[Robot, Level]:
        """The robot that the arm is, its planets lumped or free as the switch says, and its level.

        Raises InputError.
        """
        robot, level = build_level_robots(self.arm)[self.level]
        free = self.switches.planets == "free"
        stages = [replace(stage, has_free_planets=free) for stage in robot.stages]
        return replace(robot, stages=tuple(stages)), level

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates (n,) of the scenario's start, which are the robot's."""
        q, v = start_state(*self.find_robot(), self.scenario)
        return q[self.back], v[self.back]
