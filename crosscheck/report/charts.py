"""What the report draws of each experiment, as SVG: as soon as its runs are there.

Matplotlib, which takes half a second, is imported for the first drawing: no run waits for it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import xarray as xr

from crosscheck.planning.run_suite import engines_first
from crosscheck.registry import RIGID_LEVELS, same_integrator
from crosscheck.runner.tasks import RunKey


@dataclass(frozen=True)
class Chart:
    """Of an experiment, as SVG: the runs of both engines, and the rigid levels' deviation."""

    name: str
    runs: str
    levels: str


class Charts:
    """Drawings of runs, each made once: while other runs are still under way, if it can be.

    Only what needs no other run is drawn then, so that all is the same whichever ends first.
    """

    def __init__(self) -> None:
        self.runs: dict[RunKey, xr.Dataset] = {}
        self.drawn: dict[tuple[str, str], str] = {}
        self.pair = same_integrator()[:2]
        self.rigid = {level: engines_first(level)[0] for level in RIGID_LEVELS}

    def show(self, key: Any, outcome: Any) -> None:
        """A task's outcome: if it is a run that completes a drawing, that is made now."""
        if not (isinstance(key, RunKey) and isinstance(outcome, xr.Dataset)):
            return
        self.runs[key] = outcome
        if self._complete(key.experiment, *self.pair):
            self._runs(key.experiment)
        if self._complete(key.experiment, self.pair[0], *self.rigid.values()):
            self._levels(key.experiment)

    def made(self) -> list[Chart]:
        """One for every experiment that both engines ran, by name."""
        names = sorted({key.experiment for key in self.runs})
        both = [name for name in names if self._complete(name, *self.pair)]
        return [Chart(name, self._runs(name), self._levels(name)) for name in both]

    def _complete(self, experiment: str, *models: str) -> bool:
        return all(RunKey(experiment, model) in self.runs for model in models)

    def _runs(self, experiment: str) -> str:
        from crosscheck.report.figures import run_figure

        ours, theirs = (self.runs[RunKey(experiment, model)] for model in self.pair)
        return self._once((experiment, "runs"), lambda: run_figure(ours, theirs))

    def _levels(self, experiment: str) -> str:
        """Empty where no rigid level was run."""
        from crosscheck.report.figures import level_figure

        keys = {level: RunKey(experiment, model) for level, model in self.rigid.items()}
        known = {level: self.runs[key] for level, key in keys.items() if key in self.runs}
        if not known:
            return ""
        geared = self.runs[RunKey(experiment, self.pair[0])]
        return self._once((experiment, "levels"), lambda: level_figure(geared, known))

    def _once(self, key: tuple[str, str], draw: Callable[[], str]) -> str:
        if key not in self.drawn:
            self.drawn[key] = draw()
        return self.drawn[key]
