"""The runs behind the figures, reduced for storage without losing an extremum."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from itertools import pairwise

import numpy as np
import xarray as xr

from crosscheck import signals
from crosscheck.audit.claims.study_plan import plan_of
from crosscheck.audit.experiments.experiments import BACK, BACKLASH, CONSTANT, ERROR, PD
from crosscheck.audit.experiments.paper_conditions import INTEGRAL, LAWS, Condition
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.figures.figure_data import (
    LOW_ZETA,
    SMOOTH_RECORD,
    ZETA,
    make_condition,
    make_rigid_variant,
    make_start_variant,
)
from crosscheck.audit.measures.reading import select_first_planets
from crosscheck.audit.measures.rigid import COUPLED
from crosscheck.models.errors import Diverged
from crosscheck.registry import RIGID_LEVELS

# Extrema are kept per bin and variable.
BIN_S = 0.01
Windows = Mapping[str, tuple[float, float]]
WINDOWS_S: dict[str, Windows] = {
    "constant-torque": {"start": (0.0, 0.02)},
    "pd": {"start": (0.0, 0.02), "side change": (0.345, 0.385), "third": (1.0, 1.2)},
    "back-and-forth": {},
}


def select_stored_variants(scale: Scale) -> dict[str, Variant]:
    """The variants of the runs that are stored, by file name without suffix, from one start."""
    variants: dict[str, Variant] = {}
    plan, seed, integral_condition = plan_of(scale), scale.first_seed, Condition(INTEGRAL, ZETA)
    for law in LAWS:
        name = law.id.replace("/", "-")
        experiments = {f"constant-torque-{name}": CONSTANT, f"pd-{name}": PD}
        experiments |= {f"pd-{name}-b-{b:g}um": BACKLASH(b) for b in plan.backlashes}
        if not scale.quick:
            experiments |= {f"pd-{name}-E-{e:g}um": ERROR(e) for e in plan.errors}
        variants |= {
            run: make_start_variant(experiment, make_condition(law, LOW_ZETA), seed)
            for run, experiment in experiments.items()
        }
    if scale.quick:
        return variants
    variants |= {
        f"constant-torque-{level}": make_rigid_variant("constant-torque", level)
        for level in RIGID_LEVELS
    }
    variants |= {
        f"back-and-forth-b-{b:g}um": make_start_variant(
            BACK(b), integral_condition, seed, SMOOTH_RECORD
        )
        for b in plan.back
    }
    variants["back-and-forth-coupled"] = make_rigid_variant("back-and-forth", COUPLED)
    return variants


def reduce_trajectories(study: Study, scale: Scale) -> dict[str, xr.Dataset]:
    """The reduced runs by file name, from the study, which remembers them; none that diverges."""
    kept = {}
    for name, full_variant in select_stored_variants(scale).items():
        variant = scale.cut(full_variant)
        with suppress(Diverged):
            run = study.run_variants([variant], f"storing {name}", select_first_planets)[variant]
            kept[name] = reduce_run(run, WINDOWS_S[variant.scenario])
    return kept


def reduce_run(run: xr.Dataset, windows: Windows, bin_s: float = BIN_S) -> xr.Dataset:
    """The run at the samples in the windows [s], and elsewhere at variables' extrema alone.

    Every sample of a window stays; outside, per bin and per column of every variable, the first
    sample with its smallest and with its largest value.
    """
    time = run["time"].values
    kept = np.zeros(time.size, dtype=bool)
    edges = np.flatnonzero(np.diff(np.floor(time / bin_s + 1e-9).astype(int), prepend=-1))
    columns = np.hstack([x.values.reshape(time.size, -1) for x in run.data_vars.values()])
    for sign in (1, -1):
        sizes = np.nan_to_num(sign * columns, nan=-np.inf)
        for begin, end in pairwise((*edges, time.size)):
            kept[begin + sizes[begin:end].argmax(axis=0)] = True
    for window in windows.values():
        kept[signals.window(time, *window)] = True
    kept[[0, -1]] = True
    attributes = {
        "recording": "every sample in the windows; elsewhere per bin the samples of all extrema",
        "windows_s": json.dumps({name: list(window) for name, window in windows.items()}),
        "bin_s": bin_s,
        "samples_of_the_run": run.sizes["time"],
        "planets": "the first of every joint is kept",
    }
    return run.isel(time=np.flatnonzero(kept)).assign_attrs(attributes)
