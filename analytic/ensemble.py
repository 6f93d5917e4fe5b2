"""Members side by side; provisional: one after the other, on the plain kernel."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np
import xarray as xr

from analytic.model import PhysicalModel
from models.errors import Diverged
from models.loading import Case


class Chunk(NamedTuple):
    """Consecutive records of members that ran side by side.

    time (records,) [s]; theta, theta_dot, theta_ddot, torque (records, joints, members); x_sp,
    x_pr, x_sp_dot, x_pr_dot, F_sp, F_pr (records, joints, planets, members): NaN where a joint has
    no such planet; lumped, one planet stands for all.
    """

    time: np.ndarray
    theta: np.ndarray
    theta_dot: np.ndarray
    theta_ddot: np.ndarray
    torque: np.ndarray
    x_sp: np.ndarray
    x_pr: np.ndarray
    x_sp_dot: np.ndarray
    x_pr_dot: np.ndarray
    F_sp: np.ndarray
    F_pr: np.ndarray


RECORDS = 1000


@dataclass
class Group:
    """Members that run side by side; members: their places among the cases."""

    members: tuple[int, ...]
    case: Case
    kernel: Literal["fast", "plain"] = "plain"
    diverged_s: np.ndarray = field(default_factory=lambda: np.full(1, np.nan))

    def chunks(self) -> Iterator[Chunk]:
        """In the order of time, each once."""
        run = _run(self.case)
        if isinstance(run, Diverged):
            self.diverged_s[0] = run.time_s
            return
        for begin in range(0, run.sizes["time"], RECORDS):
            part = run.isel(time=slice(begin, begin + RECORDS))
            yield Chunk(part["time"].values, *(_values(part, n) for n in Chunk._fields[1:]))


def _values(part: xr.Dataset, name: str) -> np.ndarray:
    if name not in part:
        return np.full((part.sizes["time"], part.sizes["joint"], 1, 1), np.nan)
    return part[name].values[..., np.newaxis]


def _run(case: Case) -> xr.Dataset | Diverged:
    try:
        return PhysicalModel(*case).simulate()
    except Diverged as error:
        return error


def groups(cases: Sequence[Case]) -> list[Group]:
    """One for each member."""
    return [Group((place,), case) for place, case in enumerate(cases)]


def trajectories(cases: Sequence[Case]) -> list[xr.Dataset | Diverged]:
    """Whole runs."""
    return [_run(case) for case in cases]
