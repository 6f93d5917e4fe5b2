"""A unit in a worker: its derivatives at a state, or a run of it. Its code is loaded here alone.

Equations out of its accelerations: of a rigid arm also M, bias and force. A unit for
Co-Simulation runs beside the engines: the same experiment, each by its own integrator.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from crosscheck.checks.trajectories import RefinedRun, plan_refined, refine
from crosscheck.findings import Agreement
from crosscheck.mechanisms import supply
from crosscheck.models.arm.arm import Arm
from crosscheck.models.directories import require_private
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.drive import drive_data, torques_at
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.loading import Case
from crosscheck.models.mechanism import Mechanism
from crosscheck.models.trajectory import build_trajectory, recorded_times
from crosscheck.planning.comparison import Comparison, collect_tasks, judge_comparisons
from crosscheck.planning.plan import Experiment, sort_engines
from crosscheck.provenance import record_provenance
from crosscheck.registry import build, find_same_integrator_models, packages, reference_model
from crosscheck.run import run_tasks
from crosscheck.runner.isolated_reading import read_in_subprocess
from crosscheck.runner.outcomes import Failure, failure_from_error
from crosscheck.runner.process_tree import limit_resources
from crosscheck.runner.progress_update import ProgressCallback
from crosscheck.runner.tasks import RunKey
from crosscheck.runner.workers import Workers
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.fmu.archive import MappedUnit
from crosscheck.trial.input.equations import Equations

if TYPE_CHECKING:
    import xarray as xr

MOST_EVENTS = 100
PUSH_N_M = 1e3  # torque that distinguishes the drive's effect from the weight's
FAMILY = "trial-run"
UNIT_BYTES, START_S = 2_000_000_000, 20  # memory of a unit; processor time of its start [s]
STEP_S = 1e-4  # rough cost of a communication


@lru_cache(maxsize=2)
def _load_exchange_unit(unit: MappedUnit, process: int) -> ExchangeUnit:
    """The unit, loaded once in each process: a worker must not use what its parent has loaded."""
    return ExchangeUnit(unit)


class LoadedUnit:
    """An instance of a unit, which hides what FMI 2.0 and 3.0 call differently."""

    def __init__(self, mapped: MappedUnit) -> None:
        from fmpy import fmi2, fmi3

        description = mapped.description
        limit_resources(UNIT_BYTES)
        with require_private(mapped.library):  # which was unpacked a while ago
            pass
        self.mapped, self.old = mapped, description.version == 2
        unit_classes = {
            ("exchange", True): fmi2.FMU2Model,
            ("exchange", False): fmi3.FMU3Model,
            ("co-simulation", True): fmi2.FMU2Slave,
            ("co-simulation", False): fmi3.FMU3Slave,
        }
        self.unit: Any = unit_classes[description.kind, self.old](
            guid=description.token,
            modelIdentifier=description.identifier,
            unzipDirectory=str(mapped.folder),
            libraryPath=str(mapped.library),
        )
        self.unit.instantiate()
        self.set = self.unit.setReal if self.old else self.unit.setFloat64
        self.get = self.unit.getReal if self.old else self.unit.getFloat64
        self.torque = mapped.references(mapped.torque)

    def initialise(self) -> None:
        """Initialise the unit with the values that were set."""
        if self.old:
            self.unit.setupExperiment(startTime=0.0)
        self.unit.enterInitializationMode()
        self.unit.exitInitializationMode()


class ExchangeUnit(LoadedUnit):
    """An instance of a unit for Model Exchange, in continuous-time mode."""

    def __init__(self, mapped: MappedUnit) -> None:
        super().__init__(mapped)
        self.initialise()
        update = self.unit.newDiscreteStates if self.old else self.unit.updateDiscreteStates
        for _ in range(MOST_EVENTS):
            if not update()[0]:
                break
        else:
            raise RuntimeError(f"its events do not end, after {MOST_EVENTS} updates of its states")
        self.unit.enterContinuousTimeMode()
        self.begin = np.zeros(len(mapped.description.states))
        self.unit.getContinuousStates(_pointer(self.begin), self.begin.size)

    def rates(self, t: float, q: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Derivatives (states,) of all continuous states at time t [s]."""
        states, derivatives = self.begin.copy(), np.full(self.begin.size, np.nan)
        states[self.mapped.places(self.mapped.q)] = q
        states[self.mapped.places(self.mapped.v)] = v
        self.unit.setTime(t)
        self.set(self.torque, torque.tolist())
        self.unit.setContinuousStates(_pointer(states), states.size)
        ask = self.unit.getDerivatives if self.old else self.unit.getContinuousStateDerivatives
        ask(_pointer(derivatives), derivatives.size)
        return derivatives


