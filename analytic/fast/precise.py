"""A kernel that follows contact changes: an eighth-order method whose steps end where teeth meet.

A step of any order that runs over an edge of the play errs by the square of its length. Here every
step that changes a contact is shortened until it ends there, to rounding; between contacts the
motion is smooth, and Dormand and Prince's method of order 8 (Hairer, Norsett and Wanner, II.10)
chooses its steps by its own estimates of order 5 and 3.
"""

from __future__ import annotations

from functools import lru_cache
from textwrap import indent
from typing import NamedTuple

import numpy as np

from analytic.fast.batch import FastModel, Records, advances, displacements, numbers
from analytic.fast.compiled import module_of
from analytic.fast.program import TANH, Program, free_names, tabled
from analytic.fast.source import acceleration
from analytic.fast.structure import Structure
from analytic.reference import MESH_RATE_M_PER_S, MESH_SIZE_M
from models.drive import TABLE

_TEMPLATE = '''"""{about}"""

from math import sqrt

import numpy as np
from numba import carray, njit

from analytic.fast.memory import pointer
{tanh}
from models.drive import table_torques

N, STATE, STAGES = {n}, {state}, {stages}
A, FORCES, GAPS, EDGES, BEGIN, RATES, ROWS = {places}  # where they begin; all
LAST = RATES + STAGES * STATE
SHORTEST = {shortest}
WATCHED = {watched}  # meshes whose contacts end steps
JOINTS = {joints}


@njit(nogil=True, cache=True, fastmath={{"contract"}}, error_model="numpy")
def evaluate(address, t, root_t, table):
    """Accelerations, mesh forces and gaps x - e of the state at time t [s]."""
    w = carray(pointer(address), ROWS)
{tables}
{body}


@njit(nogil=True, cache=True)
def contacts(w):
    """A number for the contacts: mesh by mesh, whether one flank touches, none, or the other."""
    pattern = 0
    for i in range(WATCHED):
        gap, edge = w[GAPS + i], w[EDGES + i]
        pattern = 3 * pattern + (2 if gap > edge else 0 if gap < -edge else 1)
    return pattern


@njit(nogil=True, cache=True)
def rated(address, t, table_time, table_torque, table, rates):
    """Keep the rates of the state from place ``rates`` on; return its contacts."""
    w = carray(pointer(address), ROWS)
    {at_t}
    evaluate(address, t, sqrt(t), table)
    for i in range(N):
        w[rates + i] = w[N + i]
        w[rates + N + i] = w[A + i]
    return contacts(w)


@njit(nogil=True, cache=True, fastmath={{"contract"}}, error_model="numpy")
def attempt(address, t, h, pattern, table_time, table_torque, table):
    """A step h [s] from where the last one ended; its end is the state.

    Returns whether a stage on the way has other contacts than ``pattern``.
    """
    w, touched = carray(pointer(address), ROWS), False
{steps}
    return touched


@njit(nogil=True, cache=True, fastmath={{"contract"}}, error_model="numpy")
def error_of(address, h, rtol, atol):
    """Of a step, over what is tolerated (Hairer's combination of two estimates)."""
    w, fifth, third = carray(pointer(address), ROWS), 0.0, 0.0
    for i in range(STATE):
        scale = atol[i] + rtol * max(abs(w[BEGIN + i]), abs(w[i]))
{errors}
        fifth += (e5 / scale) ** 2
        third += (e3 / scale) ** 2
    if fifth == 0.0:
        return 0.0
    return abs(h) * fifth / sqrt((fifth + 0.01 * third) * STATE)


@njit(nogil=True, cache=True)
def margins(w, out):
    """How far beyond both edges of its play every watched mesh is [m]."""
    for i in range(WATCHED):
        out[2 * i] = w[GAPS + i] - w[EDGES + i]
        out[2 * i + 1] = w[GAPS + i] + w[EDGES + i]


@njit(nogil=True, cache=True)
def crossing(low, high):
    """Where, between 0 and 1, the first of what changes its sign would do so on a straight line."""
    first = 1.0
    for i in range(low.size):
        if (low[i] > 0.0) != (high[i] > 0.0):
            first = min(first, low[i] / (low[i] - high[i]))
    return first


@njit(nogil=True, cache=True)
def located(w, t, h, pattern, near, table_time, table_torque, table, low, high, counts):
    """The length of a step that ends just behind the first change of contact within h.

    By regula falsi (Illinois), a bisection every third time; the end is left in w, its rates
    after the stages'. low: the margins at the start; both margins are written on.
    """
    address = w.ctypes.data
    before, behind, side, count, there = 0.0, h, 0, 0, True
    margins(w, high)
    while behind - before > near:
        count += 1
        part = 0.5 if count % 3 == 0 else min(max(crossing(low, high), 1e-3), 1 - 1e-3)
        middle = before + (behind - before) * part
        attempt(address, t, middle, pattern, table_time, table_torque, table)
        there = rated(address, t + middle, table_time, table_torque, table, LAST) != pattern
        if there:
            behind = middle
            margins(w, high)
            if side == -1:
                low *= 0.5
        else:
            before = middle
            margins(w, low)
            if side == 1:
                high *= 0.5
        side = -1 if there else 1
    counts[0] += count * STAGES
    if not there:
        attempt(address, t, behind, pattern, table_time, table_torque, table)
        rated(address, t + behind, table_time, table_torque, table, LAST)
    return behind


@njit(nogil=True, cache=True)
def begin(w):
    """The next step begins at the state."""
    for i in range(STATE):
        w[BEGIN + i] = w[i]


@njit(nogil=True, cache=True)
def keep(w, out):
    """A record: state, accelerations and forces."""
    for i in range(out.size):
        out[i] = w[i]


@njit(nogil=True, cache=True)
def follow(w, interval, rtol, atol, near, table_time, table_torque, out, counts):
    """From the state in w at time 0 on, a record every ``interval`` [s] into out.

    near: how closely [s] a change of contact is found. Added to counts: evaluations of the right
    side, and changes of contact. Stops where the state is not finite or no step is short enough;
    what is left of out is not written.
    """
    address, table = w.ctypes.data, np.zeros(JOINTS)
    low, high = np.empty(2 * WATCHED), np.empty(2 * WATCHED)
    t, h = 0.0, interval
    pattern = rated(address, t, table_time, table_torque, table, RATES)
    begin(w)
    margins(w, low)
    keep(w, out[0])
    for place in range(1, out.shape[0]):
        until = place * interval
        while t < until:
            step = min(h, until - t)
            if t + step == t:
                return
            touched = attempt(address, t, step, pattern, table_time, table_torque, table)
            error = error_of(address, step, rtol, atol)
            counts[0] += STAGES
            if not error < np.inf:
                return
            if error > 1.0:
                h = step * max(0.2, 0.9 * error**-0.125)
                continue
            after = rated(address, t + step, table_time, table_torque, table, LAST)
            if after == pattern and touched and step > SHORTEST * near:
                h = step / 2  # a contact may have come and gone
                continue
            if after == pattern:
                h = step * min(5.0, 0.9 * max(error, 1e-10) ** -0.125)
            else:
                counts[1] += 1
                step = located(
                    w, t, step, pattern, near, table_time, table_torque, table, low, high, counts
                )
                pattern = contacts(w)
            t = until if step == until - t else t + step
            for i in range(STATE):
                w[RATES + i] = w[LAST + i]
            begin(w)
            margins(w, low)
        keep(w, out[place])
'''

