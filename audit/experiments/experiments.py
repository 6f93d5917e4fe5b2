"""The experiments that the paper's statements are about: what each changes in a setting."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from crosscheck.audit.experiments import ensembles
from crosscheck.audit.experiments.ensembles import EnsembleNumbers, EnsembleQuestion
from crosscheck.audit.experiments.paper_conditions import Condition
from crosscheck.audit.experiments.variant import Variant
from crosscheck.models.interface import Model
from crosscheck.registry import build

SHORT_S = 1.2  # Fig. 14's length
START_ONLY_S = 0.3  # the first fluctuation, which the shoulder's change of sides ends
SLOW_RECORD_S = 1e-4  # constant torque and back and forth: nothing fast decides there
DEFAULT_B_UM, DEFAULT_E_UM = 50.0, 5.0
WIDE_M = 3e-3
CHAOTIC_UM = 1000.0  # a clearance with which Section 4.1 calls the fluctuation chaotic
TURNING_RAD_PER_S = -1.0  # a fast start away from the target: the links turn back on their way
_TWO = ("arm.joints.*.planet_count=2",)
# At equal stiffness of all meshes together: fewer pairs alone would also be softer ones.
_AS_STIFF = (
    "arm.joints.*.*_mesh.stiffness.mean_N_per_m=1.5e8",
    "arm.joints.*.*_mesh.stiffness.amplitude_N_per_m=3e7",
)
HARMONICS = 15  # of the square wave: the paper's even ones vanish
INSIDE_M = 1e-6  # so far into contact that a mesh's force is a straight line


@dataclass(frozen=True)
class PaperExperiment:
    """An experiment: what it changes in a setting's scenario, and how it is measured.

    size_um: of a family, what makes this member; question_class: None where no run is made; meshes:
    fields of all meshes, with their values; harmonics: of the square wave that is the meshes'
    stiffness; preloaded: whether teeth carry the load from the start.
    """

    kind: str
    size_um: float | None = None
    question_class: type[EnsembleQuestion[EnsembleNumbers]] | None = ensembles.TransientPdQuestion
    scenario: str = "pd"
    duration_s: float | None = SHORT_S
    every_s: float = ensembles.RECORDED_S
    meshes: tuple[tuple[str, float], ...] = ()
    settings: tuple[str, ...] = ()
    harmonics: int = 0
    preloaded: bool = False

    @property
    def size(self) -> float | None:
        """What makes this member of its family [um]."""
        return self.size_um

    @property
    def static(self) -> bool:
        """Whether the arm's data alone decide it: no run is made."""
        return self.question_class is None

    def __str__(self) -> str:
        return self.kind if self.size_um is None else f"{self.kind} {self.size_um:g} um"


class ExperimentSeries(NamedTuple):
    """Experiments that differ in one size [um]. symbol: the paper's for it; field: the meshes'."""

    kind: str
    symbol: str
    field: str
    plain: PaperExperiment = PaperExperiment("")

    def __call__(self, size_um: float) -> PaperExperiment:
        """The family's member of this size [um]."""
        meshes = ((self.field, float(size_um) * 1e-6), *self.plain.meshes)
        return replace(self.plain, kind=self.kind, size_um=float(size_um), meshes=meshes)


