"""What all chapters of the page work from: the study, and everything that the claims were asked."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

from crosscheck.paper.claims.catalogue import CLAIMS
from crosscheck.paper.claims.judged import Judged
from crosscheck.paper.claims.rule import Claim, answers
from crosscheck.paper.claims.settings import Settings, settings, variations
from crosscheck.paper.sampling.pool import Sample, Wanted, samples
from crosscheck.paper.scale import Scale
from crosscheck.studies.study import Study


@dataclass(frozen=True)
class Material:
    """Made once for a page; nothing is run before it is asked for."""

    study: Study
    scale: Scale

    @cached_property
    def settings(self) -> Settings:
        """Every setting of the claims with its experiments."""
        return settings(self.study, self.scale)

    @cached_property
    def variations(self) -> Mapping[str, Settings]:
        """The model's variants, by name."""
        return variations(self.study, self.scale)

    @cached_property
    def judged(self) -> Mapping[str, Judged]:
        """Every claim by its id."""
        return {claim.id: self.asked(claim) for claim in CLAIMS}

    def asked(self, claim: Claim) -> Judged:
        """One claim in every setting."""
        return Judged(claim, tuple(answers(claim, self.settings)))

    def samples(self, wanted: Iterable[Wanted], what: str) -> dict[Wanted, Sample]:
        """Experiments in any settings, those of the claims among them, from the scale's starts."""
        return samples(self.study, self.scale, wanted, what)
