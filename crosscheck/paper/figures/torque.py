"""Figures 6 to 9: constant torque on both joints."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from crosscheck import signals
from crosscheck.checks.trajectories import tip_position
from crosscheck.paper.figures.measures import cycles, swing
from crosscheck.paper.figures.plate import (
    MICRO,
    Plate,
    Shelf,
    Strip,
    conditions,
    law_figure,
    table,
)
from crosscheck.paper.figures.runs import (
    LOW_ZETA,
    QUICK_LEVELS,
    rigid_run,
    smooth_torque_run,
    torque_run,
)
from crosscheck.paper.figures.verdicts import (
    STRAY,
    by_law,
    converges,
    explains,
    grows,
    near,
    verdict,
)
from crosscheck.paper.numbers import quotient
from crosscheck.paper.reading import arm_of, first_mesh
from crosscheck.paper.stage import paper_stage
from crosscheck.paper.undefined import shown
from crosscheck.registry import RIGID_LEVELS
from crosscheck.report.figures import legend, new_figure, to_svg
from crosscheck.report.fragments import COLOURS

LATE_S = (0.1, 0.5)
# Section 3.1.
STATED_RAD, STATED_TIP_M = (0.02, 0.01), 0.03
STATED_X_M, STATED_RIPPLE_M = 52e-6, 10e-6


class Gap(NamedTuple):
    """Largest deviation of both joints from a rigid level."""

    level: str
    joint_1: float
    joint_2: float

    @property
    def largest(self) -> float:
        """Of both."""
        return max(self.joint_1, self.joint_2)


def figure_6(shelf: Shelf) -> Plate:
    """Deviation of the joint angles from the rigid arm."""
    geared, rigid = _levels(shelf, 6)
    gaps, tips_mm = _gaps(geared, rigid, "theta"), _tips_mm(geared, rigid)
    passed = _passed(geared, rigid["links"])
    head = ("rigid arm", "largest |Δθ_1| [rad]", "largest |Δθ_2| [rad]", "tip at the end [mm]")
    return Plate(
        6,
        "deviation of joint angles under constant torque",
        _deviation_svg(geared, rigid, "theta", ("Δθ", "rad")),
        "Deviations of about 0.02 rad (first link) and 0.01 rad (second), some 30 mm at the tip,"
        " accumulate over time; they are put down to the gears' meshing.",
        _against_links(passed, gaps),
        conditions(geared, "Δ: detailed less rigid; baseline of the paper: links."),
        {
            "the deviation comes from the mesh": _by_mesh(gaps),
            "the tip is 30 mm off": verdict(near(tips_mm[0] / 1e3, STATED_TIP_M, 0.25)),
        },
        {
            "levels": {
                gap.level: {
                    "theta_1_rad": gap.joint_1,
                    "theta_2_rad": gap.joint_2,
                    "tip_end_mm": tip_mm,
                }
                for gap, tip_mm in zip(gaps, tips_mm, strict=True)
            },
            "passed_s": passed,
        },
        table(head, [(*gap, tip_mm) for gap, tip_mm in zip(gaps, tips_mm, strict=True)]),
    )


def _tips_mm(geared: xr.Dataset, rigid: Mapping[str, xr.Dataset]) -> list[float]:
    """How far the tips are apart at the end, at every level."""
    arm = arm_of(geared)
    tip = tip_position(geared, arm)
    squares = [((tip - tip_position(run, arm)) ** 2).sum("axis") for run in rigid.values()]
    return [1e3 * float(np.sqrt(square)[-1]) for square in squares]


def _passed(geared: xr.Dataset, links: xr.Dataset) -> list[float | None]:
    """When [s] each joint's deviation from the links alone passes what the paper states."""
    time, gap = geared["time"].values, np.abs(_deviation(geared, links, "theta"))
    return [signals.first_above(time, gap[:, joint], said) for joint, said in enumerate(STATED_RAD)]


def _against_links(passed: Sequence[float | None], gaps: Sequence[Gap]) -> str:
    names = [f"{stated:g} rad at {_at(t)}" for stated, t in zip(STATED_RAD, passed, strict=True)]
    part = quotient(gaps[-1].largest, gaps[0].largest)
    return (
        f"Against the links alone the deviations pass the stated {names[0]} (shoulder) and"
        f" {names[1]} (elbow). The levels put into the rigid arm what its gears weigh, step by"
        " step: joint masses and carriers, reflected inertia, its coupling with the base's spin."
        f" What is left against the last one, {gaps[-1].largest:.2g} rad or {shown(part, '.1g')}"
        " of the whole, is the mesh's own part."
    )


