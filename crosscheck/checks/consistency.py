"""Whether what a run recorded follows from the states that it recorded."""

from __future__ import annotations

import numpy as np
import xarray as xr

from crosscheck.checks.answers import angles_among
from crosscheck.checks.invariants import sun_of, torques_at
from models.arm import Arm
from models.drive import drive_data
from models.interface import Model

TIMES = 20
# The record's own numbers, worked out once more, a few hundred operations apart; where a solver
# closes joints by iteration, to some 1e-14 m, meshes of 1e8 N/m feel the rest as 1e-6 N of 100 N.
TOLERANCE, TOLERANCE_OF_CONSTRAINTS = 1e-9, 1e-8
# Lumped coordinates say all of a state only while the planets of a stage move alike [m, m/s].
ALIKE = {"x_sp": 1e-13, "x_pr": 1e-13, "x_sp_dot": 1e-9, "x_pr_dot": 1e-9}


class Inconsistent(ValueError):
    """A run whose accelerations, torques, forces or energies are not those of its own states."""


def require_consistent(run: xr.Dataset, model: Model, *, constrained: bool) -> None:
    """Raise Inconsistent unless the model's own functions give what its run recorded.

    At some twenty of its times, the first among them: theta_ddot, torque, kinetic_energy, F_sp and
    F_pr from theta, theta_dot and the mesh displacements and their rates. constrained: whether the
    model closes its joints by constraint equations.
    """
    tolerance = TOLERANCE_OF_CONSTRAINTS if constrained else TOLERANCE
    at = [k for k in _chosen(run) if _planets_move_alike(run, k)]
    q, v = (_states(run, model, suffix) for suffix in ("", "_dot"))
    again = [_worked_out(model, float(run["time"][k]), q[k], v[k]) for k in at]
    sizes = _sizes(run, model, q[0])
    for name, size in sizes.items():
        recorded = run[name].values[at]
        recorded = recorded[:, :, 0] if recorded.ndim == 3 else recorded
        apart = float(np.abs(recorded - np.array([values[name] for values in again])).max())
        if not apart <= tolerance * size:
            off = f"{apart:.3g} of {size:.3g} {run[name].attrs.get('units', '')}"
            raise Inconsistent(f"{name} does not follow from the recorded states: off by {off}")


def _sizes(run: xr.Dataset, model: Model, q: np.ndarray) -> dict[str, float]:
    """What each variable's difference is measured against.

    A force in free play is the rest of what the motor and the bodies' inertia leave of each other,
    and near contact it is rounding of the arcs from which displacements are read; an acceleration
    is what forces of that size do to the links.
    """
    sizes = {name: _largest(run[name]) for name in ("theta_ddot", "torque", "kinetic_energy")}
    if "F_sp" not in run:
        return sizes
    joints, angular = model.arm.joints, angles_among(model.coordinates)
    suns = [sun_of(model.arm, number) for number in range(len(joints))]
    motor = max(sizes["torque"] / (radius * ratio) for radius, ratio in suns)
    arc = max(joint.module_m * joint.ring_teeth for joint in joints) * (1 + _largest(run["theta"]))
    stiffest = max(j.mesh_stiffness_N_per_m + j.mesh_stiffness_amplitude_N_per_m for j in joints)
    force = motor + float(np.finfo(float).eps) * arc * stiffest / TOLERANCE
    sizes |= {name: _largest(run[name]) + force for name in ("F_sp", "F_pr")}
    lever = max(
        radius * ratio * j.planet_count for (radius, ratio), j in zip(suns, joints, strict=True)
    )
    inertia = np.diag(model.mass_matrix(q))[angular].min()
    return sizes | {"theta_ddot": sizes["theta_ddot"] + sizes["F_sp"] * lever / inertia}


def _largest(values: xr.DataArray) -> float:
    return float(np.nanmax(np.abs(values.values)))


def _chosen(run: xr.Dataset) -> list[int]:
    return np.unique(np.linspace(0, run.sizes["time"] - 1, TIMES).round().astype(int)).tolist()


def _planets_move_alike(run: xr.Dataset, k: int) -> bool:
    for name, limit in ALIKE.items():
        values = run[name].values[k] if name in run else np.zeros((1, 1))
        if (np.nanmax(values, axis=1) - np.nanmin(values, axis=1)).max() > limit:
            return False
    return True


def _states(run: xr.Dataset, model: Model, suffix: str) -> np.ndarray:
    """q, or with ``_dot`` v, shape (times, n), in the model's coordinates; of planet 1."""
    columns = [run[f"theta{suffix}"].values]
    if not angles_among(model.coordinates).all():
        meshes = [run[f"{name}{suffix}"].values[:, :, 0] for name in ("x_sp", "x_pr")]
        columns = [*meshes, *columns]
    return np.stack(columns, axis=2).reshape(run.sizes["time"], -1)


def _worked_out(
    model: Model, t: float, q: np.ndarray, v: np.ndarray
) -> dict[str, np.ndarray | float]:
    """Variables, per joint or one of all, from the model's functions of this state."""
    angular = angles_among(model.coordinates)
    drive = drive_data(model.scenario, len(model.arm.joints))
    torque = torques_at(drive, t, q[angular], v[angular])
    values: dict[str, np.ndarray | float] = {
        "theta_ddot": model.acceleration(t, q, v)[angular],
        "torque": torque,
        "kinetic_energy": float(v @ model.mass_matrix(q) @ v / 2),
    }
    if not angular.all():
        # With meshes that do not slide no damper acts, and what is left are motor and springs.
        force = model.generalized_force(t, q, np.where(angular, v, 0.0))
        values |= _elastic_forces(model.arm, force.reshape(-1, 3), torque)
    return values


def _elastic_forces(arm: Arm, force: np.ndarray, torque: np.ndarray) -> dict[str, np.ndarray]:
    """Force per planet [N], shape (joints,), from rows of force on x_sp, x_pr, theta (Eq. 22)."""
    planets = np.array([joint.planet_count for joint in arm.joints])
    suns = [sun_of(arm, joint) for joint in range(len(planets))]
    motor = torque / np.array([radius * ratio for radius, ratio in suns])
    return {name: (motor - force[:, row]) / planets for row, name in enumerate(("F_sp", "F_pr"))}
