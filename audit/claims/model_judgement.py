"""A claim's verdict by model of the gears: the paper's own, the gears as they are, and others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from crosscheck.audit.experiments.paper_conditions import LAW, MODELS, PLANETS, GearModel
from crosscheck.audit.judging import rule
from crosscheck.audit.judging.judgement import ClaimJudgement
from crosscheck.audit.judging.rule import Place, Verdict, VerdictKind


def model_of(place: Place) -> GearModel | None:
    """The model of the gears of the setting where an answer was found; None of a static claim."""
    values: dict[str, Any] = dict(place.conditions)
    return GearModel(values[LAW], *values[PLANETS]) if LAW in values else None


@dataclass(frozen=True)
class ModelJudgement(ClaimJudgement):
    """A claim and its answers in all settings of all models of the gears.

    variants: what those of VARIANTS say of it that were asked.
    """

    variants: Mapping[GearModel, VerdictKind] = field(default_factory=dict)

    @cached_property
    def by_model(self) -> dict[GearModel, Verdict]:
        """The verdict over the settings of each model of the gears; empty for a static claim."""
        if self.claim.static:
            return {}
        answers_by_model = {
            model: [a for a in self.answers if model_of(a.place) == model] for model in MODELS
        }
        return {
            model: rule.verdict(answers, self.claim.free)
            for model, answers in answers_by_model.items()
        }
