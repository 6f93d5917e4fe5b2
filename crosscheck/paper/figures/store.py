"""The simulations behind the figures, reduced for storage without losing an extremum."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress

import numpy as np
import xarray as xr

from crosscheck import signals
from crosscheck.paper.figures.runs import (
    BACKLASHES_UM,
    DRIVEN_UM,
    ERRORS_UM,
    LAWS,
    LOW_ZETA,
    QUICK_BACKLASHES_UM,
    backlash_run,
    control_run,
    driven_run,
    error_run,
    rigid_run,
    smooth_torque_run,
    torque_run,
)
from crosscheck.paper.reductions import first_planets
from crosscheck.paper.rigid import COUPLED
from crosscheck.paper.scale import Scale
from crosscheck.registry import RIGID_LEVELS
from crosscheck.studies.study import Study, Variant
from models.errors import Diverged

# Extrema are kept per bin and variable.
BIN_S = 0.01
Windows = Mapping[str, tuple[float, float]]
WINDOWS_S: dict[str, Windows] = {
    "constant-torque": {"start": (0.0, 0.02)},
    "pd": {"start": (0.0, 0.02), "side change": (0.345, 0.385), "third": (1.0, 1.2)},
    "back-and-forth": {},
}


def stored_runs(scale: Scale) -> dict[str, Variant]:
    """File name (without suffix) -> variant."""
    sizes = QUICK_BACKLASHES_UM if scale.quick else BACKLASHES_UM
    named = {"constant-torque-angles": smooth_torque_run()}
    for law in LAWS:
        named[f"constant-torque-{law}"] = torque_run(law, LOW_ZETA)
        named |= {f"pd-{law}-b-{b:g}um": backlash_run(law, b) for b in sizes}
    if scale.quick:
        return named
    for law in LAWS:
        named[f"pd-{law}"] = control_run(law)
        named |= {f"pd-{law}-E-{e:g}um": error_run(law, e) for e in ERRORS_UM if e != 5}
    named |= {
        f"constant-torque-{level}": rigid_run("constant-torque", level) for level in RIGID_LEVELS
    }
    named |= {f"back-and-forth-b-{b:g}um": driven_run(b) for b in DRIVEN_UM}
    named["back-and-forth-coupled"] = rigid_run("back-and-forth", COUPLED)
    return named


def trajectories(study: Study, scale: Scale) -> dict[str, xr.Dataset]:
    """File name -> reduced run, from the study, which remembers them; none where one diverges."""
    kept = {}
    for name, wanted in stored_runs(scale).items():
        variant = scale.cut(wanted)
        with suppress(Diverged):
            run = study.runs([variant], f"storing {name}", first_planets)[variant]
            kept[name] = reduced(run, WINDOWS_S[variant.scenario])
    return kept


def reduced(run: xr.Dataset, windows: Windows, bin_s: float = BIN_S) -> xr.Dataset:
    """The samples in the windows [s], and elsewhere those where a variable has an extremum.

    Every sample of a window stays; outside, per bin and per column of every variable, the first
    sample with its smallest and with its largest value.
    """
    kept = _extreme_samples(run, bin_s)
    for begin, end in windows.values():
        kept[signals.window(run["time"].values, begin, end)] = True
    kept[[0, -1]] = True
    attributes = {
        "recording": "every sample in the windows; elsewhere per bin the samples of all extrema",
        "windows_s": json.dumps({name: list(window) for name, window in windows.items()}),
        "bin_s": bin_s,
        "samples_of_the_run": run.sizes["time"],
        "planets": "those of a joint move alike: one is kept",
    }
    return run.isel(time=np.flatnonzero(kept)).assign_attrs(attributes)


def _extreme_samples(run: xr.Dataset, bin_s: float) -> np.ndarray:
    """Which samples (times,) hold a bin's minimum or maximum of any column."""
    time = run["time"].values
    bins = np.floor(time / bin_s + 1e-9).astype(int)
    edges = np.flatnonzero(np.diff(bins, prepend=-1))
    kept = np.zeros(time.size, dtype=bool)
    for variable in run.data_vars.values():
        for column in variable.values.reshape(time.size, -1).T:
            for sign in (1, -1):
                kept[_first_largest(sign * column, edges)] = True
    return kept


def _first_largest(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Index of the first largest value in each bin; NaN counts as smallest."""
    filled = np.nan_to_num(values, nan=-np.inf)
    largest = np.repeat(np.maximum.reduceat(filled, edges), np.diff(np.append(edges, filled.size)))
    hits = np.flatnonzero(filled == largest)
    return hits[np.searchsorted(hits, edges)]
