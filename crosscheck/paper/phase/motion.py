"""The analytic model on its specialised kernel with what its scenario fixes set free: the clock."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from analytic.fast.batch import Batch, Records
from analytic.model import PhysicalModel
from models.loading import Case

CHUNK = 2000  # records at a time, which stay in a processor's cache


class Motion(NamedTuple):
    """Records of a run: time (times,) [s] by the law's own clock; q, v, a (times, n)."""

    time: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray


class Continued(PhysicalModel):
    """The model from any state q, v (n,)."""

    def __init__(self, case: Case, q: np.ndarray, v: np.ndarray) -> None:
        super().__init__(*case)
        self.state = q, v

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        return self.state


def motion(model: PhysicalModel, clock_s: float = 0.0) -> Motion:
    """The model's run, the clock at ``clock_s``, a whole number of steps, at the start.

    States after one that is not finite are not either.
    """
    scenario, begun = model.scenario, round(clock_s / model.scenario.step_s)
    with np.errstate(invalid="ignore", over="ignore"):  # of a run that diverges
        parts = list(_parts(model, begun))
    steps = begun + scenario.stride * np.arange(scenario.steps // scenario.stride + 1)
    q, v, a = (np.concatenate([part[k][:, :, 0] for part in parts]) for k in range(3))
    return Motion(scenario.step_s * steps, q, v, a)


def _parts(model: PhysicalModel, begun: int) -> Iterator[Records]:
    batch, scenario = Batch([model]), model.scenario
    batch.done = begun
    yield from batch.run(scenario.steps // scenario.stride, scenario.stride, CHUNK)
