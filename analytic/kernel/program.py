"""The text of whole kernels, and where they find a member's numbers.

Three kinds: classical Runge-Kutta steps of a block of members with records on the way, the
quantities of single states, and (crosscheck.analytic.kernel.adaptive_kernel) runs at a tolerance.
See crosscheck.analytic.kernel.translate for the language.
"""

from __future__ import annotations

import ctypes
import re
import threading
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import chain
from textwrap import indent
from typing import TYPE_CHECKING, Any

from crosscheck.analytic.kernel.structure import Structure
from crosscheck.analytic.kernel.text.terms import TermStructure, name_results
from crosscheck.models.experiment.drive import TABLE

if TYPE_CHECKING:
    from crosscheck.analytic.kernel.machine import Code

# Blocks of rows before the numbers: state, stage, the step's sums and acceleration.
STATE = ("q", "v", "stage_q", "stage_v", "sum_q", "sum_v", "a")
POINTER, WHOLE, NUMBER = ctypes.c_void_p, ctypes.c_int64, ctypes.c_double
# Levels of optimisation, which change no bit: of states and brief runs, asked for some hundred
# times, the less takes a fifth of the time to compile.
RUNS, STATES = 2, 0
COMPILE_LOCK = threading.Lock()  # Python 3.11's parser fails when several threads use it at a time
Constants = dict[str, int | float]
# For each coordinate of a layout, the kernel's own, or the two whose difference it is.
RecordMap = tuple[tuple[int, ...], ...]
STAGE_ARGUMENTS = (POINTER, NUMBER, NUMBER, POINTER, NUMBER, NUMBER)

LOOK_UP = '''
def look_up(t, times: array, torques: array, rows: int, joints: int, table: array):
    """Torques at time t [s] of a table by straight lines, its ends held, into table (joints,)."""
    low = 0
    high = rows - 1
    while high - low > 1:
        middle = (low + high) // 2
        if times[middle] <= t:
            low = middle
        else:
            high = middle
    for j in range(joints):
        row = j * rows
        if t <= times[0]:
            table[j] = torques[row]
        elif t >= times[rows - 1]:
            table[j] = torques[row + rows - 1]
        else:
            slope = (torques[row + high] - torques[row + low]) / (times[high] - times[low])
            table[j] = fma(slope, t - times[low], torques[row + low])
'''

_RECORD = '''
def record(w: array, out: array, width: int):
    """Keep state, accelerations and forces in the layout's coordinates, ``width`` apart."""
    for lane in range(LANES):
{lines}
'''

_STEPS = '''
def accelerate(w: rows, t, root_t, table: array):
    """Accelerations and mesh forces of the stage's state at time t [s], left in their rows."""
{accelerate}


def first_stage(w: rows, h, part):
    """What a step's first stage leaves: sums, and the state of the next one."""
{first}


def middle_stage(w: rows, h, part):
    """The second, and with part = 1 the third: the next one is a part of h [s] further."""
{middle}


def last_stage(w: rows, h, part):
    """The fourth, and the step's end."""
{last}

{record}

def advance(
    w: array,
    blocks: int,
    first: int,
    records: int,
    stride: int,
    h,
    times: array,
    torques: array,
    rows_of_table: int,
    table: array,
    out: array,
):
    """From step ``first`` on: a record into ``out``, then each ``stride`` steps after the last.

    After the last record as many steps follow, so that the next call goes on; stride 0: none.
    Blocks are independent, so a processor works on several at a time.
    """
    step = first
    for place in range(records):
        for k in range(max(stride, 1)):
            t = step * h
            {at_t}
            for block in range(blocks):
                accelerate(at(w, block * BLOCK), t, sqrt(t), table)
            if k == 0:
                for block in range(blocks):
                    place_of = (place * RECORD * blocks + block) * LANES
                    record(at(w, block * BLOCK), at(out, place_of), blocks * LANES)
            if stride == 0:
                return
            for block in range(blocks):
                first_stage(at(w, block * BLOCK), h, 0.5)
            t = step * h + h / 2.0
            {at_t}
            for block in range(blocks):
                accelerate(at(w, block * BLOCK), t, sqrt(t), table)
                middle_stage(at(w, block * BLOCK), h, 0.5)
            for block in range(blocks):
                accelerate(at(w, block * BLOCK), t, sqrt(t), table)
                middle_stage(at(w, block * BLOCK), h, 1.0)
            t = step * h + h
            {at_t}
            for block in range(blocks):
                accelerate(at(w, block * BLOCK), t, sqrt(t), table)
                last_stage(at(w, block * BLOCK), h, 1.0)
            step += 1
'''

_STATES = '''
def evaluate(w: rows, t, root_t, table: array, h, part):
    """M, bias, force, acceleration and mesh forces of the state at time t [s]."""
{body}
'''


