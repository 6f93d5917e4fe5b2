"""One simulation of a study: what differs from the built-in arm and scenario, and running it."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import xarray as xr

from crosscheck.registry import build, entry_of
from crosscheck.studies.starts import perturbed
from models.errors import Diverged
from models.loading import Case, load_case
from models.meshes import damped
from models.scenario import MOST_RECORDS, Scenario

Planets = Literal["lumped", "free"]

Numbers = dict[str, float | None]
Measure = Callable[[xr.Dataset], Numbers]  # of the run that it is given; runs nothing itself


@dataclass(frozen=True)
class Variant:
    """One simulation: what differs from the built-in arm and scenario.

    zeta: damping ratio of all meshes, None for the damping that the arm's file gives; ring_rate
    None follows the phase law; settings: ``path=value`` as on the command line; meshes: those
    settings that concern the meshes alone, so that a rigid arm has none; seed: perturb every mesh
    displacement of the start by up to 1e-12 m, and if planets are free every planet by itself as
    much; record_every as in the scenario.
    """

    scenario: str = "pd"
    arm: str = "paper-labelled"
    phase: str = "angle"
    ring_rate: str | None = None
    zeta: float | None = None
    model: str = "analytic:physical"
    duration_s: float | None = None
    settings: tuple[str, ...] = ()
    seed: int | None = None
    record_every: int = 2
    meshes: tuple[str, ...] = ()
    planets: Planets = "lumped"

    def case(self) -> Case:
        """Arm, scenario and switches. Raises InputError."""
        switches = {"phase": self.phase}
        if self.ring_rate is not None:
            switches["ring_rate"] = self.ring_rate
        if self.planets == "free":
            switches["planets"] = self.planets
        settings = [*self.settings, *self.meshes, f"scenario.record_every={self.record_every}"]
        if self.duration_s is not None:
            settings.append(f"scenario.duration_s={self.duration_s!r}")
        case = load_case(self.arm, self.scenario, switches, settings)
        if self.zeta is not None:
            case = case._replace(arm=damped(case.arm, self.zeta))
        return case if self.seed is None else perturbed(case, self.seed)


@dataclass(frozen=True)
class Comparison:
    """Numbers of a variant's run beside other runs; both are functions of a module.

    numbers: of the run and the others, in their order; others: which they are.
    """

    numbers: Callable[[xr.Dataset, tuple[xr.Dataset, ...]], Numbers]
    others: Callable[[Variant], tuple[Variant, ...]]


def simulate(variant: Variant) -> xr.Dataset:
    """The variant's trajectory. Raises InputError and Diverged."""
    return build(variant.model, *variant.case()).simulate()


def integration(variant: Variant) -> str:
    """What the variants of one integration have in common: all inputs but how often they record.

    That too, where it changes the model's states. Raises InputError.
    """
    arm, scenario, switches = variant.case()
    if entry_of(variant.model).any_stride:
        scenario = scenario.model_copy(update={"record_every": 1})
    records = (record.model_dump_json() for record in (arm, scenario, switches))
    return "\n".join([variant.model, *records])


def simulate_all(variants: Sequence[Variant]) -> list[xr.Dataset | Diverged]:
    """The trajectories of variants of one integration, or why there is none; integrated once.

    Raises InputError.
    """
    scenarios = [variant.case().scenario for variant in variants]
    finest = math.gcd(*(scenario.stride for scenario in scenarios))
    if len(set(variants)) > 1 and scenarios[0].steps // finest <= MOST_RECORDS:
        run = _tried(replace(variants[0], record_every=finest))
        if isinstance(run, xr.Dataset):
            return [_thinned(run, scenario, finest) for scenario in scenarios]
    # A divergence shows at a record: it is every variant's own.
    runs = {variant: _tried(variant) for variant in set(variants)}
    return [runs[variant] for variant in variants]


def _tried(variant: Variant) -> xr.Dataset | Diverged:
    try:
        return simulate(variant)
    except Diverged as error:
        return error


def _thinned(run: xr.Dataset, scenario: Scenario, stride: int) -> xr.Dataset:
    """A run with records every ``stride`` steps, as if recorded as the scenario says."""
    kept = run.isel(time=slice(None, None, scenario.stride // stride))
    return kept.assign_attrs(scenario=json.dumps(scenario.model_dump()))
