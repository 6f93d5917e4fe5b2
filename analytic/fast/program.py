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
Q, A = {blocks}  # where they begin
FORCES, FORCED = {forces}, {forced}  # and how many
JOINTS = {joints}


@njit(nogil=True, cache=True, fastmath={{"contract"}}, error_model="numpy")
def first_stage(address, t, root_t, table, h):
    """A step's first stage, of a block at time t [s]; accelerations and forces are left there."""
    w = carray(pointer(address), BLOCK)
{tables}
{first}


@njit(nogil=True, cache=True, fastmath={{"contract"}}, error_model="numpy")
def middle_stage(address, t, root_t, table, h, part):
    """The second, and with part = 1 the third: the next one is a part of h [s] further."""
    w = carray(pointer(address), BLOCK)
{tables}
{middle}


@njit(nogil=True, cache=True, fastmath={{"contract"}}, error_model="numpy")
def last_stage(address, t, root_t, table, h):
    """The fourth, and the step's end."""
    w = carray(pointer(address), BLOCK)
{tables}
{last}


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
def advance(w, first, stride, h, table_time, table_torque, out):
    """From step ``first`` on: each row of ``out`` is a record, ``stride`` steps after the last.

    After the last record as many steps follow, so that the next call goes on; stride 0: none.
    Blocks are independent, so a processor works on several at a time.
    """
    step, table = first, np.zeros(JOINTS)
    begin = w.ctypes.data
    beyond = begin + w.shape[0] * BYTES
    for place in range(out.shape[0]):
        for k in range(max(stride, 1)):
            t = step * h
            {at_t}
            for address in range(begin, beyond, BYTES):
                first_stage(address, t, sqrt(t), table, h)
            if k == 0:
                for block in range(out.shape[1]):
                    record(begin + block * BYTES, out[place, block])
            if stride == 0:
                return
            t = step * h + h / 2
            {at_t}
            for address in range(begin, beyond, BYTES):
                middle_stage(address, t, sqrt(t), table, h, 0.5)
            for address in range(begin, beyond, BYTES):
                middle_stage(address, t, sqrt(t), table, h, 1.0)
            t = step * h + h
            {at_t}
            for address in range(begin, beyond, BYTES):
                last_stage(address, t, sqrt(t), table, h)
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


LARGEST = 45_000  # characters of equations: more take longer than 20 s to compile


@lru_cache(maxsize=64)
def compilable(structure: Structure) -> bool:
    """Whether a kernel of this structure is worth the time that its compilation takes."""
    return sum(map(len, acceleration(structure, alone=False))) <= LARGEST


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
        about=f"Equations of motion of {joints} joints, {lanes} lanes; written by a program.",
        lanes=lanes,
        size=size,
        block=program.rows * lanes,
        blocks=f"{STATE.index('q') * size}, {STATE.index('a') * size}",
        forces=program.forces_at * lanes,
        forced=len(structure.meshes) * lanes,
        joints=joints,
        tables=indent("\n".join(f"{name} = table[{j}]" for j, name in enumerate(tables)), "    "),
        first=_stage(program, lines, "", _FIRST),
        middle=_stage(program, lines, "stage_", _MIDDLE),
        last=_stage(program, lines, "stage_", _LAST),
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


# What a stage leaves of every coordinate x, in the rows of STATE.
_FIRST = {
    "a": "a_{x}",
    "sum_q": "v_{x}",
    "sum_v": "a_{x}",
    "stage_q": "q_{x} + h / 2 * v_{x}",
    "stage_v": "v_{x} + h / 2 * a_{x}",
}
_MIDDLE = {
    "sum_q": "{sum_q} + 2.0 * v_{x}",
    "sum_v": "{sum_v} + 2.0 * a_{x}",
    "stage_q": "{q} + part * h * v_{x}",
    "stage_v": "{v} + part * h * a_{x}",
}
_LAST = {"q": "{q} + h / 6 * ({sum_q} + v_{x})", "v": "{v} + h / 6 * ({sum_v} + a_{x})"}


def _stage(program: Program, lines: list[str], read: str, left: dict[str, str]) -> str:
    """Loads, equations and stores of one lane, in a loop over all.

    read: which state the stage is of; left: see above.
    """
    n, lanes = len(program.coordinates), program.lanes

    def at(row: int) -> str:
        return f"w[{row * lanes} + lane]" if lanes > 1 else f"w[{row}]"

    def rows(place: int) -> dict[str, str]:
        return {name: at(k * n + place) for k, name in enumerate(STATE)}

    names = list(enumerate(program.coordinates))
    loads = [f"{block}_{x} = {rows(k)[read + block]}" for block in ("q", "v") for k, x in names]
    loads += [f"{x} = {at(program.numbers_at + k)}" for k, x in enumerate(program.numbers)]
    stores = [
        f"{rows(k)[block]} = {value.format(x=x, **rows(k))}"
        for k, x in names
        for block, value in left.items()
    ]
    if "a" in left:
        meshes = enumerate(program.meshes)
        stores += [f"{at(program.forces_at + k)} = each_{mesh}" for k, mesh in meshes]
    whole = "\n".join([*loads, *lines, *stores])
    if lanes == 1:
        return indent(whole, "    ")
    return "    for lane in range(LANES):\n" + indent(whole, "        ")
