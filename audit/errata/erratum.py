"""One slip of the paper, and how much it matters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
import xarray as xr

from audit.measures.numbers import defined
from crosscheck.checks.trajectories import largest_difference
from models.experiment.scenario import Scenario
from models.interface import Model

Side = Callable[[Scenario], Model]  # equal ones make equal models


@dataclass(frozen=True)
class Trial:
    """Two models of any scenario that differ in the slip alone: as printed, and put right."""

    as_printed: Side
    put_right: Side


@dataclass(frozen=True)
class Effect:
    """Largest change over a run: joint angle [rad] and elastic mesh force per planet [N]."""

    theta_rad: float
    mesh_force_N: float


Kind = Literal["entry", "energy", "equation", "table", "count", "symbol", "text", "figure"]


@dataclass(frozen=True)
class Erratum:
    """A slip of the paper: where, and how far what is printed is from what should stand there.

    id: names it for good; size [unit]: for this arm, derived minus printed where both are numbers;
    relative: over the size of the quantity; trial: what to simulate to see the effect, None where
    there is nothing to run; quoted: what its words name; printed, derived: formulas, or words,
    which ``words.told`` gives to those that are found without; remark: what these do not say;
    printed_tex, derived_tex: the formulas as TeX, if any.
    """

    id: str
    kind: Kind
    where: str = ""
    printed: str = ""
    derived: str = ""
    size: float | None = None
    unit: str = ""
    relative: float | None = None
    trial: Trial | None = None
    quoted: Mapping[str, float | str] = field(default_factory=dict)
    remark: str = ""
    printed_tex: str = ""
    derived_tex: str = ""


def simulated(side: Side, scenario: Scenario) -> xr.Dataset:
    """A side's run. Raises Diverged."""
    return side(scenario).simulate()


def effect_of(
    trial: Trial, scenario: Scenario, run: Callable[[Side, Scenario], xr.Dataset] = simulated
) -> Effect:
    """Run both models through a scenario and compare. Raises Diverged.

    run: may give again what it has given.
    """
    printed, right = (run(side, scenario) for side in (trial.as_printed, trial.put_right))
    forces = [largest_difference(printed, right, force) for force in ("F_sp", "F_pr")]
    return Effect(largest_difference(printed, right, "theta"), float(np.max(forces)))


@dataclass(frozen=True)
class Slip:
    """An erratum and what it changes in a run, by scenario; its trial is over."""

    erratum: Erratum
    effects: dict[str, Effect]


def tried(erratum: Erratum, effects: Mapping[str, Effect]) -> Slip:
    """The erratum with its effects; None for a size that is not finite."""
    size, relative = defined(erratum.size), defined(erratum.relative)
    return Slip(replace(erratum, size=size, relative=relative, trial=None), dict(effects))
