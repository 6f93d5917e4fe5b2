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
from numba import njit

from analytic import kernel
from analytic.gears import Gears
from analytic.mesh_force import in_contact
from analytic.model import PhysicalModel
from analytic.stage import equivalent_masses
from analytic.stiffness import stiffness
from analytic.terms import Terms
from models.arm import Planetary
from models.drive import DriveData
from models.interface import require_finite
from models.trajectory import recorded_times

LEAST = 1e-300  # of a difference that passes through 0, so that its logarithm is finite
LARGEST = 1e100  # beyond it a difference is divided by itself, and its logarithm kept


class Stages(NamedTuple):
    """Of every geared stage, (stages,): where its planets are, and what their differences are like.

    mesh: place of the first planet's sun mesh among the gears; ring: where the coordinates x_pr of
    its planets begin; planets: how many of them; mass: M_p [kg] of one planet; frequency [rad/s]:
    of the differences with both meshes in contact at mean stiffness; start: how far planets are
    apart at rest [m]; floor: below which rounding does not let the spread fall [m].
    """

    mesh: np.ndarray
    ring: np.ndarray
    planets: np.ndarray
    mass: np.ndarray
    frequency: np.ndarray
    start: np.ndarray
    floor: np.ndarray


class Differences(NamedTuple):
    """Natural logarithms [1, of metres], (times, stages).

    part: of |delta|; size: of the oscillation, the root of delta^2 + (delta' / w)^2 with w the
    stage's ``frequency``.
    """

    part: np.ndarray
    size: np.ndarray


class Followed(NamedTuple):
    """A model's own run at its records, and how planets part along it.

    time (times,) [s]; x_pr (times, coordinates) [m]: of every planet that has a coordinate, stage
    after stage; differences: one for every law of contact that was asked for.
    """

    time: np.ndarray
    x_pr: list[np.ndarray]
    differences: list[Differences]


def followed(
    model: PhysicalModel, start_m: np.ndarray, pressed: Sequence[bool] = (False,)
) -> Followed:
    """Along the model's own run, at its records: how far planets get that start so far apart.

    start_m: per stage. Planets lumped or free; free ones count as all at their mean, so that what
    the other stages' planets do is in it. Exact dead zone. pressed: for each law of contact whether
    no mesh ever parts. Raises Diverged.
    """
    scenario = model.scenario
    q, v = model.start()
    law = (model.terms, model.gears, model.drive)
    span = (scenario.step_s, scenario.steps, scenario.stride)
    stages = stages_of(model, start_m)
    qs, vs, part, size = _along(*law, stages, np.array(pressed), q, v, *span)
    time = recorded_times(scenario)
    require_finite(model.name, time, qs, vs)
    ends = stages.ring + stages.planets
    x_pr = [qs[:, first:end] for first, end in zip(stages.ring, ends, strict=True)]
    return Followed(time, x_pr, [Differences(*both) for both in zip(part, size, strict=True)])


def stages_of(model: PhysicalModel, start_m: np.ndarray) -> Stages:
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
        np.array([layout.at("x_pr", joint, first) for joint in layout.meshing]),
        np.array(counts),
        mass,
        np.sqrt((gears.k_m[mesh] + gears.k_m[mesh + 1]) / mass),
        np.asarray(start_m, dtype=float),
        rounding_floor(gears.b[mesh + 1], damping / (2 * mass), model.scenario.step_s),
    )


def rounding_floor(x_m: np.ndarray, decay_per_s: np.ndarray, step_s: float) -> np.ndarray:
    """How far rounding keeps planets apart [m] that are at x and whose differences decay so fast.

    Every step adds a last place's rounding, of variance ulp^2 / 12, and a step later exp(-decay
    step) of it is left.
    """
    return np.spacing(x_m) / np.sqrt(24 * decay_per_s * step_s)


@njit(cache=True, inline="always")
def coefficients(
    gears: Gears, mesh: int, pressed: bool, t: float, q: np.ndarray, v: np.ndarray
) -> tuple[float, float]:
    """Stiffness [N/m] and damping [N s/m] against a planet's difference.

    mesh: place of its sun mesh, which its ring mesh follows.
    """
    spring, damper = 0.0, 0.0
    for i in range(mesh, mesh + 2):
        phase = kernel.phase_of(gears, i, t, q, v)
        sine = np.sin(phase)
        touching = pressed or in_contact(kernel.gap_of(gears, i, phase, sine, q), gears.b[i])
        if touching:
            spring += stiffness(gears.law, i, phase, sine, gears.k_m[i], gears.k_a[i])
        if touching or gears.damps_apart:
            damper += gears.d[i] / gears.planets[i]
    return spring, damper


