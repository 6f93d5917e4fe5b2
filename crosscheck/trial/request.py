"""A user's request for a trial of equations, of an arm or a robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from crosscheck.mechanisms import supply
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.loading import Selection
from crosscheck.runner.progress_update import ProgressCallback, ignore_progress
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.result import TrialResult


@dataclass(frozen=True)
class TrialRequest:
    """A user's request for a trial.

    Args:
        name: What reports call the equations.
        equations: The equations.
        mechanism: The arm or robot.
        scenarios: To be run, of an arm; none for a trial by states alone.
        switches: Laws of an arm's gears, None for the usual ones.
        quick: Whether to ask at fewer states.
        seed: Of the random states.
        jobs: How many forked processes run side by side.
    """

    name: str
    equations: Equations
    mechanism: Any
    scenarios: tuple[Scenario, ...] = ()
    switches: Switches | None = None
    quick: bool = False
    seed: int = 0
    jobs: int = 1


def prepare_equations(source: Any, chosen: Selection, name: str) -> Equations:
    """The equations that a user gave, or named by a text, for a mechanism. Raises InputError."""
    scenario = chosen.scenarios[0] if chosen.scenarios else None
    if isinstance(source, str):
        load = supply("load_equations", chosen.mechanism.section)
        loaded: Equations = load(source, chosen.mechanism, scenario)
        return loaded
    build = supply("build_equations", chosen.mechanism.section)
    built: Equations = build(source, chosen.mechanism, scenario, name)
    return built


def run_trial(request: TrialRequest, progress: ProgressCallback = ignore_progress) -> TrialResult:
    """Judge the equations of a request.

    Raises InputError for what cannot be tried at all, and Unfinished where the models that they are
    compared with do not answer.
    """
    trial: TrialResult = supply("run_trial", request.mechanism.section)(request, progress)
    return trial
