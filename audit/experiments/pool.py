"""The experiments of all settings, each from many starts: numbers for claims, figures and fits."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from crosscheck.audit.experiments.cells import Cell
from crosscheck.audit.experiments.experiments import Source, question
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.starts import Measured
from crosscheck.audit.experiments.study import Study


@dataclass(frozen=True)
class Sample:
    """What the starts of an experiment measured.

    numbers: name -> (starts,), nan where undefined; diverged (starts,): whether the run did;
    not_run: of the last starts, those that others stand for.
    """

    numbers: Mapping[str, np.ndarray]
    diverged: np.ndarray
    not_run: int = 0

    @classmethod
    def of(cls, measured: Measured) -> Sample:
        """The sample of what was measured, with undefined numbers as nan."""
        numbers = {name: np.array(values, float) for name, values in measured.numbers.items()}
        diverged = np.isfinite(np.array(measured.diverged_s, float))
        return cls(numbers, diverged, diverged.size - measured.ran)

    def __getitem__(self, name: str) -> np.ndarray:
        """A number of every start, (starts,). Raises KeyError for one that is not measured."""
        if self.diverged.all():
            return np.full(self.diverged.shape, math.nan)
        return self.numbers[name]


Wanted = tuple[Cell, Source]


def samples(
    study: Study, scale: Scale, wanted: Iterable[Wanted], what: str
) -> dict[Wanted, Sample]:
    """The sample of every experiment in its setting from the scale's starts, run or read."""
    # Laws in turns, so that two processes seldom compile one kernel at a time.
    unlike = sorted(dict.fromkeys(wanted), key=lambda pair: (pair[0].zeta, str(pair[1])))
    asked = [question(source, cell, scale.seeds) for cell, source in unlike]
    cut = [replace(one, variant=scale.cut(one.variant)) for one in asked]
    found = study.answers(cut, what)
    return {pair: Sample.of(one) for pair, one in zip(unlike, found, strict=True)}
