"""A robot's equations as a kernel runs them: structure, numbers and coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from crosscheck.analytic.derivation.gears import Gears, PlacedStage, gather_gears
from crosscheck.analytic.kernel.batch import SteppedEquations
from crosscheck.analytic.kernel.expressions import StraightLines, evaluate_constants
from crosscheck.analytic.kernel.numbers import Numbers, drive_numbers, stage_numbers
from crosscheck.analytic.kernel.structure import common_structure
from crosscheck.analytic.robot.algorithms import Mechanism
from crosscheck.analytic.robot.mechanism import build_mechanism, name_numbers
from crosscheck.analytic.robot.structure import RobotStructure, trace_forward_dynamics
from crosscheck.models.experiment.drive import CONSTANT, DriveData
from crosscheck.models.robot.robot import MESH_LAWS, Level, Robot


@dataclass(frozen=True)
class RobotEquations(SteppedEquations):
    """Equations of a robot at a level, its motors driven by a law."""

    robot: Robot
    level: Level
    drive: DriveData

    @cached_property
    def labels(self) -> tuple[int, ...]:
        """The number of every joint from 1 on, free joints first."""
        free = self.robot.coordinates
        others = [n for n in range(len(self.robot.joints)) if n not in free]
        order = [*free, *others]
        return tuple(order.index(n) + 1 for n in range(len(order)))

    @cached_property
    def gears(self) -> Gears:
        """Meshes of planetary stages by the labels of their joints; none of rigid gears."""
        stages = zip(self.robot.stages, self.robot.stage_columns, strict=True)
        staged = sorted(
            (self.labels[stage.joint] - 1, columns.start, stage)
            for stage, columns in (stages if self.level == "geared" else ())
        )
        placed_stages = [
            PlacedStage(stage.gears, number, first, stage.has_free_planets)
            for number, first, stage in staged
        ]
        return gather_gears(placed_stages, range(len(self.labels)), MESH_LAWS)

    @cached_property
    def _named(self) -> tuple[Mechanism, dict[str, float]]:
        return name_numbers(build_mechanism(self.robot, self.level))

    @cached_property
    def structure(self) -> RobotStructure:
        """Structure of the robot, which the kernel's text depends on."""
        is_geared = self.level == "geared"
        return RobotStructure(
            *common_structure(range(len(self.labels)), self.gears, self.drive),
            mechanism=self._named[0],
            labels=self.labels,
            rotor_meshes=len(self.robot.meshes) if is_geared else 0,
            stage_labels=tuple(
                self.labels[stage.joint] for stage in self.robot.stages if is_geared
            ),
        )

    @cached_property
    def numbers(self) -> Numbers:
        """Numbers of bodies, rotors, meshes and drive, by name, in SI units."""
        structure = self.structure
        numbers = self.constants(trace_forward_dynamics(structure)) | drive_numbers(self.drive)
        for name, (_, mesh) in zip(structure.rotor_names, self.robot.meshes, strict=False):
            numbers |= {
                f"k_{name}": mesh.stiffness_N_per_m,
                f"d_{name}": mesh.damping_N_s_per_m,
                f"b_{name}": mesh.backlash_m,
            }
        return numbers | stage_numbers(structure, self.gears)

    def constants(self, text: StraightLines) -> Numbers:
        """Numbers of the mechanism, and what a text needs of them, by name."""
        given = self._named[1]
        return {**given, **evaluate_constants(text.constants, given)}


def build_equations(robot: Robot, level: Level) -> RobotEquations:
    """Equations of a robot whose motors' torques are given from outside."""
    free = len(robot.coordinates)
    none = DriveData(CONSTANT, np.zeros((free, 3)), np.zeros(1), np.zeros((free, 1)))
    return RobotEquations(robot, level, none)
