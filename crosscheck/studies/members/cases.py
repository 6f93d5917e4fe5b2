"""A member of a study: an arm or a robot in an experiment, and what a study asks of it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import PdDrive, Scenario, expand_to_joints
from crosscheck.models.loading import (
    Case,
    require_fit,
    require_fitting,
    validate_record,
    validate_switches,
)
from crosscheck.models.robot.file import RobotFile, RobotSource
from crosscheck.models.robot.robot import RIGID, Level, Robot
from crosscheck.models.trajectory import build_trajectory
from crosscheck.registry import RIGID_LEVELS, build, find_level_engines, second_engine
from crosscheck.studies.definition.quantities import ARM_SIGNALS, SIGNALS
from crosscheck.studies.members.starts import perturb_offsets, perturb_start

if TYPE_CHECKING:
    import xarray as xr

    from crosscheck.studies.definition.definition import Definition

Raw = dict[str, Any]  # by section, what the files of a mechanism and a scenario hold


class ArmCase(Case):
    """An arm in an experiment, as a study asks it."""

    __slots__ = ()

    @property
    def mechanism(self) -> Arm:
        """The arm."""
        return self.arm

    @property
    def planet_counts(self) -> Sequence[int]:
        """Number of planets of each joint, 0 without a stage."""
        return [joint.planet_count for joint in self.arm.joints]

    @property
    def mesh_count(self) -> int:
        """How many meshes are worked out in a step."""
        planets = [count for count in self.planet_counts if count]
        return 2 * (sum(planets) if self.switches.planets == "free" else len(planets))

    @property
    def signals(self) -> tuple[str, ...]:
        """Names of the signals that its runs can have."""
        return ARM_SIGNALS

    @property
    def rigid_levels(self) -> tuple[str, ...]:
        """Levels of rigid models that its runs can be compared with."""
        return RIGID_LEVELS

    @property
    def second_engine(self) -> str:
        """Name of the model that runs spot checks."""
        return second_engine()

    def targets(self) -> np.ndarray:
        """Targets (joints,) of a PD drive [rad]."""
        return _free_targets(self.scenario, len(self.arm.joints))

    def perturb(self, seed: int, size_m: float) -> ArmCase:
        """The case from a start whose mesh displacements differ by up to ``size_m``, by a seed."""
        return ArmCase(*perturb_start(self, seed, size_m))

    def make_run(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> xr.Dataset:
        """The Dataset of a run with these signals over time [s]."""
        return build_trajectory("ensemble", self.arm, self.scenario, self.switches, time, **signals)

    def simulate_second(self) -> xr.Dataset:
        """The run by the second engine. Raises Diverged."""
        return build(second_engine(), *self).simulate()

    @classmethod
    def build(
        cls, data: Raw, definition: Definition, previous: Self | None, changed: Collection[str]
    ) -> ArmCase:
        """The case of a study's data; only sections that changed are read again.

        Raises InputError.
        """
        name = definition.mechanism
        arm, scenario, chosen = previous or (None, None, None)
        if arm is None or "arm" in changed:
            arm = validate_record(Arm, data["arm"], name)
        if scenario is None or "scenario" in changed:
            scenario = validate_record(Scenario, data["scenario"], definition.scenario)
        if chosen is None or "switches" in changed or "arm" in changed:
            chosen = validate_switches(data["switches"], arm)
        case = ArmCase(arm, scenario, chosen)
        require_fitting(case, name, definition.scenario)
        return case


@dataclass(frozen=True)
class RobotMemberCase:
    """A robot at a level in an experiment, as a study asks it."""

    robot: Robot
    level: Level
    scenario: Scenario

    switches = None

    @property
    def mechanism(self) -> Robot:
        """The robot."""
        return self.robot

    @cached_property
    def planet_counts(self) -> Sequence[int]:
        """Number of planets of each joint that moves, 0 without a stage."""
        by_joint = {stage.joint: stage.gears.planet_count for stage in self.robot.stages}
        return [by_joint.get(joint, 0) for joint in range(len(self.robot.joints))]

    @property
    def mesh_count(self) -> int:
        """Meshes that are worked out in a step, and joints, whose dynamics take about as long."""
        meshes = len(self.robot.meshes) + sum(2 * len(each.groups) for each in self.robot.stages)
        return 2 * len(self.robot.joints) + (meshes if self.level == "geared" else 0)

    @property
    def signals(self) -> tuple[str, ...]:
        """Names of the signals that its runs can have."""
        return SIGNALS

    @property
    def rigid_levels(self) -> tuple[str, ...]:
        """Levels of rigid models that its runs can be compared with."""
        return RIGID

    @property
    def second_engine(self) -> str:
        """Name of the engine that runs spot checks."""
        return find_level_engines(self.level)[1]

    def targets(self) -> np.ndarray:
        """Targets (joints,) of a PD drive [rad], [m], of all joints that move."""
        factors, offsets = self.robot.joint_map
        return factors @ _free_targets(self.scenario, factors.shape[1]) + offsets

    def perturb(self, seed: int, size_m: float) -> RobotMemberCase:
        """The case from a start whose mesh displacements differ by up to ``size_m``, by a seed."""
        start = self.scenario.start
        planets, generator = self.robot.planet_counts, np.random.default_rng(seed)
        update = perturb_offsets(start, planets, generator, size_m)
        moved = self.scenario.model_copy(update={"start": start.model_copy(update=update)})
        return replace(self, scenario=moved)

    def make_run(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> xr.Dataset:
        """The Dataset of a run with these signals over time [s]."""
        from crosscheck.models.robot.trajectory import make_robot_dataset

        name = f"ensemble:{self.level}"
        return make_robot_dataset(name, self.robot, self.scenario, time, dict(signals))

    def simulate_second(self) -> xr.Dataset:
        """The run by the second engine. Raises Diverged."""
        name = f"{self.second_engine}:{self.level}"
        return build(name, self.robot, self.scenario).simulate()

    @classmethod
    def build(
        cls, data: Raw, definition: Definition, previous: Self | None, changed: Collection[str]
    ) -> RobotMemberCase:
        """The case of a study's data; only sections that changed are read again.

        Raises InputError.
        """
        name = definition.mechanism
        if previous is None or "robot" in changed:
            file = validate_record(RobotFile, data["robot"], name)
            robot = RobotSource(file=file, urdf_text=data["urdf"]).build(name)
            level = require_level(robot, definition.level, name)
        else:
            robot, level = previous.robot, previous.level
        if previous is None or "scenario" in changed:
            scenario = validate_record(Scenario, data["scenario"], definition.scenario)
        else:
            scenario = previous.scenario
        require_fit(scenario, robot, definition.scenario)
        return RobotMemberCase(robot, level, scenario)


MemberCase = ArmCase | RobotMemberCase  # which have the same names for all that a study asks


def require_level(robot: Robot, level: Level | None, where: str) -> Level:
    """A study's level of a robot: its most detailed one unless chosen. Raises InputError."""
    if level is not None and level not in robot.levels:
        raise InputError(where, "level", level, f"{robot.name} has {', '.join(robot.levels)}")
    return level or robot.levels[-1]


def build_case(
    data: Raw,
    definition: Definition,
    previous: MemberCase | None = None,
    changed: Collection[str] = (),
) -> MemberCase:
    """The case of a study's data; only sections that changed are read again. Raises InputError."""
    if "robot" in data:
        made = previous if isinstance(previous, RobotMemberCase) else None
        return RobotMemberCase.build(data, definition, made, changed)
    return ArmCase.build(
        data, definition, previous if isinstance(previous, ArmCase) else None, changed
    )


def _free_targets(scenario: Scenario, joints: int) -> np.ndarray:
    """Targets (joints,) of the PD drive."""
    assert isinstance(scenario.drive, PdDrive)  # as was required
    return np.array(expand_to_joints(scenario.drive.target_rad, joints))
