"""One simulation of a study: what differs from the built-in arm and scenario, and running it."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal, NamedTuple

import xarray as xr
from pydantic import BaseModel

from crosscheck.models.arm.meshes import damped, squared
from crosscheck.models.errors import Diverged
from crosscheck.models.experiment.scenario import MOST_RECORDS, Scenario
from crosscheck.models.experiment.switches import Switches
from crosscheck.models.files import HERE
from crosscheck.models.loading import Case, load_case
from crosscheck.registry import build, entry_of
from crosscheck.studies.members.starts import perturbed

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
    much; record_every as in the scenario; harmonics: of the square wave that is the meshes'
    stiffness, 0 for the arm's own.
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
    mesh_work: str = "paper"
    harmonics: int = 0

    def case(self) -> Case:
        """Arm, scenario and switches, read again if a file has changed. Raises InputError."""
        return _case(self, _state("arms", self.arm), _state("scenarios", self.scenario))


def _state(folder: str, name: str) -> tuple[int, ...] | None:
    """Of what is built in or a file: another one once its content is; None if there is none."""
    for path in (HERE / folder / f"{name}.toml", name):
        with suppress(OSError, ValueError):
            state = os.stat(path)
            return state.st_ino, state.st_size, state.st_mtime_ns
    return None


@lru_cache(maxsize=2048)  # about 17 kB each; everyone asks several times
def _case(of: Variant, *files: tuple[int, ...] | None) -> Case:
    """Of a variant while its files are in these states."""
    switches = {"phase": of.phase}
    if of.ring_rate is not None:
        switches["ring_rate"] = of.ring_rate
    if of.planets == "free":
        switches["planets"] = of.planets
    if of.mesh_work != "paper":
        switches["mesh_work"] = of.mesh_work
    settings = [*of.settings, *of.meshes, f"scenario.record_every={of.record_every}"]
    if of.duration_s is not None:
        settings.append(f"scenario.duration_s={of.duration_s!r}")
    case = load_case(of.arm, of.scenario, switches, settings)
    if of.zeta is not None:
        case = case._replace(arm=damped(case.arm, of.zeta))
    if of.harmonics:
        case = case._replace(arm=squared(case.arm, of.harmonics))
    return case if of.seed is None else perturbed(case, of.seed)


@dataclass(frozen=True)
class VariantComparison:
    """Numbers of a variant's run beside other runs; both are functions of a module.

    numbers: of the run and the others, in their order; others: which they are.
    """

    numbers: Callable[[xr.Dataset, tuple[xr.Dataset, ...]], Numbers]
    others: Callable[[Variant], tuple[Variant, ...]]


def simulate(variant: Variant) -> xr.Dataset:
    """The variant's trajectory. Raises InputError and Diverged."""
    ((run,),) = simulate_all([[variant]])
    if isinstance(run, Diverged):
        raise run
    return run


def spelled_out(records: Iterable[BaseModel], *more: str) -> str:
    """What a result depends on, a line each: records with all their fields, and more."""
    return "\n".join([*more, *(record.model_dump_json() for record in records)])


def integration(variant: Variant) -> str:
    """What the variants of one integration have in common: all inputs but how often they record.

    That too, where it changes the model's states. Raises InputError.
    """
    arm, scenario, switches = variant.case()
    if entry_of(variant.model).any_stride:
        scenario = scenario.model_copy(update={"record_every": 1})
    return spelled_out((arm, scenario, switches), variant.model)


class Company(NamedTuple):
    """What integrations have in common that a model may step side by side."""

    model: str
    switches: Switches
    step_s: float
    steps: int
    drive: str


def company(variant: Variant) -> Company:
    """Of the variant's integration. Raises InputError."""
    _, scenario, switches = variant.case()
    drive = scenario.drive.kind
    return Company(variant.model, switches, scenario.step_s, scenario.steps, drive)


def simulate_all(integrations: Sequence[Sequence[Variant]]) -> list[list[xr.Dataset | Diverged]]:
    """The trajectories of the variants of every integration, or why there is none.

    Every one is made once, all of them by one model, side by side if it can. Raises InputError.
    """
    shared = [_recording_for_all(variants) for variants in integrations]
    together = iter(_run([variant for variant in shared if variant is not None]))
    return [
        _handed_out(variants, None if one is None else next(together))
        for variants, one in zip(integrations, shared, strict=True)
    ]


def _run(variants: Sequence[Variant]) -> list[xr.Dataset | Diverged]:
    """Of variants of one model, each by itself an integration."""
    models = [build(variant.model, *variant.case()) for variant in variants]
    return type(models[0]).simulate_together(models) if models else []


def _recording_for_all(variants: Sequence[Variant]) -> Variant | None:
    """The variant that records whatever these do; None if that would be too much."""
    if len(set(variants)) == 1:
        return variants[0]
    finest = _finest(variants)
    if variants[0].case().scenario.steps // finest > MOST_RECORDS:
        return None
    return replace(variants[0], record_every=finest)


def _finest(variants: Sequence[Variant]) -> int:
    """The stride at which records of all are made."""
    return math.gcd(*(variant.case().scenario.stride for variant in variants))


def _handed_out(
    variants: Sequence[Variant], run: xr.Dataset | Diverged | None
) -> list[xr.Dataset | Diverged]:
    """To every variant of an integration its own records of the run that was made for all."""
    if len(set(variants)) == 1 and run is not None:
        return [run] * len(variants)
    if isinstance(run, xr.Dataset):
        finest = _finest(variants)
        return [_thinned(run, variant.case().scenario, finest) for variant in variants]
    # A divergence shows at a record: it is every variant's own.
    unlike = list(dict.fromkeys(variants))
    runs = dict(zip(unlike, _run(unlike), strict=True))
    return [runs[variant] for variant in variants]


def _thinned(run: xr.Dataset, scenario: Scenario, stride: int) -> xr.Dataset:
    """A run with records every ``stride`` steps, as if recorded as the scenario says."""
    kept = run.isel(time=slice(None, None, scenario.stride // stride))
    return kept.assign_attrs(scenario=json.dumps(scenario.model_dump()))
