"""A robot in an experiment, from files and ``path=value`` settings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Scenario, find_misfit
from crosscheck.models.files import read_raw_scenario
from crosscheck.models.loading import apply_setting, validate_record
from crosscheck.models.robot.file import RobotSource, read_robot_file, read_source
from crosscheck.models.robot.robot import Robot

SECTIONS = ("robot", "scenario")


class RobotCase(NamedTuple):
    """A robot, what its files say, and the experiment."""

    robot: Robot
    source: RobotSource
    scenario: Scenario


def load_robot_case(name: str, scenario: str, settings: Sequence[str] = ()) -> RobotCase:
    """Robot and scenario by name or file, settings applied before validation. Raises InputError."""
    data = {"robot": read_robot_file(name), "scenario": read_raw_scenario(scenario)}
    for setting in settings:
        apply_setting(data, setting, SECTIONS)
    source, robot = read_source(name, data["robot"])
    chosen = validate_record(Scenario, data["scenario"], scenario)
    require_robot_fit(chosen, robot, scenario)
    return RobotCase(robot, source, chosen)


def load_changed_robot(name: str, settings: Sequence[str]) -> Robot:
    """A robot by name or file, settings of ``robot`` applied. Raises InputError."""
    data = {"robot": read_robot_file(name)}
    for setting in settings:
        apply_setting(data, setting, SECTIONS[:1])
    return read_source(name, data["robot"])[1]


def require_robot_fit(scenario: Scenario, robot: Robot, where: str = "") -> None:
    """Raise InputError unless the scenario's lists are of as many joints as are free."""
    where = where or scenario.name
    joints = len(robot.coordinates)
    misfit = find_misfit(scenario, [1] * joints)
    if misfit is not None and not misfit[0].startswith("start.planet_offset_m"):
        field, value, needed = misfit
        raise InputError(where, field, value, f"{needed}; {robot.name} has {joints} free joints")
    if scenario.start.planet_offset_m:
        allowed = "is for planar arms: a robot's planets move alike"
        raise InputError(where, "start.planet_offset_m", None, allowed)
