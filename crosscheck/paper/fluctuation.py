"""The third fluctuation of a run that no variant states: its rigid arm is run for it alone."""

from __future__ import annotations

import xarray as xr

from crosscheck.paper import signals
from crosscheck.paper.events import THIRD_S, third_onset, third_peak, third_window
from crosscheck.paper.reading import arm_of, excess_acceleration, scenario_of
from crosscheck.paper.rigid import RIGID_STEP_S
from crosscheck.paper.undefined import finite
from crosscheck.registry import build
from crosscheck.studies.study import Numbers

__all__ = ["THIRD_S", "third_fluctuation"]


def third_fluctuation(run: xr.Dataset) -> Numbers:
    """Amplitude [rad/s^2], onset [s] and dominant frequency [Hz] of the shoulder's excess.

    All undefined in a run that ends before the third fluctuation.
    """
    time = run["time"].values
    window = third_window(time)
    if not time[window].size:
        return dict.fromkeys(("amplitude_rad_per_s2", "onset_s", "frequency_Hz"))
    excess = excess_acceleration(run, _rigid_run(run))[:, 0]
    near = third_peak(time, excess, window)
    return finite(
        {
            "amplitude_rad_per_s2": signals.amplitude(excess[window]),
            "onset_s": third_onset(time, excess, window),
            "frequency_Hz": signals.dominant_frequency(time[near], excess[near]),
        }
    )


def _rigid_run(run: xr.Dataset) -> xr.Dataset:
    """The rigid arm with all that the gears bring along, at its own step."""
    update = {"step_s": RIGID_STEP_S, "record_every": 1}
    return build(
        "analytic:coupled", arm_of(run), scenario_of(run).model_copy(update=update)
    ).simulate()
