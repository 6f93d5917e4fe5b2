"""The unit of what a path names, as the schema states it."""

from __future__ import annotations

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.quantities import Data
from crosscheck.models.arm.version1 import MESHES, is_first
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.experiment.switches import Switches
from crosscheck.models.paths import Place
from crosscheck.schema import described

RECORDS: dict[str | int, type[Data]] = {"arm": Arm, "scenario": Scenario, "switches": Switches}


def unit_of(place: Place, data: dict[str, object]) -> str:
    """Of an entry; empty where it has none, or nothing there is known."""
    section, *keys = place
    names = [key for key in keys if isinstance(key, str)]
    if section == "arm" and is_first(data["arm"]) and names[0] == "joints":
        names = _second_version(names)
    return _below([RECORDS[section]], names)


def _second_version(names: list[str]) -> list[str]:
    """A path into a joint of a first-version arm as the second has it."""
    for mesh, fields in MESHES.items():
        if names[-1] in fields:
            return [*names[:-1], mesh, *fields[names[-1]]]
    return names


def _below(records: list[type[Data]], names: list[str]) -> str:
    """Of the field at the end of a path through records, one of those given."""
    fields = [f for record in records for f in described(record) if f.name == names[0]]
    if len(names) == 1 or not fields:
        return next((field.unit for field in fields if field.unit), "")
    return _below([record for field in fields for record in field.records], names[1:])
