"""Whether a run recorded all that its experiment asks for, and what follows from its own states."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from crosscheck.checks.answers import ask
from crosscheck.checks.modes import largest_stable_step
from crosscheck.checks.scales import (
    EPS,
    PLACE_ROUNDINGS,
    arm_reach,
    gear_arc,
    geared_joints,
    largest_stiffness,
    motor_forces,
    motor_lever,
)
from crosscheck.findings import ComparisonKey, Finding, Subject, make_check
from crosscheck.models.arm.layout import MESHES, Layout
from crosscheck.models.errors import describe_type
from crosscheck.models.experiment.drive import drive_data, torques_along
from crosscheck.models.interface import Model
from crosscheck.models.loading import Case
from crosscheck.models.trajectory import recorded_times
from crosscheck.planning.comparison import Comparison, make_comparison

if TYPE_CHECKING:
    import xarray as xr

RIGID = ("theta", "theta_dot", "theta_ddot", "torque", "kinetic_energy")
BY_PLANET = ("x_sp", "x_pr", "x_sp_dot", "x_pr_dot", "F_sp", "F_pr")
GEARED = (*RIGID, *BY_PLANET)
BY_JOINT = ("theta", "theta_dot", "theta_ddot", "torque")
SAME_TIME_S = 1e-10  # k h and 2 k (h / 2) are the same time
TIMES = 20
FORCES, TEETH = ("F_sp", "F_pr"), "the teeth's force F_sp, F_pr"
# The record's own numbers, worked out once more, a few hundred operations apart; where a solver
# closes joints by iteration, to some 1e-14 m, meshes of 1e8 N/m feel the rest as 1e-6 N of 100 N.
TOLERANCE, TOLERANCE_OF_CONSTRAINTS = 1e-9, 1e-8
# Lumped coordinates say all of a state only while the planets of a stage move together: so many
# roundings of the arcs that displacements are read from, or of the places of bodies that joints
# hold at the arm's reach, and such a part of the largest rate.
ALIKE_ROUNDINGS, ALIKE_RATES = 1000, 1e-9


def plan_records(runs: Sequence[Any]) -> Iterator[Comparison]:
    """That each of some runs is whole, and that the largest steps of their models are stable.

    runs: tasks, with their case and key; ``ask`` makes the task of a question to the run's model.
    """
    for run in runs:
        key = ComparisonKey("record", run.key.experiment, run.key.variant or "run", run.model)
        about = Subject(key, "1", "times, joints, planets, variables missing", "complete output")
        yield make_comparison(about, (run,), _accept_run)
    by_step = sorted(runs, key=lambda run: run.case.scenario.step_s)
    for run in {run.model: run for run in by_step}.values():
        key = ComparisonKey("stable-step", run.key.experiment, "step", run.model)
        about = Subject(key, "1", "largest step over its limit", "stability limit")
        judge = partial(check_stable_step, step_s=run.case.scenario.step_s)
        yield make_comparison(about, (run.ask(largest_stable_step),), judge)


def _accept_run(about: Subject, run: xr.Dataset) -> Finding:
    """The check of a run that is there: no other is passed on, see ``require_complete``."""
    return make_check(about, measured=0.0, tolerance=0.0, basis="a run is whole or it is none")


def check_stable_step(about: Subject, limit: np.ndarray, step_s: float) -> Finding:
    """Check the largest step that a plan takes against the model's own limit [s], ()."""
    limit_s, stable = float(limit), "and steps of any length are stable"
    if math.isfinite(limit_s):
        stable = f"at most {limit_s:.3g} s are stable"
    basis = f"steps of {step_s:.3g} s, {stable}"
    return make_check(about, measured=step_s / limit_s, tolerance=1.0, basis=basis)


class IncompleteRun(ValueError):
    """An error for a run that lacks something, or has it in another form."""


def require_complete(run: object, model: str, case: Case, *, meshing: bool) -> None:
    """Raise IncompleteRun unless a run covers its scenario's grid, joints, planets and variables.

    meshing: whether the model has mesh displacements. Every value must be a finite float64; mesh
    variables are NaN beyond a joint's own planets.
    """
    import xarray as xr

    if not isinstance(run, xr.Dataset):
        raise IncompleteRun(f"the run is {describe_type(run)}, must be a Dataset")
    missing = next(_find_faults(run, case, GEARED if meshing else RIGID), None)
    if missing is not None:
        raise IncompleteRun(missing)
    model_name, step = run.attrs.get("model"), run.attrs.get("step_s")
    if model_name != model or step != case.scenario.step_s:
        raise IncompleteRun(f"the run says it is of model {model_name!r} and step {step!r}")