class SteppedUnit(LoadedUnit):
    """A unit for Co-Simulation: it steps by itself from one communication to the next."""

    def __init__(self, mapped: MappedUnit, q: np.ndarray, v: np.ndarray) -> None:
        super().__init__(mapped)
        self.state = mapped.references((*mapped.q, *mapped.v))
        self.set(self.state, [*q.tolist(), *v.tolist()])
        self.initialise()

    def get_state(self) -> tuple[np.ndarray, np.ndarray]:
        """q and v, each (n,), as the unit has them."""
        q, v = np.split(np.array(self.get(self.state)), 2)
        return q, v

    def step(self, t: float, h: float, torque: np.ndarray) -> None:
        """Step the unit from t to t + h [s], torques (joints,) [N m] held."""
        self.set(self.torque, torque.tolist())
        self.unit.doStep(t, h)


def _pointer(values: np.ndarray) -> Any:
    return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def require_running(unit: MappedUnit, where: str) -> None:
    """Raise InputError for a unit that does not start and answer once, in a process of its own."""
    read_in_subprocess(where, _start, unit, fails="does not run")


def _start(unit: MappedUnit) -> None:
    """Start a unit and ask it once; what it refuses at its own start is left to the checks."""
    limit_resources(UNIT_BYTES, START_S)
    if unit.description.kind == "co-simulation":
        LoadedUnit(unit).initialise()
        return
    exchange_unit = ExchangeUnit(unit)
    q, v = (exchange_unit.begin[unit.places(names)] for names in (unit.q, unit.v))
    with suppress(Exception):
        exchange_unit.rates(0.0, q, v, np.zeros(len(unit.torque)))


