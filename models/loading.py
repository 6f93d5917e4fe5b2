"""Arms, scenarios and switches from TOML files, built-in names and ``path=value`` settings."""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import require_alike, usual_switches
from crosscheck.models.errors import InputError, rephrase
from crosscheck.models.experiment.scenario import ConstantDrive, Scenario, Switches, find_misfit
from crosscheck.models.files import parse_toml, read_raw_arm, read_raw_scenario
from crosscheck.models.inputs import doubt_degrees
from crosscheck.models.paths import SECTIONS, assign, find_paths, format_path, is_path

if TYPE_CHECKING:
    from crosscheck.models.robot.robot import Robot

Record = TypeVar("Record", bound=BaseModel)
# Tags of the schema's unions; a record of another room has its own as ``union_tags``.
UNION_TAGS = {
    *("constant", "pd", "sinusoid", "table", "number", "list", "word"),
    *("planetary", "direct", "sine", "fourier", "square"),
}
EXPECTED = {
    "model_type": "must be a table",
    "model_attributes_type": "must be a table",
    "tuple_type": "must be a list",
    "union_tag_not_found": "must be a table with a {tag}",
}


class Case(NamedTuple):
    """Everything that defines one experiment."""

    arm: Arm
    scenario: Scenario
    switches: Switches


def load_arm(name: str) -> Arm:
    """Load the arm of a built-in name or TOML file.

    Args:
        name: A built-in name, as ``crosscheck list`` shows them, or the path of a file.

    Returns:
        The arm, validated; its fields are in SI units, each with its unit in its name.

    Raises:
        InputError: There is no such file, or a field does not fit; it names file, field, value and
            what is allowed.
    """
    return validate_record(Arm, read_raw_arm(name), name)


def load_paper_arms() -> list[Arm]:
    """The paper's arm in both readings of Table I."""
    return [load_arm(f"paper-{name}") for name in ("labelled", "swapped")]


def is_the_papers(arm: Arm) -> bool:
    """Whether this is the paper's arm, in either reading."""
    return arm in load_paper_arms()


def load_scenario(name: str) -> Scenario:
    """Load the scenario of a built-in name or TOML file.

    Args:
        name: A built-in name, as ``crosscheck list`` shows them, or the path of a file.

    Returns:
        The scenario, validated, whether or not it fits any arm.

    Raises:
        InputError: There is no such file, or a field does not fit; it names file, field, value and
            what is allowed.
    """
    return validate_record(Scenario, read_raw_scenario(name), name)


def make_rest_scenario() -> Scenario:
    """An experiment without any torque, for what no drive takes part in."""
    drive = ConstantDrive(kind="constant", torque_N_m=0.0)
    return load_scenario("constant-torque").model_copy(update={"drive": drive})


def load_case(
    arm: str, scenario: str, switches: dict[str, str] | None = None, settings: Sequence[str] = ()
) -> Case:
    """Arm, scenario and switches, with ``path=value`` settings applied before validation.

    A path is dotted, begins with ``arm``, ``scenario`` or ``switches``, takes an index in a list,
    and ``*`` for any of a list, or in a name: ``arm.joints.*.*_mesh.backlash_m=2e-5``. Raises
    InputError.
    """
    chosen = [f"switches.{name}={law}" for name, law in (switches or {}).items()]
    loaded = load_selection(arm, [scenario], [*chosen, *settings])
    laws = loaded.switches or usual_switches(loaded.arm)
    return Case(loaded.arm, loaded.scenarios[0], laws)


def validate_switches(chosen: dict[str, Any], arm: Arm) -> Switches:
    """A user's switches; where they do not say how planets count, the arm does.

    Raises InputError.
    """
    given = {"planets": usual_switches(arm).planets, **chosen}
    return validate_record(Switches, given, "switches")


class Selection(NamedTuple):
    """A mechanism and the experiments that a user wants of it; no switches: the usual ones.

    file_json: JSON of what an arm's file holds, settings applied; empty where there is none.
    """

    mechanism: Any
    scenarios: tuple[Scenario, ...] = ()
    switches: Switches | None = None
    file_json: str = ""

    @property
    def arm(self) -> Arm:
        """The arm; what is of arms alone asks for it."""
        arm: Arm = self.mechanism
        return arm


def load_selection(
    arm: str, scenarios: Sequence[str] = (), settings: Sequence[str] = ()
) -> Selection:
    """An arm and scenarios by name or file, with ``path=value`` settings as in ``load_case``.

    A setting of the scenario holds for each. Raises InputError.
    """
    data: dict[str, Any] = {"arm": read_raw_arm(arm), "switches": {}}
    contents = apply_settings(data, scenarios, settings, SECTIONS)
    loaded = validate_record(Arm, data["arm"], arm)
    chosen = validate_switches(data["switches"], loaded) if data["switches"] else None
    experiments = validate_scenarios(contents, scenarios, loaded)
    laws = chosen or usual_switches(loaded)
    for scenario, name in zip(experiments, scenarios, strict=True):
        require_alike(loaded, scenario, laws, arm, name)
    if chosen:
        require_alike(loaded, None, laws, arm)
    return Selection(loaded, experiments, chosen, json.dumps(data["arm"]))


def apply_settings(
    data: dict[str, Any], scenarios: Sequence[str], settings: Sequence[str], sections: Sequence[str]
) -> list[Any]:
    """The content of scenarios by name or file, changed by settings as a mechanism's data are.

    A setting of the scenario holds for each. Raises InputError.
    """
    stages = [{"scenario": read_raw_scenario(name)} for name in scenarios]
    for setting in settings:
        section = setting.partition(".")[0].strip()
        if section == "scenario" and not stages:
            raise InputError("--set", setting, None, "needs --scenario")
        for target in stages if section == "scenario" else [data]:
            apply_setting(target, setting, sections)
    return [stage["scenario"] for stage in stages]


