"""A study's file, and all the files that it names, read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from crosscheck.models.errors import InputError
from crosscheck.models.files import (
    builtin_arms,
    builtin_robots,
    builtin_scenarios,
    read_raw_scenario,
    read_toml,
)
from crosscheck.models.loading import validate_record
from crosscheck.models.mechanism import read_sections
from crosscheck.models.paths import assign, find_paths, is_path
from crosscheck.models.refusals import refuse
from crosscheck.studies.definition.axes import varied_sections
from crosscheck.studies.definition.definition import Definition
from crosscheck.studies.definition.functions import read_source
from crosscheck.studies.definition.quantities import Function
from crosscheck.studies.members.members import PreparedStudy

BUILT_IN = {"arm": builtin_arms(), "robot": builtin_robots(), "scenario": builtin_scenarios()}


def read_study(
    file: Path, run_code: bool = False, settings: Mapping[str, Any] | None = None
) -> PreparedStudy:
    """The study of a TOML file.

    run_code: whether functions that it names may run; settings: values by path beside the file's,
    which they replace. Raises InputError naming file, field, value and what is allowed.
    """
    definition = validate_record(Definition, read_toml(file), str(file))
    changed = {**definition.settings, **(settings or {})}
    definition = definition.model_copy(update={"settings": changed})
    named = function_names(definition)
    if named and not run_code:
        allowed = "its code would be run; allow that with --run-code"
        raise InputError(str(file), "function", named[0], allowed)
    path = _find_file(file, definition.section, definition.mechanism)
    scenario = _find_file(file, "scenario", definition.scenario)
    data = {**read_sections(definition.section, path), "scenario": read_raw_scenario(scenario)}
    return build_study(definition, data, file.parent, str(file))


def _find_file(file: Path, field: str, name: str) -> str:
    """A built-in name, or the path of the file beside the study's. Raises InputError if missing."""
    if any(name in names for names in BUILT_IN.values()):
        return name
    if (path := file.parent / name).exists():
        return str(path)
    allowed = f"no such file, nor built-in name ({', '.join(BUILT_IN[field])})"
    raise InputError(str(file), field, name, allowed)


def build_study(
    definition: Definition, data: dict[str, Any], folder: Path, file: str
) -> PreparedStudy:
    """The study of a definition; data: what the files of arm or robot hold; folder: of functions.

    Raises InputError.
    """
    refuse(definition.section, "study", file, **dict(definition))
    if definition.section == "arm":  # the laws of whose teeth can be chosen
        data.setdefault("switches", dict(definition.switches))
    sections = varied_sections(data)
    for path, value in definition.settings.items():
        if not is_path(path, sections):
            allowed = f"must be a path in quotes, beginning with {', '.join(sections)}"
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