_BACKLASH, _ERROR, _AMPLITUDE = "backlash_m", "tooth_error_m", "stiffness.amplitude_N_per_m"
PD = PaperExperiment("pd", question_class=ensembles.WholePdQuestion, duration_s=None)
CONSTANT = PaperExperiment(
    "constant torque",
    scenario="constant-torque",
    question_class=ensembles.ConstantTorqueQuestion,
    duration_s=None,
    every_s=SLOW_RECORD_S,
)
# One effect of the gears left out.
NO_BACKLASH = PaperExperiment("no backlash", meshes=((_BACKLASH, 0),))
NO_ERROR = PaperExperiment("no error", meshes=((_ERROR, 0),))
CONSTANT_STIFFNESS = PaperExperiment("constant stiffness", meshes=((_AMPLITUDE, 0),))
# The shoulder's teeth alone excite: what the elbow does then comes through the links.
EXACT_ELBOW = PaperExperiment("exact elbow", settings=("arm.joints.1.*_mesh.tooth_error_m=0.0",))
# Two planets, the meshes as they are or together as stiff as three.
TWO_SOFTER = PaperExperiment("two planets as they are", settings=_TWO)
TWO_PLANETS = PaperExperiment("two planets", settings=(*_TWO, *_AS_STIFF))
# Fig. 5's wave in place of Eq. 8, its fundamental.
SQUARE = PaperExperiment("square wave", harmonics=HARMONICS)
PRELOADED = PaperExperiment("preloaded", duration_s=START_ONLY_S, preloaded=True)
# The same under constant torque.
CONSTANT_NO_ERROR, CONSTANT_SQUARE, CONSTANT_PRELOADED = (
    replace(
        CONSTANT,
        kind=f"{CONSTANT.kind}, {item.kind}",
        meshes=item.meshes,
        harmonics=item.harmonics,
        preloaded=item.preloaded,
    )
    for item in (NO_ERROR, SQUARE, PRELOADED)
)
# Section 4.1's 6 mm.
WIDE = replace(PD, kind="whole run, b = 3000 um", meshes=((_BACKLASH, WIDE_M),))
TURNING = replace(
    WIDE,
    kind="turning back, b = 3000 um",
    settings=(f"scenario.start.theta_dot_rad_per_s={TURNING_RAD_PER_S!r}",),
)
STATIC = PaperExperiment("static", question_class=None)  # follows from the arm's data alone
PLANTED = PaperExperiment("planted slips", question_class=None)  # likewise
BACKLASH = ExperimentSeries("backlash", "b", _BACKLASH)  # Figs. 16-18
ERROR = ExperimentSeries("tooth error", "E", _ERROR)  # Figs. 19-20
# What the claims ask of it ends before 1.2 s, where WIDE goes on: its numbers are those of WIDE.
WIDE_BEGINNING = BACKLASH(1e6 * WIDE_M)
DEFAULTS = (BACKLASH(DEFAULT_B_UM), ERROR(DEFAULT_E_UM))  # the PD run as a member of both sweeps
BACKLASH_NO_ERROR = ExperimentSeries("backlash, no error", "b", _BACKLASH, NO_ERROR)
_BACK = replace(CONSTANT, scenario="back-and-forth", question_class=ensembles.SwingQuestion)
_EVENLY = replace(_BACK, settings=("scenario.drive.argument=time",))
# Fig. 15, by sin(20 pi sqrt(t)) as printed and by sin(20 pi t).
BACK = ExperimentSeries("back and forth, backlash", "b", _BACKLASH, _BACK)
BACK_EVEN = ExperimentSeries("back and forth evenly, backlash", "b", _BACKLASH, _EVENLY)


SERIES = {s.kind: s for s in (BACKLASH, ERROR, BACKLASH_NO_ERROR, BACK, BACK_EVEN)}
EXPERIMENTS = {
    str(experiment): experiment
    for experiment in (
        *(PD, CONSTANT, NO_BACKLASH, NO_ERROR, CONSTANT_STIFFNESS, EXACT_ELBOW, TWO_SOFTER),
        *(TWO_PLANETS, SQUARE, PRELOADED, CONSTANT_NO_ERROR, CONSTANT_SQUARE, CONSTANT_PRELOADED),
        *(WIDE, TURNING, STATIC, PLANTED),
    )
}


def find_experiment(name: str) -> PaperExperiment:
    """The experiment whose text this is. Raises KeyError if there is none."""
    if name in EXPERIMENTS:
        return EXPERIMENTS[name]
    kind, size, _ = name.rsplit(" ", 2)
    return SERIES[kind](float(size))


def build_question(
    experiment: PaperExperiment, condition: Condition, seeds: tuple[int, ...]
) -> EnsembleQuestion[EnsembleNumbers]:
    """The experiment in a setting, as a question. Raises KeyError for one that has no run."""
    if experiment.question_class is None:
        raise KeyError(experiment)
    plain = condition.variant(experiment.scenario)
    variant = replace(
        plain,
        duration_s=experiment.duration_s,
        record_every=round(experiment.every_s / plain.case().scenario.step_s),
        meshes=tuple(
            f"arm.joints.*.*_mesh.{field}={value!r}" for field, value in experiment.meshes
        ),
        settings=experiment.settings,
        harmonics=experiment.harmonics,
    )
    return experiment.question_class(
        make_preloaded_variant(variant) if experiment.preloaded else variant, seeds
    )


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
