"""Studies from Python: the content of a study's file as arguments, the result as a Dataset."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import xarray as xr

from crosscheck.models.arm.quantities import Data
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.files import read_raw_scenario
from crosscheck.models.loading import validate_record
from crosscheck.models.mechanism import Mechanism, find_section, read_sections
from crosscheck.models.robot.robot import Level
from crosscheck.studies.batches.run import ExecutionSettings, run_study
from crosscheck.studies.definition.definition import AxisBase, Definition
from crosscheck.studies.definition.files import build_study
from crosscheck.studies.definition.quantities import MeasuredQuantity
from crosscheck.studies.members.members import PreparedStudy

SCHEMA_VERSION = 1


def sweep(
    arm: Mechanism | str,
    axes: Mapping[str, Sequence[Any]] | Sequence[AxisBase | Mapping[str, Any]],
    *,
    scenario: Scenario | str,
    measures: Sequence[MeasuredQuantity | Mapping[str, Any]],
    switches: Mapping[str, str] | None = None,
    settings: Mapping[str, Any] | None = None,
    samples: int | Mapping[str, int] | None = None,
    starts: int | Mapping[str, Any] | None = None,
    spot_checks: int = 0,
    jobs: int = 1,
    out: Path | str | None = None,
    resume: bool = False,
    level: Level | None = None,
) -> xr.Dataset:
    """Run every member of a study, and measure each; functions named in measures are run.

    Args:
        arm: The arm or robot that is varied, or the built-in name or file of one.
        axes: Lists of values by path, such as ``arm.payload_mass_kg``; or axes as a study's file
            has them, as records or mappings.
        scenario: The experiment of every member, or the built-in name or TOML file of one.
        measures: The ``quantities`` of a study's file, as records or mappings.
        switches: Laws of the gear model by the names of switches.
        settings: Values by path that all members have in place of the arm's or scenario's.
        samples: How many draws of all distributions, or a mapping that also has the seed.
        starts: How many perturbed starts of each member, or a mapping that also has the seed.
        spot_checks: How many members, evenly chosen, a second engine runs again.
        jobs: How many processes run members.
        out: NetCDF file of the result, which is kept; without it, nothing is.
        resume: Whether to go on where the study of the file ``out`` was stopped.
        level: What of a robot's gears is modelled; its most detailed level if left out.

    Returns:
        A variable for each measure over the axes, in SI units.

    Raises:
        InputError: An argument, an axis or a measure does not fit.
        Unfinished: Workers keep dying.
    """
    if isinstance(axes, Mapping):
        axes = [{"kind": "list", "path": p, "values": list(each)} for p, each in axes.items()]
    section = find_section(arm)
    given = {
        "schema_version": SCHEMA_VERSION,
        "name": "study",
        section: arm if isinstance(arm, str) else arm.name,
        "level": level,
        "scenario": scenario if isinstance(scenario, str) else scenario.name,
        "switches": dict(switches or {}),
        "settings": dict(settings or {}),
        "axes": [_to_plain_fields(axis) for axis in axes],
        "quantities": [_to_plain_fields(measure) for measure in measures],
        "samples": _count_fields(samples),
        "starts": _count_fields(starts),
        "spot_checks": spot_checks,
    }
    definition = validate_record(Definition, given, "sweep")
    data = read_sections(section, arm)
    data["scenario"] = (
        read_raw_scenario(scenario)
        if isinstance(scenario, str)
        else scenario.model_dump(mode="json", exclude_none=True)
    )
    study = build_study(definition, data, Path(), "sweep")
    return measure_study(study, ExecutionSettings(jobs, resume), out)


def measure_study(
    study: PreparedStudy, settings: ExecutionSettings, out: Path | str | None = None
) -> xr.Dataset:
    """The result of a study; out: file to keep it in. Raises InputError and Unfinished."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "study.nc") if out is None else Path(out)
        run_study(study, file, settings)
        with xr.open_dataset(file, engine="h5netcdf", decode_times=False) as result:
            return result.load()


def _to_plain_fields(record: Data | Mapping[str, Any]) -> dict[str, Any]:
    """The fields of a record by name, with numbers of NumPy's as Python's."""
    return {
        name: [_number(each) for each in value] if isinstance(value, list) else _number(value)
        for name, value in dict(record).items()
    }


def _number(value: Any) -> Any:
    """The value, as a number of Python's where it is one of NumPy's."""
    return value.tolist() if hasattr(value, "tolist") else value


def _count_fields(given: int | Mapping[str, Any] | None) -> dict[str, Any] | None:
    return {"count": given} if isinstance(given, int) else None if given is None else dict(given)
