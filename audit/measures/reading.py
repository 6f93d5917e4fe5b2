"""What is read off a run: its inputs, its first mesh, and what the gears add to a rigid arm."""

from __future__ import annotations

import json

import xarray as xr

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario, Switches


def arm_of(run: xr.Dataset) -> Arm:
    """The arm that a run was made with."""
    return Arm.model_validate(json.loads(run.attrs["arm"]))


def scenario_of(run: xr.Dataset) -> Scenario:
    """The scenario that a run was made with."""
    return Scenario.model_validate(json.loads(run.attrs["scenario"]))


def switches_of(run: xr.Dataset) -> Switches:
    """The switches that a run was made with."""
    return Switches.model_validate(json.loads(run.attrs["switches"]))


def first_planets(run: xr.Dataset) -> xr.Dataset:
    """The run with one planet per joint: the paper's model moves all of a joint alike."""
    return run.isel(planet=[0]) if "planet" in run.dims else run


def angles(run: xr.Dataset) -> xr.Dataset:
    """The joints' angles alone."""
    return run[["theta"]]
