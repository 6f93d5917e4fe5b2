"""Models that run side by side, as whole runs."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import xarray as xr

from crosscheck.analytic.ensemble import Group, group_models
from crosscheck.analytic.kernel.batch import Records
from crosscheck.analytic.model import AnalyticModel
from crosscheck.models.errors import Diverged
from crosscheck.models.trajectory import recorded_times


def run_models(models: Sequence[AnalyticModel], threads: int = 1) -> list[xr.Dataset | Diverged]:
    """Runs in the models' order, so many groups at a time; Diverged where one did."""
    outcomes: dict[int, xr.Dataset | Diverged] = {}
    groups = group_models(models)
    with ThreadPoolExecutor(threads) as pool:
        for group, records in zip(groups, pool.map(run_group, groups), strict=True):
            outcomes |= {
                place: model.make_trajectory(recorded_times(model.scenario), records[lane])
                if np.isnan(group.diverged_s[lane])
                else Diverged(model.name, float(group.diverged_s[lane]))
                for lane, (place, model) in enumerate(zip(group.members, group.models, strict=True))
            }
    return [outcomes[place] for place in range(len(models))]


def run_group(group: Group[AnalyticModel]) -> list[Records]:
    """Records (times, ...) of every member."""
    parts = zip(*(chunk.records for chunk in group.chunks()), strict=True)
    whole = Records(*(np.concatenate(each) for each in parts))
    return [
        Records(*(np.ascontiguousarray(each[:, :, lane]) for each in whole))
        for lane in range(len(group.members))
    ]
