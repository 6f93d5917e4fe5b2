"""Which kernel of analytic:physical a fault is sought on; a harmed one is not kept on disk."""

from functools import lru_cache
from typing import Literal

import numpy as np
import pytest

from crosscheck.analytic import ensemble, model
from crosscheck.analytic.kernel import machine
from crosscheck.analytic.kernel.batch import Records
from crosscheck.analytic.model import AnalyticModel
from crosscheck.models.errors import Diverged
from tests.abreast import run_group

Kernel = Literal["alone", "abreast", "terms"]
PLACE = 2  # of the member that is looked at, among others


def choose(patch: pytest.MonkeyPatch, kernel: Kernel) -> None:
    """Have ``simulate`` use it: for one member alone, for several abreast, or of the terms."""
    if kernel == "terms":
        patch.setattr(AnalyticModel, "equations", AnalyticModel.term_equations)
    elif kernel == "abreast":
        patch.setattr(model, "run_alone", _abreast)
        patch.setattr(ensemble, "CHUNK", 1)  # a record at a time


def _abreast(member: AnalyticModel) -> Records:
    """Its run among others of its structure, whose arms and starts are not its own."""
    members = [neighbour(member, place) for place in range(PLACE)]
    (group,) = ensemble.group_models([*members, member])
    records = run_group(group)[PLACE]
    if not np.isnan(group.diverged_s[PLACE]):
        raise Diverged(member.name, float(group.diverged_s[PLACE]))
    return records


def neighbour(member: AnalyticModel, place: int) -> AnalyticModel:
    """A model of the same structure with another payload, and another start."""
    arm, scenario = member.arm, member.scenario
    moved = scenario.start.model_copy(update={"theta_rad": 0.1 * (1 + place)})
    return type(member)(
        arm.model_copy(update={"payload_mass_kg": arm.payload_mass_kg + 1 + place}),
        scenario.model_copy(update={"start": moved}),
        member.switches,
    )


def keep_nothing(patch: pytest.MonkeyPatch) -> None:
    """Keep no kernel on disk, whatever is planted in it."""
    patch.setattr(machine, "load_machine_code", compiled_quickly)


@lru_cache(maxsize=64)
def compiled_quickly(text: str, lanes: int, level: int) -> bytes:
    """Machine code of a text; no level of optimisation changes a bit of what it does."""
    return machine.compile_ir(machine.translate_to_ir(text, lanes), machine.target_machine(0), 0)
