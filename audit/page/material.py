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
    """Made once for a page; nothing is run before it is asked for."""

    study: Study
    scale: Scale

    @cached_property
    def settings(self) -> Settings:
        """Every setting of the claims with planets free, with its experiments."""
        chosen = plan_of(self.scale).settings()
        return with_experiments(self.study, self.scale, chosen, "claims")

    @cached_property
    def as_modelled(self) -> Settings:
        """Every setting of the paper's own model, with its experiments."""
        chosen = plan_of(self.scale).of(AS_MODELLED)
        return with_experiments(self.study, self.scale, chosen, "claims, as modelled")

    @cached_property
    def variations(self) -> Mapping[GearModel, Settings]:
        """Further models of the gears, of the PD run alone."""
        return variations(self.study, self.scale)

    @cached_property
    def judged(self) -> Mapping[str, Judged]:
        """Every claim by its id."""
        return {claim.id: self.asked(claim) for claim in CLAIMS}

    def asked(self, claim: Claim) -> Judged:
        """One claim in every setting of every model of the gears."""
        return Judged(claim, tuple(answers(claim, [*self.as_modelled, *self.settings])))

    def samples(self, wanted: Iterable[Wanted], what: str) -> dict[Wanted, Sample]:
        """Experiments in any settings, those of the claims among them, from the scale's starts."""
        return samples(self.study, self.scale, wanted, what)
