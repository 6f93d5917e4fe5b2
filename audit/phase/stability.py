"""Evidence 4: the mesh modes linearised along the motion, and the onset that they predict.

While every tooth is in contact, differences between planets obey an equation of their own (Hill's,
see ``planets.hill``), so the motion that the planets share is linearised as if they were one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d

from crosscheck import signals
from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.experiments.ensembles import EnsembleQuestion
from crosscheck.audit.experiments.paper_conditions import Condition
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.measures.events import THIRD_S
from crosscheck.audit.measures.shares import Share, share_of
from crosscheck.audit.measures.undefined import quotient
from crosscheck.audit.phase import linear, runs
from crosscheck.audit.phase.clock import SignalEnvelope

CELLS = tuple(cell for item in runs.DECISIVE for cell in (item, runs.use_integral_phase(item)))
DURATION_S = THIRD_S[1]
BEGIN_S = 0.45  # after the teeth have changed sides; from here on contact is assumed
BETWEEN_MODES_HZ = 3000.0  # each joint has a mesh mode below and one above
ENVELOPE_S = 4e-3  # window of the running maximum
WORTH_TELLING = 2.0  # e-folds
SAMPLES = 12  # of the Jacobian's comparison with differences
STARTS = 8  # a block of the kernel
EVERY, QUICK_EVERY = 5, 20  # of the base motion's steps
RUNS_EVERY = 2  # 50 kHz: what grows from 1e-13 rad/s^2 must not be another frequency's alias
ONSET_RAD_PER_S2 = 3.0  # a hundredth of the paper's 300: where a growing vibration counts as begun
ONSET_WITHIN = 0.05  # relative error of the predicted onset
DRAWN = 300  # instants of a drawing


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


class TimeCurve(NamedTuple):
    """A curve of values (instants,) at times [s]."""

    time_s: tuple[float, ...]
    values: tuple[float, ...]

    @classmethod
    def from_values(cls, time: np.ndarray, values: np.ndarray) -> TimeCurve:
        """The curve of values (times,) at times [s]."""
        return cls(tuple(map(float, time)), tuple(map(float, values)))


@dataclass(frozen=True)
class LinearisationResult:
    """What linear theory says of a setting, and what its starts do.

    largest: None for a run that ends before; onsets: of every start that does not diverge and lasts
    long enough. Drawn: growth of the least stable mode [1/s], frequencies [Hz] and where they grow,
    the first start's vibration, simulated and predicted [rad/s^2], and its acceleration.
    """

    largest: LargestGrowth | None
    intervals: tuple[linear.Interval, ...]
    onsets: tuple[Onset, ...]
    jacobian_error: float
    growth: TimeCurve
    frequencies: tuple[TimeCurve, ...]
    unstable: tuple[tuple[bool, ...], ...]
    simulated: TimeCurve
    predicted: TimeCurve
    shoulder: SignalEnvelope

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
        plant = runs.build_plant(PhysicalModel(*case))
        base = linear.compute_base_motion(case, plant, self.every)
        modes = linear.compute_mesh_modes(plant, base)
        unstable = linear.find_unstable_intervals(base.time, modes, WORTH_TELLING)
        run = runs.simulate_motion(runs.build_models(self.variant, self.seeds))
        followed = [_follow(base, modes, run.time, item) for item in run.shoulder.T]
        (_, simulated, predicted), thin = followed[0], max(1, base.time.size // DRAWN)
        largest, part = None, signals.window(base.time, *THIRD_S)
        if part.stop > part.start:
            peak = part.start + int(np.argmax(modes.largest_growth[part]))
            mode = int(np.argmax(modes.growth[peak]))
            numbers = modes.largest_growth[peak], base.time[peak], modes.frequency[peak, mode]
            largest = LargestGrowth(*map(float, numbers))
        return LinearisationResult(
            largest=largest,
            intervals=tuple(item for item in unstable if item.end > THIRD_S[0]),
            onsets=tuple(begun for begun, _, _ in followed if begun is not None),
            jacobian_error=linear.jacobian_error(plant, base, SAMPLES),
            growth=TimeCurve.from_values(base.time[::thin], modes.largest_growth[::thin]),
            frequencies=tuple(
                TimeCurve.from_values(base.time[::thin], x[::thin]) for x in modes.frequency.T
            ),
            unstable=tuple(tuple(map(bool, grows[::thin])) for grows in (modes.growth > 0).T),
            simulated=simulated,
            predicted=predicted,
            shoulder=SignalEnvelope.from_signal(run.time, run.shoulder[:, 0]),
        )


def _follow(
    base: linear.BaseMotion, modes: linear.Modes, time: np.ndarray, shoulder: np.ndarray
) -> tuple[Onset | None, TimeCurve, TimeCurve]:
    """Onset of one start, its vibration simulated, and predicted from BEGIN_S on.

    Every mode starts from the simulated vibration at BEGIN_S and never falls below its smallest
    value after; those above 3 kHz, which decay faster, from that above 3 kHz. None and no
    prediction if the run diverged or ends before.
    """
    part, seen = (
        signals.window(x, BEGIN_S, end)
        for x, end in ((base.time, DURATION_S), (time, DURATION_S - runs.FILTER_EDGE_S))
    )
    ahead, simulated = base.time[part], vibration_envelope(time, shoulder)
    fast = modes.frequency.mean(axis=0) > BETWEEN_MODES_HZ
    whole, high = simulated[seen], vibration_envelope(time, shoulder, BETWEEN_MODES_HZ)[seen]
    if not whole.size or not np.isfinite((whole[0], high[0])).all():
        return None, _peak_curve(time, simulated), TimeCurve((), ())
    first = np.where(fast, high[0], whole[0])
    floor = np.where(fast, high.min(), whole.min())
    predicted = linear.predicted_amplitude(ahead, modes.growth[part], first, floor)
    begun = Onset(_onset(ahead, predicted), _onset(time, simulated))
    return begun, _peak_curve(time, simulated), _peak_curve(ahead, predicted)


def vibration_envelope(
    time: np.ndarray, values: np.ndarray, above_hz: float = runs.HIGH_PASS_HZ
) -> np.ndarray:
    """Running maximum, over 4 ms, of the magnitude of a signal's fast part, (times,)."""
    size = round(ENVELOPE_S / (time[1] - time[0]))
    return maximum_filter1d(np.abs(runs.vibration(time, values, above_hz)), size)


