"""A mechanism, which is an arm or a robot, and an experiment with it: the readers of both.

Whatever a name, a file or a study's content is of is decided here, and nowhere behind it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.files import is_robot, read_raw_arm
from crosscheck.models.loading import Selection, load_scenario, load_selection, require_fit
from crosscheck.models.robot.case import read_robot_data, select_robot
from crosscheck.models.robot.robot import Robot

Mechanism = Arm | Robot


def select_mechanism(
    name: str, scenarios: Sequence[str] = (), settings: Sequence[str] = ()
) -> Selection:
    """Mechanism and scenarios by name or file, with ``path=value`` settings. Raises InputError."""
    if not is_robot(name):
        return load_selection(name, scenarios, settings)
    return select_robot(name, scenarios, settings)


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
