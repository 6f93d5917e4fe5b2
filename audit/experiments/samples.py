"""The experiments of all settings, each from many starts: numbers for claims, figures and fits."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from crosscheck.audit.experiments.ensembles import EnsembleNumbers
from crosscheck.audit.experiments.experiments import PaperExperiment, build_question
from crosscheck.audit.experiments.paper_conditions import Condition
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.judging.quantities import Sample
from crosscheck.audit.judging.rule import Answer, Limits, Place, collect_answer
from crosscheck.audit.measures.thresholds import SEVERE

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
