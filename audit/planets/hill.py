"""How differences between the planets of a stage grow while all still move as one.

With x_pr,n = x_pr + delta_n and x_sp,n = x_s - x_pr,n, the differences of a stage adding up to 0,
every term of the kinetic energy that is linear in them does so too, and the meshes of planet n push
on delta_n alone: F_sp(x_sp - delta_n) against F_pr(x_pr + delta_n). For small differences

    M_p delta'' + (d_sp + d_pr) / N delta' + (k_sp c_sp + k_pr c_pr) delta = 0,

c being 1 while the mesh is in contact on the motion that all share, and 0 while it is apart: Hill's
equation, driven by contacts that come and go.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.derivation.gears import Gears
from crosscheck.analytic.derivation.stage import equivalent_masses
from crosscheck.analytic.kernel.batch import Batch
from crosscheck.analytic.model import PhysicalModel
from crosscheck.analytic.paper.mesh_force import is_in_contact
from crosscheck.analytic.paper.mesh_frequency import mesh_phase
from crosscheck.analytic.paper.stiffness import stiffness
from crosscheck.analytic.paper.tooth_error import total_error
from crosscheck.audit.phase.linear import linear_step
from crosscheck.models.arm.arm import Planetary
from crosscheck.models.trajectory import recorded_times

LEAST = 1e-300  # of a difference that passes through 0, so that its logarithm is finite
LARGEST = 1e100  # beyond it a difference is divided by itself, and its logarithm kept
LAWS = 2  # of contact: as the teeth have it, and as if none ever parted
CHUNK = 500  # steps that the models are ahead of their differences


class Stages(NamedTuple):
    """The geared stages, (stages,): where their planets are, and properties of the differences.

    mesh: place of the first planet's sun mesh among the gears; ring: where the coordinates x_pr of
    its planets begin; planets: how many of them; mass: M_p [kg] of one planet; frequency [rad/s]:
    of the differences with both meshes in contact at mean stiffness; floor: below which rounding
    does not let the spread fall [m].
    """

    mesh: np.ndarray
    ring: np.ndarray
    planets: np.ndarray
    mass: np.ndarray
    frequency: np.ndarray
    floor: np.ndarray


class Differences(NamedTuple):
    """Natural logarithms of planets' differences in metres, (times, stages).

    part: of |delta|; size: of the oscillation, the root of delta^2 + (delta' / w)^2 with w the
    stage's ``frequency``.
    """

    part: np.ndarray
    size: np.ndarray


class FollowedPlanets(NamedTuple):
    """A model's own run at its records, and how planets part along it.

    time (times,) [s]; x_pr (times, coordinates) [m] of every planet that has a coordinate, stage by
    stage; by_contact: of differences whose meshes touch where those of the run do; pressed: as if
    no mesh ever parted.
    """

    time: np.ndarray
    x_pr: list[np.ndarray]
    by_contact: Differences
    pressed: Differences


def follow_planets(
    models: Sequence[PhysicalModel], start_m: np.ndarray
) -> list[FollowedPlanets | None]:
    """How far planets that start so far apart get along the models' own runs, at their records.

    models: alike but for their starts, no table for a drive; start_m (models, stages). Planets
    lumped or free; free ones count as all at their mean, so that what the other stages' planets do
    is in it. Exact dead zone. None for a run that diverges.
    """
    first, stages = models[0], build_stages(models[0])
    time = recorded_times(first.scenario)
    with np.errstate(invalid="ignore", over="ignore"):  # of runs that diverge
        q, part, size = _integrate_differences(models, stages, np.asarray(start_m, dtype=float))
    finite = np.isfinite(q).all(axis=(0, 2))
    ends = stages.ring + stages.planets
    return [
        FollowedPlanets(
            time,
            [q[:, k, begin:end] for begin, end in zip(stages.ring, ends, strict=True)],
            *(Differences(part[:, k, law], size[:, k, law]) for law in range(LAWS)),
        )
        if finite[k]
        else None
        for k in range(len(models))
    ]


def build_stages(model: PhysicalModel) -> Stages:
    """The geared stages of a model, planets lumped or free."""
    layout, gears = model.layout, model.gears
    joints = [joint for joint in model.arm.joints if isinstance(joint, Planetary)]
    counts = [joint.planet_count if layout.free else 1 for joint in joints]
    mesh = 2 * np.cumsum([0, *counts[:-1]])
    mass = np.array([float(equivalent_masses(joint)[1]) for joint in joints])
    damping = (gears.d / gears.planets)[mesh] + (gears.d / gears.planets)[mesh + 1]
    first = 0 if layout.free else None
    return Stages(
        mesh,
        np.array([layout.at("x_pr", joint, first) for joint in layout.mesh_joints]),
        np.array(counts),
        mass,
        np.sqrt((gears.k_m[mesh] + gears.k_m[mesh + 1]) / mass),
        rounding_floor(gears.b[mesh + 1], damping / (2 * mass), model.scenario.step_s),
    )


def rounding_floor(x_m: np.ndarray, decay_per_s: np.ndarray, step_s: float) -> np.ndarray:
    """The distance [m] at which rounding keeps planets at x whose differences decay so fast.

    Every step adds a last place's rounding, of variance ulp^2 / 12, and a step later exp(-decay
    step) of it is left.
    """
    return np.spacing(x_m) / np.sqrt(24 * decay_per_s * step_s)


def coefficients(
    gears: Gears, mesh: int, t: np.ndarray, q: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Stiffness [N/m] and damping [N s/m] against a planet's difference; both with all pressed.

    mesh: place of its sun mesh, which its ring mesh follows; at times t (...,) [s] and states q, v
    (..., n), each of shape (...,).
    """
    spring, damper, pressed, damped = np.zeros((4, *q.shape[:-1]))
    for i in range(mesh, mesh + 2):
        turning = q[..., gears.theta[i]], v[..., gears.theta[i]]
        phase = mesh_phase(gears.phase, gears.rate[i], gears.offset[i], t, *turning)
        k = stiffness(gears.law, i, phase, gears.k_m[i], gears.k_a[i])
        d = gears.d[i] / gears.planets[i]
        x = q[..., gears.x_index[i]] - (
            q[..., gears.subtract_index[i]] if gears.subtract_index[i] >= 0 else 0.0
        )
        error = total_error(phase, gears.E[i], gears.error_phase[i], gears.static_error[i])
        touching = is_in_contact(x - error, gears.b[i])
        pressed += k
        damped += d
        spring += np.where(touching, k, 0.0)
        damper += np.where(touching | gears.damps_without_contact, d, 0.0)
    return spring, damper, pressed, damped


