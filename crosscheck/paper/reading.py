"""What is read off a run: its inputs, its first mesh, and what the gears add to a rigid arm."""

from __future__ import annotations

import json

import numpy as np
import xarray as xr

from models.arm import Arm
from models.scenario import Scenario
from models.switches import Switches


def arm_of(run: xr.Dataset) -> Arm:
    """The arm that a run was made with."""
    return Arm.model_validate(json.loads(run.attrs["arm"]))


def scenario_of(run: xr.Dataset) -> Scenario:
    """The scenario that a run was made with."""
    return Scenario.model_validate(json.loads(run.attrs["scenario"]))


def switches_of(run: xr.Dataset) -> Switches:
    """The switches that a run was made with."""
    return Switches.model_validate(json.loads(run.attrs["switches"]))


def first_mesh(run: xr.Dataset, quantity: str) -> np.ndarray:
    """A mesh variable of the shoulder's first planet, (times,)."""
    return run[quantity].values[:, 0, 0]


def resampled(run: xr.Dataset, quantity: str, time: np.ndarray) -> np.ndarray:
    """A smooth variable of the joints at other times, (times, joints)."""
    own = run["time"].values
    return np.array([np.interp(time, own, column) for column in run[quantity].values.T]).T


def excess_acceleration(run: xr.Dataset, rigid: xr.Dataset) -> np.ndarray:
    """Joint accelerations [rad/s^2] less those of the rigid arm, (times, joints)."""
    return run["theta_ddot"].values - resampled(rigid, "theta_ddot", run["time"].values)
