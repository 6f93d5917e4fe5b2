"""Differences of whole runs, and what comparisons of an experiment's runs are about."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.checks.records import BY_PLANET
from crosscheck.checks.sampled import ExperimentPlan
from crosscheck.checks.scales import ReasonedLimit, acceptance_limit
from crosscheck.findings import ComparisonKey, Subject
from crosscheck.models.arm.layout import lumped_layout
from crosscheck.models.trajectory import VARIABLES, unit_of

if TYPE_CHECKING:
    import xarray as xr

UNITS = {**{name: unit_of(name) for name in VARIABLES}, "tip": "m"}
MESH = ("theta", "x_sp", "x_pr")
LARGEST, APART = "largest absolute difference", "largest distance"

# Safety factor of the grid convergence index for two grids (Roache). The order is taken as 1: the
# dead zone and the clearance's impacts leave no higher one to rely on.
SAFETY = 3.0


class RunMismatch(ValueError):
    """An error for two runs that are not of the same times, joints and planets."""


def largest_difference(run: xr.Dataset, other_run: xr.Dataset, quantity: str) -> float:
    """max over time, joints and planets of |one - other|, in the quantity's unit.

    Raises RunMismatch unless both runs have the quantity at the very same times, joints and
    planets.
    """
    return float(np.fmax.reduce(np.abs(compute_difference(run, other_run, quantity)), axis=None))


def compute_difference(run: xr.Dataset, other_run: xr.Dataset, quantity: str) -> np.ndarray:
    """A run's values of a quantity less another's. Raises RunMismatch."""
    for side in (run, other_run):
        if quantity not in side:
            raise RunMismatch(f"the run of {side.attrs.get('model')} has no {quantity}")
    left, right = run.variables[quantity], other_run.variables[quantity]
    if left.dims != right.dims:
        raise RunMismatch(f"{quantity} is over {left.dims} in one run, {right.dims} in the other")
    for name in map(str, left.dims):
        if not np.array_equal(_labels(run, name), _labels(other_run, name)):
            raise RunMismatch(f"the runs have {quantity} at other values of {name}")
    if (np.isnan(left.values) != np.isnan(right.values)).any():
        raise RunMismatch(f"{quantity} has values in one run where the other has none")
    values: np.ndarray = left.values - right.values
    return values


def size(run: xr.Dataset, quantity: str) -> float:
    """Largest magnitude of a quantity in a run, in its unit."""
    return float(np.fmax.reduce(np.abs(run.variables[quantity].values), axis=None))


def _labels(run: xr.Dataset, name: str) -> np.ndarray:
    """Labels of a dimension; times to 0.1 ns, so that k h and 2 k (h/2) are the same label."""
    labels = run.variables[name].values if name in run.variables else np.arange(run.sizes[name])
    return labels.round(10) if name == "time" else labels


def uncertainty(fine: xr.Dataset, coarse: xr.Dataset, quantity: str) -> float:
    """Numerical uncertainty of `fine`: its distance from the run at twice the step, times 3."""
    return SAFETY * largest_difference(fine, coarse, quantity)


def describe_acceptance(widest: ReasonedLimit) -> str:
    """The limit that an uncertainty must stay below for a verdict, in words."""
    return f"acceptance limit of the uncertainty {widest.value:.2g}, {widest.basis}"


def step_count(run: xr.Dataset) -> float:
    """Number of steps that a run has taken, at least 1."""
    return max(float(run.variables["time"].values[-1]) / float(run.attrs["step_s"]), 1.0)


def relative_value(measured: float, run: xr.Dataset, quantity: str) -> float | None:
    """A difference over the size of the quantity in a run; None where that says nothing."""
    largest = size(run, quantity)
    return measured / largest if largest > 0 and np.isfinite(measured) else None


def has_meshes(experiment: ExperimentPlan) -> bool:
    """Whether runs of the experiment's geared models have mesh variables."""
    return bool(lumped_layout(experiment.case.arm).mesh_joints)


def recorded_quantities(experiment: ExperimentPlan, quantities: Sequence[str] = MESH) -> list[str]:
    """Those of some quantities that runs of the experiment's arm have."""
    return [name for name in quantities if has_meshes(experiment) or name not in BY_PLANET]


def find_acceptance_limit(
    experiment: ExperimentPlan, about: Subject, run: xr.Dataset
) -> ReasonedLimit:
    """The acceptance limit of an uncertainty of the subject's quantity, as large as in a run."""
    quantity, (arm, scenario, _) = about.key.quantity, experiment.case
    return acceptance_limit(quantity, arm, scenario, size(run, quantity))


def make_subject(
    family: str,
    experiment: ExperimentPlan,
    quantity: str,
    left: str,
    right: str,
    joint: int | None = None,
) -> Subject:
    """The subject of a comparison of two models' runs."""
    key = ComparisonKey(family, experiment.name, quantity, left, right, joint)
    return Subject(key, UNITS[quantity], APART if quantity == "tip" else LARGEST)
