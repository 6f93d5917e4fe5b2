"""The report's charts of each experiment, drawn as soon as its runs are finished.

Matplotlib, which takes half a second, is imported for the first drawing: no run waits for it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import xarray as xr

from crosscheck.planning.plan import sort_engines
from crosscheck.registry import RIGID_LEVELS, find_same_integrator_models, model_names
from crosscheck.report.plots.signals import Signals, collect_signals
from crosscheck.runner.tasks import RunKey


@dataclass(frozen=True)
class Pictures:
    """Drawings of the runs of a cross-check.

    levels: by experiment, the rigid levels' deviation as SVG; signals: for the page's script;
    still: SVG of the longest experiment, for a page that is printed or runs no script; still_of:
    the name of that experiment.
    """

    levels: dict[str, str]
    signals: tuple[Signals, ...] = ()
    still: str = ""
    still_of: str = ""


class Charts:
    """Drawings of runs, each made once: while other runs are still under way, if it can be.

    Only what needs no other run is drawn then, so that all is the same whichever ends first.
    """

    def __init__(self) -> None:
        self.runs: dict[RunKey, xr.Dataset] = {}
        self.levels: dict[str, str] = {}
        self.pair = find_same_integrator_models()[:2]
        self.rigid = {level: sort_engines(level)[0] for level in RIGID_LEVELS}

    def show(self, key: Any, outcome: Any) -> None:
        """Take a task's outcome; if it is a run that completes a drawing, make that now."""
        if not (isinstance(key, RunKey) and isinstance(outcome, xr.Dataset)):
            return
        self.runs[key] = outcome
        needed = (self.pair[0], *self.rigid.values())
        if len(self._runs_by_model(key.experiment, *needed)) == len(needed):
            self._draw_levels(key.experiment)

    def build_pictures(self) -> Pictures:
        """The pictures of every experiment that both engines ran, in the order of their names."""
        experiments = sorted({key.experiment for key in self.runs})
        both = [name for name in experiments if len(self._runs_by_model(name, *self.pair)) == 2]
        for name in both:
            self._draw_levels(name)
        levels = {name: self.levels[name] for name in both if name in self.levels}
        if not both:
            return Pictures(levels)
        from crosscheck.report.plots.figures import draw_run_comparison

        models = (*self.pair, *model_names("form")[-1:], *self.rigid.values())
        shown = {name: self._runs_by_model(name, *models) for name in both if levels.get(name)}
        shown = shown or {name: self._runs_by_model(name, *models) for name in both}
        longest = max(shown, key=lambda name: float(shown[name][self.pair[0]]["time"][-1]))
        still = draw_run_comparison(*(shown[longest][model] for model in self.pair))
        return Pictures(levels, tuple(collect_signals(self.pair[0], shown)), still, longest)

    def _runs_by_model(self, experiment: str, *models: str) -> dict[str, xr.Dataset]:
        """The runs of an experiment by these models, by model, as far as there are any."""
        keys = {model: RunKey(experiment, model) for model in models}
        return {model: self.runs[key] for model, key in keys.items() if key in self.runs}

    def _draw_levels(self, experiment: str) -> None:
        """Draw an experiment's rigid levels, unless they are drawn or none was run."""
        from crosscheck.report.plots.figures import draw_level_deviations

        level_runs = self._runs_by_model(experiment, *self.rigid.values())
        if level_runs and experiment not in self.levels:
            by_level = {level: level_runs[m] for level, m in self.rigid.items() if m in level_runs}
            geared = self.runs[RunKey(experiment, self.pair[0])]
            self.levels[experiment] = draw_level_deviations(geared, by_level)
