"""A whole kernel as the text of a module, and where it finds a member's numbers.

A module has ``advance``: classical Runge-Kutta steps of all lanes, with records on the way.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from textwrap import indent

from analytic.fast.source import acceleration
from analytic.fast.structure import Structure
from models.drive import TABLE

# Blocks of rows before the numbers: state, stage, the step's sums and acceleration.
STATE = ("q", "v", "stage_q", "stage_v", "sum_q", "sum_v", "a")

_TEMPLATE = '''"""{about}"""

from math import sqrt

import numpy as np
from numba import carray, njit

from analytic.fast.memory import pointer
{tanh}
from models.drive import table_torques

LANES = {lanes}
SIZE = {size}  # of the coordinates of a block
BLOCK = {block}  # numbers of a block: all rows of its lanes
BYTES = 8 * BLOCK
Q, V, STAGE_Q, STAGE_V, SUM_Q, SUM_V, A = {blocks}
FORCES, FORCED = {forces}, {forced}  # where they begin, and how many
JOINTS = {joints}


@njit(nogil=True, cache=True, fastmath={{"contract"}}, error_model="numpy")
def stage(address, t, root_t, table, weight, part):
    """Evaluate a stage of a block at time t [s], count it, and go on to the next stage."""
    w = carray(pointer(address), BLOCK)
{tables}
{body}


@njit(nogil=True, cache=True, fastmath={{"contract"}}, error_model="numpy")
def end(address, h):
    """The step's end, from its sums; the next step's first stage is there."""
    w = carray(pointer(address), BLOCK)
    for i in range(SIZE):
        q = w[Q + i] + h / 6 * w[SUM_Q + i]
        v = w[V + i] + h / 6 * w[SUM_V + i]
        w[Q + i] = q
        w[V + i] = v
        w[STAGE_Q + i] = q
        w[STAGE_V + i] = v
        w[SUM_Q + i] = 0.0
        w[SUM_V + i] = 0.0


@njit(nogil=True, cache=True)
def record(address, out):
    """Keep the state at a step's start, and accelerations and forces of its first stage."""
    w = carray(pointer(address), BLOCK)
    for i in range(2 * SIZE):
        out[i] = w[Q + i]
    for i in range(SIZE):
        out[2 * SIZE + i] = w[A + i]
    for i in range(FORCED):
        out[3 * SIZE + i] = w[FORCES + i]


@njit(nogil=True, cache=True)
def stages(address, blocks, t, table, weight, part):
    """A stage of all blocks; they are independent, so a processor works on several at a time."""
    for block in range(blocks):
        stage(address + block * BYTES, t, sqrt(t), table, weight, part)


@njit(nogil=True, cache=True)
def advance(w, first, stride, h, table_time, table_torque, out):
    """From step ``first`` on: each row of ``out`` is a record, ``stride`` steps after the last.

    After the last record as many steps follow, so that the next call goes on; stride 0: none.
    """
    step, table = first, np.zeros(JOINTS)
    address, blocks = w.ctypes.data, w.shape[0]
    for place in range(out.shape[0]):
        for k in range(max(stride, 1)):
            t = step * h
            {at_t}
            stages(address, blocks, t, table, 1.0, h / 2)
            if k == 0:
                for block in range(out.shape[1]):
                    record(address + block * BYTES, out[place, block])
            if stride == 0:
                return
            {at_half}
            stages(address, blocks, t + h / 2, table, 2.0, h / 2)
            stages(address, blocks, t + h / 2, table, 2.0, h)
            {at_end}
            stages(address, blocks, t + h, table, 1.0, h)
            for block in range(blocks):
                end(address + block * BYTES, h)
            step += 1