@njit(cache=True, inline="always")
def _place(of: Stages, j: int, part: float, q0: np.ndarray, v: np.ndarray, q: np.ndarray) -> None:
    """q0 + part v into q (n,), the planets of stage j at their mean."""
    for i in range(q.size):
        q[i] = q0[i] + part * v[i]
    total = 0.0
    for i in range(of.ring[j], of.ring[j] + of.planets[j]):
        total += q[i]
    q[of.ring[j] : of.ring[j] + of.planets[j]] = total / of.planets[j]


@njit(cache=True, inline="always")
def _step(
    gears: Gears,
    of: Stages,
    j: int,
    pressed: bool,
    t: float,
    h: float,
    q0: np.ndarray,
    s: kernel.Stages,
    x: np.ndarray,
) -> None:
    """RK4 of (delta, delta') = x in place, at the states that the shared motion's step went by.

    s.q (n,) is written on.
    """
    slid, sped, rate, bend = 0.0, 0.0, 0.0, 0.0
    for k in range(4):
        part = 0.0 if k == 0 else h if k == 3 else h / 2
        _place(of, j, part, q0, s.v[max(k - 1, 0)], s.q)
        spring, damper = coefficients(gears, of.mesh[j], pressed, t + part, s.q, s.v[k])
        at = x[0] + part * rate
        rate = x[1] + part * bend
        bend = -(spring * at + damper * rate) / of.mass[j]
        weight = 1.0 if k == 0 or k == 3 else 2.0
        slid += weight * rate
        sped += weight * bend
    x[0] += h / 6 * slid
    x[1] += h / 6 * sped


@njit(cache=True)
def _rescaled(of: Stages, j: int, x: np.ndarray, scale: np.ndarray) -> float:
    """Size of the difference x (2,) of stage j; beyond bounds it is divided by itself.

    scale (stages,): logarithms of what differences have been divided by.
    """
    whole = np.hypot(x[0], x[1] / of.frequency[j])
    least = of.floor[j] * np.exp(-scale[j])
    if least <= whole <= LARGEST:
        return whole
    x /= whole
    scale[j] += np.log(max(whole, least))
    return 1.0


@njit(cache=True)
def _along(
    terms: Terms,
    gears: Gears,
    drive: DriveData,
    of: Stages,
    pressed: np.ndarray,
    q0: np.ndarray,
    v0: np.ndarray,
    step: float,
    steps: int,
    stride: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """States q, v (records, n); logarithms (laws of contact, records, stages), part and size.

    nan once the shared motion has ceased to be finite.
    """
    records, laws, count = steps // stride + 1, pressed.size, of.mass.size
    qs, vs = np.full((records, q0.size), np.nan), np.full((records, q0.size), np.nan)
    part = np.full((laws, records, count), np.nan)
    size = part.copy()
    q, v, before, x = q0.copy(), v0.copy(), q0.copy(), np.zeros((laws, count, 2))
    scale = np.empty((laws, count))
    room, between = kernel.scratch(terms), kernel.stages(q.size)
    qs[0], vs[0] = q, v
    x[:, :, 0] = 1.0
    scale[:] = np.log(of.start)
    part[:, 0], size[:, 0] = scale, scale
    for k in range(steps):
        before[:] = q
        kernel.runge_kutta_step(terms, gears, drive, k * step, step, q, v, room, between)
        if not np.isfinite(q.sum()):
            break
        record = (k + 1) // stride if (k + 1) % stride == 0 else 0
        if record:
            qs[record], vs[record] = q, v
        for law in range(laws):
            for j in range(count):
                own = x[law, j]
                _step(gears, of, j, pressed[law], k * step, step, before, between, own)
                whole = _rescaled(of, j, own, scale[law])
                if record:
                    part[law, record, j] = scale[law, j] + np.log(max(abs(own[0]), LEAST))
                    size[law, record, j] = scale[law, j] + np.log(whole)
    return qs, vs, part, size
