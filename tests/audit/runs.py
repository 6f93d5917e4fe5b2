"""Runs of variants, whole."""

import xarray as xr

from crosscheck.audit.experiments.variant import Variant
from crosscheck.registry import build


def simulate(variant: Variant) -> xr.Dataset:
    """The variant's trajectory. Raises InputError and Diverged."""
    return build(variant.model, *variant.case()).simulate()