'''
TANH = {False: "from math import tanh", True: "from analytic.fast.hyperbolic import tanh"}


@dataclass(frozen=True)
class Program:
    """A kernel's text and its rows: those of a block of STATE, of the forces, of each number."""

    text: str
    lanes: int
    coordinates: tuple[str, ...]
    meshes: tuple[str, ...]
    numbers: tuple[str, ...]

    @property
    def forces_at(self) -> int:
        """First row of the mesh forces."""
        return len(STATE) * len(self.coordinates)

    @property
    def numbers_at(self) -> int:
        """First row of the numbers."""
        return self.forces_at + len(self.meshes)

    @property
    def rows(self) -> int:
        """Of the whole array."""
        return self.numbers_at + len(self.numbers)


@lru_cache(maxsize=64)
def program_of(structure: Structure, lanes: int) -> Program:
    """The kernel of a structure for so many lanes."""
    lines = list(acceleration(structure, lanes == 1))
    joints = len(structure.stages)
    tables = tuple(f"table{j}" for j in structure.joints)
    numbers = free_names(lines, structure, tables)
    program = Program("", lanes, structure.coordinates, structure.meshes, numbers)
    size = lanes * len(structure.coordinates)
    by_table = structure.drive == TABLE
    text = _TEMPLATE.format(
        tanh=TANH[lanes > 1],
        at_t=tabled("t", by_table),
        at_half=tabled("t + h / 2", by_table),
        at_end=tabled("t + h", by_table),
        about=f"Equations of motion of {joints} joints, {lanes} lanes; written by a program.",
        lanes=lanes,
        size=size,
        block=program.rows * lanes,
        blocks=", ".join(str(place * size) for place in range(len(STATE))),
        forces=program.forces_at * lanes,
        forced=len(structure.meshes) * lanes,
        joints=joints,
        tables=indent("\n".join(f"{name} = table[{j}]" for j, name in enumerate(tables)), "    "),
        body=_body(program, lines),
    )
    return Program(text, lanes, structure.coordinates, structure.meshes, numbers)


def tabled(time: str, by_table: bool) -> str:
    """The line that looks up a table's torques, if there is one."""
    return f"table_torques(table_time, table_torque, {time}, table)" if by_table else "pass"


def free_names(lines: list[str], structure: Structure, tables: tuple[str, ...]) -> tuple[str, ...]:
    """The names that lines use and do not set, in the order of their use: the numbers."""
    own = {f"{block}_{name}" for block in ("q", "v") for name in structure.coordinates}
    known = own | {*tables, "t", "root_t", "abs", "tanh", "if", "else"}
    found: dict[str, None] = {}
    for line in lines:
        target, _, value = line.partition("=")
        value = value.removeprefix("=")
        for name in re.findall(r"(?<![\w.])[A-Za-z]\w*", value):
            if name not in known:
                found[name] = None
        known.add(target.rstrip(" -"))
    return tuple(found)


def _body(program: Program, lines: list[str]) -> str:
    """Loads, equations and stores of one lane, in a loop over all."""
    n, lanes = len(program.coordinates), program.lanes

    def at(row: int) -> str:
        return f"w[{row * lanes} + lane]" if lanes > 1 else f"w[{row}]"

    inputs = [
        f"{block}_{name} = {at(STATE.index(f'stage_{block}') * n + place)}"
        for block in ("q", "v")
        for place, name in enumerate(program.coordinates)
    ]
    numbers = [
        f"{name} = {at(program.numbers_at + place)}" for place, name in enumerate(program.numbers)
    ]

    def block(name: str, place: int) -> str:
        return at(STATE.index(name) * n + place)

    outputs = [
        line
        for place, name in enumerate(program.coordinates)
        for line in (
            f"{block('a', place)} = a_{name}",
            f"{block('sum_q', place)} += weight * v_{name}",
            f"{block('sum_v', place)} += weight * a_{name}",
            f"{block('stage_q', place)} = {block('q', place)} + part * v_{name}",
            f"{block('stage_v', place)} = {block('v', place)} + part * a_{name}",
        )
    ]
    forces = [
        f"{at(program.forces_at + place)} = each_{name}"
        for place, name in enumerate(program.meshes)
    ]
    whole = "\n".join([*inputs, *numbers, *lines, *outputs, *forces])
    if lanes == 1:
        return indent(whole, "    ")
    return "    for lane in range(LANES):\n" + indent(whole, "        ")