@dataclass(frozen=True)
class Program:
    """A kernel's text and its rows.

    First stand ``leading_rows`` rows of state and results, then a row for every number, then blocks
    of rows for tables, each with the rows that it has.
    """

    text: str
    lanes: int
    level: int
    leading_rows: int
    numbers: tuple[str, ...]
    tables: tuple[tuple[str, int], ...]
    functions: tuple[tuple[str, tuple[Any, ...]], ...]

    @property
    def rows(self) -> int:
        """Number of all rows."""
        return self.leading_rows + len(self.numbers) + sum(count for _, count in self.tables)


@lru_cache(maxsize=64)
def compile_program(program: Program) -> Code:
    """The program's machine code."""
    from crosscheck.analytic.kernel.machine import (  # LLVM, for those who run something
        Code,
        load_machine_code,
    )

    with COMPILE_LOCK:
        data = load_machine_code(program.text, program.lanes, program.level)
    return Code(data, dict(program.functions))


@lru_cache(maxsize=64)
def build_steps_program(
    structure: Structure, record_map: RecordMap, lanes: int, level: int = RUNS
) -> Program:
    """The kernel of a structure's Runge-Kutta steps for so many lanes, at a level of optimisation.

    Rows: those of STATE, the mesh forces, the numbers. Records (3 n + meshes, members): coordinates
    of the layout, their rates and accelerations, and the mesh forces.
    """
    n, meshes = len(structure.coordinates), len(structure.meshes)
    leading_rows = len(STATE) * n + meshes
    rows = Rows(structure, list(structure.acceleration()), leading_rows)
    constants: Constants = {
        "LANES": lanes,
        "BLOCK": rows.count * lanes,
        "RECORD": 3 * n + meshes,
        "JOINTS": len(structure.driven_joints),
    }
    state, forces = _state_rows(structure), range(len(STATE) * n, leading_rows)
    loads = [f"{block}_{x} = {state[x]['stage_' + block]}" for block in "qv" for x in state]
    stores = [f"{row['a']} = a_{x}" for x, row in state.items()]
    stores += [f"w[{k}] = each_{m}" for k, m in zip(forces, structure.meshes, strict=True)]
    accelerate = rows.function(loads, stores)
    stages = {name: _stage(state, left) for name, left in _STAGES.items()}
    begin = [STATE.index(name) * n for name in ("q", "v", "a")]
    record = record_text(record_map, begin, forces)
    parts = {"at_t": lookup_line("t", structure), "record": record, **stages}
    text = LOOK_UP + _STEPS.format(accelerate=accelerate, **parts)
    pointers = (POINTER, POINTER, WHOLE, POINTER, POINTER)
    functions = (("advance", (POINTER, WHOLE, WHOLE, WHOLE, WHOLE, NUMBER, *pointers)),)
    return rows.program(text, constants, lanes, level, functions)


def record_text(record_map: RecordMap, begin: Sequence[int], forces: Iterable[int]) -> str:
    """The function that keeps a record; rows ``begin``: of coordinates, rates and accelerations."""
    force_values = [f"w[{row} * LANES + lane]" for row in forces]
    of_coordinates = [
        " - ".join(f"w[{first + place} * LANES + lane]" for place in places)
        for first in begin
        for places in record_map
    ]
    lines = [
        f"out[{row} * width + lane] = {value}"
        for row, value in enumerate([*of_coordinates, *force_values])
    ]
    return _RECORD.format(lines=indent("\n".join(lines), " " * 8))


@lru_cache(maxsize=64)
def build_states_program(structure: TermStructure) -> Program:
    """The kernel of the quantities of single states.

    Rows: q, v, M row by row, bias, force, accelerations, mesh forces, the numbers.
    """
    names, n, meshes = structure.coordinates, len(structure.coordinates), structure.meshes
    leading_rows = 5 * n + n * n + len(meshes)
    rows = Rows(structure, list(structure.acceleration()), leading_rows)
    loads = [
        f"{kind}_{x} = w[{k * n + i}]" for k, kind in enumerate("qv") for i, x in enumerate(names)
    ]
    results = [*chain(*name_results(structure).values()), *(f"each_{mesh}" for mesh in meshes)]
    stores = [f"w[{2 * n + place}] = {value}" for place, value in enumerate(results)]
    text = _STATES.format(body=rows.function(loads, stores))
    return rows.program(text, {}, 1, STATES, (("evaluate", STAGE_ARGUMENTS),))


