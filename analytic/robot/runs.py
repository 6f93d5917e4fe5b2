"""Runs of robots by the traced kernel."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.analytic.ensemble import run_alone
from crosscheck.analytic.kernel.adaptive_kernel import integrate_precisely
from crosscheck.analytic.kernel.program import RUNS, STATES
from crosscheck.analytic.robot.equations import RobotEquations
from crosscheck.models.experiment.drive import drive_data
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.interface import require_finite
from crosscheck.models.robot.robot import Level, Robot
from crosscheck.models.robot.start import start_state
from crosscheck.models.signal_map import SignalMap, map_robot
from crosscheck.models.trajectory import recorded_times

if TYPE_CHECKING:
    from crosscheck.models.robot.interface import RobotModel

# Steps below which a run takes less time than optimising its kernel: of seven joints 20 ms.
BRIEF_STEPS = 10_000


class RobotMember:
    """A robot at a level in an experiment, as a batch takes it."""

    def __init__(self, robot: Robot, level: Level, scenario: Scenario) -> None:
        self.robot, self.level, self.scenario = robot, level, scenario
        self.name = f"analytic:{level}"
        self.drive = drive_data(scenario, len(robot.coordinates), robot.motors)
        self.equations = RobotEquations(robot, level, self.drive)

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates at the start."""
        return start_state(self.robot, self.level, self.scenario)

    @property
    def signal_layout(self) -> object:
        """The joints that the records of signals belong to."""
        rotors = tuple(rotor.joint for rotor, _ in self.robot.meshes)
        stages = tuple((each.joint, each.coordinates) for each in self.robot.stages)
        return self.level, rotors, stages, tuple(joint.mimic for joint in self.robot.joints)

    @cached_property
    def signals(self) -> SignalMap:
        """What the signals are of the kernel's records."""
        return map_robot(self.robot, self.level, self.equations.labels)

    @cached_property
    def edges(self) -> np.ndarray:
        """Half clearances (meshes,) [m], in the order of the kernel's meshes."""
        rotors = [mesh.backlash_m for _, mesh in self.robot.meshes]
        count = self.equations.structure.rotor_meshes
        return np.concatenate([rotors[:count], self.equations.gears.b])


def run_robot(model: RobotModel, scenario: Scenario) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and rates (records, n) by fixed steps. Raises Diverged."""
    level = STATES if scenario.steps < BRIEF_STEPS else RUNS
    q, v, *_ = run_alone(RobotMember(model.robot, model.level, scenario), level)
    return q, v


def run_precisely(
    model: RobotModel, scenario: Scenario, rtol: float
) -> tuple[np.ndarray, np.ndarray]:
    """The same by adaptive steps that end where contacts change. Raises Diverged."""
    member = RobotMember(model.robot, model.level, scenario)
    q, v, *_ = integrate_precisely(member, rtol).records
    require_finite(member.name, recorded_times(scenario), q, v)
    return q, v