def _onset(time: np.ndarray, values: np.ndarray) -> float | None:
    """Time [s] from 0.5 s on at which a vibration first counts as begun; None for never."""
    part = signals.window(time, THIRD_S[0], DURATION_S - runs.FILTER_EDGE_S)
    return signals.crossing_time_above(time[part], values[part], ONSET_RAD_PER_S2)


def _peak_curve(time: np.ndarray, values: np.ndarray) -> TimeCurve:
    """The largest value of every bin as a curve; empty where the signal is undefined."""
    if not time.size or not np.isfinite(values).all():
        return TimeCurve((), ())
    band = SignalEnvelope.from_signal(time, values)
    return TimeCurve(band.time_s, band.high)


@dataclass(frozen=True)
class Stability:
    """The results of every setting, linearised and simulated."""

    cells: dict[Condition, LinearisationResult]

    def largest_growth(self, phase: str) -> float | None:
        """The largest growth [1/s] over all settings of a phase law; None if undefined in all."""
        peaks = [item.largest for cell, item in self.cells.items() if cell.law.phase == phase]
        return max((item.growth_per_s for item in peaks if item is not None), default=None)

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


def run_stability_test(study: Study, scale: Scale) -> Stability:
    """Growth rates against time under both laws, with predicted and simulated onsets."""
    every, seeds = (
        (QUICK_EVERY if scale.quick else EVERY),
        scale.seeds[: scale.limit_starts(STARTS)],
    )
    questions = {}
    for cell in CELLS:
        variant = replace(
            runs.build_pd_variant(cell, scale.limit_duration(DURATION_S)), record_every=RUNS_EVERY
        )
        questions[cell] = Linearisation(variant, seeds, every)
    return Stability(study.answer_by_key(questions, "phase: stability"))
