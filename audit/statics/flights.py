"""The arm on a base that is free to fly: how far its tip is from where a fixed base has it."""

from __future__ import annotations

import numpy as np
import xarray as xr

from crosscheck.checks.trajectories import tip_position
from crosscheck.models.loading import Case
from crosscheck.models.pinocchio.floating import FloatingBase, PinocchioFloating
from crosscheck.registry import build

FIXED_BASE = "pinocchio:coupled"
FIXED_TOLERANCE = 1e-10  # relative, of the fixed arm's run
LIMIT_M = 0.03  # what Section 3.1 calls considerable
EVERY = "scenario.record_every=1000"  # 10 ms


def simulate_fixed_base(case: Case) -> xr.Dataset:
    """The run of the same arm on a base that does not move."""
    return build(FIXED_BASE, *case).reference(FIXED_TOLERANCE)


def arm_mass(case: Case) -> float:
    """Mass [kg] of all that the base carries."""
    return PinocchioFloating(case.arm, case.scenario, FloatingBase(1.0)).arm_mass_kg


def tip_error(free: xr.Dataset, fixed: xr.Dataset, case: Case) -> np.ndarray:
    """Distance [m] (times,) in the inertial frame between the tips on the two bases."""
    local = tip_position(free, case.arm).values
    x, y, angle = free["base"].values.T
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    flying = np.column_stack([x, y]) + np.einsum("ijt,tj->ti", turn, local)
    return np.linalg.norm(flying - tip_position(fixed, case.arm).values, axis=1)
