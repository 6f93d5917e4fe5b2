"""A trajectory: an xarray Dataset over time, joint and, for mesh variables, planet."""

from __future__ import annotations

import io
import json
from typing import TYPE_CHECKING, Any

import numpy as np

from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.interface import Model

if TYPE_CHECKING:
    import xarray as xr


SCHEMA_VERSION = 1
_ABOUT = {
    "theta": ("rad", "joint angle, relative to the previous link"),
    "theta_dot": ("rad s-1", "joint rate"),
    "theta_ddot": ("rad s-2", "joint acceleration"),
    "torque": ("N m", "driving torque at the joint"),
    "x_sp": ("m", "displacement of the sun-planet mesh along the line of action"),
    "x_pr": ("m", "displacement of the planet-ring mesh along the line of action"),
    "x_sp_dot": ("m s-1", "rate of x_sp"),
    "x_pr_dot": ("m s-1", "rate of x_pr"),
    "F_sp": ("N", "elastic force of the sun-planet mesh, per planet, without damper"),
    "F_pr": ("N", "elastic force of the planet-ring mesh, per planet, without damper"),
    "x_mesh": ("m", "displacement of the mesh of a joint's rotor along the line of action"),
    "x_mesh_dot": ("m s-1", "rate of x_mesh"),
    "F_mesh": ("N", "elastic force of the mesh of a joint's rotor, without damper"),
    "kinetic_energy": ("J", "kinetic energy of all bodies"),
    "work": ("J", "work of drive, meshes and dampers since the start"),
    "work_turned_over": ("J", "integral of the magnitude of every force's power"),
}
VARIABLES = tuple(_ABOUT)
# Of a kind of motion or force, then of sun or ring.
MESH_VARIABLES = ("x_sp", "x_pr", "x_sp_dot", "x_pr_dot", "F_sp", "F_pr")
_DIMS = {2: ("time", "joint"), 3: ("time", "joint", "planet"), 1: ("time",)}


def trajectory(model: Model, time: np.ndarray, **variables: np.ndarray) -> xr.Dataset:
    """The Dataset of a run of ``model``; variables as ``build_trajectory`` has them."""
    return build_trajectory(
        model.name, model.arm, model.scenario, model.switches, time, **variables
    )


def build_trajectory(
    name: str,
    mechanism: Any,
    scenario: Scenario,
    chosen: Switches,
    time: np.ndarray,
    **variables: np.ndarray,
) -> xr.Dataset:
    """The Dataset of a run, by a model of this name, of an arm or a robot in an experiment.

    time (times,) [s]. Variables, by the names in this module: theta, theta_dot, theta_ddot and
    torque of shape (times, joints); x_sp, x_pr, x_sp_dot, x_pr_dot, F_sp and F_pr of shape (times,
    joints, planets); kinetic_energy, work and work_turned_over of shape (times,).
    """
    import xarray as xr  # half a second, pandas with it

    provenance = {
        "schema_version": SCHEMA_VERSION,
        "model": name,
        "step_s": scenario.step_s,
        "scenario": json.dumps(scenario.model_dump()),
        "switches": json.dumps(chosen.model_dump()),
        **mechanism.run_attributes,
    }
    data = {
        name: (_DIMS[values.ndim], values, {"units": unit_of(name), "long_name": meaning_of(name)})
        for name, values in variables.items()
    }
    joints = np.arange(1, len(mechanism.joints) + 1)
    coords = {
        "time": ("time", time, {"units": "s", "long_name": "time"}),
        "joint": ("joint", joints, {"long_name": "joint number"}),
    }
    planets = max((values.shape[2] for values in variables.values() if values.ndim == 3), default=0)
    if planets:
        coords["planet"] = ("planet", np.arange(1, planets + 1), {"long_name": "planet number"})
    return xr.Dataset(data, coords, attrs={"Conventions": "CF-1.11", **provenance})


def recorded_times(scenario: Scenario) -> np.ndarray:
    """Times [s] at which every run of a scenario is recorded, first and last step among them."""
    return scenario.step_s * np.arange(0, scenario.steps + 1, scenario.stride)


def unit_of(name: str) -> str:
    """Unit of a variable of a trajectory."""
    return _ABOUT[name][0]


def meaning_of(name: str) -> str:
    """Meaning of a variable of a trajectory, in words."""
    return _ABOUT[name][1]


def encode_netcdf(dataset: xr.Dataset) -> bytes:
    """The content of a compressed NetCDF file.

    Made in memory: HDF5 does not survive a disk that becomes full.
    """
    # With their bytes shuffled, smooth signals pack in a third of the time, into a tenth less.
    packing = {"zlib": True, "complevel": 4, "shuffle": True}
    packed = dict.fromkeys(dataset.data_vars, packing)
    content = io.BytesIO()
    dataset.to_netcdf(content, engine="h5netcdf", encoding=packed)
    return content.getvalue()