def _find_faults(run: xr.Dataset, case: Case, variables: tuple[str, ...]) -> Iterator[str]:
    """Defects of a run, in words, the gravest first."""
    yield from (f"the run has no {name}" for name in ("time", "joint") if name not in run.coords)
    yield from (f"the run has no {name}" for name in variables if name not in run)
    expected, time = recorded_times(case.scenario), run["time"].values
    if len(time) != len(expected):
        yield f"the run has {len(time)} times, the scenario asks for {len(expected)}"
    elif time.dtype != np.float64 or not (np.abs(time - expected) <= SAME_TIME_S).all():
        yield "the run's times are not those that the scenario asks for"
    yield from _find_label_faults(run, "joint", len(case.arm.joints))
    if "x_sp" in variables:
        planets = max(joint.planet_count for joint in case.arm.joints)
        yield from _find_label_faults(run, "planet", planets)
    yield from filter(None, (_describe_shape_fault(run, name) for name in variables))
    counts = np.array([[joint.planet_count] for joint in case.arm.joints])
    for name in variables:
        finite = np.isfinite(run[name].values)
        required = np.arange(finite.shape[2]) < counts if name in BY_PLANET else True
        wrong = finite != required
        if wrong.any():
            first = time[np.argwhere(wrong)[0, 0]]
            yield f"{name} is not finite at t = {first:.6g} s"


def _find_label_faults(run: xr.Dataset, name: str, count: int) -> Iterator[str]:
    expected = list(range(1, count + 1))
    labels = run[name].values.tolist() if name in run.coords else []
    if labels != expected:
        lost = [number for number in expected if number not in labels]
        yield f"the run has {name} {labels}, must be {expected}; missing {lost}"


def _describe_shape_fault(run: xr.Dataset, name: str) -> str:
    """Why a variable is not an array of float64 over its dimensions; empty if it is."""
    dims = ("time", "joint", "planet")[: 3 if name in BY_PLANET else 2 if name in BY_JOINT else 1]
    if run[name].dims != dims:
        return f"{name} is over {run[name].dims}, must be over {dims}"
    if run[name].dtype != np.float64:
        return f"{name} is of type {run[name].dtype}, must be float64"
    return ""


class InconsistentRun(ValueError):
    """An error for a run whose accelerations, torques, forces or energies belie its states."""


def require_consistent(run: xr.Dataset, model: Model, *, constrained: bool) -> None:
    """Raise InconsistentRun unless the model's own functions give what its run recorded.

    Compared at some twenty of its times, the first among them, are theta_ddot, torque,
    kinetic_energy, F_sp and F_pr, from theta, theta_dot and the mesh displacements and their rates.
    constrained: whether the model closes its joints by constraint equations.
    """
    tolerance = TOLERANCE_OF_CONSTRAINTS if constrained else TOLERANCE
    at = np.unique(np.linspace(0, run.sizes["time"] - 1, TIMES).round().astype(int))
    reach = arm_reach(model.arm) if constrained else 0.0
    if not model.layout.free:
        at = at[_planets_move_alike(run, at, model, PLACE_ROUNDINGS * EPS * reach)]
        if not at.size:
            reason = "planets that count as one are apart at the start, and ever after"
            raise InconsistentRun(reason)
    q, v = (_states(run, model.layout, suffix) for suffix in ("", "_dot"))
    again = _compute_variables(model, run["time"].values[at], q[at], v[at])
    placed = EPS * reach * largest_stiffness(model.arm) / tolerance
    for name, size in _sizes(run, model, q[0], placed).items():
        recorded = _recorded_values(run, at, name, model)
        difference = float(np.abs(recorded - again[name]).max())
        if not difference <= tolerance * size:
            units = run[name].attrs.get("units", "") if name in run else "N"
            off = f"{difference:.3g} of {size:.3g} {units}"
            raise InconsistentRun(f"{name} does not follow from the recorded states: off by {off}")


def _recorded_values(run: xr.Dataset, at: np.ndarray, name: str, model: Model) -> np.ndarray:
    """Values of a variable at these records; of the teeth, their forces on the displacements.

    These are per planet, by the virtual work of F_sp and F_pr, shape (records, displacements).
    """
    if name != TEETH:
        return np.asarray(run[name].values[at])
    layout, on_coordinates = model.layout, np.zeros((at.size, len(model.layout)))
    for mesh, force in zip(MESHES, FORCES, strict=True):
        values = run[force].values[at]
        for number, joint in geared_joints(model.arm):
            for planet in range(joint.planet_count):
                row = layout.displacement(mesh, number, planet)
                on_coordinates -= row * values[:, number, planet, None]
    return on_coordinates[:, ~layout.angular] / _planet_counts(model)


def _planet_counts(model: Model) -> np.ndarray:
    """Number of planets that each displacement is of, shape (displacements,)."""
    planets = [joint.planet_count for joint in model.arm.joints]
    moving = [c for c in model.layout.coordinates if not c.is_angle]
    return np.array([1 if model.layout.free else planets[c.joint - 1] for c in moving])