SHORTEST = 1000.0  # of a located change: a step that is not halved again
STAGES = 12


@lru_cache(maxsize=16)
def precise_program(structure: Structure) -> Program:
    """The kernel of a structure that follows contacts, and its rows.

    They are the state, accelerations, forces, gaps, edges of the play and numbers.
    """
    lines = list(acceleration(structure, alone=True))
    joints, n, m = len(structure.stages), len(structure.coordinates), len(structure.meshes)
    tables = tuple(f"table{j}" for j in structure.joints)
    names = free_names(lines, structure, tables)
    begin = 3 * n + 3 * m + len(names)
    rates = begin + 2 * n
    places = 2 * n, 3 * n, 3 * n + m, 3 * n + 2 * m, begin, rates, rates + (STAGES + 1) * 2 * n
    by_table = structure.drive == TABLE
    text = _TEMPLATE.format(
        about=f"Equations of motion of {joints} joints between contacts; written by a program.",
        tanh=TANH[False],
        n=n,
        state=2 * n,
        stages=STAGES,
        places=", ".join(map(str, places)),
        watched=0 if structure.tanh else m,
        joints=joints,
        shortest=SHORTEST,
        tables=indent("\n".join(f"{name} = table[{j}]" for j, name in enumerate(tables)), "    "),
        at_t=tabled("t", by_table),
        body=indent("\n".join(_body(structure, names, lines)), "    "),
        steps=indent("\n".join(_steps()), "    "),
        errors=indent("\n".join(_errors()), "        "),
    )
    return Program(text, 1, structure.coordinates, structure.meshes, names)


