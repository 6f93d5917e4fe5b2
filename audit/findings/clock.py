"""The clock test: a mechanism cannot know what time it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from crosscheck import signals
from crosscheck.analytic.kernel.batch import Batch
from crosscheck.analytic.model import AnalyticModel, PhysicalModel
from crosscheck.audit.experiments.ensembles import EnsembleQuestion, rigid_course
from crosscheck.audit.experiments.paper_conditions import LABELLED, LAWS, Condition, Law
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.measures.rigid import rigid_arm
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.audit.measures.undefined import JsonObject, float_or_none, to_json
from crosscheck.models.loading import load_arm
from crosscheck.signals import envelope
from crosscheck.studies.members.starts import perturb_start

CLOCKS_S = (0.0, 1.0, 5.0, 20.0)
RUN_S, RUN_ZETA = 0.8, 0.02
RUN_WINDOW_S = (0.45, 0.79)  # the side change is over, and the third fluctuation not begun
RUN_STARTS = 8  # a block of the kernel
RECORD_EVERY = 5  # steps of 10 us
CHUNK = 2000  # records at a time, which stay in a processor's cache
BINS = 400  # of what is kept for a drawing


class RecordedMotion(NamedTuple):
    """Records of runs: elapsed (times,) [s] since their start; q, v, a (times, n, members)."""

    elapsed: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray


def simulate_motion(models: Sequence[AnalyticModel], clock_s: float = 0.0) -> RecordedMotion:
    """The runs of models of one structure, the clock at ``clock_s``, whole steps, at the start.

    States after one that is not finite are not either.
    """
    batch, scenario = Batch(models), models[0].scenario
    batch.step_count = round(clock_s / scenario.step_s)
    with np.errstate(invalid="ignore", over="ignore"):  # of runs that diverge
        parts = list(batch.run(scenario.steps // scenario.stride, scenario.stride, CHUNK))
    q, v, a = (np.concatenate([part[k] for part in parts]) for k in range(3))
    return RecordedMotion(scenario.step_s * scenario.stride * np.arange(len(q)), q, v, a)


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
class ClockTest(EnsembleQuestion[list[DelayResult]]):
    """A question: what a variant, run from rest, makes of every delay of CLOCKS_S."""

    def answer(self) -> list[DelayResult]:
        models = [PhysicalModel(*perturb_start(self.case(), seed)) for seed in self.seeds]
        theta, delays = models[0].layout.theta[0], list[DelayResult]()
        runs = [simulate_motion(models, clock) for clock in CLOCKS_S]
        elapsed, rigid = runs[0].elapsed, rigid_course(rigid_arm(self.variant))
        rigid_shoulder = np.interp(elapsed, rigid.time, rigid.theta_ddot[:, 0])
        part = signals.window(elapsed, *RUN_WINDOW_S)
        for clock, run in zip(CLOCKS_S, runs, strict=True):
            shoulder = run.a[:, theta]
            excess = (shoulder - rigid_shoulder[:, None])[part]
            sizes = tuple(float_or_none(signals.amplitude(start)) for start in excess.T)
            same = bool(np.array_equal(shoulder, runs[0].a[:, theta]))
            inside = elapsed[part], shoulder[part, 0]
            band = envelope(*inside, BINS) if inside[0].size else [np.empty(0)] * 3
            drawn = SignalEnvelope(*(tuple(values.tolist()) for values in band))
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
    run_s = scale.limit_duration(RUN_S)
    variants = {
        law: replace(
            Condition(law, RUN_ZETA).variant(), duration_s=run_s, record_every=RECORD_EVERY
        )
        for law in LAWS
    }
    questions = {law: ClockTest(variant, seeds) for law, variant in variants.items()}
    delays_by_law = study.answer_by_key(questions, "clock test")
    return ClockTestResult([LawClockTest(law, delays) for law, delays in delays_by_law.items()])


def largest_force_change() -> float:
    """The most [N] by which another clock can change a planet's mesh force through e = E sin(phi).

    The phase goes from where e is E to where it is -E, at the mean stiffness: 2 E k_m.
    """
    stage = paper_stage(load_arm(LABELLED))
    return 2 * stage.tooth_error_m * stage.mesh_stiffness_N_per_m
