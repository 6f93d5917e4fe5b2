"""When a rigid arm's torque changes its sign under PD control: what no damping can move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.rigid import rigid_model
from crosscheck.registry import RIGID_LEVELS


@dataclass(frozen=True)
class Reversals:
    """Of the shoulder [s]: the meshes change sides soon after the first, and back after the second.

    None where the run ends before.
    """

    level: str
    side_change_s: float | None
    return_s: float | None


def reversals(study: Study, scale: Scale) -> list[Reversals]:
    """Of every rigid level. Raises Diverged."""
    variants = [scale.cut(Variant(model=rigid_model(x), record_every=100)) for x in RIGID_LEVELS]
    runs = study.runs(variants, "damping fit, rigid arm")
    return [
        Reversals(level, *torque_reversals(runs[variant]))
        for level, variant in zip(RIGID_LEVELS, variants, strict=True)
    ]


def torque_reversals(run: xr.Dataset) -> tuple[float | None, float | None]:
    """First two sign changes [s] of the shoulder's torque."""
    time, torque = run["time"].values, run["torque"].values[:, 0]
    changes = [float(t) for t in time[1:][np.diff(np.sign(torque)) != 0]]
    first, second = (*changes, None, None)[:2]
    return first, second
