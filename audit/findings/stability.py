"""The mesh modes linearised along the motion, and the onset that they predict.

While every tooth is in contact, differences between planets obey an equation of their own, so the
motion that the planets share is linearised as if they were one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.signal import butter, sosfiltfilt

from crosscheck import signals
from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.experiments.ensembles import EnsembleQuestion
from crosscheck.audit.experiments.paper_conditions import DECISIVE, Condition
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.findings import linear
from crosscheck.audit.judging.shares import Share, share_of
from crosscheck.audit.measures.events import THIRD_S
from crosscheck.audit.measures.undefined import JsonObject, quotient
from crosscheck.models.errors import Diverged

CELLS = tuple(cell for item in DECISIVE for cell in (item, item.use_integral_phase()))
DURATION_S = THIRD_S[1]
BEGIN_S = 0.45  # after the teeth have changed sides; from here on contact is assumed
HIGH_PASS_HZ = 600.0  # between the controlled arm's motion and the mesh modes
BETWEEN_MODES_HZ = 3000.0  # each joint has a mesh mode below and one above
ORDER = 12  # each way: 1.7 kHz leaks less than 1e-5 through 3 kHz
FILTER_SAMPLES = 3 * (ORDER + 1)  # by which the filter continues a signal at either end
FILTER_EDGE_S = 0.02  # of the record's ends, which the filter does not see whole
ENVELOPE_S = 4e-3  # window of the running maximum
STARTS = 8  # a block of the kernel
EVERY, QUICK_EVERY = 5, 20  # of the base motion's steps
RUNS_EVERY = 2  # 50 kHz: what grows from 1e-13 rad/s^2 must not be another frequency's alias
ONSET_RAD_PER_S2 = 3.0  # a hundredth of the paper's 300: where a growing vibration counts as begun
ONSET_WITHIN = 0.05  # relative error of the predicted onset


class Onset(NamedTuple):
    """Times [s] at which one start's vibration begins, predicted and simulated; None: never."""

    predicted_s: float | None
    simulated_s: float | None

    @property
    def as_predicted(self) -> bool:
        """Whether it never begins in both, or begins in both at nearly the same time."""
        if self.predicted_s is None or self.simulated_s is None:
            return self.predicted_s is self.simulated_s
        return abs(quotient(self.predicted_s, self.simulated_s) - 1) <= ONSET_WITHIN


@dataclass(frozen=True)
class LinearisationResult:
    """What linear theory says of a setting's starts, and what they do.

    onsets: of every start that does not diverge and lasts long enough.
    """

    onsets: tuple[Onset, ...]

    @property
    def as_predicted(self) -> Share | None:
        """The share of starts whose onset is foretold."""
        return share_of(onset.as_predicted for onset in self.onsets)

    @property
    def begins(self) -> Share | None:
        """The share of starts in which a vibration begins."""
        return share_of(onset.simulated_s is not None for onset in self.onsets)


@dataclass(frozen=True)
class Linearisation(EnsembleQuestion[LinearisationResult]):
    """A question: the modes along the variant's motion, all planets alike, and its runs."""

    cost = 4.0

    every: int

    def answer(self) -> LinearisationResult:
        model = PhysicalModel(*replace(self.variant, planets="lumped").case())
        base = linear.compute_base_motion(model, self.every)
        modes = linear.compute_mesh_modes(model, base)
        onsets = [
            find_onset(base, modes, run.time, run.theta_ddot[:, 0])
            for run in self._runs(self.seeds)
            if not isinstance(run, Diverged)
        ]
        return LinearisationResult(tuple(filter(None, onsets)))


def find_onset(
    base: linear.BaseMotion, modes: linear.Modes, time: np.ndarray, shoulder: np.ndarray
) -> Onset | None:
    """The onset of one start, simulated and predicted from BEGIN_S on; None if it ends before.

    Every mode starts from the simulated vibration at BEGIN_S and never falls below its smallest
    value after; those above 3 kHz, which decay faster, from that above 3 kHz.
    """
    part, seen = (
        signals.window(x, BEGIN_S, end)
        for x, end in ((base.time, DURATION_S), (time, DURATION_S - FILTER_EDGE_S))
    )
    simulated = find_vibration_envelope(time, shoulder)
    fast = modes.frequency.mean(axis=0) > BETWEEN_MODES_HZ
    whole, high = (
        values[seen]
        for values in (simulated, find_vibration_envelope(time, shoulder, BETWEEN_MODES_HZ))
    )
    if not whole.size or not np.isfinite((whole[0], high[0])).all():
        return None
    first = np.where(fast, high[0], whole[0])
    floor = np.where(fast, high.min(), whole.min())
    ahead = base.time[part]
    predicted = linear.predicted_amplitude(ahead, modes.growth[part], first, floor)
    return Onset(_find_beginning(ahead, predicted), _find_beginning(time, simulated))


def find_vibration_envelope(
    time: np.ndarray, values: np.ndarray, above_hz: float = HIGH_PASS_HZ
) -> np.ndarray:
    """Running maximum, over 4 ms, of the magnitude of a signal's fast part, (times,).

    For what is too small to be seen beside a rigid arm, whose teeth are not pressed in. Undefined,
    all nan, for a signal that is too short for the filter: Butterworth's, forth and back.
    """
    if len(values) <= FILTER_SAMPLES:
        return np.full(values.shape, np.nan)
    step_s = time[1] - time[0]
    sections = butter(ORDER, above_hz, "highpass", fs=round(1 / step_s), output="sos")
    return maximum_filter1d(np.abs(sosfiltfilt(sections, values)), round(ENVELOPE_S / step_s))


def _find_beginning(time: np.ndarray, values: np.ndarray) -> float | None:
    """Time [s] from 0.5 s on at which a vibration first counts as begun; None for never."""
    part = signals.window(time, THIRD_S[0], DURATION_S - FILTER_EDGE_S)
    return signals.crossing_time_above(time[part], values[part], ONSET_RAD_PER_S2)


@dataclass(frozen=True)
class Stability:
    """The results of every setting, linearised and simulated."""

    cells: dict[Condition, LinearisationResult]

    @property
    def supports(self) -> bool | None:
        """Whether onsets are foretold, and are in all starts of `omega_t`, in none of `angle`."""
        answers: list[bool] = []
        for cell, linearised in self.cells.items():
            if linearised.as_predicted is None or linearised.begins is None:
                return None
            begun = linearised.begins.yes == (
                linearised.begins.of if cell.law.phase == "omega_t" else 0
            )
            answers += [linearised.as_predicted.yes == linearised.as_predicted.of, begun]
        return all(answers)

    def to_dicts(self) -> list[JsonObject]:
        """The settings as JSON objects."""
        return [
            {
                "id": f"finding/stability/{cell.id}",
                "begins": str(item.begins),
                "as_predicted": str(item.as_predicted),
            }
            for cell, item in self.cells.items()
        ]


def run_stability_test(study: Study, scale: Scale) -> Stability:
    """Growth rates against time under both laws, with predicted and simulated onsets."""
    every = QUICK_EVERY if scale.quick else EVERY
    seeds = scale.seeds[: scale.limit_starts(STARTS)]
    duration_s = scale.limit_duration(DURATION_S)
    variants = {
        cell: replace(cell.variant(), duration_s=duration_s, record_every=RUNS_EVERY)
        for cell in CELLS
    }
    questions = {cell: Linearisation(variants[cell], seeds, every) for cell in CELLS}
    return Stability(study.answer_by_key(questions, "stability"))
