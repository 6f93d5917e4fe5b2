"""A measure's numbers of a variant, without a study."""

from __future__ import annotations

from crosscheck.audit.experiments.study import Measure, Numbers, Variant, VariantComparison
from crosscheck.audit.experiments.variant import simulate


def numbers_of(variant: Variant, measure: Measure | VariantComparison) -> Numbers:
    """What the measure says of the variant's run, beside those that it is held against."""
    if not isinstance(measure, VariantComparison):
        return measure(simulate(variant))
    return measure.numbers(simulate(variant), tuple(map(simulate, measure.others(variant))))
