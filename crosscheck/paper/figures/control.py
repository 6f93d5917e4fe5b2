"""Figures 10 to 13: PD control to 30 degrees."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from crosscheck import signals
from crosscheck.paper import events
from crosscheck.paper.events import THIRD_S
from crosscheck.paper.figures.measures import impact, swing
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
    DERIVATIVE,
    GAINS,
    PROPORTIONAL,
    control_run,
    gain_run,
)
from crosscheck.paper.figures.verdicts import OVERSHOOT, by_law, near, restrained, verdict, visible
from crosscheck.paper.reading import arm_of, first_mesh
from crosscheck.paper.stage import paper_stage
from crosscheck.paper.undefined import all_of, extreme
from crosscheck.report.figures import new_figure, to_svg
from crosscheck.report.fragments import COLOURS

TARGET_RAD = np.pi / 6
BANDS = (0.02, 0.01)
SETTLED_S = 2.6  # Section 3.2
SIDE_S, BACK_S = 0.3, 1.5  # Section 3.2: the teeth change sides, and return
SIDE_TOLERANCE = 0.25  # the paper says "after 0.3 s"
BACK_TOLERANCE = 0.1
AFTER_THIRD_S = 1.4
ZOOM_S = {"side change": (0.345, 0.385), "third fluctuation": (1.10, 1.11)}


def figure_10(shelf: Shelf) -> Plate:
    """Joint angles for several gains."""
    gains = [*((p, GAINS[1]) for p in PROPORTIONAL), *((GAINS[0], d) for d in DERIVATIVE)]
    variants = {gain: gain_run(*gain) for gain in gains}
    runs = shelf.runs(variants.values(), 10)
    measured = {gain: _responses(runs[variant]) for gain, variant in variants.items()}
    rows = [
        (*gain, *(value for joint in m for value in (joint.overshoot_percent, *joint.within_s)))
        for gain, m in measured.items()
    ]
    own = measured[GAINS]
    per_joint = ("overshoot [%]", "within 2 % from [s]", "within 1 % from [s]")
    head = ("P", "D", *(f"θ_{joint}: {name}" for joint in (1, 2) for name in per_joint))
    overshoot = extreme((joint.overshoot_percent for joint in own), max)
    return Plate(
        10,
        "joint angles with different gains",
        _gains_svg({gain: runs[v] for gain, v in variants.items()}),
        "P = 1000 and D = 400 bring both joints to 30 degrees without considerable overshoot, and"
        " they stay there after 2.6 s. The other gains of the figure are not given in the text.",
        "Gains other than 1000 and 400 are this project's choice (P in N m/rad, D in N m s/rad)."
        f" At the paper's gains the largest overshoot is {overshoot:.1f} %.",
        conditions(runs[variants[GAINS]], "Other gains as in the legend."),
        {
            f"no overshoot above {100 * OVERSHOOT:g} % at the paper's gains": verdict(
                restrained(overshoot / 100)
            ),
            "both joints stay within 2 % after 2.6 s": verdict(
                _settled(runs[variants[GAINS]], [joint.within_s[0] for joint in own])
            ),
        },
        {"gains": {f"P {p} D {d}": [r.to_dict() for r in m] for (p, d), m in measured.items()}},
        table(head, rows),
    )


class Response(NamedTuple):
    """A joint's response to its step: overshoot, and when it stays within each of BANDS."""

    overshoot_percent: float
    within_s: tuple[float | None, ...]

    def to_dict(self) -> dict[str, float | None]:
        """For JSON."""
        names = (f"within_{100 * band:g}_percent_s" for band in BANDS)
        within = dict(zip(names, self.within_s, strict=True))
        return {"overshoot_percent": self.overshoot_percent, **within}


def _settled(run: xr.Dataset, times: Sequence[float | None]) -> bool | None:
    """Whether all joints have settled by SETTLED_S; None if the run ends before."""
    if run["time"].values[-1] < SETTLED_S:
        return None
    return all(time is not None and time <= SETTLED_S for time in times)


def _responses(run: xr.Dataset) -> list[Response]:
    """Of every joint."""
    time = run["time"].values
    return [
        Response(
            100 * max(0.0, events.overshoot(angle, TARGET_RAD)),
            tuple(events.settling(time, angle, TARGET_RAD, band) for band in BANDS),
        )
        for angle in run["theta"].values.T
    ]


def _gains_svg(runs: dict[tuple[float, float], xr.Dataset]) -> str:
    """(a), (b): P varies, shoulder and elbow; (c), (d): D varies."""
    figure, grid = new_figure(2, 2, 2.3)
    panels = iter("abcd")
    for varied, row in enumerate(grid):
        fixed = GAINS[1 - varied]
        chosen = {gain[varied]: run for gain, run in runs.items() if gain[1 - varied] == fixed}
        for joint, axes in enumerate(row):
            for (gain, run), colour in zip(chosen.items(), COLOURS, strict=False):
                degrees = np.degrees(run["theta"].values[:, joint])
                axes.plot(run["time"], degrees, color=colour, label=f"{'PD'[varied]} = {gain}")
            axes.axhline(np.degrees(TARGET_RAD), color="k", linewidth=0.6, linestyle=":")
            title = f"({next(panels)}) {('shoulder', 'elbow')[joint]}, {'DP'[varied]} = {fixed}"
            axes.set(xlabel="time [s]", ylabel="angle [deg]", title=title)
        row[0].legend(frameon=False, loc="lower right")
    return to_svg(figure)


