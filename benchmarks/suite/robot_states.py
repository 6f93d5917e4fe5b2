"""M and accelerations of many states of a robot by its kernel's traced text, in lanes."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.kernel.batch import BLOCK_LANES, make_aligned_zeros
from crosscheck.analytic.kernel.numbers import Numbers
from crosscheck.analytic.kernel.program import (
    POINTER,
    RUNS,
    WHOLE,
    Constants,
    Program,
    Rows,
    compile_program,
)
from crosscheck.analytic.robot.equations import build_equations
from crosscheck.analytic.robot.structure import RobotStructure, trace_mass_matrix
from crosscheck.models.robot.robot import Level, Robot

_TEXT = '''
def evaluate(w: rows, x: rows):
    """Results of the states x of a block, from the numbers w."""
{body}


def evaluate_all(w: array, x: array, blocks: int):
    """Results of all blocks of states."""
    for block in range(blocks):
        evaluate(w, at(x, block * BLOCK))
'''


class StateProgram(NamedTuple):
    """A program, how many rows of a block are a state's, and how many results follow them."""

    program: Program
    inputs: int
    results: int


class RobotStates:
    """A robot at a level: M and accelerations of many states at once, by the traced algorithms."""

    def __init__(self, robot: Robot, level: Level, lanes: int = BLOCK_LANES) -> None:
        self.equations, self.lanes = build_equations(robot, level), lanes

    def forward_dynamics(self, q: np.ndarray, v: np.ndarray, torques: np.ndarray) -> np.ndarray:
        """Accelerations (states, n) under torques of motors (states, free)."""
        blocks = self.dynamics_blocks(q, v, torques)
        blocks.evaluate()
        return blocks.results()

    def dynamics_blocks(self, q: np.ndarray, v: np.ndarray, torques: np.ndarray) -> StateBlocks:
        """The states in blocks, whose results are accelerations."""
        program = build_dynamics_program(self.equations.structure, self.lanes)
        return StateBlocks(program, self.equations.numbers, np.hstack([q, v, torques]))

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """M (states, free, free) of the joints' coordinates; meshes move rotors apart from it."""
        blocks = self.mass_blocks(q)
        blocks.evaluate()
        free = self.equations.structure.mechanism.free
        matrix = np.empty((len(q), free, free))
        rows, columns = np.tril_indices(free)
        matrix[:, rows, columns] = matrix[:, columns, rows] = blocks.results()
        return matrix

    def mass_blocks(self, q: np.ndarray) -> StateBlocks:
        """The states in blocks, whose results are the lower half of M, row by row."""
        structure = self.equations.structure
        program = build_mass_program(structure, self.lanes)
        numbers = self.equations.constants(trace_mass_matrix(structure))
        return StateBlocks(program, numbers, q[:, : structure.mechanism.free])


class StateBlocks:
    """States (states, inputs) of a program side by side, the last block filled up with its last."""

    def __init__(self, made: StateProgram, numbers: Numbers, states: np.ndarray) -> None:
        lanes = made.program.lanes
        self._made, self._count, blocks = made, len(states), -(-len(states) // lanes)
        self._numbers = spread_numbers(made.program, numbers)
        self._work = make_aligned_zeros(blocks, (made.inputs + made.results) * lanes)
        self._rows = self._work.reshape(blocks, made.inputs + made.results, lanes)
        places = np.minimum(np.arange(blocks * lanes), self._count - 1).reshape(blocks, lanes)
        self._rows[:, : made.inputs] = states[places].transpose(0, 2, 1)
        self._evaluate = compile_program(made.program)["evaluate_all"]

    def evaluate(self) -> None:
        """Work out the results of all blocks."""
        self._evaluate(self._numbers.ctypes.data, self._work.ctypes.data, len(self._rows))

    def results(self) -> np.ndarray:
        """The results (states, results)."""
        result = self._rows[:, self._made.inputs :].transpose(0, 2, 1)
        return result.reshape(-1, self._made.results)[: self._count]


def spread_numbers(program: Program, numbers: Numbers) -> np.ndarray:
    """A program's numbers, each for all lanes of a block, and its tables, from their rows on."""
    single = [np.atleast_1d(numbers[name]) for name in program.numbers]
    tables = [np.asarray(numbers[name]) for name, _ in program.tables]
    rows = np.concatenate([*single, *tables]) if single or tables else np.zeros(0)
    w = make_aligned_zeros(1, max(rows.size, 1) * program.lanes)
    w[0, : rows.size * program.lanes] = np.repeat(rows, program.lanes)
    return w


@lru_cache(maxsize=64)
def build_dynamics_program(structure: RobotStructure, lanes: int) -> StateProgram:
    """The program of accelerations from coordinates, rates and torques."""
    names = structure.coordinates
    torques = [f"T{j}" for j in structure.driven_joints]
    inputs = [*(f"q_{name}" for name in names), *(f"v_{name}" for name in names), *torques]
    lines = list(structure.dynamics())
    return _build(structure, lanes, inputs, lines, [f"a_{name}" for name in names])


@lru_cache(maxsize=64)
def build_mass_program(structure: RobotStructure, lanes: int) -> StateProgram:
    """The program of the lower half of M from the joints' coordinates, row by row."""
    inputs = [f"q_theta{j}" for j in structure.driven_joints]
    free = structure.mechanism.free
    results = [f"M{i}_{j}" for i in range(free) for j in range(i + 1)]
    return _build(structure, lanes, inputs, list(trace_mass_matrix(structure).lines), results)


def _build(
    structure: RobotStructure,
    lanes: int,
    inputs: Sequence[str],
    lines: list[str],
    results: Sequence[str],
) -> StateProgram:
    rows = Rows(structure, lines, 0, inputs)
    loads = [f"{name} = x[{row}]" for row, name in enumerate(inputs)]
    stores = [f"x[{row}] = {name}" for row, name in enumerate(results, len(inputs))]
    text = _TEXT.format(body=rows.function(loads, stores))
    constants: Constants = {"BLOCK": (len(inputs) + len(results)) * lanes}
    functions = (("evaluate_all", (POINTER, POINTER, WHOLE)),)
    program = rows.program(text, constants, lanes, RUNS, functions)
    return StateProgram(program, len(inputs), len(results))
