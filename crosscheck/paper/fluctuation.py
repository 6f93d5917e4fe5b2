"""The acceleration fluctuations of Section 3.2: what the gears add to the rigid arm's motion."""

from __future__ import annotations

import json

import numpy as np
import xarray as xr

from crosscheck.paper import signals
from crosscheck.paper.undefined import finite
from crosscheck.registry import build
from crosscheck.studies.study import Numbers
from models.arm import Arm
from models.scenario import Scenario

# The paper's "third fluctuation" grows well after the side change at 0.3 s.
THIRD_S = (0.5, 1.2)
RIGID_STEP_S = 1e-4


def excess_acceleration(run: xr.Dataset) -> np.ndarray:
    """Detailed minus rigid joint acceleration [rad/s^2], shape (times, joints).

    Rigid: with all that the gears bring along rigidly (level `coupled`), integrated at its own
    step and interpolated, for it is smooth.
    """
    rigid = rigid_run(run)
    time = run["time"].values
    smooth = [
        np.interp(time, rigid["time"].values, column) for column in rigid["theta_ddot"].values.T
    ]
    return run["theta_ddot"].values - np.array(smooth).T


def rigid_run(run: xr.Dataset, level: str = "coupled") -> xr.Dataset:
    """The rigid arm at a level of the ladder through the same experiment as ``run``."""
    arm = Arm.model_validate(json.loads(run.attrs["arm"]))
    scenario = Scenario.model_validate(json.loads(run.attrs["scenario"]))
    update = {"step_s": RIGID_STEP_S, "record_every": 1}
    return build(f"analytic:{level}", arm, scenario.model_copy(update=update)).simulate()


def third_fluctuation(run: xr.Dataset) -> Numbers:
    """Amplitude [rad/s^2], onset [s] and dominant frequency [Hz] of the shoulder's excess.

    In 0.5 to 1.2 s; the frequency is that of the 0.1 s around the largest value. All undefined in a
    run that ends before.
    """
    time = run["time"].values
    part = signals.window(time, *THIRD_S)
    time, excess = time[part], excess_acceleration(run)[part, 0]
    if not time.size:
        return dict.fromkeys(("amplitude_rad_per_s2", "onset_s", "frequency_Hz"))
    centre = time[int(np.argmax(np.abs(excess)))]
    begin = min(max(centre - 0.05, time[0]), time[-1] - 0.1)
    near = signals.window(time, begin, begin + 0.1)
    return finite(
        {
            "amplitude_rad_per_s2": signals.amplitude(excess),
            "onset_s": signals.onset(time, excess),
            "frequency_Hz": signals.dominant_frequency(time[near], excess[near]),
        }
    )
