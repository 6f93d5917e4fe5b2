"""Runs that no scenario file can state: another clock, start, drive, dampers, phase rate.

The mesh phase is one linear form per mesh: phi = offset + w . q (law `angle`), or
phi = offset + (w . v) t (law `omega_t`), so that Eq. 11 in full is only another w than Eq. 12.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.signal import butter, sosfiltfilt

from crosscheck.analytic.derivation.gears import Gears
from crosscheck.analytic.derivation.terms import Terms
from crosscheck.analytic.kernel.batch import Batch
from crosscheck.analytic.kernel.equations import TermEquations
from crosscheck.analytic.kernel.states import StateEvaluator
from crosscheck.analytic.model import AnalyticModel, PhysicalModel
from crosscheck.analytic.paper.mesh_frequency import OMEGA_T
from crosscheck.analytic.paper.model import PrintedModel
from crosscheck.audit.experiments.ensembles import TransientPdQuestion
from crosscheck.audit.experiments.paper_conditions import PRINTED, REPAIRED_RATE, Condition, Law
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.variant import Variant, simulate
from crosscheck.audit.measures.events import THIRD_S
from crosscheck.audit.measures.rigid import rigid_arm
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.models.experiment.drive import DriveData
from crosscheck.models.experiment.scenario import TableDrive
from crosscheck.models.loading import Case
from crosscheck.registry import build
from crosscheck.studies.members.starts import perturb_start

CHUNK = 2000  # records at a time, which stay in a processor's cache
HIGH_PASS_HZ = 600.0  # between the controlled arm's motion and the mesh modes
ORDER = 12  # each way: 1.7 kHz leaks less than 1e-5 through 3 kHz
FILTER_SAMPLES = 3 * (ORDER + 1)  # by which the filter continues a signal at either end
FILTER_EDGE_S = 0.02  # of the record's ends, which the filter does not see whole
RIGID_STEP_S, TABLE_STEP_S = 1e-4, 1e-3
RECORD_EVERY = 5  # steps of 10 us
CONTACT = "switches.damping=contact"
NO_ERROR = "arm.joints.*.*_mesh.tooth_error_m=0.0"
# Where every start with the law's ring rate, or some with the paper's, is severe.
DECISIVE = (Condition(PRINTED, 0.005), Condition(REPAIRED_RATE, 0.02))


@dataclass(frozen=True)
class Plant:
    """A geared arm in an experiment; weights (meshes, n): w, in radians per metre or radian."""

    model: AnalyticModel
    weights: np.ndarray
    equations: TermEquations

    @property
    def terms(self) -> Terms:
        """The terms of the equations."""
        return self.equations.terms

    @property
    def gears(self) -> Gears:
        """The gears of the equations."""
        return self.equations.gears

    @property
    def drive(self) -> DriveData:
        """The drive of the equations."""
        return self.equations.drive

    @property
    def is_clock_driven(self) -> bool:
        """Whether the phases go by the clock: law `omega_t`."""
        return self.gears.phase == OMEGA_T

    def replace_parts(self, **parts: DriveData | Gears) -> Plant:
        """The plant with other parts of its equations."""
        equations = replace(self.equations, **parts)  # type: ignore[arg-type]
        return replace(self, equations=equations)

    @cached_property
    def states(self) -> StateEvaluator:
        """The evaluator of what the equations say of states."""
        return StateEvaluator(self.equations)


def build_plant(model: AnalyticModel, full_rate: bool = False) -> Plant:
    """The model's plant; ``full_rate`` keeps the terms of Eq. 11 that Eq. 12 neglects."""
    meshes = model.gears
    weights = np.zeros((meshes.x_index.size, len(model.coordinates)))
    weights[np.arange(meshes.x_index.size), meshes.theta] = meshes.rate
    if not full_rate:
        return Plant(model, weights, model.term_equations)
    more = neglected_weights(model)
    parts = model.arm, model.layout, meshes, model.drive, model.terms
    return Plant(model, weights + more, TermEquations(*parts, phase_weights=more))


def neglected_weights(model: AnalyticModel) -> np.ndarray:
    """Weights that Eq. 11 has and Eq. 12 neglects [rad/m], (meshes, n).

    Those of a sun mesh are z_s / r_s on x_sp and x_pr, those of a ring mesh z_p / r_p on x_pr.
    """
    weights = np.zeros((model.gears.x_index.size, len(model.coordinates)))
    layout = model.layout
    for number, joint in enumerate(layout.mesh_joints):
        stage = paper_stage(model.arm, joint)
        x_sp, x_pr = layout.at("x_sp", joint), layout.at("x_pr", joint)
        weights[2 * number, [x_sp, x_pr]] = stage.joint.sun_teeth / stage.geometry.r_s
        weights[2 * number + 1, x_pr] = stage.joint.planet_teeth / stage.geometry.r_p
    return weights


def simulate_rigid_arm(case: Case, step_s: float, every: int) -> xr.Dataset:
    """The run of the rigid arm at level `coupled`, recorded ``every`` so many steps."""
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
    def elapsed_s(self) -> np.ndarray:
        """Time since the motion's start, (times,) [s]."""
        return self.time - self.time[0]

    @property
    def shoulder(self) -> np.ndarray:
        """The shoulder's acceleration [rad/s^2], (times, members)."""
        return self.a[:, self.theta[0]]


class ContinuedModel(PhysicalModel):
    """A model that starts from any state q, v (n,), and runs by other equations if given."""

    def __init__(
        self, case: Case, q: np.ndarray, v: np.ndarray, equations: TermEquations | None = None
    ) -> None:
        super().__init__(*case)
        self.state = q, v
        if equations is not None:
            self.equations, self.drive = equations, equations.drive

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        return self.state


