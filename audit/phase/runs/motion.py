"""The analytic model with what its scenario fixes set free: the clock."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.kernel.batch import Batch, Records
from crosscheck.analytic.model import PhysicalModel
from crosscheck.models.loading import Case

CHUNK = 2000  # records at a time, which stay in a processor's cache


class RecordedMotion(NamedTuple):
    """Records of runs: time (times,) [s] by the law's own clock; q, v, a (times, n, members).

    theta (joints,): which coordinates the joints' angles are.
    """

    time: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    theta: np.ndarray

    @property
    def shoulder(self) -> np.ndarray:
        """Its acceleration [rad/s^2], (times, members)."""
        return self.a[:, self.theta[0]]


class Continued(PhysicalModel):
    """The model from any state q, v (n,)."""

    def __init__(self, case: Case, q: np.ndarray, v: np.ndarray) -> None:
        super().__init__(*case)
        self.state = q, v

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        return self.state


def motion(models: Sequence[PhysicalModel], clock_s: float = 0.0) -> RecordedMotion:
    """The runs of models of one structure, the clock at ``clock_s``, whole steps, at the start.

    States after one that is not finite are not either.
    """
    scenario = models[0].scenario
    begun = round(clock_s / scenario.step_s)
    with np.errstate(invalid="ignore", over="ignore"):  # of runs that diverge
        parts = list(_parts(models, begun))
    steps = begun + scenario.stride * np.arange(scenario.steps // scenario.stride + 1)
    q, v, a = (np.concatenate([part[k] for part in parts]) for k in range(3))
    return RecordedMotion(scenario.step_s * steps, q, v, a, np.array(models[0].layout.theta))


def _parts(models: Sequence[PhysicalModel], begun: int) -> Iterator[Records]:
    batch, scenario = Batch(models), models[0].scenario
    batch.done = begun
    yield from batch.run(scenario.steps // scenario.stride, scenario.stride, CHUNK)
