"""The experiments that the paper's statements are about: what each changes in a setting."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from pydantic import TypeAdapter

from crosscheck.audit.experiments.ensembles import RUNS, EnsembleNumbersQuestion
from crosscheck.audit.experiments.paper_conditions import Condition
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.judging.quantities import MeasuredExperiment
from crosscheck.models.files import read_toml
from crosscheck.models.interface import Model
from crosscheck.registry import build

DEFAULT_B_UM, DEFAULT_E_UM = 50.0, 5.0
WIDE_M = 3e-3
CHAOTIC_UM = 1000.0  # a clearance with which Section 4.1 calls the fluctuation chaotic
INSIDE_M = 1e-6  # so far into contact that a mesh's force is a straight line


@dataclass(frozen=True)
class PaperExperiment(MeasuredExperiment):
    """An experiment: what it changes in a setting's scenario, and how it is measured.

    Fields are those of experiments.toml. size: of a family, what makes this member [um]; meshes:
    fields of all meshes, with their values; duration_s: if another than that of its kind of run.
    """

    runs: Literal["transient", "whole", "torque", "swing"] = "transient"
    where: Literal["every", "shaken", "corrected", ""] = ""
    duration_s: float | None = None
    meshes: tuple[tuple[str, float], ...] = ()
    settings: tuple[str, ...] = ()
    harmonics: int = 0
    preloaded: bool = False

    def __str__(self) -> str:
        return self.kind if self.size is None else f"{self.kind} {self.size:g} um"


class ExperimentSeries(NamedTuple):
    """Experiments that differ in one size [um]. symbol: the paper's for it; field: the meshes'."""

    kind: str
    symbol: str
    field: str
    plain: PaperExperiment

    def __call__(self, size_um: float) -> PaperExperiment:
        """The family's member of this size [um]."""
        meshes = ((self.field, float(size_um) * 1e-6), *self.plain.meshes)
        return replace(self.plain, kind=self.kind, size=float(size_um), meshes=meshes, where="")


def read_experiments(tables: Mapping[str, dict[str, Any]]) -> dict[str, PaperExperiment]:
    """The experiments of experiments.toml by name."""
    experiments: dict[str, PaperExperiment] = {}
    for name, table in tables.items():
        fields = dict(table)
        like = experiments.get(fields.pop("like", ""))
        fields = {"runs": like.runs} | fields if like else fields
        fields["meshes"] = tuple(fields.get("meshes", {}).items())
        experiments[name] = TypeAdapter(PaperExperiment).validate_python({"kind": name} | fields)
    return experiments


_TABLES = read_toml(Path(__file__).with_suffix(".toml"))
EXPERIMENTS = read_experiments(_TABLES["experiments"])
SERIES = {
    kind: ExperimentSeries(
        kind,
        table["symbol"],
        table["field"],
        EXPERIMENTS.get(table.get("like", ""), PaperExperiment("")),
    )
    for kind, table in _TABLES["series"].items()
}
PD, CONSTANT, NO_ERROR, WIDE, STATIC, PLANTED = (
    EXPERIMENTS[name]
    for name in (
        *("pd", "constant torque", "no error", "whole run, b = 3000 um"),
        *("static", "planted slips"),
    )
)
BACKLASH, ERROR, BACK, BACK_EVEN = (
    SERIES[kind]
    for kind in (
        *("backlash", "tooth error"),
        *("back and forth, backlash", "back and forth evenly, backlash"),
    )
)
# What the claims ask of it ends before 1.2 s, where WIDE goes on: its numbers are those of WIDE.
WIDE_BEGINNING = BACKLASH(1e6 * WIDE_M)
DEFAULTS = (BACKLASH(DEFAULT_B_UM), ERROR(DEFAULT_E_UM))  # the PD run as a member of both sweeps


def find_experiment(name: str) -> PaperExperiment:
    """The experiment whose text this is. Raises KeyError if there is none."""
    if name in EXPERIMENTS:
        return EXPERIMENTS[name]
    kind, size, _ = name.rsplit(" ", 2)
    return SERIES[kind](float(size))


def build_question(
    experiment: PaperExperiment, condition: Condition, seeds: tuple[int, ...]
) -> EnsembleNumbersQuestion:
    """The experiment in a setting, as a question. Raises KeyError for one that has no run."""
    run = RUNS[experiment.runs]
    plain = condition.variant(run.scenario)
    variant = replace(
        plain,
        duration_s=experiment.duration_s or run.duration_s,
        record_every=round(run.record_s / plain.case().scenario.step_s),
        meshes=tuple(
            f"arm.joints.*.*_mesh.{field}={value!r}" for field, value in experiment.meshes
        ),
        settings=experiment.settings,
        harmonics=experiment.harmonics,
    )
    if experiment.preloaded:
        variant = make_preloaded_variant(variant)
    return EnsembleNumbersQuestion(variant, seeds, experiment.runs)


def make_preloaded_variant(variant: Variant) -> Variant:
    """The experiment started from meshes that do not accelerate at t = 0: the teeth bear the drive.

    All planets alike: they share the load.
    """
    model = build(variant.model, *replace(variant, planets="lumped").case())
    sun, ring = resting_offsets(model).reshape(-1, 2).T
    offsets = {"sun_planet_offset_m": sun, "planet_ring_offset_m": ring}
    start = tuple(f"scenario.start.{name}={list(map(float, x))!r}" for name, x in offsets.items())
    return replace(variant, meshes=(*variant.meshes, *start))


def resting_offsets(model: Model) -> np.ndarray:
    """Offset [m] of every mesh beyond its start at which no mesh accelerates, (meshes,).

    Meshes are in the order of the layout. Forces are straight lines while teeth touch, so one step
    of Newton's method is exact.
    """
    meshes = np.flatnonzero(~model.layout.angular)
    pose, rates = model.start()

    def accelerations(offsets: np.ndarray) -> np.ndarray:
        moved = pose.copy()
        moved[meshes] += offsets
        return model.acceleration(0.0, moved, rates)[meshes]

    inside = np.full(meshes.size, INSIDE_M)
    base = accelerations(inside)
    steps = INSIDE_M * np.eye(meshes.size)
    slopes = np.array([accelerations(inside + step) - base for step in steps]).T / INSIDE_M
    return inside - np.linalg.solve(slopes, base)