def validate_scenarios(
    contents: Sequence[Any], names: Sequence[str], mechanism: Arm | Robot
) -> tuple[Scenario, ...]:
    """The scenarios of files of these names, which fit an arm or robot. Raises InputError."""
    scenarios = []
    for content, name in zip(contents, names, strict=True):
        scenarios.append(validate_record(Scenario, content, name))
        require_fit(scenarios[-1], mechanism, name)
    return tuple(scenarios)


def require_fit(scenario: Scenario, mechanism: Arm | Robot, where: str = "") -> None:
    """Raise InputError unless the scenario's per-joint lists fit the arm or robot.

    where: the file, if the scenario's name does not say it.
    """
    where, planets = where or scenario.name, mechanism.planet_counts
    if any(scenario.start.planet_offset_m) and not any(planets):
        allowed = f"needs a stage with planets = free, which {mechanism.name} has not"
        raise InputError(where, "start.planet_offset_m", None, allowed)
    misfit = find_misfit(scenario, planets, len(mechanism.motors))
    if misfit is not None:
        raise InputError(where, *misfit)
    if not getattr(mechanism, "slides", ()):  # whose lengths would stand among the angles
        given = {"start.theta_rad": scenario.start.theta_rad}
        given["drive.target_rad"] = getattr(scenario.drive, "target_rad", ())
        for field, angles in given.items():
            doubt_degrees(where, field, angles if isinstance(angles, tuple) else (angles,))


def apply_setting(data: dict[str, Any], setting: str, sections: Sequence[str] = SECTIONS) -> None:
    """Change raw content by ``path=value``, below one of the sections. Raises InputError."""
    path, equals, text = setting.partition("=")
    if not equals or not is_path(path, sections):
        allowed = f"must be path=value, path beginning with {', '.join(sections)}"
        raise InputError("--set", setting, None, allowed)
    for place in find_paths(data, path, "--set"):
        assign(data, place, _value(text.strip()))


def _value(text: str) -> Any:
    """A TOML value, or the bare text where it is none (so that names need no quotes)."""
    try:
        (value,) = parse_toml(f"value = {text}").values()
    except ValueError:
        return text
    return value


def validate_record(record: type[Record], data: object, where: str) -> Record:
    """The record of a file's content. Raises InputError naming the file, field and value."""
    try:
        return record.model_validate(data)
    except ValidationError as error:
        # A misspelt key shows as unknown and as missing; the first says how it should be spelt.
        worst = sorted(error.errors(), key=lambda details: details["type"] != "extra_forbidden")
        raise _input_error(record, worst[0], where) from None


def _input_error(record: type[BaseModel], details: ErrorDetails, where: str) -> InputError:
    """InputError that states one of pydantic's errors in one line."""
    tags = UNION_TAGS | getattr(record, "union_tags", set())
    location = [part for part in details["loc"] if part not in tags]
    value: object = details["input"]
    kind, context = details["type"], details.get("ctx", {})
    tag = str(context.get("discriminator", "")).strip("'")
    allowed = EXPECTED.get(kind, rephrase(details["msg"])).replace("{tag}", tag)
    if kind == "value_error":
        field, _, allowed = str(context["error"]).partition("|")
        location, value = [*location, *field.split(".")], _entry(value, field)
    elif kind == "extra_forbidden":
        *above, key = details["loc"]  # the user's own key, whatever it is called
        location = [*(part for part in above if part not in tags), key]
        keys = sorted(_keys_at(record.model_json_schema(), above))
        close = difflib.get_close_matches(str(key), keys, n=1, cutoff=0.4)
        hint = f"did you mean {close[0]}?" if close else f"allowed: {', '.join(keys)}"
        allowed = f"unknown key; {hint}"
    elif kind == "missing":
        value, allowed = None, "is missing; a value is required"
    elif kind == "union_tag_invalid":
        location = [*location, tag]
        value, allowed = context["tag"], f"must be one of {context['expected_tags']}"
    return InputError(where, format_path(tuple(location)), value, allowed)


def _entry(value: Any, dotted: str) -> Any:
    """Value at a path as ``joints[0].kind`` in nested tables and lists, None if there is none."""
    for key in re.findall(r"[^.\[\]]+", dotted):
        if isinstance(value, list | tuple) and key.isdigit() and int(key) < len(value):
            value = value[int(key)]
        else:
            value = value.get(key) if isinstance(value, dict) else None
    return value


def _keys_at(schema: dict[str, Any], location: list[Any]) -> set[str]:
    """Every key that the records at this place of a JSON schema know, tags in the location.

    Where no tag chooses between variants, the keys are those of all together.
    """
    nodes = [schema]
    for part in location:
        below = [
            node.get("items")
            if isinstance(part, int)
            else node.get("properties", {}).get(part) or node.get("additionalProperties")
            for node in nodes
        ]
        inner = [variant for node in below if node for variant in _variants(schema, node)]
        tagged = [  # records that are chosen among others by this word
            node
            for node in nodes
            if part in [field.get("const") for field in node.get("properties", {}).values()]
        ]
        nodes = inner or tagged or nodes
    return {key for node in nodes for key in node.get("properties", {})}


def _variants(schema: dict[str, Any], node: dict[str, Any]) -> list[dict[str, Any]]:
    """The records that a node of a schema may be."""
    if "$ref" in node:
        return [schema["$defs"][node["$ref"].rsplit("/", 1)[1]]]
    return [
        variant
        for key in ("oneOf", "anyOf")
        for option in node.get(key, [])
        for variant in _variants(schema, option)
    ] or [node]
