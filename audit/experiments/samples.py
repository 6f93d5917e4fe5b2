"""How much of the study is run, and what its experiments measure from all starts."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from crosscheck.audit.experiments.ensembles import EnsembleNumbers
from crosscheck.audit.experiments.experiments import PaperExperiment, build_question
from crosscheck.audit.experiments.paper_conditions import Condition
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.judging.quantities import Sample
from crosscheck.audit.judging.rule import Answer, Limits, Place, collect_answer
from crosscheck.audit.measures.thresholds import SEVERE

STARTS = 32


@dataclass(frozen=True)
class Scale:
    """How much is run. longest_s: limit of mesh simulations.

    What a run is then too short for is undefined, in words and records. most_starts: of a sample;
    first_seed: of every sample's starts, whose seeds follow one another.
    """

    longest_s: float = math.inf
    most_starts: int = STARTS
    first_seed: int = 1

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds of a sample's starts."""
        return tuple(range(self.first_seed, self.first_seed + self.most_starts))

    def limit_duration(self, duration_s: float) -> float:
        """A duration [s], cut to longest_s."""
        return min(duration_s, self.longest_s)

    def cut(self, variant: Variant) -> Variant:
        """The variant with its run cut to longest_s."""
        if math.isinf(self.longest_s):
            return variant
        duration_s = variant.case().scenario.duration_s
        return replace(variant, duration_s=self.limit_duration(duration_s))


FULL = Scale()


SampleRequest = tuple[Condition, PaperExperiment]


def build_sample(ensemble_numbers: EnsembleNumbers) -> Sample:
    """The sample of what was measured, with undefined numbers as nan."""
    numbers = {name: np.array(values, float) for name, values in ensemble_numbers.numbers.items()}
    diverged = np.isfinite(np.array(ensemble_numbers.diverged_s, float))
    return Sample(numbers, diverged, diverged.size - ensemble_numbers.ran)


def collect_samples(
    study: Study, scale: Scale, requests: Iterable[SampleRequest], label: str
) -> dict[SampleRequest, Sample]:
    """The sample of every experiment in its setting from the scale's starts, run or read."""
    # Laws in turns, so that two processes seldom compile one kernel at a time.
    unlike = sorted(dict.fromkeys(requests), key=lambda pair: (pair[0].zeta, str(pair[1])))
    questions = [
        build_question(experiment, condition, scale.seeds) for condition, experiment in unlike
    ]
    cut = [replace(entry, variant=scale.cut(entry.variant)) for entry in questions]
    answers = study.answer_questions(cut, label)
    return {pair: build_sample(entry) for pair, entry in zip(unlike, answers, strict=True)}


def judge_third_fluctuation(*samples: Sample) -> Answer:
    """Whether the third fluctuation is severe: the answer of all starts of samples that were run.

    It is the number and the limit of claim 3.2-11.
    """
    sizes = np.concatenate([sample["third"][: sample.run] for sample in samples])
    return collect_answer(Place(), sizes, Limits(low=SEVERE))