class Rows:
    """Equations as the body of row functions; so many rows stand before their numbers.

    inputs: names that the functions' own loads set; without them, the torques of a table.
    """

    def __init__(
        self,
        structure: Structure,
        lines: list[str],
        leading_rows: int,
        inputs: Sequence[str] | None = None,
    ) -> None:
        self.leading_rows, self.lines = leading_rows, lines
        tabled = tuple(f"table{j}" for j in structure.driven_joints)
        self.joint_torques = tabled if inputs is None else ()
        free = find_free_names(lines, structure, self.joint_torques if inputs is None else inputs)
        self.numbers = tuple(name for name in free if not name.startswith("rows_"))
        pieces = {
            mesh_name: stage.pieces
            for j, stage in structure.geared_joints
            for n in range(1, stage.planets + 1)
            for mesh_name in (stage.numbers_name(side, j, n) for side in ("sp", "pr"))
        }
        named = (name for name in free if name.startswith("rows_"))
        self.tables = tuple((name, pieces[_mesh_of_rows(name)]) for name in named)

    @property
    def count(self) -> int:
        """Number of all rows."""
        return self.leading_rows + len(self.numbers) + sum(count for _, count in self.tables)

    def function(self, loads: Sequence[str], stores: Sequence[str]) -> str:
        """The indented body of a function: loads, equations, stores."""
        tables = [f"{name} = table[{j}]" for j, name in enumerate(self.joint_torques)]
        first = enumerate(self.numbers, self.leading_rows)
        loads = [*tables, *loads, *(f"{name} = w[{row}]" for row, name in first)]
        return indent("\n".join([*loads, *self.lines, *stores]), "    ")

    def program(
        self,
        text: str,
        constants: Constants,
        lanes: int,
        level: int,
        functions: tuple[tuple[str, tuple[Any, ...]], ...],
    ) -> Program:
        """The program of a text, with these constants and those that give the begins of tables."""
        row = self.leading_rows + len(self.numbers)
        for name, count in self.tables:
            constants = constants | {name: row}
            row += count
        head = "".join(f"{name} = {value!r}\n" for name, value in constants.items())
        parts = self.leading_rows, self.numbers, self.tables, functions
        return Program(head + text, lanes, level, *parts)


def _mesh_of_rows(name: str) -> str:
    """The mesh of ``rows_{mesh}_{what}``."""
    return name.removeprefix("rows_").rpartition("_")[0]


def lookup_line(time: str, structure: Structure) -> str:
    """The line that looks up a table's torques, if there is one; else one that does nothing."""
    if structure.drive != TABLE:
        return '""'
    return f"look_up({time}, times, torques, rows_of_table, JOINTS, table)"


def find_free_names(
    lines: Iterable[str], structure: Structure, defined_names: Iterable[str]
) -> tuple[str, ...]:
    """The names that lines use and do not set, in the order of their use: the numbers."""
    state_names = {f"{block}_{name}" for block in ("q", "v") for name in structure.coordinates}
    words = {"t", "root_t", "w", "abs", "rint", "pick", "power_of_two", "if", "else"}
    set_before = state_names | words | set(defined_names)
    names: dict[str, None] = {}
    for line in lines:
        target, _, value = line.partition("=")
        value = value.removeprefix("=")
        for name in re.findall(r"(?<![\w.])[A-Za-z]\w*", value):
            if name not in set_before:
                names[name] = None
        set_before.add(target.rstrip(" -"))
    return tuple(names)


# Sums of a stage for every coordinate x, in the rows of STATE: its own state is q_x and v_x.
_FIRST = {
    "sum_q": "v_{x}",
    "sum_v": "a_{x}",
    "stage_q": "q_{x} + h / 2.0 * v_{x}",
    "stage_v": "v_{x} + h / 2.0 * a_{x}",
}
_MIDDLE = {
    "sum_q": "{sum_q} + 2.0 * v_{x}",
    "sum_v": "{sum_v} + 2.0 * a_{x}",
    "stage_q": "{q} + part * h * v_{x}",
    "stage_v": "{v} + part * h * a_{x}",
}
_LAST = {
    "q": "{q} + h / 6.0 * ({sum_q} + v_{x})",
    "v": "{v} + h / 6.0 * ({sum_v} + a_{x})",
    "stage_q": "{q}",
    "stage_v": "{v}",
}
_STAGES = {"first": _FIRST, "middle": _MIDDLE, "last": _LAST}


def _state_rows(structure: Structure) -> dict[str, dict[str, str]]:
    """The rows of STATE that each coordinate has."""
    n = len(structure.coordinates)
    return {
        x: {name: f"w[{k * n + place}]" for k, name in enumerate(STATE)}
        for place, x in enumerate(structure.coordinates)
    }


def _stage(state: dict[str, dict[str, str]], left: dict[str, str]) -> str:
    """The body of a stage's function. state: rows by coordinate; left: see above."""
    loads = {"q": "stage_q", "v": "stage_v", "a": "a"}
    lines = []
    for x, row in state.items():
        lines += [f"{name}_{x} = {row[block]}" for name, block in loads.items()]
        lines += [f"{row[block]} = {value.format(x=x, **row)}" for block, value in left.items()]
    return indent("\n".join(lines), "    ")
