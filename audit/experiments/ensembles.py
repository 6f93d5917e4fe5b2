"""One experiment in one setting from many starts, and whole runs.

The starts differ by next to nothing. No single run shows whether its behaviour depends
on that difference.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Sequence
from copy import copy
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import Any, NamedTuple, TypeVar

import numpy as np

from crosscheck.analytic.model import AnalyticModel
from crosscheck.audit.experiments.pd import measure_transient_pd, measure_whole_pd
from crosscheck.audit.experiments.study import Question, Records, Study, raise_if_diverged
from crosscheck.audit.experiments.torque import measure_back_and_forth, measure_constant_torque
from crosscheck.audit.experiments.variant import (
    PERTURBATION_M,
    Numbers,
    Variant,
    perturb_start,
    remove_gears,
    rigid_arm,
)
from crosscheck.audit.measures.run_signals import RunSignals, extract_signals, simulate_signals
from crosscheck.models.errors import Diverged
from crosscheck.models.interface import Model
from crosscheck.models.trajectory import recorded_times
from crosscheck.registry import RIGID_LEVELS, build, get_entry

AT_ONCE = 16  # runs in memory: about 100 MB
FIRST = 8  # starts that are run before it is asked whether more could tell anything else
ALIKE = 1e-3  # relative: starts that agree so well have grown their 1e-12 m by less than 1e5
# Numbers that show the perturbation itself, whatever comes of it.
PERTURBATION_ITSELF = ("planets_apart_m", "force_at_start_N")
ResultT = TypeVar("ResultT")
RIGID_SHIFT_RAD = 1e-6  # small enough to stay in proportion for 2 s
SHORT_S = 1.2  # Fig. 14's length
SLOW_RECORD_S = 1e-4  # constant torque and back and forth: nothing fast decides there
RECORDED_S = 5e-5  # 13 samples of a period at 1.5 kHz, 4 at the highest mesh mode


class EnsembleNumbers(NamedTuple):
    """Every start's numbers by name, None where undefined, and when its run diverged [s], or None.

    A start that diverged has no numbers: all are None. ran: how many starts were run; where the
    first FIRST agree they stand for all others, in turns.
    """

    numbers: dict[str, list[float | None]]
    diverged_s: list[float | None]
    ran: int


@dataclass(frozen=True)
class EnsembleQuestion(Question[ResultT]):
    """A question about a variant that is run from starts perturbed by these seeds."""

    variant: Variant
    seeds: tuple[int, ...]

    @property
    def model_names(self) -> tuple[str, ...]:
        """The name of the variant's model."""
        return (self.variant.model,)

    def records(self) -> Records:
        return self.variant.case()

    @property
    def cost(self) -> float:
        """Estimated cost [s], measures included."""
        steps, entry = self.variant.case().scenario.steps, get_entry(self.variant.model)
        return len(self.seeds) * steps * entry.call_s / entry.abreast


@dataclass(frozen=True)
class EnsembleNumbersQuestion(EnsembleQuestion[EnsembleNumbers]):
    """A question: numbers of whole runs of a kind from every start, beside rigid arms.

    runs: one of RUNS; apart_m: by how much at most every mesh starts elsewhere.
    """

    runs: str = "transient"
    apart_m: float = PERTURBATION_M

    @property
    def model_names(self) -> tuple[str, ...]:
        """Names of the models of the runs and of the rigid arms beside them."""
        return (*super().model_names, *(rigid.model for rigid in self.rigid_variants))

    @property
    def rigid_variants(self) -> Sequence[Variant]:
        """The variants of the rigid arms that the runs are compared with."""
        return RUNS[self.runs].find_rigid(self.variant)

    def models(self, seeds: Sequence[int]) -> Sequence[Model]:
        """Models that run from the starts with these seeds."""
        case = self.variant.case()
        cases = [perturb_start(case, seed, self.apart_m) for seed in seeds]
        model = build(self.variant.model, *case)
        if not isinstance(model, AnalyticModel):
            return [build(self.variant.model, *each) for each in cases]
        restarted = []
        for _, scenario, _ in cases:  # they share all but the start with the first
            other = copy(model)
            other.scenario, other.equations = scenario, model.equations
            restarted.append(other)
        return restarted

    def answer(self) -> EnsembleNumbers:
        starts = self._measure_starts(self.seeds[:FIRST])
        if len(self.seeds) > FIRST and not are_alike(collect_numbers(starts, len(starts))):
            starts += self._measure_starts(self.seeds[FIRST:])
        return collect_numbers(starts, len(self.seeds))

    def _measure_starts(self, seeds: Sequence[int]) -> list[Numbers | Diverged]:
        """Numbers of all starts with these seeds, each of which is run."""
        models, starts = self.models(seeds), list[Numbers | Diverged]()
        measure = RUNS[self.runs].measure
        times = recorded_times(self.variant.case().scenario)
        rigid = [rigid_course(each).at(times) for each in self.rigid_variants]
        for first in range(0, len(models), AT_ONCE):
            for run in run_side_by_side(models[first : first + AT_ONCE]):
                starts.append(run if isinstance(run, Diverged) else measure(run, *rigid))
        return starts


