"""The clock test: a mechanism cannot know what time it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from crosscheck import signals
from crosscheck.analytic.kernel.batch import Batch, Records
from crosscheck.analytic.model import AnalyticModel, PhysicalModel
from crosscheck.audit.experiments.ensembles import EnsembleQuestion, rigid_course
from crosscheck.audit.experiments.paper_conditions import LABELLED, LAWS, Condition, Law
from crosscheck.audit.experiments.samples import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import perturb_start, rigid_arm
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.audit.measures.undefined import JsonObject, float_or_none
from crosscheck.models.loading import load_arm
from crosscheck.models.trajectory import recorded_times
from crosscheck.signals import envelope

CLOCKS_S = (0.0, 1.0, 5.0, 20.0)
RUN_S, RUN_ZETA = 0.8, 0.02
RUN_WINDOW_S = (0.45, 0.79)  # the side change is over, and the third fluctuation not begun
RUN_STARTS = 8  # a block of the kernel
RECORD_EVERY = 5  # steps of 10 us
CHUNK = 2000  # records at a time, which stay in a processor's cache
BINS = 400  # of what is kept for a drawing


def simulate_motion(models: Sequence[AnalyticModel], clock_s: float = 0.0) -> Records:
    """The runs of models of one structure, the clock at ``clock_s``, whole steps, at the start.

    States after one that is not finite are not either.
    """
    batch, scenario = Batch(models), models[0].scenario
    batch.step_count = round(clock_s / scenario.step_s)
    with np.errstate(invalid="ignore", over="ignore"):  # of runs that diverge
        parts = list(batch.run(scenario.steps // scenario.stride, scenario.stride, CHUNK))
    return Records(*(np.concatenate(each) for each in zip(*parts, strict=True)))


@dataclass(frozen=True)
class DelayResult:
    """What one delay of the clock makes of runs from one set of starts.

    vibration_rad_per_s2: of every start's run, None where it diverged or is too short; same:
    whether the runs are bit for bit those with the clock from 0; shoulder: the first start's
    acceleration [rad/s^2] in RUN_WINDOW_S for a drawing: times [s], least and largest of bins.
    """

    clock_s: float
    vibration_rad_per_s2: tuple[float | None, ...]
    same: bool
    shoulder: tuple[list[float], list[float], list[float]]


@dataclass(frozen=True)
class ClockTest(EnsembleQuestion[list[DelayResult]]):
    """A question: what a variant, run from rest, makes of every delay of CLOCKS_S."""

    def answer(self) -> list[DelayResult]:
        models = [PhysicalModel(*perturb_start(self.variant.case(), seed)) for seed in self.seeds]
        theta = models[0].layout.theta[0]
        runs = [simulate_motion(models, clock).a[:, theta] for clock in CLOCKS_S]
        elapsed, rigid = recorded_times(models[0].scenario), rigid_course(rigid_arm(self.variant))
        rigid_shoulder = np.interp(elapsed, rigid.time, rigid.theta_ddot[:, 0])
        part = signals.window(elapsed, *RUN_WINDOW_S)
        delays = []
        for clock, shoulder in zip(CLOCKS_S, runs, strict=True):
            excess = (shoulder - rigid_shoulder[:, None])[part]
            sizes = tuple(float_or_none(signals.amplitude(start)) for start in excess.T)
            same = bool(np.array_equal(shoulder, runs[0]))
            inside = elapsed[part], shoulder[part, 0]
            time, low, high = envelope(*inside, BINS) if inside[0].size else [np.empty(0)] * 3
            drawn = time.tolist(), low.tolist(), high.tolist()
            delays.append(DelayResult(clock, sizes, same, drawn))
        return delays


@dataclass(frozen=True)
class ClockTestResult:
    """The clock test of all three laws: the results at every delay."""

    delays_by_law: Mapping[Law, Sequence[DelayResult]]

    @property
    def blind(self) -> dict[Law, bool]:
        """Whether no run of a law depends on the time."""
        return {law: all(each.same for each in d) for law, d in self.delays_by_law.items()}

    @property
    def supports(self) -> bool:
        """Whether both of the paper's laws know the time and the integral does not."""
        return all(blind == (law.phase == "angle") for law, blind in self.blind.items())

    def to_dicts(self) -> list[JsonObject]:
        """The results of each law as a JSON object."""
        return [
            {
                "id": f"finding/clock/{law.id}",
                "blind": self.blind[law],
                "vibration_rad_per_s2": {
                    f"{each.clock_s:g}": each.vibration_rad_per_s2 for each in delays
                },
            }
            for law, delays in self.delays_by_law.items()
        ]


def run_clock_test(study: Study, scale: Scale) -> ClockTestResult:
    """The clock test: runs from rest with the clock at 0, 1, 5 and 20 s."""
    seeds = scale.seeds[:RUN_STARTS]
    run_s, questions = scale.limit_duration(RUN_S), {}
    for law in LAWS:
        variant = Condition(law, RUN_ZETA).variant()
        variant = replace(variant, duration_s=run_s, record_every=RECORD_EVERY)
        questions[law] = ClockTest(variant, seeds)
    return ClockTestResult(study.answer_by_key(questions, "clock test"))


def largest_force_change() -> float:
    """The most [N] by which another clock can change a planet's mesh force through e = E sin(phi).

    The phase goes from where e is E to where it is -E, at the mean stiffness: 2 E k_m.
    """
    stage = paper_stage(load_arm(LABELLED))
    return 2 * stage.tooth_error_m * stage.mesh_stiffness_N_per_m
