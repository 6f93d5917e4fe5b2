"""One simulation of a study: what differs from the built-in arm and scenario, and running it."""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

from crosscheck.models.arm.meshes import replace_by_square_wave, replace_damping
from crosscheck.models.files import HERE
from crosscheck.models.loading import Case, load_case
from crosscheck.studies.members.cases import perturb_scenario

Planets = Literal["lumped", "free"]
Equations = Literal["corrected", "printed"]  # of motion; see GEARED_MODELS

GEARED_MODELS: dict[Equations, str] = {
    "corrected": "analytic:physical",
    "printed": "analytic:printed",  # Eqs. 21-22: three planets counted as one, whose count is fixed
}

PERTURBATION_M = 1e-12  # perturbation of every mesh displacement in a seeded start [m]
Numbers = dict[str, float | None]


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
    model: str = GEARED_MODELS["corrected"]
    duration_s: float | None = None
    settings: tuple[str, ...] = ()
    seed: int | None = None
    record_every: int = 2
    meshes: tuple[str, ...] = ()
    planets: Planets = "lumped"
    mesh_work: str = "paper"
    harmonics: int = 0

    def case(self) -> Case:
        """The arm, scenario and switches, read again if a file has changed. Raises InputError."""
        return _case(self, _state("arms", self.arm), _state("scenarios", self.scenario))


def _state(folder: str, name: str) -> tuple[int, ...] | None:
    """The state of a built-in or other file, another once its content is; None if there is none."""
    for path in (HERE / folder / f"{name}.toml", name):
        with suppress(OSError, ValueError):
            state = os.stat(path)
            return state.st_ino, state.st_size, state.st_mtime_ns
    return None


@lru_cache(maxsize=2048)  # about 17 kB each; everyone asks several times
def _case(variant: Variant, *files: tuple[int, ...] | None) -> Case:
    """The arm, scenario and switches of a variant while its files are in these states."""
    switches = {"phase": variant.phase}
    if variant.ring_rate is not None:
        switches["ring_rate"] = variant.ring_rate
    if variant.planets == "free":
        switches["planets"] = variant.planets
    if variant.mesh_work != "paper":
        switches["mesh_work"] = variant.mesh_work
    settings = [*variant.settings, *variant.meshes, f"scenario.record_every={variant.record_every}"]
    if variant.duration_s is not None:
        settings.append(f"scenario.duration_s={variant.duration_s!r}")
    case = load_case(variant.arm, variant.scenario, switches, settings)
    if variant.zeta is not None:
        case = case._replace(arm=replace_damping(case.arm, variant.zeta))
    if variant.harmonics:
        case = case._replace(arm=replace_by_square_wave(case.arm, variant.harmonics))
    return case if variant.seed is None else perturb_start(case, variant.seed)


COUPLED = "coupled"  # the level with all that the gears bring along rigidly
PRINTED_RIGID = "analytic:printed-rigid"  # the same of the printed equations: their own limit
RIGID_STEP_S = 1e-4  # the rigid arm is smooth


def rigid_model(level: str, geared: str = GEARED_MODELS["corrected"]) -> str:
    """The name of the model of a rigid level, beside a geared model.

    With all that gears bring along, the printed equations have a rigid limit of their own: with any
    other an error of theirs would count as the meshes' doing.
    """
    if level == COUPLED and geared == GEARED_MODELS["printed"]:
        return PRINTED_RIGID
    return f"analytic:{level}"


def rigid_arm(variant: Variant, level: str = COUPLED) -> Variant:
    """The rigid arm at a level through the same experiment, every step recorded.

    Nothing is left that concerns the meshes alone, so geared runs share one rigid arm.
    """
    return replace(
        remove_gears(variant, level),
        settings=(*variant.settings, f"scenario.step_s={RIGID_STEP_S!r}"),
        record_every=1,
    )


def remove_gears(variant: Variant, level: str = COUPLED) -> Variant:
    """The rigid arm at a level in the same experiment, at the geared run's step and records."""
    return Variant(
        variant.scenario,
        variant.arm,
        model=rigid_model(level, variant.model),
        duration_s=variant.duration_s,
        settings=variant.settings,
        record_every=variant.record_every,
    )


def perturb_start(case: Case, seed: int, size_m: float = PERTURBATION_M) -> Case:
    """The case with every mesh displacement of its start changed by up to ``size_m``, by a seed.

    If planets are free, every planet's own displacement is changed too. All is added to what the
    scenario says of the start.
    """
    free = case.switches.planets == "free"
    counts = [count if free else 0 for count in case.arm.planet_counts]
    return case._replace(scenario=perturb_scenario(case.scenario, counts, seed, size_m))
