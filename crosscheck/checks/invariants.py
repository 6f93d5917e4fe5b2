"""Power balance and angular momentum: what must hold for any model of the arm.

Both use a model's own M, bias and acceleration on one side and first principles on the other.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from crosscheck.checks.states import States, random_states
from crosscheck.findings import Finding, checked, failed
from models.drive import drive_data, joint_torque
from models.interface import Model

# Powers of 1e4 N x 0.1 m/s whose forces carry the rounding of displacements (see states).
TOLERANCE = 1e-10
BASIS = "rounding of the forces, as for accelerations"
# Of the work done: two orders above what the reference integrator asks of each step.
WORK_TOLERANCE = 1e-9
GAP_TOLERANCE = 1e-12


class Motion(NamedTuple):
    """One state, what moves it and how it moves: M a + bias [n], force [n], torques [joints]."""

    v: np.ndarray
    inertial: np.ndarray
    force: np.ndarray
    torques: np.ndarray


def invariants(case: str, models: Sequence[Model], count: int, seed: int) -> Iterator[Finding]:
    """Both balances for every geared model, at random states."""
    for model in models:
        states = random_states(model.coordinates, model.arm, count, seed)
        for quantity, unit, residual in (
            ("power", "W", _power_residual),
            ("angular momentum rate", "N m", _angular_momentum_residual),
        ):
            yield _balanced(case, model, states, (quantity, unit), residual)


def _balanced(
    case: str,
    model: Model,
    states: States,
    what: tuple[str, str],
    residual: Callable[[Model, Motion], tuple[float, float]],
) -> Finding:
    quantity, unit = what
    fields: dict[str, Any] = {
        "id": f"invariants/{case}/{quantity.replace(' ', '-')}/{model.name}",
        "quantity": quantity,
        "unit": unit,
        "left": model.name,
        "right": "first principles",
        "metric": f"largest residual over {len(states.t)} random states",
    }
    try:
        pairs = [residual(model, _motion(model, *state)) for state in zip(*states, strict=True)]
    except Exception as error:  # a model that raises is a failed check
        return failed(note=f"{type(error).__name__}: {error}", **fields)
    gaps, sizes = np.array(pairs).T
    size = float(np.sqrt((sizes**2).mean()))
    measured = float(np.abs(gaps).max())
    return checked(
        measured=measured,
        tolerance=TOLERANCE * size,
        basis=f"{TOLERANCE:g} of the terms' size, {size:.3g} {unit}: {BASIS}",
        relative=measured / size,
        **fields,
    )


def constraints(case: str, models: Sequence[Model], count: int, seed: int) -> Iterator[Finding]:
    """Joints that a model closes by constraint equations stay closed, at the model's own motion."""
    for model in models:
        if "constraint_residual" not in model.abilities:
            continue
        fields: dict[str, Any] = {
            "id": f"invariants/{case}/constraints/{model.name}",
            "quantity": "constraint residual",
            "unit": "1",
            "left": model.name,
            "right": "closed joints",
            "metric": f"largest gap, rate or acceleration over its size, {count} random states",
        }
        states = random_states(model.coordinates, model.arm, count, seed)
        try:
            gaps = [_widest_gap(model, *state) for state in zip(*states, strict=True)]
        except Exception as error:  # a model that raises is a failed check
            yield failed(note=f"{type(error).__name__}: {error}", **fields)
            continue
        basis = "rounding of places of a metre, rates and accelerations of their own size"
        yield checked(measured=max(gaps), tolerance=GAP_TOLERANCE, basis=basis, **fields)


def _widest_gap(model: Model, t: float, q: np.ndarray, v: np.ndarray) -> float:
    a = model.acceleration(t, q, v)
    reach = sum(link.length_m for link in model.arm.links)
    sizes = [max(1.0, reach * float(np.abs(vector[2::3]).max())) for vector in (v * 0, v, a)]
    residuals = model.constraint_residual(q, v, a)
    return max(float(np.abs(r).max()) / size for r, size in zip(residuals, sizes, strict=True))


def _motion(model: Model, t: float, q: np.ndarray, v: np.ndarray) -> Motion:
    inertial = model.mass_matrix(q) @ model.acceleration(t, q, v) + model.bias(q, v)
    drive = drive_data(model.scenario, len(model.arm.joints))
    torques = [
        joint_torque(drive.code, gains, drive.table_time, table, t, theta, theta_dot)
        for gains, table, theta, theta_dot in zip(
            drive.gains, drive.table_torque, q[2::3], v[2::3], strict=True
        )
    ]
    return Motion(v, inertial, model.generalized_force(t, q, v), np.array(torques))


def _power_residual(model: Model, motion: Motion) -> tuple[float, float]:
    """d(kinetic)/dt = sum of T theta_s' / n and of what the meshes and dampers put in.

    v . (M a + bias) is the rate of v . M v / 2. A motor turns its sun n times as fast as the link,
    and by the mesh displacements; its torque reaches a mesh row of the force as T / (n r_s).
    """
    supplied, size = 0.0, 0.0
    for joint, torque in enumerate(motion.torques):
        radius, ratio = _sun(model, joint)
        dx_sp, dx_pr, dtheta = motion.v[3 * joint : 3 * joint + 3]
        motor = torque / ratio
        sun_rate = (dx_sp + dx_pr) / radius + ratio * dtheta
        mesh = motion.force[3 * joint : 3 * joint + 2] - motor / radius
        terms = np.array([motor * sun_rate, mesh[0] * dx_sp, mesh[1] * dx_pr])
        supplied += terms.sum()
        size += np.abs(terms).sum()
    return float(motion.v @ motion.inertial - supplied), float(size)


def _angular_momentum_residual(model: Model, motion: Motion) -> tuple[float, float]:
    """dH/dt = T_1 / n + (N F_pr1 + d_pr x_pr1') r_r: only the ground acts from outside.

    Turning the whole arm turns the first ring's teeth past its planets: x_pr1 changes by -r_r.
    """
    radius, ratio = _sun(model, 0)
    ring = radius * model.arm.joints[0].ring_teeth / model.arm.joints[0].sun_teeth
    motor = motion.torques[0] / ratio
    rate = motion.inertial[2] - ring * motion.inertial[1]
    on_teeth = motor / radius - motion.force[1]
    return float(rate - motor - on_teeth * ring), float(abs(motor) + abs(on_teeth * ring))


def _sun(model: Model, joint: int) -> tuple[float, float]:
    """(base radius of the sun [m], speed ratio) from the arm's own numbers."""
    data = model.arm.joints[joint]
    pitch = data.module_m * data.sun_teeth / 2
    radius = pitch * math.cos(math.radians(data.pressure_angle_deg))
    return radius, (data.sun_teeth + data.ring_teeth) / data.sun_teeth


def energy_over_run(case: str, run: xr.Dataset) -> Iterator[Finding]:
    """Kinetic energy gained against work done, over a run that integrated the work along."""
    if "work" not in run:
        return
    gained = run["kinetic_energy"].values - run["kinetic_energy"].values[0]
    work = run["work"].values
    size = float(run["work_turned_over"].values[-1])
    measured = float(np.abs(gained - work).max())
    yield checked(
        id=f"invariants/{case}/energy/{run.attrs['model']}",
        quantity="energy",
        unit="J",
        left=run.attrs["model"],
        right="first principles",
        metric="largest difference of energy gained and work done over the run",
        measured=measured,
        tolerance=WORK_TOLERANCE * size,
        basis=f"{WORK_TOLERANCE:g} of the work turned over, {size:.3g} J",
        relative=measured / size,
    )
