"""The rigid arm in an experiment of the geared one."""

from __future__ import annotations

import xarray as xr

from crosscheck.models.loading import Case
from crosscheck.registry import build


def rigid_motion(case: Case, step_s: float, every: int) -> xr.Dataset:
    """With all that the gears bring along rigidly (level `coupled`); ``every``: of its steps."""
    scenario = case.scenario.model_copy(update={"step_s": step_s, "record_every": every})
    return build("analytic:coupled", case.arm, scenario).simulate()
