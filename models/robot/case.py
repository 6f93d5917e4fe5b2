"""A robot in an experiment, from files and ``path=value`` settings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Scenario, find_misfit
from crosscheck.models.files import read_raw_scenario
from crosscheck.models.loading import apply_setting, validate_record
from crosscheck.models.robot.file import fill_masses, read_robot_file, read_source
from crosscheck.models.robot.robot import Robot

SECTIONS = ("robot", "scenario")


class RobotCase(NamedTuple):
    """A robot in an experiment."""

    robot: Robot
    scenario: Scenario


def read_robot_data(name: str) -> dict[str, Any]:
    """What ``gather_robot_data`` gives of a robot by name or file. Raises InputError."""
    content = read_robot_file(name)
    source, _ = read_source(name, content)
    return gather_robot_data(content, source.urdf_text, source.file.urdf)


def gather_robot_data(content: dict[str, Any], urdf_text: str, where: str) -> dict[str, Any]:
    """A robot's file as data with paths to every link's mass, and the URDF's text.

    content: of the robot's file, which is changed; where: the URDF. Raises InputError.
    """
    fill_masses(content, urdf_text, where)
    return {"robot": content, "urdf": urdf_text}


def load_robot_case(name: str, scenario: str, settings: Sequence[str] = ()) -> RobotCase:
    """Robot and scenario by name or file, settings applied before validation. Raises InputError."""
    data = {"robot": read_robot_file(name), "scenario": read_raw_scenario(scenario)}
    robot = _apply_settings(name, data, settings, SECTIONS)
    chosen = validate_record(Scenario, data["scenario"], scenario)
    require_robot_fit(chosen, robot, scenario)
    return RobotCase(robot, chosen)


def load_changed_robot(name: str, settings: Sequence[str]) -> Robot:
    """A robot by name or file, settings of ``robot`` applied. Raises InputError."""
    return _apply_settings(name, {"robot": read_robot_file(name)}, settings, SECTIONS[:1])


def _apply_settings(
    name: str, data: dict[str, Any], settings: Sequence[str], sections: Sequence[str]
) -> Robot:
    """The robot of changed data. Raises InputError."""
    if any(setting.strip().startswith("robot.links.") for setting in settings):
        source, _ = read_source(name, data["robot"])
        fill_masses(data["robot"], source.urdf_text, source.file.urdf)
    for setting in settings:
        apply_setting(data, setting, sections)
    return read_source(name, data["robot"])[1]


def require_robot_fit(scenario: Scenario, robot: Robot, where: str = "") -> None:
    """Raise InputError unless the scenario's lists are of as many joints as are free."""
    where = where or scenario.name
    joints = len(robot.coordinates)
    if scenario.start.planet_offset_m and not any(robot.planet_counts):
        allowed = f"needs a stage with planets = free, which {robot.name} has not"
        raise InputError(where, "start.planet_offset_m", None, allowed)
    misfit = find_misfit(scenario, robot.planet_counts)
    if misfit is not None:
        field, value, needed = misfit
        raise InputError(where, field, value, f"{needed}; {robot.name} has {joints} free joints")
