"""A study's file, and all the files that it names, read."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from crosscheck.models.errors import InputError
from crosscheck.models.files import builtin_arms, builtin_scenarios, read_toml
from crosscheck.models.loading import raw_case, validated
from crosscheck.models.paths import assign, is_path, places
from crosscheck.studies.definition.definition import Definition
from crosscheck.studies.definition.functions import source_of
from crosscheck.studies.definition.quantities import Function
from crosscheck.studies.members.members import PreparedStudy


def read_study(file: Path, run_code: bool = False) -> PreparedStudy:
    """The study of a TOML file. run_code: whether functions that it names may run.

    Raises InputError naming file, field, value and what is allowed.
    """
    definition = validated(Definition, read_toml(file), str(file))
    named = functions_of(definition)
    if named and not run_code:
        allowed = "its code would be run; allow that with --run-code"
        raise InputError(str(file), "function", named[0], allowed)
    here, arm, scenario = file.parent, definition.arm, definition.scenario
    arm = arm if arm in builtin_arms() else str(here / arm)
    scenario = scenario if scenario in builtin_scenarios() else str(here / scenario)
    data = raw_case(arm, scenario, dict(definition.switches))
    return study_from(definition, data, here, str(file))


def study_from(
    definition: Definition, data: dict[str, Any], folder: Path, file: str
) -> PreparedStudy:
    """The study of a definition; data: of ``raw_case``; folder: of functions. Raises InputError."""
    for path, value in definition.settings.items():
        if not is_path(path):
            allowed = "must be a path in quotes, beginning with arm, scenario or switches"
            raise InputError(file, "settings", path, allowed)
        for place in places(data, path, f"{file}: settings"):
            assign(data, place, value)
    sources = {name: source_of(name, folder) for name in functions_of(definition)}
    study = PreparedStudy(definition, data, sources, file)
    _ = study.base, study.axes  # whatever is wrong with them shows now
    return study


def functions_of(definition: Definition) -> Sequence[str]:
    """Names of the user's functions, as the definition has them."""
    return [one.function for one in definition.quantities if isinstance(one, Function)]
