"""A unit in a worker: its derivatives at a state, or a run of it. Its code is loaded here alone.

Equations out of its accelerations: of a rigid arm also M, bias and force.
"""

from __future__ import annotations

import ctypes
import os
from functools import lru_cache
from typing import Any

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.trial.coordinates.frame import frame_of
from crosscheck.trial.fmu.archive import MappedUnit
from crosscheck.trial.input.equations import Equations

MOST_EVENTS = 100
PUSH_N_M = 1e3  # by which torques are told from weight


def acceleration_of(
    unit: MappedUnit, t: float, q: np.ndarray, v: np.ndarray, torque: np.ndarray
) -> np.ndarray:
    """v' (n,) at time t [s], with torques (joints,); other states are as the unit begins.

    Raises what FMPy raises.
    """
    return _exchange(unit, os.getpid()).rates(t, q, v, torque)[unit.places(unit.v)]


@lru_cache(maxsize=2)
def _exchange(unit: MappedUnit, process: int) -> ExchangeUnit:
    """One for each process, since a worker must not use what its parent has loaded."""
    return ExchangeUnit(unit)


class LoadedUnit:
    """An instance of a unit, with what FMI 2.0 and 3.0 call differently."""

    def __init__(self, mapped: MappedUnit) -> None:
        from fmpy import fmi2, fmi3

        said = mapped.description
        self.mapped, self.old = mapped, said.version == 2
        kinds = {
            ("exchange", True): fmi2.FMU2Model,
            ("exchange", False): fmi3.FMU3Model,
            ("co-simulation", True): fmi2.FMU2Slave,
            ("co-simulation", False): fmi3.FMU3Slave,
        }
        self.unit: Any = kinds[said.kind, self.old](
            guid=said.token,
            modelIdentifier=said.identifier,
            unzipDirectory=str(mapped.folder),
            libraryPath=str(mapped.library),
        )
        self.unit.instantiate()
        self.set = self.unit.setReal if self.old else self.unit.setFloat64
        self.get = self.unit.getReal if self.old else self.unit.getFloat64
        self.torque = mapped.references(mapped.torque)

    def initialise(self) -> None:
        """From what was set on."""
        if self.old:
            self.unit.setupExperiment(startTime=0.0)
        self.unit.enterInitializationMode()
        self.unit.exitInitializationMode()


class ExchangeUnit(LoadedUnit):
    """For Model Exchange, in continuous-time mode."""

    def __init__(self, mapped: MappedUnit) -> None:
        super().__init__(mapped)
        self.initialise()
        update = self.unit.newDiscreteStates if self.old else self.unit.updateDiscreteStates
        for _ in range(MOST_EVENTS):
            if not update()[0]:
                break
        self.unit.enterContinuousTimeMode()
        self.begin = np.zeros(len(mapped.description.states))
        self.unit.getContinuousStates(_pointer(self.begin), self.begin.size)

    def rates(self, t: float, q: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Derivatives of all states."""
        states, found = self.begin.copy(), np.full(self.begin.size, np.nan)
        states[self.mapped.places(self.mapped.q)] = q
        states[self.mapped.places(self.mapped.v)] = v
        self.unit.setTime(t)
        self.set(self.torque, torque.tolist())
        self.unit.setContinuousStates(_pointer(states), states.size)
        ask = self.unit.getDerivatives if self.old else self.unit.getContinuousStateDerivatives
        ask(_pointer(found), found.size)
        return found


class SteppedUnit(LoadedUnit):
    """For Co-Simulation: it steps by itself from one communication to the next."""

    def __init__(self, mapped: MappedUnit, q: np.ndarray, v: np.ndarray) -> None:
        super().__init__(mapped)
        self.state = mapped.references((*mapped.q, *mapped.v))
        self.set(self.state, [*q.tolist(), *v.tolist()])
        self.initialise()

    def now(self) -> tuple[np.ndarray, np.ndarray]:
        """q and v."""
        q, v = np.split(np.array(self.get(self.state)), 2)
        return q, v

    def step(self, t: float, h: float, torque: np.ndarray) -> None:
        """From t to t + h [s], torques held."""
        self.set(self.torque, torque.tolist())
        self.unit.doStep(t, h)


def _pointer(values: np.ndarray) -> Any:
    return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def fmu_equations(unit: MappedUnit, arm: Arm) -> Equations:
    """The equations of a unit for Model Exchange, which runs in workers alone.

    With a torque on each coordinate M is what resists them; else there is the acceleration alone.
    """
    frame = frame_of(unit.coordinates, arm)
    theta = frame.jacobian(np.zeros(len(frame.names)))[frame.layout.theta]
    joints, size = theta.shape
    if joints != size:
        return Equations(
            acceleration=lambda t, x, v, torque: acceleration_of(unit, t, x, v, torque),
            coordinates=unit.coordinates,
        )

    def mass_matrix(x: np.ndarray) -> np.ndarray:
        still, gained = np.zeros(size), np.zeros((size, joints))
        for joint, push in enumerate(PUSH_N_M * np.eye(joints)):
            ahead, back = (acceleration_of(unit, 0.0, x, still, sign * push) for sign in (1, -1))
            gained[:, joint] = (ahead - back) / (2 * PUSH_N_M)
        return theta.T @ np.linalg.inv(gained)

    def bias(x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """What is even in the rates and vanishes with them: weight and friction do not."""
        idle = np.zeros(joints)
        ahead, back, still = (acceleration_of(unit, 0.0, x, s * v, idle) for s in (1, -1, 0))
        return mass_matrix(x) @ (still - (ahead + back) / 2)

    def force(t: float, x: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        return mass_matrix(x) @ acceleration_of(unit, t, x, v, torque) + bias(x, v)

    return Equations(
        mass_matrix=mass_matrix,
        bias=bias,
        force=force,
        coordinates=unit.coordinates,
        level=unit.level,
    )
