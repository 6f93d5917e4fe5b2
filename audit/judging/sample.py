"""What an experiment measured, start by start."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Sample:
    """What the starts of an experiment measured.

    numbers: name -> (starts,), nan where undefined; diverged (starts,): whether the run did;
    not_run: of the last starts, those that others stand for, so that start i of one experiment has
    a start i of another beside it; they are no evidence, and never counted.
    """

    numbers: Mapping[str, np.ndarray]
    diverged: np.ndarray
    not_run: int = 0

    @property
    def run(self) -> int:
        """How many starts were run."""
        return self.diverged.size - self.not_run

    def __getitem__(self, name: str) -> np.ndarray:
        """A number of every start, (starts,). Raises KeyError for one that is not measured."""
        if self.diverged.all():
            return np.full(self.diverged.shape, math.nan)
        return self.numbers[name]