def figure_7(shelf: Shelf) -> Plate:
    """Deviation of the joint rates from the rigid arm."""
    geared, rigid = _levels(shelf, 7)
    gaps = _gaps(geared, rigid, "theta_dot")
    head = ("rigid arm", "largest |Δω_1| [rad/s]", "largest |Δω_2| [rad/s]")
    return Plate(
        7,
        "deviation of joint rates under constant torque",
        _deviation_svg(geared, rigid, "theta_dot", ("Δω", "rad/s")),
        "Shown beside Fig. 6, without numbers, as the effect of the gear train.",
        "The mesh's own part is again what is left against the last level.",
        conditions(geared, "Δ: detailed less rigid; baseline of the paper: links."),
        {"the deviation comes from the mesh": _by_mesh(gaps)},
        {"levels": {g.level: {"joint_1": g.joint_1, "joint_2": g.joint_2} for g in gaps}},
        table(head, gaps),
    )


def _levels(shelf: Shelf, number: int) -> tuple[xr.Dataset, dict[str, xr.Dataset]]:
    variants = {
        level: rigid_run("constant-torque", level)
        for level in (QUICK_LEVELS if shelf.scale.quick else RIGID_LEVELS)
    }
    runs = shelf.runs([smooth_torque_run(), *variants.values()], number)
    return runs[smooth_torque_run()], {level: runs[v] for level, v in variants.items()}


def _deviation(geared: xr.Dataset, rigid: xr.Dataset, quantity: str) -> np.ndarray:
    return geared[quantity].values - rigid[quantity].values


def _gaps(geared: xr.Dataset, rigid: Mapping[str, xr.Dataset], quantity: str) -> list[Gap]:
    return [
        Gap(level, *np.abs(_deviation(geared, run, quantity)).max(axis=0).tolist())
        for level, run in rigid.items()
    ]


def _by_mesh(gaps: Sequence[Gap]) -> str:
    return verdict(explains(gaps[-1].largest, gaps[0].largest))


def _at(time: float | None) -> str:
    return "no time of this run" if time is None else f"{time:.3f} s"


def _deviation_svg(
    geared: xr.Dataset, rigid: Mapping[str, xr.Dataset], quantity: str, label: tuple[str, str]
) -> str:
    """The paper's baseline on the left, all levels on a logarithmic scale on the right.

    label: symbol and unit.
    """
    symbol, unit = label
    figure, grid = new_figure(1, 2, 2.8)
    left, right = grid[0]
    time, styles = geared["time"].values, ("-", "--")
    for (level, run), colour in zip(rigid.items(), COLOURS, strict=False):
        gap = _deviation(geared, run, quantity)
        for joint, style in enumerate(styles):
            size = np.maximum(np.abs(gap[:, joint]), 1e-9)
            right.plot(time, size, style, color=colour, label=None if joint else level)
            if level == "links":
                left.plot(time, gap[:, joint], style, color=colour, label=f"joint {joint + 1}")
    left.set(xlabel="time [s]", ylabel=f"{symbol} [{unit}]", title="detailed less rigid (links)")
    right.set(
        xlabel="time [s]",
        ylabel=f"|{symbol}| [{unit}]",
        yscale="log",
        title="all rigid levels (joint 2 dashed)",
    )
    left.legend(frameon=False)
    legend(figure, right)
    return to_svg(figure)


