"""A robot in an experiment, from files and ``path=value`` settings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.files import read_raw_scenario
from crosscheck.models.loading import apply_setting, require_fit, validate_record
from crosscheck.models.robot.file import fill_masses, read_robot_file, read_source
from crosscheck.models.robot.robot import Robot

SECTIONS = ("robot", "scenario")


class RobotCase(NamedTuple):
    """A robot in an experiment."""

    robot: Robot
    scenario: Scenario


def read_robot_data(name: str) -> dict[str, Any]:
    """A robot's file as data with paths to every link's mass, and the URDF's text.

    Raises InputError.
    """
    content = read_robot_file(name)
    source, _ = read_source(name, content)
    fill_masses(content, source.urdf_text, source.file.urdf)
    return {"robot": content, "urdf": source.urdf_text}


def load_robot_case(name: str, scenario: str, settings: Sequence[str] = ()) -> RobotCase:
    """Robot and scenario by name or file, settings applied before validation. Raises InputError."""
    data = {"robot": read_robot_file(name), "scenario": read_raw_scenario(scenario)}
    robot = _apply_settings(name, data, settings, SECTIONS)
    chosen = validate_record(Scenario, data["scenario"], scenario)
    require_fit(chosen, robot, scenario)
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
