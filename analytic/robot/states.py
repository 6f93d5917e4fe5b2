"""Quantities of many states of a robot by machine code, as many at a time as a block has lanes."""

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
from crosscheck.analytic.robot.equations import RobotEquations
from crosscheck.analytic.robot.structure import RobotStructure, trace_mass_matrix
from crosscheck.models.experiment.drive import CONSTANT, DriveData
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
        free = len(robot.coordinates)
        still = DriveData(CONSTANT, np.zeros((free, 3)), np.zeros(1), np.zeros((free, 1)))
        self.equations, self.lanes = RobotEquations(robot, level, still), lanes

    def forward_dynamics(self, q: np.ndarray, v: np.ndarray, torques: np.ndarray) -> np.ndarray:
        """Accelerations (states, n) under torques of motors (states, free)."""
        program = build_dynamics_program(self.equations.structure, self.lanes)
        return self._evaluate(program, self.equations.numbers, [q, v, torques])

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """M (states, free, free) of the joints' coordinates; meshes move rotors apart from it."""
        structure = self.equations.structure
        program = build_mass_program(structure, self.lanes)
        numbers = self.equations.constants(trace_mass_matrix(structure))
        free = structure.mechanism.free
        entries = self._evaluate(program, numbers, [q[:, :free]])
        matrix = np.empty((len(q), free, free))
        rows, columns = np.tril_indices(free)
        matrix[:, rows, columns] = matrix[:, columns, rows] = entries
        return matrix

    def _evaluate(
        self, made: StateProgram, numbers: Numbers, states: Sequence[np.ndarray]
    ) -> np.ndarray:
        """Results (states, results) of a program, the last block filled up with its last state."""
        given, lanes = np.hstack(states), self.lanes
        blocks = -(-len(given) // lanes)
        w = spread_numbers(made.program, numbers)
        x = make_aligned_zeros(blocks, (made.inputs + made.results) * lanes)
        rows = x.reshape(blocks, made.inputs + made.results, lanes)
        places = np.minimum(np.arange(blocks * lanes), len(given) - 1).reshape(blocks, lanes)
        rows[:, : made.inputs] = given[places].transpose(0, 2, 1)
        code = compile_program(made.program)
        code["evaluate_all"](w.ctypes.data, x.ctypes.data, blocks)
        found = rows[:, made.inputs :].transpose(0, 2, 1)
        return found.reshape(-1, made.results)[: len(given)]


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
