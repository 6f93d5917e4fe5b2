"""The experiments that the paper's statements are about: what each changes in a setting."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from crosscheck.audit.experiments.cells import Cell
from crosscheck.audit.experiments.lyapunov import Lyapunov
from crosscheck.audit.experiments.starts import (
    RECORDED_S,
    BackAndForth,
    ConstantTorque,
    Measured,
    Perturbed,
    TransientPd,
    WholePd,
)
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
class Source:
    """An experiment; of a family, the size [um] that makes this member. words: what it changes."""

    kind: str
    size_um: float | None = None
    words: str = ""

    def __str__(self) -> str:
        return self.kind if self.size_um is None else f"{self.kind} {self.size_um:g} um"


class Family(NamedTuple):
    """Experiments that differ in one size [um]. symbol: the paper's for it."""

    kind: str
    symbol: str

    def __call__(self, size_um: float) -> Source:
        """Its member of this size."""
        return Source(self.kind, float(size_um), f"at {self.symbol} = {size_um:g} µm")


PD, CONSTANT = Source("pd"), Source("constant torque")
# One effect of the gears left out, under PD control and under constant torque.
NO_BACKLASH = Source("no backlash", words="without backlash")
NO_ERROR = Source("no error", words="without tooth error")
CONSTANT_STIFFNESS = Source("constant stiffness", words="with constant stiffness")
CONSTANT_NO_ERROR = Source("constant torque, no error", words="without tooth error")
TWO_PLANETS = Source("two planets", words="with two planets, each mesh 1.5 times as stiff")
TWO_SOFTER = Source("two planets as they are", words="with two planets, each mesh as it is")
# Fig. 5's wave in place of Eq. 8, its fundamental.
SQUARE = Source("square wave", words="with the square wave of Fig. 5")
CONSTANT_SQUARE = Source("constant torque, square wave", words="with the square wave of Fig. 5")
PRELOADED = Source("preloaded", words="from teeth that already carry the load")
CONSTANT_PRELOADED = Source(
    "constant torque, preloaded", words="from teeth that already carry the load"
)
WIDE = Source("whole run, b = 3000 um", words="at b = 3000 µm")  # Section 4.1's 6 mm
TURNING = Source("turning back, b = 3000 um", words="at b = 3000 µm, links turning back")
NEIGHBOURS = Source("neighbouring motions, b = 1000 um", words="at b = 1000 µm")
STATIC = Source("static")  # follows from the arm's data alone
PLANTED = Source("planted slips")  # likewise
BACKLASH, ERROR = Family("backlash", "b"), Family("tooth error", "E")  # Figs. 16-20
BACKLASH_NO_ERROR = Family("backlash, no error", "b")
BACK = Family("back and forth, backlash", "b")  # Fig. 15, by sin(20 pi sqrt(t)) as printed
BACK_EVEN = Family("back and forth evenly, backlash", "b")  # by sin(20 pi t)


def question(source: Source, cell: Cell, seeds: tuple[int, ...]) -> Perturbed[Measured]:
    """The experiment in a setting. Raises KeyError for one that no run is made for."""
    short = replace(_recorded(cell.variant(), RECORDED_S), duration_s=SHORT_S)
    if source == PD:
        return WholePd(_recorded(cell.variant(), RECORDED_S), seeds)
    if source in (WIDE, TURNING):
        whole = _set(_recorded(cell.variant(), RECORDED_S), "backlash_m", WIDE_M)
        return WholePd(_changed(whole, source), seeds)
    if source == NEIGHBOURS:
        return Lyapunov(_set(short, "backlash_m", 1e-6 * CHAOTIC_UM), seeds)
    if source == PRELOADED:
        return TransientPd(preloaded(replace(short, duration_s=START_ONLY_S)), seeds)
    if source == CONSTANT_PRELOADED:
        driven = _recorded(cell.variant("constant-torque"), SLOW_RECORD_S)
        return ConstantTorque(preloaded(driven), seeds)
    if source in (CONSTANT, CONSTANT_NO_ERROR, CONSTANT_SQUARE):
        variant = _recorded(cell.variant("constant-torque"), SLOW_RECORD_S)
        return ConstantTorque(_changed(variant, source), seeds)
    if source.kind in (BACK.kind, BACK_EVEN.kind):
        shaken = _recorded(cell.variant("back-and-forth"), SLOW_RECORD_S)
        return BackAndForth(_changed(shaken, source), seeds)
    return TransientPd(_changed(short, source), seeds)


_SETTINGS = {
    TWO_PLANETS.kind: (*_TWO, *_AS_STIFF),
    TWO_SOFTER.kind: _TWO,
    BACK_EVEN.kind: ("scenario.drive.argument=time",),
    TURNING.kind: (f"scenario.start.theta_dot_rad_per_s={TURNING_RAD_PER_S!r}",),
}


def _changed(variant: Variant, source: Source) -> Variant:
    """What the experiment changes."""
    if source in (CONSTANT, WIDE):
        return variant
    if source in (SQUARE, CONSTANT_SQUARE):
        return replace(variant, harmonics=HARMONICS)
    if source.kind in _SETTINGS:
        variant = replace(variant, settings=_SETTINGS[source.kind])
    whole = (TWO_PLANETS, TWO_SOFTER, TURNING)
    return variant if source in whole else _mesh_changed(variant, source)


def _mesh_changed(variant: Variant, source: Source) -> Variant:
    """One field of all meshes."""
    if source.kind in (BACKLASH.kind, BACK.kind, BACK_EVEN.kind):
        return _set(variant, "backlash_m", _metres(source))
    if source.kind == BACKLASH_NO_ERROR.kind:
        return _set(_set(variant, "backlash_m", _metres(source)), "tooth_error_m", 0)
    if source.kind == ERROR.kind:
        return _set(variant, "tooth_error_m", _metres(source))
    return _set(variant, _LEFT_OUT[source], 0)


_LEFT_OUT = {
    NO_BACKLASH: "backlash_m",
    NO_ERROR: "tooth_error_m",
    CONSTANT_NO_ERROR: "tooth_error_m",
    CONSTANT_STIFFNESS: "stiffness.amplitude_N_per_m",
}


def _metres(source: Source) -> float:
    return (source.size_um or 0.0) * 1e-6


def _set(variant: Variant, field: str, value: float) -> Variant:
    return replace(variant, meshes=(*variant.meshes, f"arm.joints.*.*_mesh.{field}={value!r}"))


def _recorded(variant: Variant, every_s: float) -> Variant:
    step_s = variant.case().scenario.step_s
    return replace(variant, record_every=round(every_s / step_s))


def preloaded(variant: Variant) -> Variant:
    """The experiment from meshes that do not accelerate at t = 0: the teeth bear the drive.

    All planets alike: they share the load.
    """
    model = build(variant.model, *replace(variant, planets="lumped").case())
    sun, ring = resting_offsets(model).reshape(-1, 2).T
    offsets = {"sun_planet_offset_m": sun, "planet_ring_offset_m": ring}
    start = tuple(f"scenario.start.{name}={list(map(float, x))!r}" for name, x in offsets.items())
    return replace(variant, meshes=(*variant.meshes, *start))


def resting_offsets(model: Model) -> np.ndarray:
    """How far [m] every mesh is beyond its start when none accelerates, (meshes,).

    In the order of the layout. Forces are straight lines while teeth touch, so one step of Newton's
    method is exact.
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
