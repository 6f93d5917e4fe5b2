"""Runs that no scenario file can state: another clock, start, drive, dampers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.signal import butter, sosfiltfilt

from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.experiments.cells import PRINTED, REPAIRED_RATE, Cell, Law
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.starts import TransientPd
from crosscheck.audit.experiments.variant import Variant, simulate
from crosscheck.audit.measures.events import THIRD_S
from crosscheck.audit.measures.rigid import rigid_arm
from crosscheck.audit.phase.runs.plant import rigid_motion
from crosscheck.models.experiment.scenario import TableDrive
from crosscheck.models.loading import Case
from crosscheck.studies.members.starts import perturbed

HIGH_PASS_HZ = 600.0  # between the controlled arm's motion and the mesh modes
ORDER = 12  # each way: 1.7 kHz leaks less than 1e-5 through 3 kHz
FILTER_SAMPLES = 3 * (ORDER + 1)  # by which the filter continues a signal at either end
FILTER_EDGE_S = 0.02  # of the record's ends, which the filter does not see whole
RIGID_STEP_S, TABLE_STEP_S = 1e-4, 1e-3
RECORD_EVERY = 5  # steps of 10 us
CONTACT = "switches.damping=contact"
NO_ERROR = "arm.joints.*.*_mesh.tooth_error_m=0.0"
# Where every start with the law's ring rate, or some with the paper's, is severe.
DECISIVE = (Cell(PRINTED, 0.005), Cell(REPAIRED_RATE, 0.02))


def integrated(cell: Cell) -> Cell:
    """The same with the phase as an integral."""
    return replace(cell, law=Law("angle", cell.law.ring_rate))


def pd_run(cell: Cell, duration_s: float, *meshes: str) -> Variant:
    """The PD run of a setting, its meshes changed, recorded at 20 kHz."""
    one = cell.variant()
    return replace(one, duration_s=duration_s, record_every=RECORD_EVERY, meshes=meshes)


def models_of(variant: Variant, seeds: Sequence[int]) -> list[PhysicalModel]:
    """The analytic model from every start."""
    case = variant.case()
    return [PhysicalModel(*perturbed(case, seed)) for seed in seeds]


@dataclass(frozen=True)
class Changed(TransientPd):
    """The PD run with other dampers or another drive, all numbers of ``transient``.

    damping: factors on the dampers of sun and ring meshes; recorded: the rigid arm's torque played
    back, no feedback.
    """

    damping: tuple[float, float] = (1.0, 1.0)
    recorded: bool = False

    def case(self) -> Case:
        case = super().case()
        return played_back(case) if self.recorded else case

    def models(self, seeds: Sequence[int]) -> list[PhysicalModel]:
        case = self.case()
        found = [PhysicalModel(*perturbed(case, seed)) for seed in seeds]
        for model in found:
            factors = np.resize(self.damping, model.gears.d.size)
            model.gears = model.gears._replace(d=model.gears.d * factors)
        return found


@dataclass(frozen=True)
class Change:
    """One thing that is changed in the PD run; damping, recorded: of ``Changed``."""

    name: str
    meshes: tuple[str, ...] = ()
    settings: tuple[str, ...] = ()
    damping: tuple[float, float] = (1.0, 1.0)
    recorded: bool = False

    def question(self, cell: Cell, scale: Scale, *meshes: str) -> Changed:
        """The changed run until the third fluctuation ends, from every start; meshes: more."""
        variant = replace(pd_run(cell, THIRD_S[1], *self.meshes, *meshes), settings=self.settings)
        return Changed(scale.cut(variant), scale.seeds, self.damping, self.recorded)


def played_back(case: Case) -> Case:
    """The case with its drive replaced by the torque that the rigid arm needs in it."""
    rigid = rigid_motion(case, RIGID_STEP_S, round(TABLE_STEP_S / RIGID_STEP_S))
    time = rigid["time"].values.copy()
    time[-1] = max(time[-1], case.scenario.duration_s)
    return with_torque(case, time, rigid["torque"].values)


def with_torque(case: Case, time: np.ndarray, torque: np.ndarray) -> Case:
    """The case driven by torques (times, joints) [N m], by straight lines between times [s]."""
    drive = TableDrive(
        kind="table",
        time_s=tuple(map(float, time)),
        torque_N_m=tuple(tuple(map(float, column)) for column in torque.T),
    )
    return case._replace(scenario=case.scenario.model_copy(update={"drive": drive}))


def shoulder_excess(variant: Variant, elapsed: np.ndarray, theta_ddot: np.ndarray) -> np.ndarray:
    """Shoulder accelerations (times, members) less the rigid arm's at times since its start."""
    rigid = _simulated(rigid_arm(variant))
    own = np.interp(elapsed, rigid["time"].values, rigid["theta_ddot"].values[:, 0])
    return theta_ddot - own[:, None]


_simulated = lru_cache(maxsize=8)(simulate)


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
