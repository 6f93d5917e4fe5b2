"""The third fluctuation of a run, beside its rigid arm."""

from __future__ import annotations

import xarray as xr

from crosscheck import signals
from crosscheck.paper.events import THIRD_S, third_onset, third_peak, third_window
from crosscheck.paper.numbers import finite
from crosscheck.paper.reading import excess_acceleration
from crosscheck.paper.rigid import beside_coupled
from crosscheck.studies.study import Comparison, Numbers

__all__ = ["THIRD_FLUCTUATION", "THIRD_S", "third_fluctuation"]


def third_fluctuation(run: xr.Dataset, others: tuple[xr.Dataset, ...]) -> Numbers:
    """Amplitude [rad/s^2], onset [s] and dominant frequency [Hz] of the shoulder's excess.

    others: the rigid arm. All undefined in a run that ends before the third fluctuation.
    """
    time = run["time"].values
    window = third_window(time)
    if not time[window].size:
        return dict.fromkeys(("amplitude_rad_per_s2", "onset_s", "frequency_Hz"))
    (rigid,) = others
    excess = excess_acceleration(run, rigid)[:, 0]
    near = third_peak(time, excess, window)
    return finite(
        {
            "amplitude_rad_per_s2": signals.amplitude(excess[window]),
            "onset_s": third_onset(time, excess, window),
            "frequency_Hz": signals.dominant_frequency(time[near], excess[near]),
        }
    )


THIRD_FLUCTUATION = Comparison(third_fluctuation, beside_coupled)
