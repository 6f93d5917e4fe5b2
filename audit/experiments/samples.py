"""The experiments of all settings, each from many starts: numbers for claims, figures and fits."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from crosscheck.audit.experiments.ensembles import EnsembleNumbers
from crosscheck.audit.experiments.experiments import PaperExperiment, build_question
from crosscheck.audit.experiments.paper_conditions import Condition
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study


@dataclass(frozen=True)
class Sample:
    """What the starts of an experiment measured.

    numbers: name -> (starts,), nan where undefined; diverged (starts,): whether the run did;
    not_run: of the last starts, those that others stand for, so that start i of one experiment has
    a start i of another beside it; they are no evidence, and never counted.
    """

    numbers: Mapping[str, np.ndarray]
    diverged: np.ndarray
    not_run: int = 0

    @property
    def run(self) -> int:
        """How many starts were run."""
        return self.diverged.size - self.not_run

    @classmethod
    def from_numbers(cls, ensemble_numbers: EnsembleNumbers) -> Sample:
        """The sample of what was measured, with undefined numbers as nan."""
        numbers = {
            name: np.array(values, float) for name, values in ensemble_numbers.numbers.items()
        }
        diverged = np.isfinite(np.array(ensemble_numbers.diverged_s, float))
        return cls(numbers, diverged, diverged.size - ensemble_numbers.ran)

    def __getitem__(self, name: str) -> np.ndarray:
        """A number of every start, (starts,). Raises KeyError for one that is not measured."""
        if self.diverged.all():
            return np.full(self.diverged.shape, math.nan)
        return self.numbers[name]


SampleRequest = tuple[Condition, PaperExperiment]


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
    return {pair: Sample.from_numbers(entry) for pair, entry in zip(unlike, answers, strict=True)}
