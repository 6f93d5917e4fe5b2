"""A vibration that has grown under the controller is handed over: does it live on the feedback?

From one and the same state the run goes on with the controller as it was, with the rigid arm's
torque played back, and with the controller looking at the sun.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from crosscheck import signals
from crosscheck.analytic.kernel.batch import Batch
from crosscheck.analytic.kernel.equations import TermEquations
from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.experiments.starts import Perturbed
from crosscheck.audit.experiments.torque import fast
from crosscheck.audit.hypotheses.evidence.flutter import played_back
from crosscheck.audit.phase.runs.experiments import models_of
from crosscheck.audit.phase.runs.plant import Continued
from crosscheck.models.experiment.drive import drive_data

HANDED_S, AFTER_S = 0.9, 0.2  # when it is handed over, and how long it is watched
LAST_S, SMOOTHED_S = 0.05, 5e-3  # where it is measured; slower than the meshes' vibrations
STRIDE = 5


class Handed(NamedTuple):
    """Shoulder vibration [rad/s^2] of every start, AFTER_S later, by what drives the arm."""

    link: list[float]
    torque: list[float]
    sun: list[float]


@dataclass(frozen=True)
class DriveHandover(Perturbed[Handed]):
    """The variant's run under PD control, handed over at HANDED_S."""

    cost = 16.0

    def answer(self) -> Handed:
        case, models = self.variant.case(), models_of(self.variant, self.seeds)
        table = drive_data(played_back(case, self.variant).scenario, len(case.arm.joints))
        later = table._replace(table_time=table.table_time - HANDED_S)
        model, states = models[0], grown(models)
        parts = model.arm, model.layout, model.gears
        ways = (
            model.term_equations,
            TermEquations(*parts, later, model.terms),
            TermEquations(*parts, model.drive, model.terms, sensor=model.terms.drive_map),
        )
        return Handed(*([_left(Continued(case, *x, way)) for x in states] for way in ways))


def grown(models: Sequence[PhysicalModel]) -> list[tuple[np.ndarray, np.ndarray]]:
    """The states q, v (n,) at HANDED_S."""
    steps = round(HANDED_S / models[0].scenario.step_s)
    *_, last = Batch(models).run(1, steps, 1)
    return [(last.q[-1, :, i].copy(), last.v[-1, :, i].copy()) for i in range(len(models))]


def _left(run: Continued) -> float:
    """Largest fast part [rad/s^2] of the shoulder's acceleration at the end; inf if it diverges."""
    step = run.scenario.step_s
    with np.errstate(invalid="ignore", over="ignore"):  # of a run that diverges
        made = Batch([run], lanes=1).advance(round(AFTER_S / step) // STRIDE, STRIDE).a
    time, shoulder = STRIDE * step * np.arange(len(made)), made[:, run.layout.theta[0], 0]
    if not np.isfinite(shoulder).all():
        return np.inf
    return signals.amplitude(fast(time, shoulder, SMOOTHED_S)[time >= AFTER_S - LAST_S])
