"""The quantities of single states by machine code: M, bias, force, accelerations, mesh forces."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.kernel.batch import look_up_torques, number_rows
from crosscheck.analytic.kernel.equations import TermEquations
from crosscheck.analytic.kernel.program import build_states_program, compile_program
from crosscheck.models.experiment.drive import TABLE


class Quantities(NamedTuple):
    """Quantities of a state: M (n, n), bias C v, force F - D v, accelerations and mesh forces.

    bias, force and acceleration have shape (n,); mesh_forces (meshes,) [N] are elastic, per planet.
    """

    mass_matrix: np.ndarray
    bias: np.ndarray
    force: np.ndarray
    acceleration: np.ndarray
    mesh_forces: np.ndarray


class StateEvaluator:
    """Evaluator of a model's equations at states that it is asked for one after the other."""

    def __init__(self, equations: TermEquations) -> None:
        program = build_states_program(equations.structure)
        self._drive, self._n = equations.drive, equations.structure.size
        self._code = compile_program(program)
        self._evaluate = self._code["evaluate"]
        numbers = number_rows(program, equations.numbers)
        self._work = np.concatenate([np.zeros(program.leading_rows), *numbers])
        self._address = self._work.ctypes.data
        self._table = look_up_torques(self._drive, 0.0)
        self._table_address = self._table.ctypes.data
        sizes = (2 * self._n, self._n**2, self._n, self._n, self._n)
        self._ends: list[int] = np.cumsum(sizes).tolist()
        self._last = program.leading_rows

    def evaluate(self, t: float, q: np.ndarray, v: np.ndarray) -> Quantities:
        """Quantities at time t [s] and a state q, v (n,), as copies."""
        n, work, ends = self._n, self._work, self._ends
        work[:n], work[n : 2 * n] = q, v
        if self._drive.code == TABLE:
            self._table[:] = look_up_torques(self._drive, t)
        self._evaluate(self._address, t, sqrt(t), self._table_address, 0.0, 0.0)
        made = work[: self._last].copy()
        return Quantities(
            made[ends[0] : ends[1]].reshape(n, n),
            made[ends[1] : ends[2]],
            made[ends[2] : ends[3]],
            made[ends[3] : ends[4]],
            made[ends[4] :],
        )
