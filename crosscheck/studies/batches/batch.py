"""One batch of a study: consecutive members run side by side, and what is measured of them."""

from __future__ import annotations

import gc
from collections.abc import Iterable, Sequence
from functools import lru_cache
from importlib import import_module
from typing import TYPE_CHECKING, cast

import numpy as np
import xarray as xr

from crosscheck.models.errors import Diverged
from crosscheck.models.loading import Case
from crosscheck.registry import build, reference_model, second_engine
from crosscheck.studies.definition.quantities import SIGNALS
from crosscheck.studies.measures.columns import DIVERGED, columns
from crosscheck.studies.measures.observers import ChunkRecords, Watched, observer
from crosscheck.studies.members.members import PreparedStudy, study_of

if TYPE_CHECKING:
    from crosscheck.analytic.model import AnalyticModel

Numbers = dict[str, np.ndarray]  # by column, (members, *the column's shape)


def run_batch(text: str, begin: int, end: int) -> Numbers:
    """The numbers of a study's members from one place to before another, by column.

    text: ``PreparedStudy.text``. All numbers of a member that diverged are nan, but the time at
    which it did. Raises InputError.
    """
    from crosscheck.analytic.ensemble import groups

    study = study_of(text)
    cases = list(study.cases(begin, end))
    numbers = _nothing(study, len(cases))
    for group in groups(models_of(cases)):
        mine = list(group.members)
        with np.errstate(invalid="ignore", over="ignore"):  # of members that diverge
            found = _watch(study, [cases[member] for member in mine], group.chunks())
        for name, values in found.items():
            numbers[name][mine] = values
        gone = np.array(mine)[~np.isnan(group.diverged_s)]
        for values in numbers.values():
            values[gone] = np.nan
        numbers[DIVERGED][mine] = group.diverged_s
    return numbers


def run_check(text: str, place: int) -> Numbers:
    """The numbers of one member's run by a second engine, by column; nan if it diverged.

    Raises InputError.
    """
    study = study_of(text)
    (case,) = study.cases(place, place + 1)
    numbers = _nothing(study, 1)
    try:
        run = build(second_engine(), *case).simulate()
    except Diverged as error:
        numbers[DIVERGED][0] = error.time_s
        return numbers
    return numbers | _watch(study, [case], [_AsChunk(run)])


def models_of(cases: Sequence[Case]) -> list[AnalyticModel]:
    """The reference model of each case; their kernels run side by side. Raises InputError."""
    return [cast("AnalyticModel", build(reference_model(), *case)) for case in cases]


@lru_cache
def made_ready() -> None:
    """Prepare a worker for its batches, once: import what they need, out of the collector's sight.

    The collector would go through a million objects of the libraries again and again (measured:
    5 %).
    """
    import_module("crosscheck.analytic.ensemble")
    gc.freeze()


class _AsChunk:
    """A whole run as the only chunk of a group of one."""

    def __init__(self, run: xr.Dataset) -> None:
        self.run, self.time = run, run["time"].values

    def __getattr__(self, name: str) -> np.ndarray:
        if name not in SIGNALS:
            raise AttributeError(name)
        if name not in self.run:  # an arm without meshes
            return np.full((self.time.size, self.run.sizes["joint"], 1, 1), np.nan)
        return self.run[name].values[..., np.newaxis]


def _nothing(study: PreparedStudy, members: int) -> Numbers:
    return {c.name: np.full((members, *c.shape), np.nan) for c in columns(study)}


def _watch(study: PreparedStudy, cases: list[Case], chunks: Iterable[ChunkRecords]) -> Numbers:
    watched = Watched(cases, study.sources, study.file)
    watching = [observer(quantity, watched) for quantity in study.definition.quantities]
    for chunk in chunks:
        for one in watching:
            one.see(chunk)
    return {name: values for one in watching for name, values in one.found().items()}