def figure_11(shelf: Shelf) -> Plate:
    """Driving torques."""
    runs = shelf.laws(11, control_run)
    measured = {law: torques(run) for law, run in runs.items()}
    rows = [(law, *m.ripple_N_m, *m.largest_N_m) for law, m in measured.items()]
    names = ("ripple of T_{} [N m]", "largest |T_{}| [N m]")
    head = ("phase law", *(name.format(joint) for name in names for joint in (1, 2)))
    strips = _control_strips("T [N m]", lambda run: run["torque"].values)
    return Plate(
        11,
        "driving torques under PD control",
        law_figure(runs, strips),
        "While the angles are smooth, the torques of both joints fluctuate at high frequency.",
        "The ripple is half of the largest peak-to-peak value within 5 ms, in 0.5 to 1.2 s; it is D"
        " times the rate's, output side.",
        conditions(runs["angle"]),
        {
            "both torques ripple in 0.5 to 1.2 s": by_law(
                {
                    law: all_of(map(visible, m.ripple_N_m, m.largest_N_m))
                    for law, m in measured.items()
                }
            )
        },
        {"laws": {law: m._asdict() for law, m in measured.items()}},
        table(head, rows),
    )


class Torques(NamedTuple):
    """Of both joints: ripple in the third fluctuation, largest value [N m]."""

    ripple_N_m: list[float]
    largest_N_m: list[float]


def torques(run: xr.Dataset) -> Torques:
    """Of a run."""
    time, columns = run["time"].values, run["torque"].values.T
    return Torques(
        [swing(time, column, *THIRD_S) for column in columns],
        [signals.amplitude(column) for column in columns],
    )


def _control_strips(label: str, values: Callable[[xr.Dataset], np.ndarray]) -> list[Strip]:
    return [Strip(label, values, (0.0, 3.0)), *(Strip(label, values, w) for w in ZOOM_S.values())]


def figure_12(shelf: Shelf) -> Plate:
    """x_sp1 under PD control."""
    runs = shelf.laws(12, control_run)
    measured = {law: sides(run) for law, run in runs.items()}
    rows = [(law, *m) for law, m in measured.items()]
    torque = runs["angle"]["torque"].values[:, 0]
    brakes = signals.first_below(runs["angle"]["time"].values, torque, 0.0)
    head = ("phase law", "sides change at [s]", "and back at [s]", "changes in 0.5 to 1.4 s")
    return Plate(
        12,
        "sun-planet displacement of the shoulder under PD control",
        law_figure(runs, _control_strips("x_sp1 [µm]", lambda r: MICRO * first_mesh(r, "x_sp"))),
        "After 0.3 s the displacement changes sign: the teeth mesh on the opposite side. In 1.5 s"
        " they return.",
        f"{_braking(brakes)} Later changes are a vibration's.",
        conditions(runs["angle"]),
        {
            "the side changes near 0.3 s": by_law(
                {law: near(m.first_s, SIDE_S, SIDE_TOLERANCE) for law, m in measured.items()}
            ),
            "the teeth return near 1.5 s": by_law(
                {law: near(m.back_s, BACK_S, BACK_TOLERANCE) for law, m in measured.items()}
            ),
        },
        {"laws": {law: m._asdict() for law, m in measured.items()}},
        table(head, rows),
    )


def _braking(at_s: float | None) -> str:
    if at_s is None:
        return "The shoulder's torque does not turn negative in this run."
    return (
        f"The shoulder's torque turns negative at {at_s:.3f} s: the arm begins to brake, and the"
        " teeth change sides under either law."
    )


class Sides(NamedTuple):
    """When the teeth arrive at the other side and, after AFTER_THIRD_S, back; how often between.

    By the displacement; ``between`` counts from the third fluctuation's begin.
    """

    first_s: float | None
    back_s: float | None
    between: int


def sides(run: xr.Dataset) -> Sides:
    """Of the shoulder's first planet."""
    time, backlash = run["time"].values, paper_stage(arm_of(run)).backlash_m
    changes = events.arrivals(time, first_mesh(run, "x_sp"), backlash)
    later = changes[changes > AFTER_THIRD_S]
    between = (changes >= THIRD_S[0]) & (changes <= AFTER_THIRD_S)
    return Sides(
        float(changes[0]) if changes.size else None,
        float(later[0]) if later.size else None,
        int(between.sum()),
    )


def figure_13(shelf: Shelf) -> Plate:
    """F_sp1 under PD control."""
    runs = shelf.laws(13, control_run)
    measured = {law: _forces(run) for law, run in runs.items()}
    rows = [(law, *m) for law, m in measured.items()]
    head = (
        "phase law",
        "start peak [N]",
        "contact at the other side [s]",
        "its peak [N]",
        "bouncing [s]",
        "third fluctuation, ± [N]",
    )
    return Plate(
        13,
        "sun-planet force of the shoulder under PD control",
        law_figure(runs, _control_strips("F_sp1 [N]", lambda run: first_mesh(run, "F_sp"))),
        "The force changes its sign with the displacement, which excites the second fluctuation;"
        " the third one follows no sudden excitation.",
        "Elastic force per planet; ± is half of the largest peak-to-peak value in 5 ms.",
        conditions(runs["angle"]),
        {
            "the force changes its sign near 0.3 s": by_law(
                {law: near(m.contact_s, SIDE_S, SIDE_TOLERANCE) for law, m in measured.items()}
            )
        },
        {"laws": {law: m._asdict() for law, m in measured.items()}},
        table(head, rows),
    )


class Forces(NamedTuple):
    """F_sp1 at the start, at first contact of the opposite flanks, in the third fluctuation."""

    start_peak_N: float
    contact_s: float | None
    peak_N: float | None
    bouncing_s: float | None
    third_N: float


def _forces(run: xr.Dataset) -> Forces:
    time, force = run["time"].values, first_mesh(run, "F_sp")
    start = float(force[signals.window(time, 0, 0.1)].max())
    return Forces(start, *impact(time, force), swing(time, force, *THIRD_S))
