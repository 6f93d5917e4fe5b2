"""The tasks of a cross-check: what to run, and running it on several processes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import joblib
import numpy as np
import xarray as xr

from crosscheck.registry import build
from models.arm import Arm
from models.loading import Case


@dataclass(frozen=True)
class Failure:
    """Why a simulation has no trajectory: the exception's name and message."""

    kind: str
    message: str

    def __str__(self) -> str:
        return f"{self.kind}: {self.message}"


Outcome = xr.Dataset | Failure


@dataclass(frozen=True)
class Simulation:
    """One run of one model; ``rtol`` asks for its adaptive reference instead of fixed steps."""

    key: str
    model: str
    case: Case
    rtol: float | None = None

    @property
    def cost(self) -> float:
        """Rough seconds, to start the longest first."""
        per_step = 2e-4 if self.model.startswith("exudyn") else 1e-5
        return self.case.scenario.steps * per_step * (4 if self.rtol else 1)

    def perform(self) -> Outcome:
        """The trajectory, or what prevented it: a failed check, not a crash."""
        try:
            model = build(self.model, *self.case)
            return model.simulate() if self.rtol is None else model.reference(self.rtol)
        except Exception as error:
            return Failure(type(error).__name__, " ".join(str(error).split()))


class Task(Protocol):
    """A piece of work for another process, rough seconds long."""

    @property
    def key(self) -> str: ...

    @property
    def cost(self) -> float: ...

    def perform(self) -> Any: ...


def perform_all(tasks: Sequence[Task], jobs: int, done: Callable[[str], None]) -> dict[str, Any]:
    """All results by key, in the tasks' order; ``done`` is told each key as it finishes."""
    longest_first = sorted(tasks, key=lambda task: -task.cost)
    parallel = joblib.Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1)
    results = {}
    for key, result in parallel(joblib.delayed(_perform)(task) for task in longest_first):
        results[key] = result
        done(key)
    return {task.key: results[task.key] for task in tasks}


def _perform(task: Task) -> tuple[str, Any]:
    return task.key, task.perform()


def with_step(case: Case, step_s: float) -> Case:
    """The case at another step, recorded at the same times."""
    scenario = case.scenario
    ratio = scenario.step_s * scenario.stride / step_s
    update = {"step_s": step_s, "record_every": max(1, round(ratio))}
    return case._replace(scenario=scenario.model_copy(update=update))


def nudged(case: Case) -> Case:
    """The case with x_sp1 one unit in the last place away from where it starts."""
    start = case.scenario.start
    joints = len(case.arm.joints)
    at = _first_displacement(case.arm, start.mesh)
    offset = (float(np.spacing(at)), *([0.0] * (joints - 1)))
    moved = start.model_copy(update={"sun_planet_offset_m": offset})
    return case._replace(scenario=case.scenario.model_copy(update={"start": moved}))


def _first_displacement(arm: Arm, mesh: str) -> float:
    return arm.joints[0].backlash_m if mesh == "contact" else 0.0
