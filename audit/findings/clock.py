"""The clock test: a mechanism cannot know what time it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from crosscheck import signals
from crosscheck.audit.experiments.motion import (
    build_models,
    build_pd_variant,
    shoulder_excess,
    simulate_motion,
)
from crosscheck.audit.experiments.paper_conditions import LABELLED, LAWS, Condition, Law
from crosscheck.audit.experiments.question import Question, Records
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.audit.measures.undefined import JsonObject, float_or_none, to_json
from crosscheck.models.loading import load_arm
from crosscheck.signals import envelope

CLOCKS_S = (0.0, 1.0, 5.0, 20.0)
RUN_S, RUN_ZETA = 0.8, 0.02
RUN_WINDOW_S = (0.45, 0.79)  # the side change is over, and the third fluctuation not begun
RUN_STARTS = 8  # a block of the kernel
BINS = 400  # of what is kept for a drawing


class SignalEnvelope(NamedTuple):
    """A fast signal for a drawing: smallest and largest value of bins at times [s]."""

    time_s: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]


@dataclass(frozen=True)
class DelayResult:
    """What one delay of the clock makes of runs from one set of starts.

    vibration_rad_per_s2: of every start's run, None where it diverged or is too short; same:
    whether the runs are bit for bit those with the clock from 0; shoulder: the first start's
    acceleration [rad/s^2] in RUN_WINDOW_S.
    """

    clock_s: float
    vibration_rad_per_s2: tuple[float | None, ...]
    same: bool
    shoulder: SignalEnvelope


@dataclass(frozen=True)
class ClockTest(Question[list[DelayResult]]):
    """A question: what a law makes of every delay of CLOCKS_S, planets free."""

    cost = 6.0

    law: Law
    run_s: float
    seeds: tuple[int, ...]

    @property
    def run(self) -> Variant:
        """The variant whose runs start from rest."""
        return build_pd_variant(Condition(self.law, RUN_ZETA), self.run_s)

    def records(self) -> Records:
        return self.run.case()

    def answer(self) -> list[DelayResult]:
        models = build_models(self.run, self.seeds)
        runs = [simulate_motion(models, clock) for clock in CLOCKS_S]
        delays = []
        for clock, run in zip(CLOCKS_S, runs, strict=True):
            part = signals.window(run.elapsed_s, *RUN_WINDOW_S)
            excess = shoulder_excess(self.run, run.elapsed_s, run.shoulder)[part]
            sizes = tuple(float_or_none(signals.amplitude(start)) for start in excess.T)
            same = bool(np.array_equal(run.shoulder, runs[0].shoulder))
            inside = run.elapsed_s[part], run.shoulder[part, 0]
            band = envelope(*inside, BINS) if inside[0].size else [np.empty(0)] * 3
            drawn = SignalEnvelope(*(tuple(map(float, values)) for values in band))
            delays.append(DelayResult(clock, sizes, same, drawn))
        return delays


@dataclass(frozen=True)
class LawClockTest:
    """The results of one law at every delay."""

    law: Law
    delays: Sequence[DelayResult]

    @property
    def blind(self) -> bool:
        """Whether no run depends on the time."""
        return all(delay.same for delay in self.delays)

    def to_dict(self) -> JsonObject:
        """The results as a JSON object."""
        largest = {f"{x.clock_s:g}": x.vibration_rad_per_s2 for x in self.delays}
        where = f"finding/clock/{self.law.id}"
        return to_json({"id": where, "blind": self.blind, "vibration_rad_per_s2": largest})


@dataclass(frozen=True)
class ClockTestResult:
    """The clock test of all three laws."""

    laws: Sequence[LawClockTest]

    @property
    def supports(self) -> bool:
        """Whether both of the paper's laws know the time and the integral does not."""
        return all(law_test.blind == (law_test.law.phase == "angle") for law_test in self.laws)


def run_clock_test(study: Study, scale: Scale) -> ClockTestResult:
    """The clock test: runs from rest with the clock at 0, 1, 5 and 20 s."""
    seeds = scale.seeds[: scale.limit_starts(RUN_STARTS)]
    questions = {law: ClockTest(law, scale.limit_duration(RUN_S), seeds) for law in LAWS}
    delays_by_law = study.answer_by_key(questions, "clock test")
    return ClockTestResult([LawClockTest(law, delays) for law, delays in delays_by_law.items()])


def largest_force_change() -> float:
    """The most [N] by which another clock can change a planet's mesh force through e = E sin(phi).

    The phase goes from where e is E to where it is -E, at the mean stiffness: 2 E k_m.
    """
    stage = paper_stage(load_arm(LABELLED))
    return 2 * stage.tooth_error_m * stage.mesh_stiffness_N_per_m
