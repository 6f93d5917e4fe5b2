"""A robot and its experiments, from files and ``path=value`` settings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.files import read_raw_scenario
from crosscheck.models.loading import Selection, apply_setting, require_fit, validate_record
from crosscheck.models.robot.file import fill_masses, read_robot_file, read_source


def read_robot_data(name: str) -> dict[str, Any]:
    """A robot's file as data with paths to every link's mass, and the URDF's text.

    Raises InputError.
    """
    content = read_robot_file(name)
    source, _ = read_source(name, content)
    fill_masses(content, source.urdf_text, source.file.urdf)
    return {"robot": content, "urdf": source.urdf_text}


def select_robot(
    name: str, scenarios: Sequence[str] = (), settings: Sequence[str] = ()
) -> Selection:
    """Robot and scenarios by name or file, settings applied before validation. Raises InputError.

    A setting of the scenario holds for each.
    """
    experiments = []
    for scenario in scenarios or [""]:
        data = {"robot": read_robot_file(name)}
        if scenario:
            data["scenario"] = read_raw_scenario(scenario)
        if any(setting.strip().startswith("robot.links.") for setting in settings):
            source, _ = read_source(name, data["robot"])
            fill_masses(data["robot"], source.urdf_text, source.file.urdf)
        for setting in settings:
            apply_setting(data, setting, tuple(data))
        _, robot = read_source(name, data["robot"])
        if scenario:
            experiments.append(validate_record(Scenario, data["scenario"], scenario))
            require_fit(experiments[-1], robot, scenario)
    return Selection(robot, tuple(experiments))
