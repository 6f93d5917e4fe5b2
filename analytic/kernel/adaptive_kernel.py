"""Kernels that choose their steps: Dormand and Prince's method of order 8, in machine code.

The method (Hairer, Norsett and Wanner, II.10) sizes its steps by its own estimates of order 5 and
3. A step of any order that runs over an edge of the backlash errs by the square of its length. So
a *precise* run shortens every step that changes a contact until it ends there, to rounding, and
between contacts the motion is smooth. A *reference* run steps over contacts and lets its error
estimates shorten the steps; it also integrates the work of all forces.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from textwrap import indent
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crosscheck.analytic.kernel import program as programs
from crosscheck.analytic.kernel.batch import Records, contiguous_table, number_rows
from crosscheck.analytic.kernel.program import Constants, Program, RecordMap, Rows, compile_program
from crosscheck.analytic.kernel.structure import Structure

if TYPE_CHECKING:
    from crosscheck.analytic.kernel.batch import SteppedEquations, SteppedModel
    from crosscheck.analytic.kernel.equations import TermEquations

_TEMPLATE = '''
def evaluate(w: rows, t, root_t, table: array, h, part):
    """Accelerations, mesh forces and gaps x - e of the state at time t [s]."""
{body}


def contacts(w: array) -> int:
    """A number for the contacts: mesh by mesh, whether one flank touches, none, or the other."""
    pattern = 0
    for i in range(WATCHED):
        gap = w[GAPS + i]
        edge = w[EDGES + i]
        flank = 1
        if gap > edge:
            flank = 2
        if gap < -edge:
            flank = 0
        pattern = 3 * pattern + flank
    return pattern


def rated(
    w: array, t, times: array, torques: array, rows_of_table: int, table: array, rates: int
) -> int:
    """Keep the rates of the state from place ``rates`` on; return its contacts."""
    {at_t}
    evaluate(w, t, sqrt(t), table, 0.0, 0.0)
    for i in range(N):
        w[rates + i] = w[N + i]
        w[rates + N + i] = w[A + i]
{power}
    return contacts(w)


def attempt(
    w: array, t, h, pattern: int, times: array, torques: array, rows_of_table: int, table: array
) -> bool:
    """A step h [s] from where the last one ended; its end is the state.

    Returns whether a stage on the way has other contacts than ``pattern``.
    """
    touched = False
{steps}
    return touched


def error_of(w: array, h, rtol, atol: array) -> float:
    """Of a step, over what is tolerated (Hairer's combination of two estimates)."""
    fifth = 0.0
    third = 0.0
    for i in range(STATE):
        scale = fma(rtol, max(abs(w[BEGIN + i]), abs(w[i])), atol[i])
{errors}
        fifth += e5 / scale * (e5 / scale)
        third += e3 / scale * (e3 / scale)
    if fifth == 0.0:
        return 0.0
    return abs(h) * fifth / sqrt((fifth + 0.01 * third) * STATE)


def eighth_root(x) -> float:
    """Of x."""
    return sqrt(sqrt(sqrt(x)))


def margins(w: array, out: array):
    """How far beyond both edges of its play every watched mesh is [m]."""
    for i in range(WATCHED):
        out[2 * i] = w[GAPS + i] - w[EDGES + i]
        out[2 * i + 1] = w[GAPS + i] + w[EDGES + i]


def crossing(low: array, high: array) -> float:
    """Where, between 0 and 1, the first of what changes its sign would do so on a straight line."""
    first = 1.0
    for i in range(2 * WATCHED):
        if (low[i] > 0.0) != (high[i] > 0.0):
            first = min(first, low[i] / (low[i] - high[i]))
    return first


def halve(values: array):
    """All of them."""
    for i in range(2 * WATCHED):
        values[i] = 0.5 * values[i]


def located(
    w: array,
    t,
    h,
    pattern: int,
    near,
    times: array,
    torques: array,
    rows_of_table: int,
    table: array,
    low: array,
    high: array,
    counts: array,
) -> float:
    """The length of a step that ends just behind the first change of contact within h.

    By regula falsi (Illinois), a bisection every third time; the end is left in w, its rates
    after the stages'. low: the margins at the start; both margins are written on.
    """
    before = 0.0
    behind = h
    side = 0
    count = 0
    there = True
    margins(w, high)
    while behind - before > near:
        count += 1
        part = 0.5
        if count % 3 != 0:
            part = min(max(crossing(low, high), 1e-3), 1.0 - 1e-3)
        middle = fma(behind - before, part, before)
        attempt(w, t, middle, pattern, times, torques, rows_of_table, table)
        after = rated(w, t + middle, times, torques, rows_of_table, table, LAST)
        there = after != pattern
        if there:
            behind = middle
            margins(w, high)
            if side == -1:
                halve(low)
            side = -1
        else:
            before = middle
            margins(w, low)
            if side == 1:
                halve(high)
            side = 1
    counts[0] = counts[0] + count * STAGES
    if not there:
        attempt(w, t, behind, pattern, times, torques, rows_of_table, table)
        rated(w, t + behind, times, torques, rows_of_table, table, LAST)
    return behind


def begin(w: array):
    """The next step begins at the state."""
    for i in range(STATE):
        w[BEGIN + i] = w[i]

{record}

def follow(
    w: array,
    records: int,
    interval,
    rtol,
    atol: array,
    near,
    times: array,
    torques: array,
    rows_of_table: int,
    table: array,
    low: array,
    high: array,
    out: array,
    counts: array,
):
    """From the state in w at time 0 on, a record every ``interval`` [s] into out.

    near: how closely [s] a change of contact is found. Added to counts: evaluations of the right
    side, and changes of contact. Stops where no step is short enough, as from a state that is not
    finite; what is left of out is not written.
    """
    t = 0.0
    h = interval
    pattern = rated(w, t, times, torques, rows_of_table, table, RATES)
    begin(w)
    margins(w, low)
    record(w, out, 1)
    for place in range(1, records):
        until = place * interval
        while t < until:
            step = min(h, until - t)
            if t + step == t:
                return
            touched = attempt(w, t, step, pattern, times, torques, rows_of_table, table)
            error = error_of(w, step, rtol, atol)
            counts[0] = counts[0] + STAGES
            if not error <= 1.0:  # or no number, as of a step that leads too far
                h = step * max(0.2, 0.9 / eighth_root(error))
                continue
            after = rated(w, t + step, times, torques, rows_of_table, table, LAST)
            if after == pattern and touched and step > SHORTEST * near:
                h = step / 2.0  # a contact may have come and gone
                continue
            if after == pattern:
                h = step * min(5.0, 0.9 / eighth_root(max(error, 1e-10)))
            else:
                counts[1] = counts[1] + 1
                step = located(
                    w,
                    t,
                    step,
                    pattern,
                    near,
                    times,
                    torques,
                    rows_of_table,
                    table,
                    low,
                    high,
                    counts,
                )
                pattern = contacts(w)
            if step == until - t:
                t = until
            else:
                t = t + step
            for i in range(STATE):
                w[RATES + i] = w[LAST + i]
            begin(w)
            margins(w, low)
        record(w, at(out, place * RECORD), 1)
'''

_POWER = """
    power = 0.0
    turned_over = 0.0
    for i in range(N):
        power = fma(w[PUSHES + i], w[N + i], power)
        turned_over = fma(abs(w[PUSHES + i]), abs(w[N + i]), turned_over)
    w[rates + 2 * N] = power
    w[rates + 2 * N + 1] = turned_over
"""

# Halving stops at steps of this many times the error in locating an event.
SHORTEST = 1000.0
STAGES = 12
# Sizes below which an error does not matter at relative tolerance 1: displacements of the order of
# the play and their rates at the mesh modes, against angles of the order of a radian.
MESH_SIZE_M, MESH_RATE_M_PER_S = 1e-4, 1e-1
WORKS = 2  # integrals of a reference run: the work done, and the magnitude of its rate


@lru_cache(maxsize=32)
def build_adaptive_program(structure: Structure, record_map: RecordMap, works: int = 0) -> Program:
    """A kernel of steps of chosen length, which end where contacts change unless there are works.

    works: 0, or WORKS of a TermStructure, whose forces' work is integrated.

    Rows: the state (coordinates, rates, works), accelerations, mesh forces, gaps, edges of the
    backlash, where a step begins, rates of its stages and end, generalized forces where there are
    works, and the numbers.
    """
    n, m = len(structure.coordinates), len(structure.meshes)
    state = 2 * n + works
    forces = state + n
    begin = forces + 3 * m
    rates = begin + state
    pushes = rates + (STAGES + 1) * state
    rows = Rows(structure, list(structure.acceleration()), pushes + (n if works else 0))
    constants: Constants = {
        "N": n,
        "STATE": state,
        "STAGES": STAGES,
        "A": state,
        "FORCES": forces,
        "GAPS": forces + m,
        "EDGES": forces + 2 * m,
        "BEGIN": begin,
        "RATES": rates,
        "LAST": rates + STAGES * state,
        "PUSHES": pushes,
        "RECORD": 3 * n + m + works,
        "LANES": 1,
        "WATCHED": 0 if works or structure.tanh else m,
        "JOINTS": len(structure.driven_joints),
        "SHORTEST": SHORTEST,
    }
    loads, stores = _loads_and_stores(structure, state)
    if works:
        stores += [f"w[{pushes + k}] = f{k}" for k in range(n)]
    recorded = [*range(forces, forces + m), *range(2 * n, state)]
    text = programs.LOOK_UP + _TEMPLATE.format(
        at_t=programs.lookup_line("t", structure),
        body=rows.function(loads, stores),
        power=_POWER if works else "",
        steps=indent("\n".join(_steps()), "    "),
        errors=indent("\n".join(_errors()), "        "),
        record=programs.record_text(record_map, (0, n, state), recorded),
    )
    pointer, whole, number = programs.POINTER, programs.WHOLE, programs.NUMBER
    table = (pointer, pointer, whole, pointer)
    numbers = (pointer, whole, number, number, pointer, number)
    follow = ("follow", (*numbers, *table, *[pointer] * 4))
    return rows.program(text, constants, 1, programs.RUNS, (follow,))


def _loads_and_stores(structure: Structure, results: int) -> tuple[list[str], list[str]]:
    """Lines that load the state and store accelerations, forces and gaps from row results on."""
    names, meshes = structure.coordinates, structure.meshes
    n, m = len(names), len(meshes)
    loads = [
        f"{block}_{name} = w[{first + k}]"
        for k, name in enumerate(names)
        for block, first in (("q", 0), ("v", n))
    ]
    stores = [f"w[{results + k}] = a_{name}" for k, name in enumerate(names)]
    for k, mesh in enumerate(meshes, results + n):
        stores.append(f"w[{k}] = each_{mesh}")
        stores.append(f"w[{k + m}] = gap_{mesh}")
    return loads, stores


def _steps() -> list[str]:
    """Lines of every stage after the first, and the step's end, by SciPy's table of the method."""
    from scipy.integrate import DOP853  # a third of a second, for this kernel alone

    lines = []
    for stage in range(1, STAGES):
        lines += _sum(DOP853.A[stage, :stage])
        time = f"fma({float(DOP853.C[stage])!r}, h, t)"
        rest = f"times, torques, rows_of_table, table, RATES + {stage} * STATE"
        lines.append(f"passed = rated(w, {time}, {rest})")
        lines.append("touched = touched or passed != pattern")
    return lines + _sum(DOP853.B)


def _sum(weights: np.ndarray) -> list[str]:
    step = f"w[i] = fma(h, {_weighted_sum(weights)}, w[BEGIN + i])"
    return ["for i in range(STATE):", f"    {step}"]


def _errors() -> list[str]:
    from scipy.integrate import DOP853

    return [f"{name} = {_weighted_sum(e)}" for name, e in (("e5", DOP853.E5), ("e3", DOP853.E3))]


def _weighted_sum(weights: Sequence[float] | np.ndarray) -> str:
    """Text of the sum of the stages' rates with these weights."""
    text = ""
    for stage, weight in enumerate(weights):
        if weight:
            rate = f"w[RATES + {stage} * STATE + i]"
            text = (
                f"fma({float(weight)!r}, {rate}, {text})" if text else f"{float(weight)!r} * {rate}"
            )
    return text


NEAR_S = 1e-13  # error of a change of contact [s]; its effect on a step is far below rounding


class AdaptiveRun(NamedTuple):
    """A run of one member at a relative tolerance; rows are NaN from where it diverged.

    records: of the layout's coordinates; works (records, works) [J]: what all forces have done
    since the start, and turned over (the integral of the rate's magnitude), of a reference run;
    evaluations: of the right side; changes: of contact.
    """

    records: Records
    works: np.ndarray
    evaluations: int
    changes: int


def integrate_precisely(model: SteppedModel, rtol: float) -> AdaptiveRun:
    """A model's run whose steps end where contacts change."""
    return _integrate(model, model.equations, 0, rtol)


def integrate_reference(model: SteppedModel, equations: TermEquations, rtol: float) -> AdaptiveRun:
    """A model's run by the equations of its terms, steps over contacts, with the forces' work."""
    return _integrate(model, equations, WORKS, rtol)


def _integrate(
    model: SteppedModel, equations: SteppedEquations, works: int, rtol: float
) -> AdaptiveRun:
    scenario, structure = model.scenario, equations.structure
    program = build_adaptive_program(structure, equations.record_map(), works)
    n, m = len(structure.coordinates), len(structure.meshes)
    state = np.concatenate([*map(equations.to_kernel, model.start()), np.zeros(works)])
    edges = model.edges
    rest = np.zeros(program.leading_rows - len(state) - n - 3 * m)
    numbers = number_rows(program, equations.numbers)
    w = np.concatenate([state, np.zeros(n + 2 * m), edges, rest, *numbers])
    records = scenario.steps // scenario.stride + 1
    out = np.full((records, 3 * n + m + works), np.nan)
    is_angle = np.array([name.startswith("theta") for name in structure.coordinates])
    sizes = [np.where(is_angle, 1.0, size) for size in (MESH_SIZE_M, MESH_RATE_M_PER_S)]
    atol = rtol * np.concatenate([*sizes, np.ones(works)])
    times, torques = contiguous_table(model.drive)
    table, low, high, counts = (np.zeros(k) for k in (len(torques), 2 * m, 2 * m, 2))
    compile_program(program)["follow"](
        w.ctypes.data,
        records,
        scenario.step_s * scenario.stride,
        rtol,
        atol.ctypes.data,
        NEAR_S,
        times.ctypes.data,
        torques.ctypes.data,
        times.size,
        *(each.ctypes.data for each in (table, low, high, out, counts)),
    )
    *recorded, done = np.split(out, (n, 2 * n, 3 * n, 3 * n + m), axis=1)
    return AdaptiveRun(Records(*recorded), done, int(counts[0]), int(counts[1]))
