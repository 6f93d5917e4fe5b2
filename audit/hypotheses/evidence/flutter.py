"""Vibration that is left late in a simulated run, from many starts, and what it lives on.

The same motion runs with the controller and without it: the rigid arm's torque played back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from crosscheck import signals
from crosscheck.audit.claims.rule import State, quantiles_of, state
from crosscheck.audit.experiments.cells import INTEGRAL, Cell
from crosscheck.audit.experiments.pool import Sample
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.starts import RECORDED_S, TransientPd, rigid_course
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Numbers, Planets, Variant
from crosscheck.audit.measures.course import Course
from crosscheck.audit.measures.rigid import rigid_arm
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.undefined import finite
from crosscheck.audit.phase.runs.experiments import with_torque
from crosscheck.models.loading import Case

VIBRATES = 1.0  # rad/s^2: what is left of the impacts is below it by then
SETTLED_S = (0.9, 1.2)  # well after the impacts of the side change
TABLE_S = 1e-3  # rows of a torque that is played back
Damping = Literal["always", "contact"]


class FlutterSetting(NamedTuple):
    """What a vibration may hang on. played_back: the torque does not answer to the motion."""

    damping: Damping
    zeta: float
    tooth_error_um: float = 0.0
    varying: bool = True  # the mesh stiffness
    played_back: bool = False
    planets: Planets = "free"

    @property
    def id(self) -> str:
        """Names it in claims.json."""
        words = [
            self.damping,
            f"zeta {self.zeta:g}",
            f"E {self.tooth_error_um:g} um",
            "k varies" if self.varying else "k steady",
            "played back" if self.played_back else "PD",
            self.planets,
        ]
        return "/".join(words)

    def variant(self) -> Variant:
        """The PD run, the phase an integral, as long as needed."""
        meshes = [
            f"switches.damping={self.damping}",
            f"arm.joints.*.*_mesh.tooth_error_m={self.tooth_error_um * 1e-6!r}",
        ]
        if not self.varying:
            meshes.append("arm.joints.*.*_mesh.stiffness.amplitude_N_per_m=0.0")
        cell = Cell(INTEGRAL, self.zeta, planets=self.planets).variant()
        stride = round(RECORDED_S / cell.case().scenario.step_s)
        return replace(cell, meshes=tuple(meshes), duration_s=SETTLED_S[1], record_every=stride)


@dataclass(frozen=True)
class Vibrations(TransientPd):
    """Of the shoulder in SETTLED_S, less the rigid arm: size [rad/s^2] and frequency [Hz]."""

    played_back: bool = False

    def case(self) -> Case:
        case = super().case()
        return played_back(case, self.variant) if self.played_back else case

    def numbers(self, run: Course, rigid: tuple[Course, ...]) -> Numbers:
        (beside,) = rigid
        part = signals.window(run.time, *SETTLED_S)
        excess = (run.theta_ddot - beside.theta_ddot)[part, 0]
        return finite(
            {
                "vibration": signals.amplitude(excess),
                "frequency_Hz": signals.dominant_frequency(run.time[part], excess),
            }
        )


@dataclass(frozen=True)
class Flutter:
    """What is left in a setting: sizes [rad/s^2] of all starts that last so long, ascending.

    inf: the run diverged; frequency_Hz: median of those that vibrate, None for none.
    """

    setting: FlutterSetting
    sizes: tuple[float, ...]
    frequency_Hz: float | None

    @property
    def share(self) -> Share | None:
        """Of the starts that vibrate."""
        shaken = sum(size > VIBRATES for size in self.sizes)
        return Share(shaken, len(self.sizes)) if self.sizes else None

    @property
    def state(self) -> State:
        """Whether it vibrates here."""
        return state(self.share)

    @property
    def quantiles(self) -> tuple[float, ...]:
        """PARTS of the sizes; inf where these diverged."""
        return quantiles_of(self.sizes) or ()


def flutters(
    study: Study, settings: Sequence[FlutterSetting], seeds: tuple[int, ...], scale: Scale
) -> list[Flutter]:
    """Every setting from these starts."""
    asked = [
        Vibrations(scale.cut(one.variant()), seeds, played_back=one.played_back) for one in settings
    ]
    found = study.answers(asked, "H6, vibration against damping")
    return [
        flutter_of(one, Sample.of(measured)) for one, measured in zip(settings, found, strict=True)
    ]


def flutter_of(setting: FlutterSetting, sample: Sample) -> Flutter:
    """From what its starts measured; one that ends before says nothing."""
    sizes = np.where(sample.diverged, np.inf, sample["vibration"])
    vibrating = sample["frequency_Hz"][np.isfinite(sizes) & (sizes > VIBRATES)]
    known = np.sort(sizes[~np.isnan(sizes)])
    frequency = float(np.median(vibrating)) if vibrating.size else None
    return Flutter(setting, tuple(map(float, known)), frequency)


def played_back(case: Case, variant: Variant) -> Case:
    """The case with its drive replaced by the torque that the rigid arm needs in it."""
    count = round(case.scenario.duration_s / TABLE_S) + 1
    time = np.linspace(0.0, case.scenario.duration_s, count)
    return with_torque(case, time, rigid_course(rigid_arm(variant)).at(time).torque)
