"""Cross-validation of geared-arm models: load, build, simulate, check."""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"
# What every reader of JSON holds exactly; the command line and a record take the same seeds.
LARGEST_SEED = 2**32 - 1
__all__ = [
    "Agreement",
    "Finding",
    "InputError",
    "build",
    "check",
    "load_arm",
    "load_scenario",
    "simulate",
    "sweep",
    "switches",
]
_HOME = {
    "Agreement": "crosscheck.findings",
    "Finding": "crosscheck.findings",
    "InputError": "crosscheck.models.errors",
    "sweep": "crosscheck.studies.api",
    "switches": "crosscheck.models.experiment.scenario",
}


def __getattr__(name: str) -> Any:
    # Lazily, so that the command line starts without numpy, xarray or an engine.
    if name not in __all__:
        raise AttributeError(f"module 'crosscheck' has no attribute {name!r}")
    return getattr(importlib.import_module(_HOME.get(name, "crosscheck.api")), name)
