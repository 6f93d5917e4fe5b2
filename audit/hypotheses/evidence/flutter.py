"""Vibration that is left late in a simulated run, from many starts, and what it lives on.

The same motion runs with the controller and without it: the rigid arm's torque played back. And a
vibration that has grown under the controller goes on under another law: from one and the same state
the run goes on with the controller as it was, with that torque, and with the controller looking at
the sun.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from crosscheck import signals
from crosscheck.analytic.kernel.batch import Batch
from crosscheck.analytic.kernel.equations import TermEquations
from crosscheck.audit.claims.rule import State, quantiles_of, state
from crosscheck.audit.experiments import ensembles, paper_conditions, samples
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.torque import fast_part
from crosscheck.audit.experiments.variant import Numbers, Planets, Variant
from crosscheck.audit.measures.rigid import rigid_arm
from crosscheck.audit.measures.run_signals import RunSignals
from crosscheck.audit.measures.shares import Share, share_of
from crosscheck.audit.measures.undefined import floats_or_none
from crosscheck.audit.phase.runs import ContinuedModel, build_models, set_drive_torque
from crosscheck.models.experiment.drive import drive_data
from crosscheck.models.loading import Case

VIBRATES = 1.0  # rad/s^2: what is left of the impacts is below it by then
SETTLED_S = (0.9, 1.2)  # well after the impacts of the side change
TABLE_S = 1e-3  # rows of a torque that is played back
HANDED_S, AFTER_S = 0.9, 0.2  # when it is handed over, and how long it is watched
LAST_S, SMOOTHED_S = 0.05, 5e-3  # where it is measured; slower than the meshes' vibrations
STRIDE = 5
Damping = Literal["always", "contact"]


class FlutterSetting(NamedTuple):
    """What a vibration may depend on. played_back: the torque does not answer to the motion."""

    damping: Damping
    zeta: float
    tooth_error_um: float = 0.0
    varying: bool = True  # the mesh stiffness
    played_back: bool = False
    planets: Planets = "free"

    @property
    def id(self) -> str:
        """The name of the setting in claims.json."""
        stiffness = "k varies" if self.varying else "k steady"
        drive = "played back" if self.played_back else "PD"
        numbers = f"zeta {self.zeta:g}/E {self.tooth_error_um:g} um"
        return f"{self.damping}/{numbers}/{stiffness}/{drive}/{self.planets}"

    def variant(self) -> Variant:
        """The PD run of the setting, the phase an integral, until SETTLED_S ends."""
        meshes = [
            f"switches.damping={self.damping}",
            f"arm.joints.*.*_mesh.tooth_error_m={self.tooth_error_um * 1e-6!r}",
        ]
        if not self.varying:
            meshes.append("arm.joints.*.*_mesh.stiffness.amplitude_N_per_m=0.0")
        cell = paper_conditions.Condition(
            paper_conditions.INTEGRAL, self.zeta, planets=self.planets
        ).variant()
        stride = round(ensembles.RECORDED_S / cell.case().scenario.step_s)
        return replace(cell, meshes=tuple(meshes), duration_s=SETTLED_S[1], record_every=stride)


@dataclass(frozen=True)
class VibrationQuestion(ensembles.TransientPdQuestion):
    """A question: shoulder vibration in SETTLED_S, less the rigid arm: [rad/s^2] and [Hz]."""

    played_back: bool = False

    def case(self) -> Case:
        case = super().case()
        return replace_drive_by_rigid_torque(case, self.variant) if self.played_back else case

    def numbers(self, run: RunSignals, rigid: tuple[RunSignals, ...]) -> Numbers:
        (beside,) = rigid
        part = signals.window(run.time, *SETTLED_S)
        excess = (run.theta_ddot - beside.theta_ddot)[part, 0]
        return floats_or_none(
            {
                "vibration": signals.amplitude(excess),
                "frequency_Hz": signals.dominant_frequency(run.time[part], excess),
            }
        )


@dataclass(frozen=True)
class Flutter:
    """Vibration left in a setting: sizes [rad/s^2] of the starts that last so long, ascending.

    inf: the run diverged; frequency_Hz: median of those that vibrate, None for none.
    """

    setting: FlutterSetting
    sizes: tuple[float, ...]
    frequency_Hz: float | None

    @property
    def share(self) -> Share | None:
        """The share of the starts that vibrate; None without any."""
        return share_of(size > VIBRATES for size in self.sizes)

    @property
    def state(self) -> State:
        """What the starts say of whether the setting vibrates."""
        return state(self.share)

    @property
    def quantiles(self) -> tuple[float, ...]:
        """The quantiles PARTS of the sizes; inf where these diverged."""
        return quantiles_of(self.sizes) or ()


def measure_flutter(
    study: Study, settings: Sequence[FlutterSetting], scale: Scale
) -> list[Flutter]:
    """The vibration in every setting, from the scale's starts."""
    questions = {
        flutter_setting: VibrationQuestion(
            scale.cut(flutter_setting.variant()),
            scale.seeds,
            played_back=flutter_setting.played_back,
        )
        for flutter_setting in settings
    }
    measurements = study.answer_by_key(questions, "H6, vibration against damping")
    return [
        summarize_flutter(setting, samples.Sample.from_numbers(measured))
        for setting, measured in measurements.items()
    ]


