"""A unit for Co-Simulation beside the engines: the same experiment, each by its own integrator."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from crosscheck.checks.invariants import torques_at
from crosscheck.checks.scales import meaningful
from crosscheck.checks.trajectories import UNITS, refined, size
from crosscheck.findings import About, Agreement, Finding, Key
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.drive import drive_data
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.loading import Case
from crosscheck.models.trajectory import recorded, recorded_times
from crosscheck.planning.comparison import Comparison, Results, findings_of, tasks_of
from crosscheck.planning.plan import Experiment
from crosscheck.planning.run_suite import engines_first
from crosscheck.provenance import provenance
from crosscheck.registry import build, lead, packages, same_integrator
from crosscheck.run import performed
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.tasks import RunKey
from crosscheck.runner.underway import Told
from crosscheck.runner.workers import Workers
from crosscheck.trial.coordinates.frame import frame_of
from crosscheck.trial.fmu.archive import MappedUnit
from crosscheck.trial.fmu.unit import SteppedUnit
from crosscheck.trial.input.traces import told_failure

if TYPE_CHECKING:
    import xarray as xr

FAMILY = "trial-run"
STEP_S = 1e-4  # rough cost of a communication


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
        """What it is called."""
        return RunKey(self.case.scenario.name, self.name, self.variant)

    @property
    def model(self) -> str:
        """Whose run."""
        return self.name

    @property
    def cost(self) -> float:
        """Rough seconds."""
        return 1.0 + self.case.scenario.steps * STEP_S

    def perform(self) -> xr.Dataset | Failure:
        """Angles and rates at the scenario's times, or why there are none."""
        try:
            return self._run()
        except BaseException as error:  # also what a unit raises through FMPy
            return told_failure(error)

    def _run(self) -> xr.Dataset:
        """Torques are told and held at every communication, at least two between records."""
        arm, scenario, _ = self.case
        frame = frame_of(self.unit.coordinates, arm)
        theta, drive = frame.layout.theta, drive_data(scenario, len(arm.joints))
        q, v = build(self.reference, *self.case).start()
        own = SteppedUnit(self.unit, frame.place(q), np.linalg.solve(frame.jacobian(q), v))
        time = recorded_times(scenario)
        often = max(scenario.stride // 2, 1) * (1 if self.variant else 2)
        found = []
        for begin, end in zip(time, [*time[1:], None], strict=True):
            x, u = own.now()
            found.append((frame.position(x)[theta], (frame.jacobian(x) @ u)[theta]))
            for part in range(often if end is not None else 0):
                h = (end - begin) / often
                t = begin + part * h
                x, u = own.now()
                angle, rate = frame.position(x)[theta], (frame.jacobian(x) @ u)[theta]
                own.step(t, h, torques_at(drive, t, angle, rate))
        angles, rates = (np.array(each) for each in zip(*found, strict=True))
        run = recorded(self.name, *self.case, time, theta=angles, theta_dot=rates)
        return run.assign_attrs(step_s=(time[1] - time[0]) / often)


def beside(
    unit: MappedUnit,
    name: str,
    arm: Arm,
    scenarios: Sequence[Scenario],
    laws: Switches,
    jobs: int,
    told: Told,
) -> Agreement:
    """What the unit's runs have to do with those of the engines.

    Each is as uncertain as refining its steps shows, of the unit those of its communication.
    """
    found = [
        comparison
        for scenario in scenarios
        for comparison in _comparisons(unit, name, Case(arm, scenario, laws))
    ]
    with Workers(jobs) as workers:
        results = performed(workers, tasks_of(found), told)
    settings = arm, 0, False, tuple(scenarios), laws
    record = provenance(*settings, packages=packages(), model=name)
    return Agreement(list(findings_of(found, results)), record)


def require_comparable(unit: MappedUnit, where: str) -> None:
    """Raise InputError for a rigid unit that does not say which level it is."""
    if unit.coordinates.gearing == "rigid" and not unit.level:
        allowed = "must say which rigid level a unit for Co-Simulation is: links, carriers, ..."
        raise InputError(where, "level", None, allowed)


def _comparisons(unit: MappedUnit, name: str, case: Case) -> Iterator[Comparison]:
    engines = engines_first(unit.level) if unit.level else [lead(), *same_integrator()]
    first = next(engine for engine in engines if engine.startswith("analytic"))
    own = UnitRun(unit, name, case, first), UnitRun(unit, name, case, first, "coarse")
    experiment = Experiment(case.scenario.name, case)
    for engine in dict.fromkeys(engines):
        theirs = experiment.run(engine), experiment.run(engine, "coarse")
        for quantity in ("theta", "theta_dot"):
            key = Key(FAMILY, case.scenario.name, quantity, name, engine)
            about = About(key, UNITS[quantity], "largest absolute difference")

            def judged(about: About, results: Results, theirs: Any = theirs) -> Finding:
                left, right = ([results.need(run) for run in side] for side in (own, theirs))
                quantity = about.key.quantity
                widest = meaningful(quantity, case.arm, case.scenario, size(right[0], quantity))
                return refined(about, left, right, widest)

            yield Comparison(about, (*own, *theirs), judged)
