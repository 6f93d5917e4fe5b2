"""Whether a run recorded all that its experiment asks for."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.models.loading import Case
from crosscheck.models.trajectory import recorded_times

if TYPE_CHECKING:
    import xarray as xr


RIGID = ("theta", "theta_dot", "theta_ddot", "torque", "kinetic_energy")
BY_PLANET = ("x_sp", "x_pr", "x_sp_dot", "x_pr_dot", "F_sp", "F_pr")
GEARED = (*RIGID, *BY_PLANET)
BY_JOINT = ("theta", "theta_dot", "theta_ddot", "torque")
SAME_TIME_S = 1e-10  # k h and 2 k (h / 2) are the same time


class Incomplete(ValueError):
    """A run that lacks something, or has it in another form."""


def require_complete(run: object, model: str, case: Case, *, meshing: bool) -> None:
    """Raise Incomplete unless a run covers its scenario's grid, joints, planets and variables.

    meshing: whether the model has mesh displacements. Every value must be a finite float64; mesh
    variables are NaN beyond a joint's own planets.
    """
    import xarray as xr

    if not isinstance(run, xr.Dataset):
        raise Incomplete(f"the run is a {type(run).__name__}, must be a Dataset")
    missing = next(_missing(run, case, GEARED if meshing else RIGID), None)
    if missing is not None:
        raise Incomplete(missing)
    told, step = run.attrs.get("model"), run.attrs.get("step_s")
    if told != model or step != case.scenario.step_s:
        raise Incomplete(f"the run says it is of model {told!r} and step {step!r}")


def _missing(run: xr.Dataset, case: Case, variables: tuple[str, ...]) -> Iterator[str]:
    """What is not as it must be, the gravest first."""
    yield from (f"the run has no {name}" for name in ("time", "joint") if name not in run.coords)
    yield from (f"the run has no {name}" for name in variables if name not in run)
    expected, time = recorded_times(case.scenario), run["time"].values
    if len(time) != len(expected):
        yield f"the run has {len(time)} times, the scenario asks for {len(expected)}"
    elif time.dtype != np.float64 or not (np.abs(time - expected) <= SAME_TIME_S).all():
        yield "the run's times are not those that the scenario asks for"
    yield from _other_labels(run, "joint", len(case.arm.joints))
    if "x_sp" in variables:
        planets = max(joint.planet_count for joint in case.arm.joints)
        yield from _other_labels(run, "planet", planets)
    yield from (_misshapen(run, name) for name in variables if _misshapen(run, name))
    counts = np.array([[joint.planet_count] for joint in case.arm.joints])
    for name in variables:
        known = np.isfinite(run[name].values)
        own = np.arange(known.shape[2]) < counts if name in BY_PLANET else True
        wrong = known != own
        if wrong.any():
            first = time[np.argwhere(wrong)[0, 0]]
            yield f"{name} is not finite at t = {first:.6g} s"


def _other_labels(run: xr.Dataset, name: str, count: int) -> Iterator[str]:
    expected = list(range(1, count + 1))
    labels = run[name].values.tolist() if name in run.coords else []
    if labels != expected:
        lost = [number for number in expected if number not in labels]
        yield f"the run has {name} {labels}, must be {expected}; missing {lost}"


def _misshapen(run: xr.Dataset, name: str) -> str:
    """Why a variable is not an array of float64 over its dimensions, or nothing."""
    dims = ("time", "joint", "planet")[: 3 if name in BY_PLANET else 2 if name in BY_JOINT else 1]
    if run[name].dims != dims:
        return f"{name} is over {run[name].dims}, must be over {dims}"
    if run[name].dtype != np.float64:
        return f"{name} is of type {run[name].dtype}, must be float64"
    return ""
