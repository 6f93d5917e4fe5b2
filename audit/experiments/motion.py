"""Runs that no scenario file can state: another clock, another start."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.signal import butter, sosfiltfilt

from crosscheck.analytic.kernel.batch import Batch
from crosscheck.analytic.model import AnalyticModel, PhysicalModel
from crosscheck.audit.experiments.paper_conditions import PRINTED, REPAIRED_RATE, Condition, Law
from crosscheck.audit.experiments.variant import Variant, simulate
from crosscheck.audit.measures.rigid import rigid_arm
from crosscheck.studies.members.starts import perturb_start

CHUNK = 2000  # records at a time, which stay in a processor's cache
HIGH_PASS_HZ = 600.0  # between the controlled arm's motion and the mesh modes
ORDER = 12  # each way: 1.7 kHz leaks less than 1e-5 through 3 kHz
FILTER_SAMPLES = 3 * (ORDER + 1)  # by which the filter continues a signal at either end
FILTER_EDGE_S = 0.02  # of the record's ends, which the filter does not see whole
RECORD_EVERY = 5  # steps of 10 us
# Where every start with the law's ring rate, or some with the paper's, is severe.
DECISIVE = (Condition(PRINTED, 0.005), Condition(REPAIRED_RATE, 0.02))


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
    def elapsed_s(self) -> np.ndarray:
        """Time since the motion's start, (times,) [s]."""
        return self.time - self.time[0]

    @property
    def shoulder(self) -> np.ndarray:
        """The shoulder's acceleration [rad/s^2], (times, members)."""
        return self.a[:, self.theta[0]]


def simulate_motion(models: Sequence[AnalyticModel], clock_s: float = 0.0) -> RecordedMotion:
    """The runs of models of one structure, the clock at ``clock_s``, whole steps, at the start.

    States after one that is not finite are not either.
    """
    batch, scenario = Batch(models), models[0].scenario
    batch.step_count = begun = round(clock_s / scenario.step_s)
    with np.errstate(invalid="ignore", over="ignore"):  # of runs that diverge
        parts = list(batch.run(scenario.steps // scenario.stride, scenario.stride, CHUNK))
    steps = begun + scenario.stride * np.arange(scenario.steps // scenario.stride + 1)
    q, v, a = (np.concatenate([part[k] for part in parts]) for k in range(3))
    return RecordedMotion(scenario.step_s * steps, q, v, a, np.array(models[0].layout.theta))


def use_integral_phase(cell: Condition) -> Condition:
    """The setting with the phase as an integral, at its own ring rate."""
    return replace(cell, law=Law("angle", cell.law.ring_rate))


def build_pd_variant(cell: Condition, duration_s: float) -> Variant:
    """The PD run of a setting, recorded at 20 kHz."""
    return replace(cell.variant(), duration_s=duration_s, record_every=RECORD_EVERY)


def build_models(variant: Variant, seeds: Sequence[int]) -> list[PhysicalModel]:
    """The analytic models of a variant from the starts with these seeds."""
    case = variant.case()
    return [PhysicalModel(*perturb_start(case, seed)) for seed in seeds]


def shoulder_excess(variant: Variant, elapsed: np.ndarray, theta_ddot: np.ndarray) -> np.ndarray:
    """Shoulder accelerations (times, members) [rad/s^2] less the rigid arm's at these times."""
    rigid = _cached_simulate(rigid_arm(variant))
    rigid_acceleration = np.interp(elapsed, rigid["time"].values, rigid["theta_ddot"].values[:, 0])
    return theta_ddot - rigid_acceleration[:, None]


_cached_simulate = lru_cache(maxsize=8)(simulate)


def vibration(time: np.ndarray, values: np.ndarray, above_hz: float = HIGH_PASS_HZ) -> np.ndarray:
    """The fast part of a signal (times, ...): Butterworth, forth and back.

    For what is too small to be seen beside a rigid arm, whose teeth are not pressed in. Undefined,
    all nan, for one that is too short for the filter.
    """
    if len(values) <= FILTER_SAMPLES:
        return np.full(values.shape, np.nan)
    rate = round(1 / (time[1] - time[0]))
    sections = butter(ORDER, above_hz, "highpass", fs=rate, output="sos")
    return sosfiltfilt(sections, values, axis=0)
