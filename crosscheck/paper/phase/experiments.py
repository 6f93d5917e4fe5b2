"""Runs that no scenario file can state: another clock, start, drive, dampers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.signal import butter, sosfiltfilt

from analytic.model import PhysicalModel
from crosscheck import signals
from crosscheck.paper.fluctuation import THIRD_S
from crosscheck.paper.numbers import defined
from crosscheck.paper.phase.motion import Continued, Motion, motion
from crosscheck.paper.phase.plant import (
    Plant,
    accelerations_along,
    integrate,
    plant_of,
)
from crosscheck.paper.phase.rigid import rigid_motion
from crosscheck.studies.study import Study, Variant
from crosscheck.tasks import Failure
from crosscheck.workers import perform_all
from models.errors import Unfinished
from models.loading import Case
from models.scenario import TableDrive

ANALYTIC = "analytic:physical"
ENGINE = "exudyn:tree"
STRIDE = 2
HIGH_PASS_HZ = 600.0  # between the controlled arm's motion and the mesh modes
ORDER = 12  # each way: 1.7 kHz leaks less than 1e-5 through 3 kHz
FILTER_SAMPLES = 3 * (ORDER + 1)  # by which the filter continues a signal at either end
FILTER_EDGE_S = 0.02  # of the record's ends, which the filter does not see whole
RIGID_STEP_S, TABLE_STEP_S = 1e-4, 1e-3


class Setting(NamedTuple):
    """What the paper does not tell: damping ratio of all joints, reading of Eq. 13's ring rate."""

    zeta: float
    ring_rate: str


SETTINGS = (Setting(0.005, "eq13"), Setting(0.02, "corrected"))  # the third fluctuation's two


class Response(NamedTuple):
    """time (times,) [s], counted from the law's own t = 0; theta_ddot (times, joints) [rad/s^2].

    q, v (n,): the last state.
    """

    time: np.ndarray
    theta_ddot: np.ndarray
    q: np.ndarray
    v: np.ndarray


@dataclass(frozen=True)
class Experiment:
    """A variant with something changed that is not in its files.

    clock_s: what the clock shows at the start; after: start from the last state of that
    experiment, its clock going on; full_rate: phases from Eq. 11 in full; damping: factors on the
    dampers of sun and ring meshes; recorded: the rigid arm's torque played back, no feedback.
    """

    variant: Variant
    clock_s: float = 0.0
    after: Experiment | None = None
    full_rate: bool = False
    damping: tuple[float, float] = (1.0, 1.0)
    recorded: bool = False

    @property
    def key(self) -> str:
        """Different for different experiments."""
        return repr(self)

    @property
    def cost(self) -> float:
        """Rough seconds."""
        return 0.5 * (self.variant.duration_s or 3.0)

    def model(self) -> PhysicalModel:
        """The arm under this experiment's laws, but for Eq. 11 in full, at its start."""
        case = self.variant.case()
        if self.recorded:
            case = played_back(case)
        model = PhysicalModel(*case) if self.after is None else self._continued(case, self.after)
        factors = np.tile(self.damping, len(case.arm.joints))
        model.gears = model.gears._replace(d=model.gears.d * factors)
        return model

    @staticmethod
    def _continued(case: Case, after: Experiment) -> PhysicalModel:
        before = _performed(after)
        return Continued(case, before.q, before.v)

    def plant(self) -> Plant:
        """The same with Eq. 11 as the experiment has it."""
        return plant_of(self.model(), self.full_rate)

    def perform(self) -> Response:
        """Run it."""
        model = self.model()
        clock = self.clock_s if self.after is None else float(_performed(self.after).time[-1])
        run = self._in_full(model, clock) if self.full_rate else motion(model, clock)
        return Response(run.time, run.a[:, model.layout.theta], run.q[-1], run.v[-1])

    def _in_full(self, model: PhysicalModel, clock: float) -> Motion:
        """By Eq. 11 in full, which the model's own kernels do not know."""
        plant, scenario = plant_of(model, full_rate=True), model.scenario
        qs, vs = integrate(plant, clock, *model.start(), scenario.step_s, scenario.steps, STRIDE)
        time = clock + scenario.step_s * STRIDE * np.arange(len(qs))
        return Motion(time, qs, vs, accelerations_along(plant, time, qs, vs))


@lru_cache(maxsize=4)
def _performed(experiment: Experiment) -> Response:
    """What several experiments start from is run once."""
    return experiment.perform()


def played_back(case: Case) -> Case:
    """The case with its drive replaced by the torque that the rigid arm needs in it."""
    rigid = rigid_motion(case, RIGID_STEP_S, round(TABLE_STEP_S / RIGID_STEP_S))
    time = rigid["time"].values.copy()
    time[-1] = max(time[-1], case.scenario.duration_s)
    drive = TableDrive(
        kind="table",
        time_s=tuple(map(float, time)),
        torque_N_m=tuple(tuple(map(float, column)) for column in rigid["torque"].values.T),
    )
    return case._replace(scenario=case.scenario.model_copy(update={"drive": drive}))


def responses(
    study: Study, experiments: Sequence[Experiment], what: str
) -> dict[Experiment, Response]:
    """All of them, on the study's processes. Raises Unfinished."""
    wanted = list(dict.fromkeys(experiments))
    done = 0
    study.told(what, done, len(wanted))

    def finished(_: str) -> None:
        nonlocal done
        done += 1
        study.told(what, done, len(wanted))

    found = perform_all(wanted, study.jobs, finished)
    failures = [outcome for outcome in found.values() if isinstance(outcome, Failure)]
    if failures:
        raise Unfinished(f"{what}: {failures[0]}")
    return {experiment: found[experiment.key] for experiment in wanted}


@dataclass(frozen=True)
class ThirdAmplitude:
    """Largest shoulder vibration [rad/s^2] of an experiment's third fluctuation.

    None: the run diverged, or ends before.
    """

    experiment: Experiment

    @property
    def inputs(self) -> str:
        records = self.experiment.variant.case()
        return "\n".join([repr(self.experiment), *(r.model_dump_json() for r in records)])

    @property
    def cost(self) -> float:
        return self.experiment.cost

    def answer(self) -> float | None:
        return defined(third_amplitude(self.experiment.perform()))


def vibration(time: np.ndarray, values: np.ndarray, above_hz: float = HIGH_PASS_HZ) -> np.ndarray:
    """The fast part of a signal (times,): Butterworth, forth and back.

    Undefined, all nan, for one that is too short for the filter.
    """
    if values.size <= FILTER_SAMPLES:
        return np.full(values.shape, np.nan)
    rate = round(1 / (time[1] - time[0]))
    sections = butter(ORDER, above_hz, "highpass", fs=rate, output="sos")
    return sosfiltfilt(sections, values)


def third_amplitude(response: Response) -> float:
    """Largest shoulder vibration [rad/s^2] in the third fluctuation's window.

    Infinite if the run diverged, nan if it ends before.
    """
    signal = response.theta_ddot[:, 0]
    if not np.isfinite(signal).all():
        return float("inf")
    part = signals.window(response.time, THIRD_S[0], THIRD_S[1] - FILTER_EDGE_S)
    return signals.amplitude(vibration(response.time, signal)[part])
