"""The mesh modes linearised along the motion, and the onset that they predict.

While every tooth is in contact, differences between planets obey an equation of their own, so the
motion that the planets share is linearised as if they were one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d

from crosscheck import signals
from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.experiments import motion
from crosscheck.audit.experiments.ensembles import EnsembleQuestion
from crosscheck.audit.experiments.paper_conditions import Condition
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.findings import linear
from crosscheck.audit.judging.shares import Share, share_of
from crosscheck.audit.measures.events import THIRD_S
from crosscheck.audit.measures.undefined import JsonObject, quotient

CELLS = tuple(cell for item in motion.DECISIVE for cell in (item, motion.use_integral_phase(item)))
DURATION_S = THIRD_S[1]
BEGIN_S = 0.45  # after the teeth have changed sides; from here on contact is assumed
BETWEEN_MODES_HZ = 3000.0  # each joint has a mesh mode below and one above
ENVELOPE_S = 4e-3  # window of the running maximum
STARTS = 8  # a block of the kernel
EVERY, QUICK_EVERY = 5, 20  # of the base motion's steps
RUNS_EVERY = 2  # 50 kHz: what grows from 1e-13 rad/s^2 must not be another frequency's alias
ONSET_RAD_PER_S2 = 3.0  # a hundredth of the paper's 300: where a growing vibration counts as begun
ONSET_WITHIN = 0.05  # relative error of the predicted onset


class LargestGrowth(NamedTuple):
    """The moment at which the least stable mode grows most, from 0.5 to 1.2 s."""

    growth_per_s: float
    at_s: float
    frequency_Hz: float


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
    """What linear theory says of a setting, and what its starts do.

    largest: None for a run that ends before; onsets: of every start that does not diverge and lasts
    long enough.
    """

    largest: LargestGrowth | None
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
        case = replace(self.variant, planets="lumped").case()
        plant = linear.build_plant(PhysicalModel(*case))
        base = linear.compute_base_motion(case, plant, self.every)
        modes = linear.compute_mesh_modes(plant, base)
        run = motion.simulate_motion(motion.build_models(self.variant, self.seeds))
        onsets = [find_onset(base, modes, run.time, start) for start in run.shoulder.T]
        largest, part = None, signals.window(base.time, *THIRD_S)
        if part.stop > part.start:
            peak = part.start + int(np.argmax(modes.largest_growth[part]))
            mode = int(np.argmax(modes.growth[peak]))
            numbers = modes.largest_growth[peak], base.time[peak], modes.frequency[peak, mode]
            largest = LargestGrowth(*map(float, numbers))
        return LinearisationResult(largest, tuple(filter(None, onsets)))


def find_onset(
    base: linear.BaseMotion, modes: linear.Modes, time: np.ndarray, shoulder: np.ndarray
) -> Onset | None:
    """The onset of one start, simulated and predicted from BEGIN_S on; None if it ends before.

    Every mode starts from the simulated vibration at BEGIN_S and never falls below its smallest
    value after; those above 3 kHz, which decay faster, from that above 3 kHz.
    """
    part, seen = (
        signals.window(x, BEGIN_S, end)
        for x, end in ((base.time, DURATION_S), (time, DURATION_S - motion.FILTER_EDGE_S))
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
    time: np.ndarray, values: np.ndarray, above_hz: float = motion.HIGH_PASS_HZ
) -> np.ndarray:
    """Running maximum, over 4 ms, of the magnitude of a signal's fast part, (times,)."""
    size = round(ENVELOPE_S / (time[1] - time[0]))
    return maximum_filter1d(np.abs(motion.vibration(time, values, above_hz)), size)


def _find_beginning(time: np.ndarray, values: np.ndarray) -> float | None:
    """Time [s] from 0.5 s on at which a vibration first counts as begun; None for never."""
    part = signals.window(time, THIRD_S[0], DURATION_S - motion.FILTER_EDGE_S)
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
                "largest_growth_per_s": item.largest and item.largest.growth_per_s,
                "frequency_Hz": item.largest and item.largest.frequency_Hz,
                "begins": str(item.begins),
                "as_predicted": str(item.as_predicted),
            }
            for cell, item in self.cells.items()
        ]


def run_stability_test(study: Study, scale: Scale) -> Stability:
    """Growth rates against time under both laws, with predicted and simulated onsets."""
    every, seeds = (
        (QUICK_EVERY if scale.quick else EVERY),
        scale.seeds[: scale.limit_starts(STARTS)],
    )
    questions = {}
    for cell in CELLS:
        variant = motion.build_pd_variant(cell, scale.limit_duration(DURATION_S))
        questions[cell] = Linearisation(replace(variant, record_every=RUNS_EVERY), seeds, every)
    return Stability(study.answer_by_key(questions, "stability"))