def figure_8(shelf: Shelf) -> Plate:
    """x_sp1 under constant torque."""
    runs = shelf.laws(8, lambda law: torque_run(law, LOW_ZETA))
    measured = {law: _displacement(run) for law, run in runs.items()}
    arm = arm_of(runs["angle"])
    stage = paper_stage(arm)
    force = 100 / (stage.geometry.n * stage.joint.planet_count * stage.geometry.r_s)
    static = stage.backlash_m + force / stage.mesh_stiffness_N_per_m
    speed = float(np.abs(runs["angle"]["theta_dot"].values[:, 0]).max())
    mesh_Hz = stage.joint.ring_teeth * speed / (2 * np.pi)
    rows = [(law, MICRO * m.middle_m, MICRO * m.ripple_m, *m.cycles) for law, m in measured.items()]
    head = ("phase law", "mid-range [µm]", "ripple [µm]", *(f"cycles to {t:g} s" for t in _ENDS_S))
    seen = (
        f"b + T / (n N r_s k_m) = {MICRO * static:.2f} µm and the ripple is 2 E less what the"
        " varying stiffness takes away: statics give both numbers under either law. The frequency"
        f" is that of the teeth, at most {mesh_Hz:.1f} Hz under angle, and not of a vibration; the"
        " elbow's reaction turns the shoulder back and stops it again: it does not only rise."
    )
    return Plate(
        8,
        "sun-planet displacement of the shoulder under constant torque",
        law_figure(runs, _strips("x_sp1 [µm]", "x_sp", MICRO)),
        "x_sp1 vibrates at the start and converges to 52 µm; then it ripples by about 10 µm, the"
        " tooth error, with a frequency that rises as the shoulder turns faster.",
        seen,
        conditions(runs["angle"]),
        {
            "mid-range 52 µm": _all(measured, lambda m: near(m.middle_m, STATED_X_M, 0.01)),
            "ripple about 10 µm": _all(measured, lambda m: near(m.ripple_m, STATED_RIPPLE_M, 0.2)),
            "the frequency rises with time": _all(measured, lambda m: grows(m.cycles)),
        },
        {
            "static_um": MICRO * static,
            "mesh_Hz": mesh_Hz,
            "laws": {law: m._asdict() for law, m in measured.items()},
        },
        table(head, rows),
    )


def _all(
    measured: Mapping[str, Displacement], decide: Callable[[Displacement], bool | None]
) -> str:
    return by_law({law: decide(m) for law, m in measured.items()})


_ENDS_S = (0.1, 0.2, 0.3, 0.4, 0.5)


class Displacement(NamedTuple):
    """x_sp1 under constant torque from 0.1 s on; slow cycles in each 0.1 s up to _ENDS_S."""

    middle_m: float
    ripple_m: float
    cycles: list[float]


def _displacement(run: xr.Dataset) -> Displacement:
    time, x = run["time"].values, first_mesh(run, "x_sp")
    late = x[signals.window(time, *LATE_S)]
    middle = signals.middle(late)
    parts = [signals.window(time, end - 0.1, end) for end in _ENDS_S]
    return Displacement(
        middle,
        signals.peak_to_peak(late),
        [cycles(time[p], x[p], middle, STATED_RIPPLE_M / 4) for p in parts],
    )


def _strips(label: str, quantity: str, scale: float) -> list[Strip]:
    windows = ((0.0, 0.5), (0.0, 0.01))
    return [Strip(label, lambda run: scale * first_mesh(run, quantity), w) for w in windows]


def figure_9(shelf: Shelf) -> Plate:
    """F_sp1 under constant torque."""
    runs = shelf.laws(9, lambda law: torque_run(law, LOW_ZETA))
    measured = {law: _force(run) for law, run in runs.items()}
    rows = [(law, *force) for law, force in measured.items()]
    ripple = max(quotient(force.late_ripple_N, force.late_mean_N) for force in measured.values())
    head = ("phase law", "start peak [N]", "late mean [N]", "late ripple [N]", "converged at [s]")
    return Plate(
        9,
        "sun-planet force of the shoulder under constant torque",
        law_figure(runs, _strips("F_sp1 [N]", "F_sp", 1.0)),
        "F_sp1 follows the same trend as x_sp1: an impact at the start, then convergence.",
        f"From {LATE_S[0]:g} s on the force ripples by {shown(ripple, '.2g')} of its mean: the"
        " displacement follows the tooth error of Fig. 8, the force need not.",
        conditions(runs["angle"], "Force per planet, without its damper."),
        {
            "a starting impact that converges": by_law(
                {
                    law: converges(force.late_mean_N, force.converged_s, LATE_S[1])
                    for law, force in measured.items()
                }
            )
        },
        {"laws": {law: force._asdict() for law, force in measured.items()}},
        table(head, rows),
    )


class Force(NamedTuple):
    """F_sp1 under constant torque; ripple and mean from 0.1 s on."""

    start_peak_N: float
    late_mean_N: float
    late_ripple_N: float
    converged_s: float | None


def _force(run: xr.Dataset) -> Force:
    time, force = run["time"].values, first_mesh(run, "F_sp")
    late = signals.mean(force[signals.window(time, *LATE_S)])
    return Force(
        float(force[signals.window(time, 0, 0.01)].max()),
        late,
        2 * swing(time, force, *LATE_S),
        signals.settling_time(time, force, late, STRAY * late),
    )