def _sizes(run: xr.Dataset, model: Model, q: np.ndarray, placed: float) -> dict[str, float]:
    """The size relative to which each variable's difference is measured, by name.

    placed: of a force [N] that is known to rounding of the bodies' places. A force out of contact
    is the rest of what the motor and the bodies' inertia leave of each other, and near contact it
    is rounding of the arcs from which displacements are read; an acceleration is what forces of
    that size do to the links.
    """
    names = "theta_ddot", "torque", "kinetic_energy"
    sizes = {name: _largest_magnitude(run[name]) for name in names}
    if not model.layout.mesh_joints:
        return sizes
    joints = [joint for _, joint in geared_joints(model.arm)]
    motor = max(sizes["torque"] / motor_lever(joint) for joint in joints)
    arc = 2 * gear_arc(model.arm) * (1 + _largest_magnitude(run["theta"]))
    force = motor + max(EPS * arc * largest_stiffness(model.arm) / TOLERANCE, placed)
    teeth = max(_largest_magnitude(run[name]) for name in FORCES) + force
    teeth *= max(joint.planet_count for joint in joints) if model.layout.free else 1
    sizes |= {TEETH: teeth}
    lever = max(motor_lever(joint) * joint.planet_count for joint in joints)
    inertia = np.diag(model.mass_matrix(q))[model.layout.theta].min()
    moved = teeth * lever / inertia
    return sizes | {"theta_ddot": sizes["theta_ddot"] + moved}


def _largest_magnitude(values: xr.DataArray) -> float:
    return float(np.nanmax(np.abs(values.values)))


def _planets_move_alike(
    run: xr.Dataset, at: np.ndarray, model: Model, placed_m: float
) -> np.ndarray:
    """Whether all planets of each stage move equally at each sample, shape (samples,).

    placed_m: rounding of the places [m] from which displacements are read, 0 where none are.
    """
    alike = np.ones(at.size, dtype=bool)
    arcs = gear_arc(model.arm) * (1 + _largest_magnitude(run["theta"]))
    read = max(ALIKE_ROUNDINGS * EPS * arcs, placed_m)
    swept = placed_m * _largest_magnitude(run["theta_dot"])
    for mesh in MESHES if model.layout.mesh_joints else ():
        rates = max(ALIKE_RATES * _largest_magnitude(run[f"{mesh}_dot"]), swept)
        for name, limit in ((mesh, read), (f"{mesh}_dot", rates)):
            values = run[name].values[at][:, model.layout.mesh_joints]
            spreads = np.nanmax(values, axis=2) - np.nanmin(values, axis=2)
            alike &= ~(spreads.max(axis=1) > limit)
    return alike


def _states(run: xr.Dataset, layout: Layout, suffix: str) -> np.ndarray:
    """States q, or with ``_dot`` v, (times, n), in a model's coordinates; lumped, of planet 1."""
    states = np.empty((run.sizes["time"], len(layout)))
    states[:, layout.theta] = run[f"theta{suffix}"].values
    if not layout.mesh_joints:
        return states
    x_sp, x_pr = (run[f"{mesh}{suffix}"].values for mesh in MESHES)
    for place, coordinate in enumerate(layout.coordinates):
        joint, planet = coordinate.joint - 1, max(coordinate.planet - 1, 0)
        if coordinate.meaning == "x_s":
            states[:, place] = x_sp[:, joint, 0] + x_pr[:, joint, 0]
        elif not coordinate.is_angle:
            values = x_sp if coordinate.meaning == "x_sp" else x_pr
            states[:, place] = values[:, joint, planet]
    return states


def _compute_variables(
    model: Model, t: np.ndarray, q: np.ndarray, v: np.ndarray
) -> dict[str, np.ndarray]:
    """Variables at times t (states,) by name, worked out by the model's functions.

    Those of the teeth are the forces on the displacements without the motors', per planet [N].
    """
    layout = model.layout
    drive = drive_data(model.scenario, len(model.arm.joints))
    torque = torques_along(drive, t, q[:, layout.theta], v[:, layout.theta])
    acceleration = ask(model, "acceleration", q.shape, t, q, v)
    inertia = ask(model, "mass_matrix", (*q.shape, q.shape[1]), q)
    values = {"theta_ddot": acceleration[:, layout.theta], "torque": torque}
    values["kinetic_energy"] = np.einsum("si,sij,sj->s", v, inertia, v) / 2
    if layout.mesh_joints:
        # With meshes that do not slide no damper acts, but motor and springs do.
        still = np.where(layout.angular, v, 0.0)
        force = ask(model, "generalized_force", q.shape, t, q, still)
        on_teeth = force - motor_forces(model.arm, layout, torque)
        values[TEETH] = on_teeth[:, ~layout.angular] / _planet_counts(model)
    return values
