"""Whole runs: is the difference of two trajectories inside what their integrators can explain?"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from crosscheck.findings import Finding, checked, measured_only
from models.arm import Arm

UNITS = {
    "theta": "rad",
    "theta_dot": "rad s-1",
    "x_sp": "m",
    "x_pr": "m",
    "F_sp": "N",
    "F_pr": "N",
    "tip": "m",
    "theta_ddot": "rad s-2",
    "torque": "N m",
    "kinetic_energy": "J",
}


class Limit(NamedTuple):
    """A tolerance with the reason for it."""

    value: float
    basis: str


# RK4 commutes with a linear change of coordinates: two models with the same equations, step and
# start differ by rounding alone, whatever coordinates they use inside.
_SAME_STEP = "same integrator and step: what the growth of rounding over 1e6 stages can explain"
SAME_STEP = {
    "theta": Limit(1e-10, _SAME_STEP),
    "x_sp": Limit(1e-13, _SAME_STEP),
    "x_pr": Limit(1e-13, _SAME_STEP),
    "F_sp": Limit(1.2e-5, "1e-13 m at the peak mesh stiffness of the paper's arm, 1.2e8 N/m"),
    "F_pr": Limit(1.2e-5, "1e-13 m at the peak mesh stiffness of the paper's arm, 1.2e8 N/m"),
    "theta_dot": Limit(1e-9, "1e-10 rad at the 10 1/s of the arm's own motion"),
    "theta_ddot": Limit(1.5e-6, "1.2e-5 N on the meshes, measured 0.11 rad/s2 per N"),
    "torque": Limit(5e-7, "the PD gains, 1000 N m/rad and 400 N m s/rad, on theta and theta_dot"),
    "kinetic_energy": Limit(5e-7, "1e-9 rad/s at the arm's largest momentum, 500 N m s"),
}
# An uncertainty above these would hide differences that the paper discusses.
MEANINGFUL = {
    "theta": Limit(1e-6, "a thousandth of the 0.001 rad that the paper discusses"),
    "x_sp": Limit(5e-7, "a tenth of the paper's tooth error of 5 um"),
    "x_pr": Limit(5e-7, "a tenth of the paper's tooth error of 5 um"),
}
# Safety factor of the grid convergence index for two grids (Roache). The order is taken as 1: the
# dead zone and the clearance's impacts leave no higher one to rely on.
SAFETY = 3.0


def largest_difference(one: xr.Dataset, other: xr.Dataset, quantity: str) -> float:
    """max over time, joints and planets of |one - other|, in the quantity's unit.

    Runs recorded on different grids are compared at the times that both have; nan if one run has
    a value where the other has none.
    """
    left, right = xr.align(_on_grid(one[quantity]), _on_grid(other[quantity]), join="inner")
    if left.sizes["time"] < 2 or bool((left.isnull() != right.isnull()).any()):
        return np.nan
    return float(np.abs(left - right).max())


def size(run: xr.Dataset, quantity: str) -> float:
    """Largest magnitude of a quantity in a run."""
    return float(np.abs(run[quantity]).max())


def _on_grid(values: xr.DataArray) -> xr.DataArray:
    """Times rounded to 0.1 ns, so that k h and 2 k (h/2) are the same label."""
    return values.assign_coords(time=values["time"].round(10))


def uncertainty(fine: xr.Dataset, coarse: xr.Dataset, quantity: str) -> float:
    """Numerical uncertainty of `fine`: its distance from the run at twice the step, times 3."""
    return SAFETY * largest_difference(fine, coarse, quantity)


def same_step(case: str, left: xr.Dataset, right: xr.Dataset) -> Iterator[Finding]:
    """Two models through the same integrator and step, over the whole run."""
    for quantity, limit in SAME_STEP.items():
        yield _difference(f"same-step/{case}", left, right, quantity, limit)


def at_time(case: str, left: xr.Dataset, right: xr.Dataset, time_s: float) -> Iterator[Finding]:
    """The same comparison at one instant."""
    here, there = (_at(run, time_s) for run in (left, right))
    for quantity, limit in SAME_STEP.items():
        yield _difference(f"at-{time_s:g}-s/{case}", here, there, quantity, limit)


def _at(run: xr.Dataset, time_s: float) -> xr.Dataset:
    """The record at one time and the one before, as a run of its own."""
    index = int(np.argmin(np.abs(run["time"].values - time_s)))
    return run.isel(time=slice(max(index - 1, 0), index + 1))


def _difference(
    case: str, left: xr.Dataset, right: xr.Dataset, quantity: str, limit: Limit
) -> Finding:
    measured = largest_difference(left, right, quantity)
    return checked(
        measured=measured,
        tolerance=limit.value,
        basis=limit.basis,
        relative=_relative(measured, left, quantity),
        metric="largest absolute difference",
        **_fields(case, left, right, quantity),
    )


def refined(
    case: str,
    left: tuple[xr.Dataset, xr.Dataset],
    right: tuple[xr.Dataset, xr.Dataset],
    quantities: tuple[str, ...] = ("theta", "x_sp", "x_pr"),
) -> Iterator[Finding]:
    """Each side's own best run against the other's; (fine, coarse) give its uncertainty."""
    for quantity in quantities:
        own = [uncertainty(*side, quantity) for side in (left, right)]
        combined = float(np.hypot(own[0], own[1]))
        meaningful = MEANINGFUL[quantity]
        measured = largest_difference(left[0], right[0], quantity)
        yield checked(
            measured=measured,
            tolerance=combined,
            resolved=combined <= meaningful.value,
            basis=(
                f"combined uncertainty by step refinement, {own[0]:.2g} and {own[1]:.2g};"
                f" means something below {meaningful.value:g}, {meaningful.basis}"
            ),
            relative=_relative(measured, left[0], quantity),
            metric="largest absolute difference",
            **_fields(f"refined/{case}", left[0], right[0], quantity),
        )


def sensitivity(case: str, run: xr.Dataset, nudged: xr.Dataset) -> Iterator[Finding]:
    """How far a run moves when its start is changed in the last place."""
    for quantity in ("theta", "x_sp"):
        measured = largest_difference(run, nudged, quantity)
        yield measured_only(
            measured=measured,
            basis="start changed by one unit in the last place of x_sp1",
            relative=_relative(measured, run, quantity),
            metric="largest absolute difference",
            **_fields(f"one-ulp/{case}", run, nudged, quantity),
        )


def deviation(case: str, rigid: xr.Dataset, geared: xr.Dataset, arm: Arm) -> Iterator[Finding]:
    """How far a rigid arm is from the geared one: joint by joint, and at the tip."""
    tips = [run.assign(tip=tip_position(run, arm)) for run in (rigid, geared)]
    yield _deviation(f"deviation/{case}", tips[0], tips[1], "tip")
    for joint in rigid["joint"].values:
        one, other = (run.sel(joint=[joint]) for run in (rigid, geared))
        for quantity in ("theta", "theta_dot"):
            yield _deviation(f"deviation/{case}/joint{joint}", one, other, quantity)


def form_deviation(case: str, form: xr.Dataset, engine: xr.Dataset) -> Iterator[Finding]:
    """How far a form of the equations that is not trusted is from an engine."""
    for quantity in ("theta", "x_sp", "F_sp", "F_pr"):
        yield _deviation(f"form/{case}", form, engine, quantity)


def _deviation(case: str, rigid: xr.Dataset, geared: xr.Dataset, quantity: str) -> Finding:
    measured = largest_difference(rigid, geared, quantity)
    return measured_only(
        measured=measured,
        basis="",
        relative=_relative(measured, geared, quantity),
        metric="largest absolute difference",
        **_fields(case, rigid, geared, quantity),
    )


def tip_position(run: xr.Dataset, arm: Arm) -> xr.DataArray:
    """Tip in the base frame, (time, axis) [m], from relative joint angles."""
    absolute = run["theta"].cumsum("joint")
    lengths = xr.DataArray([link.length_m for link in arm.links], dims="joint")
    axes = [(lengths * turn(absolute)).sum("joint") for turn in (np.cos, np.sin)]
    return xr.concat(axes, "axis").transpose("time", "axis")


def _relative(measured: float, run: xr.Dataset, quantity: str) -> float | None:
    largest = size(run, quantity)
    return measured / largest if largest > 0 and np.isfinite(measured) else None


def _fields(case: str, left: xr.Dataset, right: xr.Dataset, quantity: str) -> dict[str, Any]:
    one, other = left.attrs["model"], right.attrs["model"]
    return {
        "id": f"{case}/{quantity}/{one}~{other}",
        "quantity": quantity,
        "unit": UNITS[quantity],
        "left": one,
        "right": other,
    }
