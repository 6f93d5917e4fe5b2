"""What runs tell of their third fluctuation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from crosscheck.studies.study import Comparison, Numbers, Study, Variant


@dataclass(frozen=True)
class Fluctuation:
    """A run's third fluctuation, see the measures; None for what is undefined or not asked.

    planet_spread_m: how far planets of a stage part; diverged_s: when the run diverged.
    """

    onset_s: float | None = None
    frequency_Hz: float | None = None
    amplitude_rad_per_s2: float | None = None
    planet_spread_m: float | None = None
    diverged_s: float | None = None

    @classmethod
    def of(cls, numbers: Numbers) -> Fluctuation:
        """From what a measure gave. Raises TypeError for a number of another name."""
        return cls(**numbers)


def measured(
    study: Study, variants: Sequence[Variant], measure: Comparison, what: str
) -> list[Fluctuation]:
    """Of every variant's run."""
    return [Fluctuation.of(numbers) for numbers in study.measures(variants, measure, what)]