def summarize_flutter(setting: FlutterSetting, sample: samples.Sample) -> Flutter:
    """The vibration in a setting from what its starts measured; starts that end before left out."""
    sizes = np.where(sample.diverged, np.inf, sample["vibration"])
    vibrating = sample["frequency_Hz"][np.isfinite(sizes) & (sizes > VIBRATES)]
    defined_sizes = np.sort(sizes[~np.isnan(sizes)])
    frequency = float(np.median(vibrating)) if vibrating.size else None
    return Flutter(setting, tuple(map(float, defined_sizes)), frequency)


def replace_drive_by_rigid_torque(case: Case, variant: Variant) -> Case:
    """The case with its drive replaced by the torque that the rigid arm needs in it."""
    count = round(case.scenario.duration_s / TABLE_S) + 1
    time = np.linspace(0.0, case.scenario.duration_s, count)
    return set_drive_torque(case, time, ensembles.rigid_course(rigid_arm(variant)).at(time).torque)


class VibrationAfterHandover(NamedTuple):
    """The shoulder vibration [rad/s^2] of every start, AFTER_S later, by what drives the arm."""

    link: list[float]
    torque: list[float]
    sun: list[float]


@dataclass(frozen=True)
class DriveHandover(ensembles.EnsembleQuestion[VibrationAfterHandover]):
    """A question: the variant's run under PD control, its law switched at HANDED_S."""

    cost = 16.0

    def answer(self) -> VibrationAfterHandover:
        case, models = self.variant.case(), build_models(self.variant, self.seeds)
        table = drive_data(
            replace_drive_by_rigid_torque(case, self.variant).scenario, len(case.arm.joints)
        )
        later = table._replace(table_time=table.table_time - HANDED_S)
        model = models[0]
        *_, last = Batch(models).run(1, round(HANDED_S / model.scenario.step_s), 1)
        states = [(last.q[-1, :, i].copy(), last.v[-1, :, i].copy()) for i in range(len(models))]
        parts = model.arm, model.layout, model.gears
        ways = (
            model.term_equations,
            TermEquations(*parts, later, model.terms),
            TermEquations(*parts, model.drive, model.terms, sensor=model.terms.drive_map),
        )
        return VibrationAfterHandover(
            *([_residual_vibration(ContinuedModel(case, *x, way)) for x in states] for way in ways)
        )


def _residual_vibration(run: ContinuedModel) -> float:
    """Largest fast part [rad/s^2] of the shoulder's acceleration at the end; inf if it diverges."""
    step = run.scenario.step_s
    with np.errstate(invalid="ignore", over="ignore"):  # of a run that diverges
        made = Batch([run], lanes=1).advance(round(AFTER_S / step) // STRIDE, STRIDE).a
    time, shoulder = STRIDE * step * np.arange(len(made)), made[:, run.layout.theta[0], 0]
    if not np.isfinite(shoulder).all():
        return np.inf
    return signals.amplitude(fast_part(time, shoulder, SMOOTHED_S)[time >= AFTER_S - LAST_S])
