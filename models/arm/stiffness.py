"""Laws of time-varying mesh stiffness as data: k over the mesh phase, one period per tooth pitch.

The phase is that of the sine law (Eqs. 8, 12, 13). Every engine works a law out by itself; the
arithmetic here only decides whether it stays positive.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import FailFast, Field, model_validator

from crosscheck.models.arm import quantities
from crosscheck.models.arm.quantities import Data

Waves = Field(max_length=50, strict=False)
Rows = Field(min_length=5, max_length=2000, strict=False)
SAMPLES_PER_WAVE = 64  # samples of the highest wave, which miss 1e-3 of its size


class SineStiffness(Data):
    """k = mean + amplitude sin(phase), the paper's Eq. 8."""

    law: Literal["sine"]
    """Which law this is."""
    mean_N_per_m: quantities.Stiffness
    """The mean."""
    amplitude_N_per_m: quantities.StiffnessPart
    """k_a of the wave, below the mean."""

    @model_validator(mode="after")
    def _check_positive(self) -> Self:
        if self.amplitude_N_per_m >= self.mean_N_per_m:
            mean = f"{self.mean_N_per_m:g} N/m"
            raise ValueError(f"amplitude_N_per_m|must be below the mean stiffness, {mean}")
        return self


class FourierStiffness(Data):
    """k = mean + sum over n = 1, 2, ... of cosine_n cos(n phase) + sine_n sin(n phase)."""

    law: Literal["fourier"]
    """Which law this is."""
    mean_N_per_m: quantities.Stiffness
    """The mean."""
    cosine_N_per_m: Annotated[tuple[quantities.Wave, ...], Waves, FailFast()] = ()
    """Amplitudes at the mesh frequency, twice that, and so on."""
    sine_N_per_m: Annotated[tuple[quantities.Wave, ...], Waves, FailFast()] = ()
    """The sines' amplitudes; the lists may differ in length."""

    @model_validator(mode="after")
    def _check_positive(self) -> Self:
        least = self.mean_N_per_m + _waves_minimum(self.cosine_N_per_m, self.sine_N_per_m)
        if least <= 0:
            raise ValueError(
                f"mean_N_per_m|must keep the stiffness positive; it falls to {least:.3g} N/m"
            )
        return self


class SquareStiffness(Data):
    """The square wave of Fig. 5 by the given number of harmonics of its series, Eq. 7.

    The contact ratio is the paper's e; the phase is 2 pi t / T of Eq. 7.
    """

    law: Literal["square"]
    """Which law this is."""
    contact_ratio: quantities.ContactRatio
    """Mean number of tooth pairs in contact."""
    least_N_per_m: quantities.Stiffness
    """Stiffness while one pair carries."""
    largest_N_per_m: quantities.Stiffness
    """Stiffness while two pairs carry."""
    harmonics: quantities.Harmonics
    """Terms of the series."""

    @model_validator(mode="after")
    def _check_positive(self) -> Self:
        if self.largest_N_per_m < self.least_N_per_m:
            raise ValueError(
                f"largest_N_per_m|must be at least least_N_per_m = {self.least_N_per_m:g}"
            )
        swing, overlap = self.largest_N_per_m - self.least_N_per_m, self.contact_ratio - 1
        turns = [(n * math.pi, 2 * n * math.pi * overlap) for n in range(1, self.harmonics + 1)]
        cosines = tuple(math.sin(lag) / turn for turn, lag in turns)
        sines = tuple((1 - math.cos(lag)) / turn for turn, lag in turns)
        least = self.least_N_per_m + swing * (overlap + _waves_minimum(cosines, sines))
        if least <= 0:
            raise ValueError(
                "least_N_per_m|must keep the series positive, which undershoots it; the stiffness"
                f" falls to {least:.3g} N/m"
            )
        return self


class TableStiffness(Data):
    """k through rows of a table over one period, by the periodic cubic spline (C2).

    ``phase_cycles`` rises from 0 to 1; the last stiffness is the first again.
    """

    law: Literal["table"]
    """Which law this is."""
    phase_cycles: Annotated[tuple[quantities.Cycles, ...], Rows, FailFast()]
    """Phase over 2 pi of every row, rising from 0 to 1."""
    stiffness_N_per_m: Annotated[tuple[quantities.Stiffness, ...], Rows, FailFast()]
    """k of every row; the last one repeats the first."""

    @model_validator(mode="after")
    def _check_periodic(self) -> Self:
        cycles, stiffness = self.phase_cycles, self.stiffness_N_per_m
        if (cycles[0], cycles[-1]) != (0.0, 1.0):
            raise ValueError("phase_cycles|must run from 0 to 1")
        if any(later - earlier < 1e-6 for earlier, later in pairwise(cycles)):
            raise ValueError("phase_cycles|must increase, by at least 1e-6 each")
        if len(stiffness) != len(cycles):
            raise ValueError(f"stiffness_N_per_m|needs {len(cycles)} values, as phase_cycles")
        if stiffness[0] != stiffness[-1]:
            raise ValueError(
                f"stiffness_N_per_m|must be periodic: ends at {stiffness[-1]:g}, begins at"
                f" {stiffness[0]:g}"
            )
        return self

    @model_validator(mode="after")
    def _check_positive(self) -> Self:
        least = _spline_minimum(self.phase_cycles, self.stiffness_N_per_m)
        if least <= 0:
            raise ValueError(
                "stiffness_N_per_m|must keep the spline through it positive; it falls to"
                f" {least:.3g} N/m between rows"
            )
        return self


StiffnessLaw = Annotated[
    SineStiffness | FourierStiffness | SquareStiffness | TableStiffness, Field(discriminator="law")
]


# Files have the same wave in many meshes, and studies vary its size: its shape is sampled once.
@lru_cache(maxsize=1000)
def _waves_minimum(cosines: tuple[float, ...], sines: tuple[float, ...]) -> float:
    """Smallest sum of waves, by SAMPLES_PER_WAVE samples for each of them over a period."""
    count = SAMPLES_PER_WAVE * max(len(cosines), len(sines), 1)
    return min(
        sum(c * math.cos(n * phase) for n, c in enumerate(cosines, 1))
        + sum(s * math.sin(n * phase) for n, s in enumerate(sines, 1))
        for phase in (2 * math.pi * (place / count) for place in range(count))
    )


@lru_cache(maxsize=1000)
def _spline_minimum(cycles: tuple[float, ...], stiffness: tuple[float, ...]) -> float:
    """Smallest value [N/m] of the periodic cubic spline through the rows, by 16 samples a row."""
    from numpy import linspace
    from scipy.interpolate import CubicSpline  # a third of a second, for tables alone

    spline = CubicSpline(cycles, stiffness, bc_type="periodic")
    return float(min(spline(linspace(a, b, 17)).min() for a, b in pairwise(cycles)))
