"""What all chapters of the page work from: the study, and everything that the claims were asked."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from crosscheck.audit.claims import study_plan
from crosscheck.audit.claims.catalogue import CLAIMS, ModelJudgement
from crosscheck.audit.claims.study_plan import (
    ResultsByCondition,
    run_experiments,
    run_model_variants,
)
from crosscheck.audit.errata.erratum import Erratum
from crosscheck.audit.errata.finder import EFFECT_S, ErrataQuestion
from crosscheck.audit.experiments.paper_conditions import (
    AS_MODELLED,
    LABELLED,
    GearModel,
)
from crosscheck.audit.experiments.samples import SampleRequest, Scale, collect_samples
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.judging.quantities import Sample
from crosscheck.audit.judging.rule import evaluate_claim


@dataclass(frozen=True)
class AuditContext:
    """What a page is made from, once; nothing is run before it is asked for."""

    study: Study
    scale: Scale

    @cached_property
    def settings(self) -> ResultsByCondition:
        """The settings of the claims with planets free, each with its experiments."""
        chosen = study_plan.FULL.claim_conditions()
        return run_experiments(self.study, self.scale, chosen, "claims")

    @cached_property
    def as_modelled(self) -> ResultsByCondition:
        """The settings of the paper's own model, each with its experiments."""
        chosen = study_plan.FULL.model_conditions(AS_MODELLED)
        return run_experiments(self.study, self.scale, chosen, "claims, as modelled")

    @cached_property
    def variations(self) -> Mapping[GearModel, ResultsByCondition]:
        """The settings of further models of the gears, with the PD run's experiments alone."""
        return run_model_variants(self.study, self.scale)

    @property
    def effect_s(self) -> float:
        """How long [s] the runs behind the effects of errata last."""
        return self.scale.limit_duration(EFFECT_S)

    @cached_property
    def errata(self) -> Sequence[Erratum]:
        """The errors of equations, with Table I as its labels say."""
        question = ErrataQuestion(LABELLED, self.effect_s)
        (errata,) = self.study.answer_questions([question], "errata sheet")
        return errata

    @cached_property
    def judged_claims(self) -> Mapping[str, ModelJudgement]:
        """The claims with their answers in all settings, by id."""
        settings = [*self.as_modelled, *self.settings]
        return {c.id: ModelJudgement(c, tuple(evaluate_claim(c, settings))) for c in CLAIMS}

    def samples(self, requests: Iterable[SampleRequest], what: str) -> dict[SampleRequest, Sample]:
        """Samples of experiments in any settings, also the claims', from the scale's starts."""
        return collect_samples(self.study, self.scale, requests, what)
