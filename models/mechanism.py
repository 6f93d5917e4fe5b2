"""A mechanism, which is an arm or a robot, and an experiment with it: the readers of both.

Whatever a name, a file or a study's content is of is decided here, and nowhere behind it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from fnmatch import fnmatchcase
from typing import Any

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.files import is_robot, read_raw_arm
from crosscheck.models.loading import (
    Selection,
    apply_settings,
    load_scenario,
    load_selection,
    require_fit,
    validate_scenarios,
)
from crosscheck.models.robot.file import fill_masses, read_robot_file, read_source
from crosscheck.models.robot.robot import Robot

Mechanism = Arm | Robot


def select_mechanism(
    name: str, scenarios: Sequence[str] = (), settings: Sequence[str] = ()
) -> Selection:
    """Mechanism and scenarios by name or file, with ``path=value`` settings. Raises InputError."""
    try:
        return (select_robot if is_robot(name) else load_selection)(name, scenarios, settings)
    except InputError as error:
        field = re.sub(r"\[(\d+)\]", r".\1", error.field)
        paths = [setting.partition("=")[0].strip().partition(".")[2] for setting in settings]
        if not any(fnmatchcase(field, path) for path in paths):
            raise
        where = f"{error.where} (by an option)"
        raise InputError(where, error.field, error.value, error.allowed) from None


def adopt_mechanism(given: Mechanism | str, scenarios: Sequence[Scenario | str] = ()) -> Selection:
    """The same of records, or of names or files in their place. Raises InputError."""
    chosen = select_mechanism(given) if isinstance(given, str) else Selection(given)
    loaded = tuple(load_scenario(s) if isinstance(s, str) else s for s in scenarios)
    for scenario in loaded:
        require_fit(scenario, chosen.mechanism)
    return chosen._replace(scenarios=loaded)


def find_section(given: Mechanism | str) -> str:
    """The first word of a mechanism's paths: arm or robot. Raises InputError."""
    if isinstance(given, str):
        return "robot" if is_robot(given) else "arm"
    return given.section


def read_sections(section: str, given: Mechanism | str) -> dict[str, Any]:
    """The content of a mechanism's file, by section, as studies vary it. Raises InputError."""
    if not isinstance(given, str):
        return given.sections
    return read_robot_data(given) if section == "robot" else {"arm": read_raw_arm(given)}


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
    """Robot and scenarios by name or file, with settings as in ``load_case``. Raises InputError."""
    data = {"robot": read_robot_file(name)}
    if any(setting.strip().startswith("robot.links.") for setting in settings):
        source, _ = read_source(name, data["robot"])
        fill_masses(data["robot"], source.urdf_text, source.file.urdf)
    contents = apply_settings(data, scenarios, settings, ("robot", "scenario"))
    _, robot = read_source(name, data["robot"])
    return Selection(robot, validate_scenarios(contents, scenarios, robot))
