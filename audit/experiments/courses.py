"""Whole runs, for what is drawn and for what no measure of an experiment has."""

from __future__ import annotations

import io
from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from crosscheck.audit.experiments.ensembles import run_side_by_side
from crosscheck.audit.experiments.question import Question, Records
from crosscheck.audit.experiments.study import Study, raise_if_diverged
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.run_signals import RunSignals
from crosscheck.registry import build, get_entry

AT_ONCE = 8  # runs in one question: as many as a kernel steps side by side


@dataclass(frozen=True)
class CoursesQuestion(Question[list[RunSignals]]):
    """A question: the courses of variants, those of alike analytic models stepped side by side."""

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
    parts = [tuple(every[first : first + AT_ONCE]) for first in range(0, len(every), AT_ONCE)]
    answers = study.answer_questions([CoursesQuestion(part) for part in parts], label)
    courses = [course for answer in answers for course in answer]
    return dict(zip(every, courses, strict=True))
