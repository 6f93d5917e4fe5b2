"""The simulations of a cross-check: what to run, and running it on several processes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import joblib
import numpy as np
import xarray as xr

from crosscheck.registry import build
from models.arm import Arm
from models.loading import Case


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


@dataclass(frozen=True)
class Failure:
    """Why a simulation has no trajectory: the exception's name and message."""

    kind: str
    message: str

    def __str__(self) -> str:
        return f"{self.kind}: {self.message}"


Outcome = xr.Dataset | Failure


def perform(simulation: Simulation) -> tuple[str, Outcome]:
    """(key, trajectory), or what prevented it: a failed check, not a crash."""
    try:
        model = build(simulation.model, *simulation.case)
        if simulation.rtol is None:
            return simulation.key, model.simulate()
        return simulation.key, model.reference(simulation.rtol)
    except Exception as error:
        return simulation.key, Failure(type(error).__name__, " ".join(str(error).split()))


def perform_all(
    simulations: Sequence[Simulation], jobs: int, done: Callable[[str], None]
) -> dict[str, Outcome]:
    """All outcomes by key; ``done`` is told each key as it finishes."""
    longest_first = sorted(simulations, key=lambda simulation: -simulation.cost)
    parallel = joblib.Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1)
    outcomes = {}
    for key, outcome in parallel(joblib.delayed(perform)(item) for item in longest_first):
        outcomes[key] = outcome
        done(key)
    return outcomes


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
