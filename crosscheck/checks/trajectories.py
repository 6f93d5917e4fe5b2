"""Whole runs: is the difference of two trajectories inside what their integrators can explain?"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crosscheck.checks.scales import EPS, ReasonedLimit
from crosscheck.findings import Finding, Subject, make_check, make_measurement
from crosscheck.models.arm.arm import Arm
from crosscheck.models.trajectory import VARIABLES, unit_of

if TYPE_CHECKING:
    import xarray as xr

UNITS = {**{name: unit_of(name) for name in VARIABLES}, "tip": "m"}

# RK4 commutes with a linear change of coordinates: two models with the same equations, step and
# start differ by rounding alone, whatever coordinates they use inside. Every step rounds, and so
# many roundings add up at random; the factor is for roundings that do more than one in the start.
SAME_STEP = (
    *("theta", "x_sp", "x_pr", "F_sp", "F_pr"),
    *("theta_dot", "theta_ddot", "torque", "kinetic_energy"),
)
ROUNDINGS_AT_ONCE = 10
# Safety factor of the grid convergence index for two grids (Roache). The order is taken as 1: the
# dead zone and the clearance's impacts leave no higher one to rely on.
SAFETY = 3.0
# Three grids in their asymptotic range give the order to a few per cent of one.
ORDER_TOLERANCE = 0.2


class RunMismatch(ValueError):
    """An error for two runs that are not of the same times, joints and planets."""


def largest_difference(run: xr.Dataset, other_run: xr.Dataset, quantity: str) -> float:
    """max over time, joints and planets of |one - other|, in the quantity's unit.

    Raises RunMismatch unless both runs have the quantity at the very same times, joints and
    planets.
    """
    return float(np.fmax.reduce(np.abs(_difference(run, other_run, quantity)), axis=None))


def _difference(run: xr.Dataset, other_run: xr.Dataset, quantity: str) -> np.ndarray:
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


class Pair(NamedTuple):
    """A run, and one from a start that is one rounding away."""

    run: xr.Dataset
    nudged: xr.Dataset


def check_same_step(
    about: Subject, left: xr.Dataset, right: xr.Dataset, pair: Pair, widest: ReasonedLimit
) -> Finding:
    """Check runs of two models through the same integrator and step, over the whole run."""
    quantity = about.key.quantity
    limit = repetition_limit(pair, quantity)
    measured = largest_difference(left, right, quantity)
    return make_check(
        about,
        measured=measured,
        tolerance=limit.value,
        resolved=limit.value <= widest.value,
        basis=f"{limit.basis}; {describe_acceptance(widest)}",
        relative=_relative_value(measured, left, quantity),
    )


def repetition_limit(pair: Pair, quantity: str) -> ReasonedLimit:
    """The limit of how far the same steps may lead apart by rounding alone."""
    grown, rounding = largest_difference(*pair, quantity), EPS * size(pair.run, quantity)
    steps = step_count(pair.run)
    basis = (
        f"{ROUNDINGS_AT_ONCE} sqrt(N) (g + eps s), N = {steps:.0f} steps, g = {grown:.1e} (what one"
        f" rounding in the start grows to), eps s = {rounding:.1e} (rounding of the quantity)"
    )
    return ReasonedLimit(ROUNDINGS_AT_ONCE * math.sqrt(steps) * (grown + rounding), basis)


def describe_acceptance(widest: ReasonedLimit) -> str:
    """The limit that an uncertainty must stay below for a verdict, in words."""
    return f"acceptance limit of the uncertainty {widest.value:.2g}, {widest.basis}"


def step_count(run: xr.Dataset) -> float:
    """Number of steps that a run has taken, at least 1."""
    return max(float(run.variables["time"].values[-1]) / float(run.attrs["step_s"]), 1.0)


def check_at_time(
    about: Subject,
    left: xr.Dataset,
    right: xr.Dataset,
    pair: Pair,
    widest: ReasonedLimit,
    time_s: float,
) -> Finding:
    """Check like ``check_same_step``, at one instant: the record there and the one before."""

    def select_records(run: xr.Dataset) -> xr.Dataset:
        index = int(np.argmin(np.abs(run["time"].values - time_s)))
        return run.isel(time=slice(max(index - 1, 0), index + 1))

    return check_same_step(about, select_records(left), select_records(right), pair, widest)


def check_refined_runs(
    about: Subject,
    left: Sequence[xr.Dataset],
    right: Sequence[xr.Dataset],
    widest: ReasonedLimit,
) -> Finding:
    """Check each side's own best run against the other's.

    A side is a sequence of pairs, fine and coarse, its own first; the pair furthest apart gives its
    uncertainty. An integrator's error where contacts change depends on where in a step they do, so
    that one pair may be close together by chance.
    """
    quantity = about.key.quantity
    uncertainties = [
        max(uncertainty(*pair, quantity) for pair in zip(side[::2], side[1::2], strict=True))
        for side in (left, right)
    ]
    rounding = max(run_rounding(side[0], quantity) for side in (left, right))
    combined = float(np.hypot(uncertainties[0], uncertainties[1]))
    measured = largest_difference(left[0], right[0], quantity)
    return make_check(
        about,
        measured=measured,
        tolerance=combined + rounding,
        resolved=combined <= widest.value,
        basis=(
            f"sqrt(u1^2 + u2^2) + eps s sqrt(N), u1 = {uncertainties[0]:.2g} and u2 ="
            f" {uncertainties[1]:.2g} by step"
            f" refinement, eps s sqrt(N) = {rounding:.1g}; {describe_acceptance(widest)}"
        ),
        relative=_relative_value(measured, left[0], quantity),
    )


def run_rounding(run: xr.Dataset, quantity: str) -> float:
    """Rounding alone of a quantity over a run: half an ulp a step, added up at random.

    Every step rounds the state that it adds to; over N steps that is sqrt(N) roundings of its
    size. No refinement can measure less.
    """
    return float(EPS * size(run, quantity) * math.sqrt(step_count(run)))


def measure_sensitivity(about: Subject, run: xr.Dataset, nudged: xr.Dataset) -> Finding:
    """Measure how far a run moves when its start is changed by a rounding."""
    return measure_deviation(
        about, nudged, run, "every angle and displacement started a rounding away"
    )


def measure_deviation(
    about: Subject, left: xr.Dataset, right: xr.Dataset, basis: str = ""
) -> Finding:
    """Measure how far runs are apart that nobody expects to agree; of one joint, where named.

    The relative difference is over the size of the quantity in the right run.
    """
    quantity, joint = about.key.quantity, about.key.joint
    if joint is not None:
        left, right = (run.sel(joint=[joint]) for run in (left, right))
    measured = largest_difference(right, left, quantity)
    relative = _relative_value(measured, right, quantity)
    return make_measurement(about, measured=measured, basis=basis, relative=relative)


def measure_tip_deviation(about: Subject, left: xr.Dataset, right: xr.Dataset, arm: Arm) -> Finding:
    """Measure the largest distance between the tips of two runs, and its share of the reach."""
    left_run, right_run = (run.assign(tip=tip_position(run, arm)) for run in (left, right))
    distances = np.linalg.norm(_difference(left_run, right_run, "tip"), axis=1)
    measured = float(np.fmax.reduce(distances))
    relative = measured / sum(link.length_m for link in arm.links)
    return make_measurement(about, measured=measured, relative=relative)


def tip_position(run: xr.Dataset, arm: Arm) -> xr.DataArray:
    """Position of the tip in the base frame, (time, axis) [m], from relative joint angles."""
    import xarray as xr

    absolute = run["theta"].cumsum("joint")
    lengths = xr.DataArray([link.length_m for link in arm.links], dims="joint")
    axes = [(lengths * turn(absolute)).sum("joint") for turn in (np.cos, np.sin)]
    return xr.concat(axes, "axis").transpose("time", "axis")


def _relative_value(measured: float, run: xr.Dataset, quantity: str) -> float | None:
    largest = size(run, quantity)
    return measured / largest if largest > 0 and np.isfinite(measured) else None


def observed_order(runs: Sequence[xr.Dataset], quantity: str) -> float:
    """Observed order p from runs at h, h/2, h/4: differences shrink by 2^p (Richardson)."""
    coarse, middle, fine = runs
    first = largest_difference(coarse, middle, quantity)
    second = largest_difference(middle, fine, quantity)
    return math.log2(first / second) if first > 0 and second > 0 else math.nan


def check_formal_order(
    about: Subject, runs: Sequence[xr.Dataset], formal: int, quantity: str
) -> Finding:
    """Check that runs show the integrator's order in smooth motion."""
    observed = observed_order(runs, quantity)
    difference, basis = abs(observed - formal), "three grids in the asymptotic range"
    note = f"observed order {observed:.3f} from steps h, h/2, h/4"
    return make_check(about, measured=difference, tolerance=ORDER_TOLERANCE, basis=basis, note=note)


def measure_impact_order(about: Subject, runs: Sequence[xr.Dataset], quantity: str) -> Finding:
    """Measure the order of convergence through impacts."""
    note = "the dead zone's kink leaves less than the formal order"
    return make_measurement(about, measured=observed_order(runs, quantity), note=note)


def check_stable_step(about: Subject, limit: np.ndarray, step_s: float) -> Finding:
    """Check the largest step that a plan takes against the model's own limit [s], ()."""
    limit_s = float(limit)
    is_limited = math.isfinite(limit_s)
    limit_text = (
        f"at most {limit_s:.3g} s are stable"
        if is_limited
        else "and steps of any length are stable"
    )
    basis = f"steps of {step_s:.3g} s, {limit_text}"
    return make_check(about, measured=step_s / limit_s, tolerance=1.0, basis=basis)
