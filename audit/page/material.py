"""What all chapters of the page work from: the study, and everything that the claims were asked."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

from crosscheck.audit.claims.catalogue import CLAIMS
from crosscheck.audit.claims.judged import Judged
from crosscheck.audit.claims.rule import Claim, answers
from crosscheck.audit.claims.settings import Settings, plan_of, variations, with_experiments
from crosscheck.audit.experiments.cells import AS_MODELLED, GearModel
from crosscheck.audit.experiments.pool import Sample, Wanted, samples
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study


@dataclass(frozen=True)
class Material:
    """What a page is made from, once; nothing is run before it is asked for."""

    study: Study
    scale: Scale

    @cached_property
    def settings(self) -> Settings:
        """The settings of the claims with planets free, each with its experiments."""
        chosen = plan_of(self.scale).settings()
        return with_experiments(self.study, self.scale, chosen, "claims")

    @cached_property
    def as_modelled(self) -> Settings:
        """The settings of the paper's own model, each with its experiments."""
        chosen = plan_of(self.scale).of(AS_MODELLED)
        return with_experiments(self.study, self.scale, chosen, "claims, as modelled")

    @cached_property
    def variations(self) -> Mapping[GearModel, Settings]:
        """The settings of further models of the gears, with the PD run's experiments alone."""
        return variations(self.study, self.scale)

    @cached_property
    def judged(self) -> Mapping[str, Judged]:
        """The claims with their answers in all settings, by id."""
        return {claim.id: self.asked(claim) for claim in CLAIMS}

    def asked(self, claim: Claim) -> Judged:
        """A claim with its answers in every setting of every model of the gears."""
        return Judged(claim, tuple(answers(claim, [*self.as_modelled, *self.settings])))

    def samples(self, wanted: Iterable[Wanted], what: str) -> dict[Wanted, Sample]:
        """Samples of experiments in any settings, also the claims', from the scale's starts."""
        return samples(self.study, self.scale, wanted, what)