def _body(structure: Structure, names: tuple[str, ...], lines: list[str]) -> list[str]:
    """Loads, equations and stores."""
    n, meshes = len(structure.coordinates), structure.meshes
    first = 3 * n + 3 * len(meshes)
    rows = enumerate(structure.coordinates)
    loads = [
        f"{block}_{name} = w[{at + k}]" for k, name in rows for block, at in (("q", 0), ("v", n))
    ]
    loads += [f"{name} = w[{first + k}]" for k, name in enumerate(names)]
    stores = [f"w[{2 * n + k}] = a_{name}" for k, name in enumerate(structure.coordinates)]
    for k, mesh in enumerate(meshes):
        stores.append(f"w[{3 * n + k}] = each_{mesh}")
        stores.append(f"w[{3 * n + len(meshes) + k}] = gap_{mesh}")
    return [*loads, *lines, *stores]


def _steps() -> list[str]:
    """Every stage after the first, and the step's end, by SciPy's table of the method."""
    from scipy.integrate import DOP853  # a third of a second, for this kernel alone

    found = []
    for stage in range(1, STAGES):
        found += _sum(DOP853.A[stage, :stage])
        time = f"t + {float(DOP853.C[stage])!r} * h"
        rest = f"table_time, table_torque, table, RATES + {stage} * STATE"
        found.append(f"touched |= rated(address, {time}, {rest}) != pattern")
    return found + _sum(DOP853.B)


def _sum(weights: np.ndarray) -> list[str]:
    return ["for i in range(STATE):", f"    w[i] = w[BEGIN + i] + h * ({_weighed(weights)})"]


def _errors() -> list[str]:
    from scipy.integrate import DOP853

    return [f"{name} = {_weighed(e)}" for name, e in (("e5", DOP853.E5), ("e3", DOP853.E3))]


def _weighed(weights: np.ndarray) -> str:
    """The sum of the stages' rates with these weights."""
    terms = (f"{float(a)!r} * w[RATES + {s} * STATE + i]" for s, a in enumerate(weights) if a)
    return " + ".join(terms)


NEAR_S = 1e-13  # of a change of contact: what it leaves of a step's error is far below rounding


class Followed(NamedTuple):
    """A run's records, of one member; how many evaluations it took, how many contacts changed."""

    records: Records
    evaluations: int
    changes: int


def followed(model: FastModel, rtol: float) -> Followed:
    """A model's run at a relative tolerance; NaN from where it diverged."""
    assert model.structure is not None  # the caller asks it
    program, scenario, drive = precise_program(model.structure), model.scenario, model.drive
    n, m = len(program.coordinates), len(program.meshes)
    own = numbers(model)
    state = [advances(model.layout, x) for x in model.start()]
    edges = model.gears.b
    rates = np.zeros((STAGES + 2) * 2 * n)
    values = [own[name] for name in program.numbers]
    w = np.concatenate([*state, np.zeros(n + 2 * m), edges, values, rates])
    out = np.full((scenario.steps // scenario.stride + 1, 3 * n + m), np.nan)
    counts = np.zeros(2, dtype=np.int64)
    is_angle = np.array([name.startswith("theta") for name in program.coordinates])
    of_meshes = MESH_SIZE_M, MESH_RATE_M_PER_S
    sizes = np.concatenate([np.where(is_angle, 1.0, size) for size in of_meshes])
    interval, table = scenario.step_s * scenario.stride, (drive.table_time, drive.table_torque)
    module = module_of(program)
    module.follow(w, interval, rtol, rtol * sizes, NEAR_S, *table, out, counts)
    q, v, a = (
        displacements(model.layout, out[:, k * n : (k + 1) * n, None])[:, :, 0] for k in range(3)
    )
    return Followed(Records(q, v, a, out[:, 3 * n :]), int(counts[0]), int(counts[1]))
