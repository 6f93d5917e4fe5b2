"""A unit for Model Exchange in a worker: its derivatives at any time, state and input."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.trial.fmu.description import FmuDescription

MOST_EVENTS = 100


@dataclass(frozen=True)
class MappedUnit:
    """An unpacked FMU and its binary; places of q and v among its states, references of its
    torques."""

    folder: Path
    library: Path
    description: FmuDescription
    q: tuple[int, ...]
    v: tuple[int, ...]
    torque: tuple[int, ...]

    def acceleration(
        self, t: float, q: np.ndarray, v: np.ndarray, torque: np.ndarray
    ) -> np.ndarray:
        """v' (n,) at time t [s], with torques (joints,); other states are as the unit begins.

        Loads the unit's code into this process. Raises what FMPy raises.
        """
        return _running(self, os.getpid()).rates(t, q, v, torque)[list(self.v)]


@lru_cache(maxsize=2)
def _running(mapped: MappedUnit, process: int) -> RunningUnit:
    """One for each process, since a worker must not use what its parent has loaded."""
    return RunningUnit(mapped)


class RunningUnit:
    """Instantiated, initialised, in continuous-time mode."""

    def __init__(self, mapped: MappedUnit) -> None:
        from fmpy.fmi2 import FMU2Model
        from fmpy.fmi3 import FMU3Model

        self.mapped, said = mapped, mapped.description
        self.old = said.version == 2
        made: Any = FMU2Model if self.old else FMU3Model
        self.unit: Any = made(
            guid=said.token,
            modelIdentifier=said.identifier,
            unzipDirectory=str(mapped.folder),
            libraryPath=str(mapped.library),
        )
        self.unit.instantiate()
        if self.old:
            self.unit.setupExperiment(startTime=0.0)
        self.unit.enterInitializationMode()
        self.unit.exitInitializationMode()
        self._settle()
        self.count = len(said.states)
        self.numbers = np.zeros(self.count)
        self.unit.getContinuousStates(self._pointer(self.numbers), self.count)

    def _settle(self) -> None:
        """Let events at the start happen."""
        update = self.unit.newDiscreteStates if self.old else self.unit.updateDiscreteStates
        for _ in range(MOST_EVENTS):
            if not update()[0]:
                break
        self.unit.enterContinuousTimeMode()

    def _pointer(self, values: np.ndarray) -> Any:
        import ctypes

        return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))

    def rates(self, t: float, q: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Derivatives of all states."""
        states, found = self.numbers.copy(), np.full(self.count, np.nan)
        states[list(self.mapped.q)], states[list(self.mapped.v)] = q, v
        self.unit.setTime(t)
        setting = self.unit.setReal if self.old else self.unit.setFloat64
        setting(list(self.mapped.torque), torque.tolist())
        self.unit.setContinuousStates(self._pointer(states), self.count)
        ask = self.unit.getDerivatives if self.old else self.unit.getContinuousStateDerivatives
        ask(self._pointer(found), self.count)
        return found