class ContinuedPrintedModel(PrintedModel):
    """The printed equations from any state q, v (n,)."""

    def __init__(self, case: Case, q: np.ndarray, v: np.ndarray) -> None:
        super().__init__(*case)
        self.state = q, v

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        return self.state


def simulate_motion(models: Sequence[AnalyticModel], clock_s: float = 0.0) -> RecordedMotion:
    """The runs of models of one structure, the clock at ``clock_s``, whole steps, at the start.

    States after one that is not finite are not either.
    """
    batch, scenario = Batch(models), models[0].scenario
    batch.step_count = begun = round(clock_s / scenario.step_s)
    with np.errstate(invalid="ignore", over="ignore"):  # of runs that diverge
        parts = list(batch.run(scenario.steps // scenario.stride, scenario.stride, CHUNK))
    steps = begun + scenario.stride * np.arange(scenario.steps // scenario.stride + 1)
    q, v, a = (np.concatenate([part[k] for part in parts]) for k in range(3))
    return RecordedMotion(scenario.step_s * steps, q, v, a, np.array(models[0].layout.theta))


def use_integral_phase(cell: Condition) -> Condition:
    """The setting with the phase as an integral, at its own ring rate."""
    return replace(cell, law=Law("angle", cell.law.ring_rate))


def build_pd_variant(cell: Condition, duration_s: float, *meshes: str) -> Variant:
    """The PD run of a setting with these changes of its meshes, recorded at 20 kHz."""
    variant = cell.variant()
    return replace(variant, duration_s=duration_s, record_every=RECORD_EVERY, meshes=meshes)


def build_models(variant: Variant, seeds: Sequence[int]) -> list[PhysicalModel]:
    """The analytic models of a variant from the starts with these seeds."""
    case = variant.case()
    return [PhysicalModel(*perturb_start(case, seed)) for seed in seeds]


@dataclass(frozen=True)
class ChangeQuestion(TransientPdQuestion):
    """A question: numbers of ``transient`` of the PD run with other dampers or another drive.

    damping: factors on the dampers of sun and ring meshes; recorded: the rigid arm's torque played
    back, no feedback.
    """

    damping: tuple[float, float] = (1.0, 1.0)
    recorded: bool = False

    def case(self) -> Case:
        case = super().case()
        return replace_drive_by_rigid_torque(case) if self.recorded else case

    def models(self, seeds: Sequence[int]) -> list[PhysicalModel]:
        case = self.case()
        models = [PhysicalModel(*perturb_start(case, seed)) for seed in seeds]
        for model in models:
            factors = np.resize(self.damping, model.gears.d.size)
            model.gears = model.gears._replace(d=model.gears.d * factors)
        return models


@dataclass(frozen=True)
class Change:
    """A change of one thing in the PD run; damping, recorded: as in ``ChangeQuestion``."""

    name: str
    meshes: tuple[str, ...] = ()
    settings: tuple[str, ...] = ()
    damping: tuple[float, float] = (1.0, 1.0)
    recorded: bool = False

    def question(self, cell: Condition, scale: Scale, *meshes: str) -> ChangeQuestion:
        """The changed run until the third fluctuation ends, as a question; meshes: more changes."""
        variant = replace(
            build_pd_variant(cell, THIRD_S[1], *self.meshes, *meshes), settings=self.settings
        )
        return ChangeQuestion(scale.cut(variant), scale.seeds, self.damping, self.recorded)


def replace_drive_by_rigid_torque(case: Case) -> Case:
    """The case with its drive replaced by the torque that the rigid arm needs in it."""
    rigid = simulate_rigid_arm(case, RIGID_STEP_S, round(TABLE_STEP_S / RIGID_STEP_S))
    time = rigid["time"].values.copy()
    time[-1] = max(time[-1], case.scenario.duration_s)
    return set_drive_torque(case, time, rigid["torque"].values)


def set_drive_torque(case: Case, time: np.ndarray, torque: np.ndarray) -> Case:
    """The case driven by torques (times, joints) [N m], by straight lines between times [s]."""
    drive = TableDrive(
        kind="table",
        time_s=tuple(map(float, time)),
        torque_N_m=tuple(tuple(map(float, column)) for column in torque.T),
    )
    return case._replace(scenario=case.scenario.model_copy(update={"drive": drive}))


def shoulder_excess(variant: Variant, elapsed: np.ndarray, theta_ddot: np.ndarray) -> np.ndarray:
    """Shoulder accelerations (times, members) [rad/s^2] less the rigid arm's at these times."""
    rigid = _cached_simulate(rigid_arm(variant))
    rigid_acceleration = np.interp(elapsed, rigid["time"].values, rigid["theta_ddot"].values[:, 0])
    return theta_ddot - rigid_acceleration[:, None]


_cached_simulate = lru_cache(maxsize=8)(simulate)


def vibration(time: np.ndarray, values: np.ndarray, above_hz: float = HIGH_PASS_HZ) -> np.ndarray:
    """The fast part of a signal (times, ...): Butterworth, forth and back.

    For what is too small to be seen beside a rigid arm, whose teeth are not pressed in. Undefined,
    all nan, for one that is too short for the filter.
    """
    if len(values) <= FILTER_SAMPLES:
        return np.full(values.shape, np.nan)
    rate = round(1 / (time[1] - time[0]))
    sections = butter(ORDER, above_hz, "highpass", fs=rate, output="sos")
    return sosfiltfilt(sections, values, axis=0)
