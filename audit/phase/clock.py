"""Evidence 1: the clock test. A mechanism cannot know what time it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from crosscheck import signals
from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.experiments.paper_conditions import LAWS, Condition, Law
from crosscheck.audit.experiments.question import Question, Records
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.undefined import float_or_none
from crosscheck.audit.phase.linear import compute_base_motion
from crosscheck.audit.phase.runs import (
    build_models,
    build_pd_variant,
    build_plant,
    shoulder_excess,
    simulate_motion,
)
from crosscheck.signals import envelope

CLOCKS_S = (0.0, 1.0, 5.0, 20.0)
MOTION_S, RUN_S = 1.2, 0.8
RUN_ZETA = 0.02
RUN_WINDOW_S = (0.45, 0.79)  # the side change is over, and the third fluctuation not begun
RUN_STARTS = 8  # a block of the kernel
EVERY = 10  # steps of the motion that is taken as given: 0.1 ms
BINS = 400  # of what is kept for a drawing
CLOCK_N = 1e-9  # rounding of mesh forces of some 1e3 N, with room


class SignalEnvelope(NamedTuple):
    """A fast signal for a drawing: smallest and largest value of bins at times [s]."""

    time_s: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]

    @classmethod
    def from_signal(cls, time: np.ndarray, values: np.ndarray) -> SignalEnvelope:
        """The envelope of values (times,) at times [s]."""
        return cls(*(tuple(map(float, part)) for part in envelope(time, values, BINS)))


@dataclass(frozen=True)
class DelayResult:
    """Results of the clock test at one delay: one motion, and runs from one set of starts.

    largest_change_N: of any mesh force along the motion, against the clock from 0; largest_force_N:
    along it with the clock from 0; vibration_rad_per_s2: of every start's run, None where it
    diverged or is too short; same: whether the runs are bit for bit those with the clock from 0;
    force_N, shoulder: F_sp1 along the motion, the first start's acceleration [rad/s^2].
    """

    clock_s: float
    largest_change_N: float
    largest_force_N: float
    vibration_rad_per_s2: tuple[float | None, ...]
    same: bool
    force_N: SignalEnvelope
    shoulder: SignalEnvelope


@dataclass(frozen=True)
class ClockTest(Question[list[DelayResult]]):
    """A question: what a law makes of every delay of CLOCKS_S. It needs no knowledge of D."""

    cost = 8.0

    law: Law
    motion_s: float
    run_s: float
    seeds: tuple[int, ...]

    @property
    def run(self) -> Variant:
        """The variant whose runs start from rest, planets free."""
        return build_pd_variant(Condition(self.law, RUN_ZETA), self.run_s)

    def records(self) -> Records:
        return self.run.case()

    def answer(self) -> list[DelayResult]:
        # The controlled arm's own motion under this law from clock 0, without vibration: teeth are
        # pressed in as it needs, all planets of a stage alike. Damping is no part of it.
        lumped = Variant(
            phase=self.law.phase, ring_rate=self.law.ring_rate, duration_s=self.motion_s
        )
        plant = build_plant(PhysicalModel(*lumped.case()))
        along = compute_base_motion(lumped.case(), plant, EVERY)
        forces = []  # elastic, per planet [N], (times, meshes), by clock
        for clock in CLOCKS_S:
            states = zip(along.time + clock, along.q, along.v, strict=True)
            forces.append(np.array([plant.states.evaluate(*state).mesh_forces for state in states]))
        models = build_models(self.run, self.seeds)
        runs = [simulate_motion(models, clock) for clock in CLOCKS_S]
        excess = [
            shoulder_excess(self.run, x.elapsed_s, x.shoulder)[
                signals.window(x.elapsed_s, *RUN_WINDOW_S)
            ]
            for x in runs
        ]
        return [
            DelayResult(
                clock_s=clock,
                largest_change_N=float(np.abs(force - forces[0]).max()),
                largest_force_N=float(np.abs(forces[0]).max()),
                vibration_rad_per_s2=tuple(float_or_none(signals.amplitude(x)) for x in left.T),
                same=bool(np.array_equal(run.shoulder, runs[0].shoulder)),
                force_N=SignalEnvelope.from_signal(along.time, force[:, 0]),
                shoulder=SignalEnvelope.from_signal(run.elapsed_s, run.shoulder[:, 0]),
            )
            for clock, force, run, left in zip(CLOCKS_S, forces, runs, excess, strict=True)
        ]


@dataclass(frozen=True)
class LawClockTest:
    """The results of one law at every delay."""

    law: Law
    delays: Sequence[DelayResult]

    @property
    def blind(self) -> bool:
        """Whether no mesh force depends on the time."""
        return all(delay.largest_change_N <= CLOCK_N for delay in self.delays)


@dataclass(frozen=True)
class ClockTestResult:
    """The clock test of all three laws."""

    laws: Sequence[LawClockTest]

    @property
    def supports(self) -> bool:
        """Whether both of the paper's laws know the time and the integral does not."""
        return all(law_test.blind == (law_test.law.phase == "angle") for law_test in self.laws)


def run_clock_test(study: Study, scale: Scale) -> ClockTestResult:
    """The clock test: forces along one motion and runs from rest, clock at 0, 1, 5 and 20 s."""
    lasting = scale.limit_duration(MOTION_S), scale.limit_duration(RUN_S)
    seeds = scale.seeds[: scale.limit_starts(RUN_STARTS)]
    questions = {law: ClockTest(law, *lasting, seeds) for law in LAWS}
    delays_by_law = study.answer_by_key(questions, "phase: clock test")
    return ClockTestResult([LawClockTest(law, delays) for law, delays in delays_by_law.items()])