def build_fmu_equations(unit: MappedUnit, mechanism: Mechanism) -> Equations:
    """The equations of a unit for Model Exchange, which runs in workers alone.

    With a torque on each coordinate M is what resists them; else there is the acceleration alone.
    """
    frame = supply("build_frame", mechanism.section)(unit.coordinates, mechanism)
    theta = frame.jacobian(np.zeros(len(frame.layout)))[frame.layout.theta]
    joints, size = theta.shape

    def ask(t: float, x: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """v' (n,) at time t [s], torques (joints,); other states are as the unit begins."""
        return _load_exchange_unit(unit, os.getpid()).rates(t, x, v, torque)[unit.places(unit.v)]

    if joints != size:
        return Equations(acceleration=ask, coordinates=unit.coordinates)

    def mass_matrix(x: np.ndarray) -> np.ndarray:
        still, gained = np.zeros(size), np.zeros((size, joints))
        for joint, push in enumerate(PUSH_N_M * np.eye(joints)):
            ahead, back = (ask(0.0, x, still, sign * push) for sign in (1, -1))
            gained[:, joint] = (ahead - back) / (2 * PUSH_N_M)
        return theta.T @ np.linalg.inv(gained)

    def bias(x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """The part that is even in the rates and vanishes with them; weight and friction do not."""
        idle = np.zeros(joints)
        ahead, back, still = (ask(0.0, x, s * v, idle) for s in (1, -1, 0))
        return mass_matrix(x) @ (still - (ahead + back) / 2)

    def force(t: float, x: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        return mass_matrix(x) @ ask(t, x, v, torque) + bias(x, v)

    return Equations(
        mass_matrix=mass_matrix,
        bias=bias,
        force=force,
        coordinates=unit.coordinates,
        level=unit.level,
    )


@dataclass(frozen=True)
class UnitRun:
    """A run of a unit; variant: ``coarse`` communicates half as often."""

    unit: MappedUnit
    name: str
    case: Case
    reference: str
    variant: Literal["", "coarse"] = ""

    @cached_property
    def key(self) -> RunKey:
        """The run's key: its scenario, model and variant."""
        return RunKey(self.case.scenario.name, self.name, self.variant)

    @property
    def model(self) -> str:
        """The name that the unit has as a model."""
        return self.name

    @property
    def cost(self) -> float:
        """Estimated time that the run takes [s]."""
        return 1.0 + self.case.scenario.steps * STEP_S

    def perform(self) -> xr.Dataset | Failure:
        """Angles and rates at the scenario's times, or why there are none."""
        try:
            return self._run()
        except BaseException as error:  # also what a unit raises through FMPy
            return failure_from_error(error)

    def _run(self) -> xr.Dataset:
        """The unit's run, as a trajectory.

        Torques are set and held at every communication, at least two between records.
        """
        arm, scenario, _ = self.case
        frame = build_frame(self.unit.coordinates, arm)
        theta, drive = frame.layout.theta, drive_data(scenario, len(arm.joints))
        q, v = build(self.reference, *self.case).start()
        x_0 = frame.place(q)
        stepped_unit = SteppedUnit(self.unit, x_0, np.linalg.solve(frame.jacobian(x_0), v))

        def joint_motion() -> tuple[np.ndarray, np.ndarray]:
            """Angles and rates of the joints, as the unit has them now."""
            x, u = stepped_unit.get_state()
            return frame.position(x)[theta], (frame.jacobian(x) @ u)[theta]

        time = recorded_times(scenario)
        often = max(scenario.stride // 2, 1) * (1 if self.variant else 2)
        records = []
        for begin, end in zip(time, [*time[1:], None], strict=True):
            records.append(joint_motion())
            for part in range(often if end is not None else 0):
                h = (end - begin) / often
                t = begin + part * h
                stepped_unit.step(t, h, torques_at(drive, t, *joint_motion()))
        angles, rates = (np.array(each) for each in zip(*records, strict=True))
        run = build_trajectory(self.name, *self.case, time, theta=angles, theta_dot=rates)
        return run.assign_attrs(step_s=(time[1] - time[0]) / often)


def compare_unit_runs(
    unit: MappedUnit,
    name: str,
    arm: Arm,
    scenarios: Sequence[Scenario],
    laws: Switches,
    jobs: int,
    progress: ProgressCallback,
) -> Agreement:
    """The cross-check of a unit's runs with those of the engines.

    Each run is as uncertain as refining its steps shows; of the unit, the steps of communication.
    """
    comparisons = [
        comparison
        for scenario in scenarios
        for comparison in _plan_comparisons(unit, name, Case(arm, scenario, laws))
    ]
    with Workers(jobs) as workers:
        results = run_tasks(workers, collect_tasks(comparisons), progress)
    settings = arm, 0, False, tuple(scenarios), laws
    record = record_provenance(*settings, packages=packages(), model=name)
    return Agreement(list(judge_comparisons(comparisons, results)), record)


def require_comparable(unit: MappedUnit, where: str) -> None:
    """Raise InputError for a rigid unit that does not say which level it is."""
    if unit.coordinates.gearing == "rigid" and not unit.level:
        allowed = "must say which rigid level a unit for Co-Simulation is: links, carriers, ..."
        raise InputError(where, "level", None, allowed)


def _plan_comparisons(unit: MappedUnit, name: str, case: Case) -> Iterator[Comparison]:
    geared = [reference_model(), *find_same_integrator_models()]
    engines = sort_engines(unit.level) if unit.level else geared
    first = next(engine for engine in engines if engine.startswith("analytic"))
    fine = UnitRun(unit, name, case, first)
    of_unit = RefinedRun(fine, ((fine, replace(fine, variant="coarse")),))
    experiment = Experiment(case.scenario.name, case)
    for engine in dict.fromkeys(engines):
        sides = of_unit, refine(experiment, engine)
        yield from plan_refined(experiment, *sides, FAMILY, ("theta", "theta_dot"))
