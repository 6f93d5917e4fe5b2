"""Which kernel of analytic:physical a fault is sought on, and specialised kernels as plain Python.

A harmed kernel is never compiled: it would take seconds and leave its text in the user's folder.
"""

from __future__ import annotations

import ctypes
import math
import re
from types import ModuleType
from typing import Any, Literal

import pytest
import xarray as xr

from analytic import ensemble, model
from analytic.fast import batch, hyperbolic
from analytic.fast.program import Program
from analytic.model import AnalyticModel
from models.errors import Diverged

Kernel = Literal["alone", "abreast", "plain"]
PLACE = 2  # of the member that is looked at, among others


def choose(patch: pytest.MonkeyPatch, kernel: Kernel) -> None:
    """Have ``simulate`` use it: for one member alone, for several abreast, or the plain one."""
    if kernel == "plain":
        patch.setattr(AnalyticModel, "structure", None)
    elif kernel == "abreast":
        patch.setattr(model, "alone", _abreast)
        patch.setattr(ensemble, "CHUNK", 1)  # a record at a time


def _abreast(member: AnalyticModel) -> xr.Dataset:
    """Its run among others of its structure, whose arms and starts are not its own."""
    members = [neighbour(member, place) for place in range(PLACE)]
    run = ensemble.trajectories([*members, member])[PLACE]
    if isinstance(run, Diverged):
        raise run
    return run


def neighbour(member: AnalyticModel, place: int) -> AnalyticModel:
    """A model of the same structure with another payload, and another start."""
    arm, scenario = member.arm, member.scenario
    moved = scenario.start.model_copy(update={"theta_rad": 0.1 * (1 + place)})
    return type(member)(
        arm.model_copy(update={"payload_mass_kg": arm.payload_mass_kg + 1 + place}),
        scenario.model_copy(update={"start": moved}),
        member.switches,
    )


def interpret(patch: pytest.MonkeyPatch) -> None:
    """Run the text of specialised kernels as Python, whatever is planted in it."""
    patch.setattr(batch, "module_of", interpreted)
    patch.setattr(hyperbolic, "power_of_two", lambda exponent: math.ldexp(1.0, int(exponent)))


def interpreted(program: Program) -> ModuleType:
    """A program's module without numba's decorators, and without a file."""
    module = ModuleType("interpreted")
    exec(re.sub(r"(?m)^@njit.*\n", "", program.text), vars(module))
    vars(module)["pointer"] = _pointer
    return module


def _pointer(address: int) -> Any:
    return ctypes.cast(address, ctypes.POINTER(ctypes.c_double))
