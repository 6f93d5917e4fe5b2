"""Members of a study that are robots."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from crosscheck.models import loading
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.robot.file import RobotFile, RobotSource
from crosscheck.models.robot.robot import RIGID, Level, Robot
from crosscheck.registry import find_level_engines
from crosscheck.studies.definition.quantities import SIGNALS
from crosscheck.studies.members.cases import MemberCase, Raw

if TYPE_CHECKING:
    import xarray as xr

    from crosscheck.analytic.robot.runs import RobotMember
    from crosscheck.studies.definition.definition import Definition


def read_member(
    data: Raw, definition: Definition, scenario: Scenario, robot: Robot | None
) -> MemberCase:
    """The case of a study's data; robot: where it is read already. Raises InputError."""
    name, level = definition.mechanism, definition.level
    if robot is None:
        file = loading.validate_record(RobotFile, data["robot"], name)
        robot = RobotSource(file=file, urdf_text=data["urdf"]).build(name)
    if level is not None and level not in robot.levels:
        raise InputError(name, "level", level, f"{robot.name} has {', '.join(robot.levels)}")
    return make_case(robot, level or robot.levels[-1], scenario)


def make_case(robot: Robot, level: Level, scenario: Scenario) -> MemberCase:
    """The case of a robot at a level; joints are as long in work as meshes."""
    planets = {stage.joint: stage.gears.planet_count for stage in robot.stages}
    meshes = len(robot.meshes) + sum(2 * len(each.groups) for each in robot.stages)
    return MemberCase(
        robot,
        scenario,
        None,
        level,
        signals=SIGNALS,
        rigid_levels=RIGID,
        second_model=f"{find_level_engines(level)[1]}:{level}",
        planet_counts=[planets.get(joint, 0) for joint in range(len(robot.joints))],
        free_planets=robot.planet_counts,
        mesh_count=2 * len(robot.joints) + (meshes if level == "geared" else 0),
    )


def require_fit(case: MemberCase, definition: Definition) -> None:
    """Raise InputError unless robot and scenario fit each other."""
    loading.require_fit(case.scenario, case.mechanism, definition.scenario)


def make_model(case: MemberCase) -> RobotMember:
    """The robot at its level in its experiment, as its kernel takes it."""
    from crosscheck.analytic.robot.runs import RobotMember

    assert case.level is not None  # as it was read
    return RobotMember(case.mechanism, case.level, case.scenario)


def find_rigid_model(
    case: MemberCase, level: Level, smooth: Scenario
) -> tuple[object, Callable[[], Any]]:
    """Key of the rigid model in a smooth experiment, by its numbers, and what gives it."""
    from crosscheck.analytic.robot.runs import RobotMember

    model = RobotMember(case.mechanism, level, smooth)
    numbers = frozenset(model.equations.numbers.items())
    return (numbers, model.equations.structure, smooth), lambda: model


def make_run(case: MemberCase, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> xr.Dataset:
    """The Dataset of a run with these signals over time [s]."""
    from crosscheck.models.robot.trajectory import make_robot_dataset

    name = f"ensemble:{case.level}"
    return make_robot_dataset(name, case.mechanism, case.scenario, time, dict(signals))
