"""A study's file, and all the files that it names, read."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from crosscheck.models.errors import InputError
from crosscheck.models.files import builtin_arms, builtin_scenarios, read_toml
from crosscheck.models.loading import read_raw_case, validate_record
from crosscheck.models.paths import assign, find_paths, is_path
from crosscheck.studies.definition.definition import Definition
from crosscheck.studies.definition.functions import read_source
from crosscheck.studies.definition.quantities import Function
from crosscheck.studies.members.members import PreparedStudy


def read_study(file: Path, run_code: bool = False) -> PreparedStudy:
    """The study of a TOML file. run_code: whether functions that it names may run.

    Raises InputError naming file, field, value and what is allowed.
    """
    definition = validate_record(Definition, read_toml(file), str(file))
    named = function_names(definition)
    if named and not run_code:
        allowed = "its code would be run; allow that with --run-code"
        raise InputError(str(file), "function", named[0], allowed)
    here, arm, scenario = file.parent, definition.arm, definition.scenario
    arm = arm if arm in builtin_arms() else str(here / arm)
    scenario = scenario if scenario in builtin_scenarios() else str(here / scenario)
    data = read_raw_case(arm, scenario, dict(definition.switches))
    return build_study(definition, data, here, str(file))


def build_study(
    definition: Definition, data: dict[str, Any], folder: Path, file: str
) -> PreparedStudy:
    """The study of a definition; data: of ``read_raw_case``; folder: of functions.

    Raises InputError.
    """
    for path, value in definition.settings.items():
        if not is_path(path):
            allowed = "must be a path in quotes, beginning with arm, scenario or switches"
            raise InputError(file, "settings", path, allowed)
        for place in find_paths(data, path, f"{file}: settings"):
            assign(data, place, value)
    sources = {name: read_source(name, folder) for name in function_names(definition)}
    study = PreparedStudy(definition, data, sources, file)
    _ = study.base, study.axes  # whatever is wrong with them shows now
    return study


def function_names(definition: Definition) -> Sequence[str]:
    """Names of the user's functions, as the definition has them."""
    return [
        quantity.function for quantity in definition.quantities if isinstance(quantity, Function)
    ]
