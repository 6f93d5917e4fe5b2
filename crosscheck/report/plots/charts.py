"""The report's charts of each experiment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import xarray as xr

from crosscheck.planning.plan import sort_engines
from crosscheck.registry import RIGID_LEVELS, find_same_integrator_models, model_names
from crosscheck.report.plots.figures import draw_level_deviations, draw_run_comparison
from crosscheck.report.plots.signals import Signals, collect_signals
from crosscheck.runner.outcomes import Failure
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


def draw_pictures(runs: Mapping[RunKey, xr.Dataset | Failure]) -> Pictures:
    """The pictures of every experiment that both engines ran, in the order of their names."""
    pair = find_same_integrator_models()[:2]
    rigid = {level: sort_engines(level)[0] for level in RIGID_LEVELS}
    models = (*pair, *model_names("form")[-1:], *rigid.values())
    shown, levels = dict[str, dict[str, xr.Dataset]](), dict[str, str]()
    for name in sorted({key.experiment for key in runs}):
        outcomes = {model: runs.get(RunKey(name, model)) for model in models}
        by_model = {model: run for model, run in outcomes.items() if isinstance(run, xr.Dataset)}
        if not by_model.keys() >= {*pair}:
            continue
        shown[name] = by_model
        by_level = {level: by_model[m] for level, m in rigid.items() if m in by_model}
        if by_level:
            levels[name] = draw_level_deviations(by_model[pair[0]], by_level)
    if not shown:
        return Pictures(levels)
    shown = {name: shown[name] for name in levels} or shown
    longest = max(shown, key=lambda name: float(shown[name][pair[0]]["time"][-1]))
    still = draw_run_comparison(*(shown[longest][model] for model in pair))
    return Pictures(levels, tuple(collect_signals(pair[0], shown)), still, longest)
