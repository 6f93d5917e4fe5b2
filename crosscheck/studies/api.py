"""Studies from Python: what a study's file says, as arguments; the result as a Dataset."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import xarray as xr

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.quantities import Data
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.files import read_raw_arm, read_raw_scenario
from crosscheck.models.loading import validate_record
from crosscheck.studies.batches.run import ExecutionSettings, run_study
from crosscheck.studies.definition.definition import AxisBase, Definition
from crosscheck.studies.definition.files import build_study
from crosscheck.studies.definition.quantities import MeasuredQuantity

SCHEMA_VERSION = 1


def sweep(
    arm: Arm | str,
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
    scheduler: str | None = None,
    out: Path | str | None = None,
    resume: bool = False,
) -> xr.Dataset:
    """Run every member of a study; returns what was measured over the axes, in SI units.

    axes: values by path, or axes as a study's file has them, as records or mappings; measures: the
    quantities as a study's file has them, as records or mappings. samples, starts: how many, or a
    mapping that also has the seed. jobs: processes of this machine; scheduler: address of a Dask
    scheduler in their place. out: file to keep, which with ``resume`` goes on where it was stopped.
    Functions named in measures are run.

    Raises InputError, and Unfinished where workers keep dying.
    """
    if isinstance(axes, Mapping):
        axes = [{"kind": "list", "path": p, "values": list(each)} for p, each in axes.items()]
    given = {
        "schema_version": SCHEMA_VERSION,
        "name": "study",
        "arm": arm if isinstance(arm, str) else arm.name,
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
    data = {
        "arm": read_raw_arm(arm) if isinstance(arm, str) else _content(arm),
        "scenario": read_raw_scenario(scenario)
        if isinstance(scenario, str)
        else _content(scenario),
        "switches": dict(switches or {}),
    }
    study = build_study(definition, data, Path(), "sweep")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "study.nc") if out is None else Path(out)
        run_study(study, file, ExecutionSettings(jobs, scheduler, resume))
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


def _content(record: Arm | Scenario) -> dict[str, Any]:
    """The content of an arm or scenario, as its file would have it."""
    return record.model_dump(mode="json", exclude_none=True)
