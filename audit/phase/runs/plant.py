"""The analytic model with what its scenario fixes set free: the clock, the start, the phase's rate.

The mesh phase is one linear form per mesh: phi = offset + w . q (law `angle`), or
phi = offset + (w . v) t (law `omega_t`), so that Eq. 11 in full is only another w than Eq. 12.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import xarray as xr

from crosscheck.analytic.derivation.gears import Gears
from crosscheck.analytic.derivation.terms import Terms
from crosscheck.analytic.kernel.batch import Batch
from crosscheck.analytic.kernel.equations import TermEquations
from crosscheck.analytic.kernel.states import StateEvaluator
from crosscheck.analytic.model import AnalyticModel, PhysicalModel
from crosscheck.analytic.paper.mesh_frequency import OMEGA_T
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.models.experiment.drive import DriveData
from crosscheck.models.loading import Case
from crosscheck.registry import build

CHUNK = 2000  # records at a time, which stay in a processor's cache


@dataclass(frozen=True)
class Plant:
    """A geared arm in an experiment; weights (meshes, n): w, in radians per metre or radian."""

    model: AnalyticModel
    weights: np.ndarray
    equations: TermEquations

    @property
    def terms(self) -> Terms:
        """Of the equations."""
        return self.equations.terms

    @property
    def gears(self) -> Gears:
        """Of the equations."""
        return self.equations.gears

    @property
    def drive(self) -> DriveData:
        """Of the equations."""
        return self.equations.drive

    @property
    def timed(self) -> bool:
        """Whether the phases go by the clock: law `omega_t`."""
        return self.gears.phase == OMEGA_T

    def changed(self, **parts: DriveData | Gears) -> Plant:
        """With other parts of its equations."""
        equations = replace(self.equations, **parts)  # type: ignore[arg-type]
        return replace(self, equations=equations)

    @cached_property
    def states(self) -> StateEvaluator:
        """What the equations say of states."""
        return StateEvaluator(self.equations)


def plant_of(model: AnalyticModel, full_rate: bool = False) -> Plant:
    """The model's plant; ``full_rate`` keeps the terms of Eq. 11 that Eq. 12 neglects."""
    meshes = model.gears
    weights = np.zeros((meshes.where.size, len(model.coordinates)))
    weights[np.arange(meshes.where.size), meshes.theta] = meshes.rate
    if not full_rate:
        return Plant(model, weights, model.term_equations)
    more = neglected_weights(model)
    parts = model.arm, model.layout, meshes, model.drive, model.terms
    return Plant(model, weights + more, TermEquations(*parts, phase_weights=more))


def neglected_weights(model: AnalyticModel) -> np.ndarray:
    """Eq. 11 less Eq. 12 [rad/m], (meshes, n): z_s / r_s on x_sp and x_pr; z_p / r_p on x_pr."""
    weights = np.zeros((model.gears.where.size, len(model.coordinates)))
    layout = model.layout
    for number, joint in enumerate(layout.meshing):
        stage = paper_stage(model.arm, joint)
        x_sp, x_pr = layout.at("x_sp", joint), layout.at("x_pr", joint)
        weights[2 * number, [x_sp, x_pr]] = stage.joint.sun_teeth / stage.geometry.r_s
        weights[2 * number + 1, x_pr] = stage.joint.planet_teeth / stage.geometry.r_p
    return weights


def rigid_motion(case: Case, step_s: float, every: int) -> xr.Dataset:
    """With all that the gears bring along rigidly (level `coupled`); ``every``: of its steps."""
    scenario = case.scenario.model_copy(update={"step_s": step_s, "record_every": every})
    return build("analytic:coupled", case.arm, scenario).simulate()


class RecordedMotion(NamedTuple):
    """Records of runs: time (times,) [s] by the law's own clock; q, v, a (times, n, members).

    theta (joints,): which coordinates the joints' angles are.
    """

    time: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    theta: np.ndarray

    @property
    def elapsed(self) -> np.ndarray:
        """Time since its start, (times,) [s]."""
        return self.time - self.time[0]

    @property
    def shoulder(self) -> np.ndarray:
        """Its acceleration [rad/s^2], (times, members)."""
        return self.a[:, self.theta[0]]


class Continued(PhysicalModel):
    """The model from any state q, v (n,); its runs are made by other equations, if given."""

    def __init__(
        self, case: Case, q: np.ndarray, v: np.ndarray, equations: TermEquations | None = None
    ) -> None:
        super().__init__(*case)
        self.state = q, v
        if equations is not None:
            self.equations, self.drive = equations, equations.drive

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        return self.state


def motion(models: Sequence[PhysicalModel], clock_s: float = 0.0) -> RecordedMotion:
    """The runs of models of one structure, the clock at ``clock_s``, whole steps, at the start.

    States after one that is not finite are not either.
    """
    batch, scenario = Batch(models), models[0].scenario
    batch.done = begun = round(clock_s / scenario.step_s)
    with np.errstate(invalid="ignore", over="ignore"):  # of runs that diverge
        parts = list(batch.run(scenario.steps // scenario.stride, scenario.stride, CHUNK))
    steps = begun + scenario.stride * np.arange(scenario.steps // scenario.stride + 1)
    q, v, a = (np.concatenate([part[k] for part in parts]) for k in range(3))
    return RecordedMotion(scenario.step_s * steps, q, v, a, np.array(models[0].layout.theta))
