"""One batch of a study: consecutive members run side by side, and their quantities."""

from __future__ import annotations

import gc
from functools import lru_cache
from importlib import import_module

import numpy as np
import xarray as xr

from crosscheck import registry
from crosscheck.analytic.ensemble import group_models
from crosscheck.models.errors import Diverged
from crosscheck.studies.definition.quantities import MESH_SIGNALS, SIGNALS
from crosscheck.studies.measures.columns import DIVERGED, list_columns
from crosscheck.studies.measures.measurement import measure_members
from crosscheck.studies.members.members import PreparedStudy, load_study

Numbers = dict[str, np.ndarray]  # arrays (members, *the column's shape) by column


def run_batch(text: str, begin: int, end: int) -> Numbers:
    """The numbers of a study's members from one place to before another, by column.

    text: ``PreparedStudy.text``. All numbers of a member that diverged are nan, but the time at
    which it did. Raises InputError.
    """
    study = load_study(text)
    cases = list(study.cases(begin, end))
    numbers = _make_empty_numbers(study, len(cases))
    for group in group_models([case.make_model() for case in cases]):
        members = list(group.members)
        with np.errstate(invalid="ignore", over="ignore"):  # of members that diverge
            some = [cases[member] for member in members]
            values_by_column = measure_members(study, some, group.chunks())
        for name, values in values_by_column.items():
            numbers[name][members] = values
        gone = np.array(members)[~np.isnan(group.diverged_s)]
        for values in numbers.values():
            values[gone] = np.nan
        numbers[DIVERGED][members] = group.diverged_s
    return numbers


def run_check(text: str, place: int) -> Numbers:
    """The numbers of one member's run by a second engine, by column; nan if it diverged.

    Raises InputError.
    """
    study = load_study(text)
    (case,) = study.cases(place, place + 1)
    numbers = _make_empty_numbers(study, 1)
    try:
        run = registry.build(case.second_model, *case.experiment).simulate()
    except Diverged as error:
        numbers[DIVERGED][0] = error.time_s
        return numbers
    return numbers | measure_members(study, [case], [_RunChunk(run)])


@lru_cache
def prepare_worker() -> None:
    """Prepare a worker for its batches, once: import modules, and hide them from the collector.

    The collector would go through a million objects of the libraries again and again (measured:
    5 %).
    """
    import_module("crosscheck.analytic.robot.runs")
    gc.freeze()


class _RunChunk:
    """A whole run as the only chunk of a group of one."""

    def __init__(self, run: xr.Dataset) -> None:
        self.run, self.time = run, run["time"].values

    def __getattr__(self, name: str) -> np.ndarray:
        if name not in SIGNALS:
            raise AttributeError(name)
        if name not in self.run:  # without such meshes
            planet = (0,) if name in MESH_SIGNALS else ()
            return np.full((self.time.size, self.run.sizes["joint"], *planet, 1), np.nan)
        return self.run[name].values[..., np.newaxis]


def _make_empty_numbers(study: PreparedStudy, members: int) -> Numbers:
    return {c.name: np.full((members, *c.shape), np.nan) for c in list_columns(study)}
