"""Evidence 5: the large vibration under the other law, planets free."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from crosscheck import signals
from crosscheck.audit.experiments.ensembles import EnsembleQuestion
from crosscheck.audit.experiments.paper_conditions import PRINTED, REPAIRED_RATE, Condition, Law
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.measures import events, shares, third_fluctuation, thresholds
from crosscheck.audit.phase import runs
from crosscheck.audit.phase.clock import SignalEnvelope

# At the smallest damping the controller itself flutters; with the paper's ring rate few starts are
# severe, with the other all.
CELLS = (
    Condition(PRINTED, 0.003),
    Condition(PRINTED, 0.005),
    Condition(REPAIRED_RATE, 0.005),
    Condition(REPAIRED_RATE, 0.007),
    Condition(REPAIRED_RATE, 0.02),
)
SHOWN = CELLS[2]
AFTER_S = 0.4
# After the handover: what is handed over, what is left soon and late.
WINDOWS_S = ((0.0, 0.01), (0.03, 0.04), (0.33, 0.38))
Phase = Literal["omega_t", "angle"]
DEAD = 0.1  # of the vibration handed over


class LawAfterSwitch(NamedTuple):
    """A law under which the vibration goes on, with the tooth error or without."""

    phase: Phase
    with_error: bool = True

    @property
    def name(self) -> str:
        """The law's name in words."""
        return self.phase if self.with_error else f"{self.phase}, E = 0"


PRINTED_AFTER_SWITCH, INTEGRATED, ERROR_FREE = (
    LawAfterSwitch("omega_t"),
    LawAfterSwitch("angle"),
    LawAfterSwitch("angle", False),
)
LAWS_AFTER_SWITCH = (PRINTED_AFTER_SWITCH, INTEGRATED, ERROR_FREE)


class DecayAfterSwitch(NamedTuple):
    """The vibration [rad/s^2] of one start under one law: at the switch, soon after, late."""

    before: float
    soon: float
    late: float

    @property
    def dies(self) -> bool:
        """Whether the vibration falls to a tenth of what it was at the switch."""
        return self.late <= DEAD * self.before


@dataclass(frozen=True)
class LawSwitch:
    """A setting's severe starts, each continued at the height of its vibration.

    start_count: starts that do not diverge; at_s: of every severe one; decays: by heir, in their
    order; drawn: the first severe start's acceleration under every heir.
    """

    start_count: int
    at_s: tuple[float, ...]
    decays: tuple[tuple[DecayAfterSwitch, ...], ...]
    drawn: tuple[SignalEnvelope, ...]


@dataclass(frozen=True)
class Handover(EnsembleQuestion[LawSwitch]):
    """A question: what becomes of a setting's severe starts; variant: up to the third's end."""

    cost = 16.0

    cell: Condition
    after_s: float

    def answer(self) -> LawSwitch:
        run = runs.simulate_motion(runs.build_models(self.variant, self.seeds))
        excess = self._excess(run)
        sound = np.isfinite(excess).all(axis=0)
        part, size = signals.window(run.time, *events.THIRD_S), np.where(sound, np.abs(excess), 0.0)
        # Severe starts, and at which record each is largest.
        peaks = {
            start: part.start + int(np.argmax(size[part, start]))
            for start in range(sound.size)
            if part.stop > part.start and size[part, start].max() > thresholds.SEVERE
        }
        continued = [
            [self._resume_run(run, start, peak, law) for start, peak in peaks.items()]
            for law in LAWS_AFTER_SWITCH
        ]
        return LawSwitch(
            start_count=int(sound.sum()),
            at_s=tuple(float(run.time[peak]) for peak in peaks.values()),
            decays=tuple(
                tuple(self._measure_decay(motion) for motion in each) for each in continued
            ),
            drawn=tuple(
                SignalEnvelope.from_signal(each[0].time, each[0].shoulder[:, 0])
                for each in continued
                if each
            ),
        )

    def _resume_run(
        self, run: runs.RecordedMotion, start: int, record: int, law: LawAfterSwitch
    ) -> runs.RecordedMotion:
        """The run under an heir from a start's state at a record, the clock going on."""
        rate = self.cell.law.ring_rate if law.phase == "omega_t" else "corrected"
        cell = Condition(Law(law.phase, rate), self.cell.zeta, self.cell.arm)
        meshes = () if law.with_error else (runs.NO_ERROR,)
        case = runs.build_pd_variant(cell, self.after_s, *meshes).case()
        state = run.q[record, :, start].copy(), run.v[record, :, start].copy()
        return runs.simulate_motion([runs.ContinuedModel(case, *state)], float(run.time[record]))

    def _measure_decay(self, run: runs.RecordedMotion) -> DecayAfterSwitch:
        excess = self._excess(run)
        sizes = (signals.amplitude(excess[signals.window(run.elapsed_s, *w)]) for w in WINDOWS_S)
        return DecayAfterSwitch(*sizes)

    def _excess(self, run: runs.RecordedMotion) -> np.ndarray:
        """Shoulder acceleration [rad/s^2] less the whole rigid run's, (times, members)."""
        whole = replace(self.variant, duration_s=events.THIRD_S[1] + AFTER_S)
        return runs.shoulder_excess(whole, run.time, run.shoulder)


class SwitchOutcome(NamedTuple):
    """The vibration [rad/s^2] of a setting's severe starts under an heir; dying: how many do."""

    cell: Condition
    heir: LawAfterSwitch
    asked: int
    before: third_fluctuation.Quantiles
    soon: third_fluctuation.Quantiles
    late: third_fluctuation.Quantiles
    dying: shares.Share | None

    @property
    def is_decaying_in_all(self) -> bool:
        """Whether there are severe starts, and the vibration of every one dies."""
        return self.dying is not None and self.dying.yes == self.dying.of


@dataclass(frozen=True)
class HandoverResult:
    """The fates of every setting under every heir."""

    outcomes: Sequence[SwitchOutcome]
    shown: LawSwitch

    def select_law(self, law: LawAfterSwitch) -> dict[Condition, SwitchOutcome]:
        """The fates under one heir, by setting."""
        return {fate.cell: fate for fate in self.outcomes if fate.heir == law}

    @property
    def supports(self) -> bool | None:
        """Whether vibrations all die under `angle` wherever all do without tooth error, or None."""
        with_error, without = self.select_law(INTEGRATED), self.select_law(ERROR_FREE)
        dying = [
            with_error[cell].is_decaying_in_all
            for cell in without
            if without[cell].is_decaying_in_all
        ]
        return all(dying) if dying else None


def run_handover(study: Study, scale: Scale) -> HandoverResult:
    """The fates of states at the height of the vibration, continued under each law."""
    third_s, after_s = scale.limit_duration(events.THIRD_S[1]), scale.limit_duration(AFTER_S)
    questions = {
        cell: Handover(runs.build_pd_variant(cell, third_s), scale.seeds, cell, after_s)
        for cell in CELLS
    }
    results = study.answer_by_key(questions, "phase: handover")
    outcomes = []
    for cell, result in results.items():
        for law, decays in zip(LAWS_AFTER_SWITCH, result.decays, strict=True):
            numbers = np.array(decays, dtype=float).reshape(-1, len(WINDOWS_S))
            before, soon, late = map(third_fluctuation.quantiles, numbers.T)
            dying = shares.share_of(each.dies for each in decays)
            outcomes.append(SwitchOutcome(cell, law, result.start_count, before, soon, late, dying))
    return HandoverResult(outcomes, results[SHOWN])
