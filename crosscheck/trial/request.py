"""A user's request for a trial of equations, of an arm or a robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from crosscheck.mechanisms import supply
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.loading import Selection
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.input.loading import load_equations


@dataclass(frozen=True)
class TrialRequest:
    """A user's request for a trial, of an arm or a robot.

    name: what reports call the equations; scenarios: to be run, of an arm, none for a trial by
    states alone; switches: laws of an arm's gears, None for the usual ones; quick: whether to ask
    at fewer states; jobs: how many forked processes run side by side.
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
    given = chosen.mechanism, chosen.scenarios[0] if chosen.scenarios else None
    if isinstance(source, str):
        return load_equations(source, *given)
    return supply("build_equations", chosen.mechanism.section)(source, *given, name)
