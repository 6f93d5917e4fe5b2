"""Evidence 5: the large vibration handed over to the other law, planets free."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from crosscheck import signals
from crosscheck.audit.experiments.cells import PRINTED, REPAIRED_RATE, Cell, Law
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.starts import Perturbed
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.measures import events, shares, third, thresholds
from crosscheck.audit.phase import runs
from crosscheck.audit.phase.clock import SignalEnvelope

# At the smallest damping the controller itself flutters; with the paper's ring rate few starts are
# severe, with the other all.
CELLS = (
    Cell(PRINTED, 0.003),
    Cell(PRINTED, 0.005),
    Cell(REPAIRED_RATE, 0.005),
    Cell(REPAIRED_RATE, 0.007),
    Cell(REPAIRED_RATE, 0.02),
)
SHOWN = CELLS[2]
AFTER_S = 0.4
# After the handover: what is handed over, what is left soon and late.
WINDOWS_S = ((0.0, 0.01), (0.03, 0.04), (0.33, 0.38))
Phase = Literal["omega_t", "angle"]
DEAD = 0.1  # of the vibration handed over


class Heir(NamedTuple):
    """A law under which the vibration goes on, with the tooth error or without."""

    phase: Phase
    with_error: bool = True

    @property
    def name(self) -> str:
        """The law's name in words."""
        return self.phase if self.with_error else f"{self.phase}, E = 0"


PRINTED_HEIR, INTEGRATED, ERROR_FREE = Heir("omega_t"), Heir("angle"), Heir("angle", False)
HEIRS = (PRINTED_HEIR, INTEGRATED, ERROR_FREE)


class Left(NamedTuple):
    """The vibration [rad/s^2] of one start under one heir: handed over, left soon, left late."""

    before: float
    soon: float
    late: float

    @property
    def dies(self) -> bool:
        """Whether the vibration falls to a tenth of what was handed over."""
        return self.late <= DEAD * self.before


@dataclass(frozen=True)
class HandedOver:
    """A setting's severe starts, each continued at the height of its vibration.

    asked: starts that do not diverge; at_s: of every severe one; left: by heir, in their order;
    drawn: the first severe start's acceleration under every heir.
    """

    asked: int
    at_s: tuple[float, ...]
    left: tuple[tuple[Left, ...], ...]
    drawn: tuple[SignalEnvelope, ...]


@dataclass(frozen=True)
class Handover(Perturbed[HandedOver]):
    """A question: what becomes of a setting's severe starts; variant: up to the third's end."""

    cost = 16.0

    cell: Cell
    after_s: float

    def answer(self) -> HandedOver:
        run = runs.motion(runs.models_of(self.variant, self.seeds))
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
            [self._continued(run, start, peak, heir) for start, peak in peaks.items()]
            for heir in HEIRS
        ]
        return HandedOver(
            asked=int(sound.sum()),
            at_s=tuple(float(run.time[peak]) for peak in peaks.values()),
            left=tuple(tuple(self._left(one) for one in each) for each in continued),
            drawn=tuple(
                SignalEnvelope.of(each[0].time, each[0].shoulder[:, 0])
                for each in continued
                if each
            ),
        )

    def _continued(
        self, run: runs.RecordedMotion, start: int, record: int, heir: Heir
    ) -> runs.RecordedMotion:
        """The run under an heir from a start's state at a record, the clock going on."""
        rate = self.cell.law.ring_rate if heir.phase == "omega_t" else "corrected"
        cell = Cell(Law(heir.phase, rate), self.cell.zeta, self.cell.arm)
        meshes = () if heir.with_error else (runs.NO_ERROR,)
        case = runs.pd_run(cell, self.after_s, *meshes).case()
        state = run.q[record, :, start].copy(), run.v[record, :, start].copy()
        return runs.motion([runs.Continued(case, *state)], float(run.time[record]))

    def _left(self, run: runs.RecordedMotion) -> Left:
        excess = self._excess(run)
        sizes = (signals.amplitude(excess[signals.window(run.elapsed, *w)]) for w in WINDOWS_S)
        return Left(*sizes)

    def _excess(self, run: runs.RecordedMotion) -> np.ndarray:
        """Shoulder acceleration [rad/s^2] less the whole rigid run's, (times, members)."""
        whole = replace(self.variant, duration_s=events.THIRD_S[1] + AFTER_S)
        return runs.shoulder_excess(whole, run.time, run.shoulder)


class Fate(NamedTuple):
    """The vibration [rad/s^2] of a setting's severe starts under an heir; dying: how many do."""

    cell: Cell
    heir: Heir
    asked: int
    before: third.Quantiles
    soon: third.Quantiles
    late: third.Quantiles
    dying: shares.Share | None

    @property
    def all_die(self) -> bool:
        """Whether there are severe starts, and the vibration of every one dies."""
        return self.dying is not None and self.dying.yes == self.dying.of


@dataclass(frozen=True)
class Handovers:
    """The fates of every setting under every heir."""

    fates: Sequence[Fate]
    shown: HandedOver

    def under(self, heir: Heir) -> dict[Cell, Fate]:
        """The fates under one heir, by setting."""
        return {fate.cell: fate for fate in self.fates if fate.heir == heir}

    @property
    def supports(self) -> bool | None:
        """Whether vibrations all die under `angle` wherever all do without tooth error, or None."""
        with_error, without = self.under(INTEGRATED), self.under(ERROR_FREE)
        dying = [with_error[cell].all_die for cell in without if without[cell].all_die]
        return all(dying) if dying else None


def handover(study: Study, scale: Scale) -> Handovers:
    """The fates of states at the height of the vibration, continued under each law."""
    third_s, after_s = scale.seconds(events.THIRD_S[1]), scale.seconds(AFTER_S)
    asked = {
        cell: Handover(runs.pd_run(cell, third_s), scale.seeds, cell, after_s) for cell in CELLS
    }
    found = study.answered(asked, "phase: handover")
    fates = []
    for cell, one in found.items():
        for heir, left in zip(HEIRS, one.left, strict=True):
            numbers = np.array(left, dtype=float).reshape(-1, len(WINDOWS_S))
            before, soon, late = map(third.quantiles, numbers.T)
            dying = shares.share_of(each.dies for each in left)
            fates.append(Fate(cell, heir, one.asked, before, soon, late, dying))
    return Handovers(fates, found[SHOWN])