def _integrate_differences(
    models: Sequence[PhysicalModel], of: Stages, start_m: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Step the models and their differences; return q, ``part`` and ``size`` at the records.

    Of members, what is kept at records: q (records, members, n) [m, rad]; logarithms of the
    differences' ``part`` and ``size``, (records, members, LAWS, stages).
    """
    scenario, batch = models[0].scenario, Batch(models)
    stride, records = scenario.stride, scenario.steps // scenario.stride + 1
    shape = (len(models), LAWS, of.mass.size)
    kept = np.empty((records, len(models), len(models[0].layout)))
    part, size = np.empty((2, records, *shape))
    x = np.tile((1.0, 0.0), (*shape, 1))  # delta and delta' over exp(scale)
    scale = np.repeat(np.log(start_m)[:, None], LAWS, axis=1)
    for begin in range(0, scenario.steps + 1, CHUNK):
        q, v = _states(models, batch.run_stages(min(CHUNK, scenario.steps + 1 - begin)))
        transfers = _transfers(models[0], of, begin, q, v)
        for step, transfer in enumerate(transfers, start=begin):
            whole = np.hypot(x[..., 0], x[..., 1] / of.frequency)
            if step % stride == 0:
                kept[step // stride] = q[step - begin, 0]
                part[step // stride] = scale + np.log(np.maximum(np.abs(x[..., 0]), LEAST))
                size[step // stride] = scale + np.log(whole)
            x = (transfer @ x[..., None])[..., 0]
            whole = np.hypot(x[..., 0], x[..., 1] / of.frequency)
            least = of.floor * np.exp(-scale)
            beyond = ~((least <= whole) & (whole <= LARGEST))
            x /= np.where(beyond, whole, 1.0)[..., None]
            scale += np.where(beyond, np.log(np.maximum(whole, least)), 0.0)
    return kept, part, size


def _states(models: Sequence[PhysicalModel], passed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """q and v (steps, 4, members, n) in the layout's coordinates, of what ``staged`` returns."""
    steps, stages, _, rows, _ = passed.shape
    recorded = models[0].equations.record_map()
    members = passed.transpose(0, 1, 3, 2, 4).reshape(steps * stages, rows, -1)[..., : len(models)]
    q, v = (
        np.stack(
            [half[:, index] - sum(half[:, k] for k in less) for index, *less in recorded], axis=1
        )
        for half in (members[:, : rows // 2], members[:, rows // 2 :])
    )
    shape = (steps, stages, rows // 2, len(models))
    return q.reshape(shape).swapaxes(2, 3), v.reshape(shape).swapaxes(2, 3)


def _transfers(
    model: PhysicalModel, of: Stages, begin: int, q: np.ndarray, v: np.ndarray
) -> np.ndarray:
    """Matrices by which every step of Runge and Kutta multiplies (delta, delta').

    Shape (steps, members, LAWS, stages, 2, 2); planets of a stage at their mean.
    """
    together = q.copy()
    for ring, planets in zip(of.ring, of.planets, strict=True):
        places = slice(ring, ring + planets)
        together[..., places] = q[..., places].mean(axis=-1, keepdims=True)
    h, parts = model.scenario.step_s, np.array([0.0, 0.5, 0.5, 1.0])
    t = h * (begin + np.arange(len(q))[:, None] + parts)[:, :, None]
    stage_coefficients = [
        np.stack(coefficients(model.gears, mesh, t, together, v), -1) for mesh in of.mesh
    ]
    by_stage = np.stack(stage_coefficients, axis=3)
    # Stiffness and damping at the four stages of a step.
    by_law = by_stage.reshape(*by_stage.shape[:-1], LAWS, 2).swapaxes(3, 4)
    rates = np.zeros((*by_law.shape, 2))
    rates[..., 0, 1] = 1.0
    rates[..., 1, :] = -by_law / of.mass[:, None]
    return linear_step(np.moveaxis(rates, 1, 0), np.eye(2), h)
