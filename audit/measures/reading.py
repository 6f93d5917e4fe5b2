"""What is read off a run: its inputs, its first mesh, and what the gears add to a rigid arm."""

from __future__ import annotations

import json

import xarray as xr

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.loading import Case


def read_arm(run: xr.Dataset) -> Arm:
    """The arm that a run was made with."""
    return Arm.model_validate(json.loads(run.attrs["arm"]))


def read_case(run: xr.Dataset) -> Case:
    """Arm, scenario and switches that a run was made with."""
    scenario, switches = (json.loads(run.attrs[name]) for name in ("scenario", "switches"))
    return Case(read_arm(run), Scenario.model_validate(scenario), Switches.model_validate(switches))


def select_first_planets(run: xr.Dataset) -> xr.Dataset:
    """The run with one planet per joint: the paper's model moves all of a joint alike."""
    return run.isel(planet=[0]) if "planet" in run.dims else run


def select_angles(run: xr.Dataset) -> xr.Dataset:
    """The run with nothing but the joints' angles."""
    return run[["theta"]]