def collect_numbers(starts: Sequence[Numbers | Diverged], count: int) -> EnsembleNumbers:
    """The numbers of so many starts, for which those that were run stand in turns."""
    numbers = [{} if isinstance(start, Diverged) else start for start in starts]
    diverged = [start.time_s if isinstance(start, Diverged) else None for start in starts]
    turns = [place % len(starts) for place in range(count)]
    names = dict.fromkeys(name for start in numbers for name in start)
    return EnsembleNumbers(
        {name: [numbers[turn].get(name) for turn in turns] for name in names},
        [diverged[turn] for turn in turns],
        len(starts),
    )


def are_alike(ensemble_numbers: EnsembleNumbers) -> bool:
    """Whether no run diverged and every number is the same in all starts, to ALIKE of its size.

    The motion is then a smooth function of its start, and further starts as near give the same.
    """
    if any(time is not None for time in ensemble_numbers.diverged_s):
        return False
    for name, values in ensemble_numbers.numbers.items():
        defined = [value for value in values if value is not None]
        if name in PERTURBATION_ITSELF or not defined:
            continue
        span, size = float(np.ptp(defined)), float(np.abs(defined).max())
        if len(defined) < len(values) or span > ALIKE * size:
            return False
    return True


def find_coupled_arm(variant: Variant) -> Sequence[Variant]:
    """The rigid arm with all that gears bring along."""
    return [rigid_arm(variant)]


def find_all_levels(variant: Variant) -> Sequence[Variant]:
    """The rigid arm at every level."""
    return [rigid_arm(variant, level) for level in RIGID_LEVELS]


def find_shifted_pair(variant: Variant) -> Sequence[Variant]:
    """The rigid arm at the geared one's step, and another that starts a little away.

    The torque's infinite slope at t = 0 then costs geared and rigid arm the same and drops out.
    """
    rigid = remove_gears(variant)
    shift = f"scenario.start.theta_rad={RIGID_SHIFT_RAD!r}"
    return rigid, replace(rigid, settings=(*rigid.settings, shift))


class RunKind(NamedTuple):
    """How experiments are run and measured, and beside which rigid arms.

    duration_s: None for the scenario's own.
    """

    scenario: str
    measure: Callable[..., Numbers]
    find_rigid: Callable[[Variant], Sequence[Variant]] = find_coupled_arm
    duration_s: float | None = None
    record_s: float = SLOW_RECORD_S


RUNS = {
    "transient": RunKind("pd", measure_transient_pd, duration_s=SHORT_S, record_s=RECORDED_S),
    "whole": RunKind("pd", measure_whole_pd, record_s=RECORDED_S),
    "torque": RunKind("constant-torque", measure_constant_torque, find_all_levels),
    "swing": RunKind("back-and-forth", measure_back_and_forth, find_shifted_pair),
}


@lru_cache(maxsize=16)
def rigid_course(variant: Variant) -> RunSignals:
    """The course of a rigid arm's run. Raises Diverged."""
    (run,) = run_side_by_side([build(variant.model, *variant.case())])
    return raise_if_diverged(run)


def run_side_by_side(models: Sequence[Model]) -> list[RunSignals | Diverged]:
    """Runs of models of one kind, in their order, or why there is none."""
    analytic = [model for model in models if isinstance(model, AnalyticModel)]
    if analytic:
        return simulate_signals(analytic)
    results = list[RunSignals | Diverged]()
    for model in models:
        try:
            results.append(extract_signals(model.simulate()))
        except Diverged as error:
            results.append(error)
    return results


COURSES_AT_ONCE = 8  # runs in one question: as many as a kernel steps side by side


@dataclass(frozen=True)
class CoursesQuestion(Question[list[RunSignals]]):
    """A question: the courses of variants, those of equal analytic models stepped side by side."""

    variants: tuple[Variant, ...]

    @property
    def model_names(self) -> tuple[str, ...]:
        """The names of the variants' models."""
        return tuple(dict.fromkeys(variant.model for variant in self.variants))

    @property
    def cost(self) -> float:
        """Estimated cost [s]."""
        return sum(v.case().scenario.steps * get_entry(v.model).call_s for v in self.variants)

    def records(self) -> Records:
        return [record for variant in self.variants for record in variant.case()]

    def answer(self) -> list[RunSignals]:
        models = [build(variant.model, *variant.case()) for variant in self.variants]
        return list(map(raise_if_diverged, run_side_by_side(models)))

    def encode(self, answer: list[RunSignals]) -> bytes:
        """The courses' signals as an NPZ file: JSON takes too long."""
        content = io.BytesIO()
        arrays: dict[str, Any] = {
            f"{place}/{name}": getattr(run, name)
            for place, run in enumerate(answer)
            for name in SIGNALS
        }
        np.savez(content, **arrays)
        return content.getvalue()

    def decode(self, content: bytes) -> list[RunSignals]:
        """The courses from their signals and the variants' inputs."""
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            return [
                RunSignals(variant.case(), **{n: file[f"{place}/{n}"][()] for n in SIGNALS})
                for place, variant in enumerate(self.variants)
            ]


SIGNALS = [field.name for field in fields(RunSignals) if field.name != "case"]


def simulate_courses(
    study: Study, variants: Iterable[Variant], label: str
) -> dict[Variant, RunSignals]:
    """The courses of variants, made or read. Raises Diverged if one diverges."""
    every = list(dict.fromkeys(variants))
    parts = [
        tuple(every[first : first + COURSES_AT_ONCE])
        for first in range(0, len(every), COURSES_AT_ONCE)
    ]
    answers = study.answer_questions([CoursesQuestion(part) for part in parts], label)
    courses = [course for answer in answers for course in answer]
    return dict(zip(every, courses, strict=True))
