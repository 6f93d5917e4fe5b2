"""Evidence 1: the clock test. A mechanism cannot know what time it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from analytic.model import PhysicalModel
from crosscheck import signals
from crosscheck.paper.numbers import defined
from crosscheck.paper.phase.experiments import Experiment, Response, responses, vibration
from crosscheck.paper.phase.linear import Base, base_motion
from crosscheck.paper.phase.plant import forces_along, plant_of
from crosscheck.paper.phase.verdict import Evidence, knows_the_clock
from crosscheck.paper.record import Record
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import shown
from crosscheck.report.figures import KILO, draw, legend, new_figure, to_svg
from crosscheck.report.fragments import COLOURS, figure, heading, paragraph, table
from crosscheck.studies.study import Study, Variant

CLOCKS_S = (0.0, 1.0, 5.0, 20.0)
LAWS = ("omega_t", "angle")
MOTION_S, RUN_S = 1.2, 0.3
RUN_ZETA = 0.02
RUN_WINDOW_S = (0.1, 0.28)  # past the starting impact, before the side change


@dataclass(frozen=True)
class ClockForce(Record):
    """Mesh forces along one motion, against those with the clock started at 0."""

    phase: str
    clock_s: float
    largest_change_N: float
    largest_force_N: float

    @property
    def id(self) -> str:
        return f"clock-force/{self.phase}/{self.clock_s:g}"


@dataclass(frozen=True)
class ClockRun(Record):
    """A run from rest, its clock started at another time."""

    phase: str
    clock_s: float
    vibration_rad_per_s2: float | None
    identical_to_clock_0: bool

    @property
    def id(self) -> str:
        return f"clock-run/{self.phase}/{self.clock_s:g}"


def clock_test(study: Study, scale: Scale) -> Evidence:
    """Forces along one motion and runs from one start, the clock set to 0, 1, 5 and 20 s."""
    motion = _motion(scale)
    forces = {law: _forces(law, motion) for law in LAWS}
    runs = _runs(study, scale)
    told, ran = _force_records(forces), _run_records(runs)
    blind = {
        law: not any(knows_the_clock(r.largest_change_N) for r in told if r.phase == law)
        for law in LAWS
    }
    text = [
        heading("1. The clock test"),
        paragraph(_statement(told, blind)),
        table(
            (
                "phase law",
                "clock at start [s]",
                "largest change of a mesh force, same motion [N]",
                "largest vibration in a run from rest [rad/s²]",
            ),
            [_row(force, run) for force, run in zip(told, ran, strict=True)],
        ),
        figure(_figure(motion.time, forces, runs), _caption()),
    ]
    return Evidence("\n".join(text), [*told, *ran], blind["angle"] and not blind["omega_t"])


def _motion(scale: Scale) -> Base:
    """The controlled arm's own motion, meshes pressed in as it needs; no damper has a say in it."""
    case = scale.cut(Variant(phase="angle", duration_s=MOTION_S)).case()
    return base_motion(case, plant_of(PhysicalModel(*case)), 10)


def _forces(law: str, motion: Base) -> dict[float, np.ndarray]:
    """Elastic force per planet [N], (times, meshes), by clock."""
    case = Variant(phase=law, ring_rate="corrected").case()
    plant = plant_of(PhysicalModel(*case))
    return {
        clock: forces_along(plant, motion.time + clock, motion.q, motion.v) for clock in CLOCKS_S
    }


def _runs(study: Study, scale: Scale) -> dict[tuple[str, float], Response]:
    one = scale.cut(Variant(ring_rate="corrected", zeta=RUN_ZETA, duration_s=RUN_S))
    wanted = {
        (law, clock): Experiment(replace(one, phase=law), clock)
        for law in LAWS
        for clock in CLOCKS_S
    }
    found = responses(study, list(wanted.values()), "phase: clock test")
    return {name: found[experiment] for name, experiment in wanted.items()}


def _force_records(forces: dict[str, dict[float, np.ndarray]]) -> list[ClockForce]:
    return [
        ClockForce(
            phase=law,
            clock_s=clock,
            largest_change_N=float(np.abs(values - by_clock[0.0]).max()),
            largest_force_N=float(np.abs(by_clock[0.0]).max()),
        )
        for law, by_clock in forces.items()
        for clock, values in by_clock.items()
    ]


def _run_records(runs: dict[tuple[str, float], Response]) -> list[ClockRun]:
    return [
        ClockRun(
            phase=law,
            clock_s=clock,
            vibration_rad_per_s2=defined(_largest(run)),
            identical_to_clock_0=bool(np.array_equal(run.theta_ddot, runs[law, 0.0].theta_ddot)),
        )
        for (law, clock), run in runs.items()
    ]


def _largest(run: Response) -> float:
    part = signals.window(run.time - run.time[0], *RUN_WINDOW_S)
    return signals.amplitude(vibration(run.time, run.theta_ddot[:, 0])[part])


def _row(force: ClockForce, run: ClockRun) -> tuple[str, ...]:
    same = ", bit for bit the run at 0" if run.identical_to_clock_0 and run.clock_s else ""
    return (
        force.phase,
        f"{force.clock_s:g}",
        f"{force.largest_change_N:.4g}",
        f"{shown(run.vibration_rad_per_s2)}{same}",
    )


def _statement(forces: Sequence[ClockForce], blind: dict[str, bool]) -> str:
    delay_s = CLOCKS_S[1]
    force = next(f for f in forces if (f.phase, f.clock_s) == ("omega_t", delay_s))
    says = {True: "does not depend on the clock", False: "depends on the clock"}
    return (
        "Question: does a mesh force depend on when a motion happens? The controlled arm's motion"
        f" over {MOTION_S:g} s (PD 1000/400, labelled reading, E = 5 µm) is taken as given, and"
        " the elastic mesh forces in it are worked out with the clock started at 0, 1, 5 and"
        " 20 s. No damper enters, so the unknown D has no say. Under omega_t a delay of"
        f" {delay_s:g} s changes a force by up to {force.largest_change_N:.0f} N, where"
        f" the largest force of all is {force.largest_force_N:.0f} N. Runs from rest"
        f" (zeta = {RUN_ZETA:g}) do the same. Verdict: under omega_t the force"
        f" {says[blind['omega_t']]}, under angle it {says[blind['angle']]}."
        " No law of a mechanism may do so: it is not the teeth that vibrate, it is the formula."
    )


def _figure(
    time: np.ndarray,
    forces: dict[str, dict[float, np.ndarray]],
    runs: dict[tuple[str, float], Response],
) -> str:
    drawing, grid = new_figure(2, 2, 2.3)
    for column, law in enumerate(LAWS):
        for clock, colour in zip(CLOCKS_S, COLOURS, strict=False):
            label = f"clock from {clock:g} s"
            above, below = grid[0, column], grid[1, column]
            draw(above, time, KILO * forces[law][clock][:, 0], label, colour)
            run = runs[law, clock]
            elapsed = run.time - run.time[0]
            draw(below, elapsed, run.theta_ddot[:, 0], label, colour)
        grid[0, column].set(title=law, xlabel="time since the start [s]")
        grid[1, column].set(xlabel="time since the start [s]")
    grid[0, 0].set_ylabel("F_sp1, same motion [kN]")
    grid[1, 0].set_ylabel("shoulder acceleration [rad/s²]")
    legend(drawing, grid[0, 1])
    for row in grid:
        low = min(axes.get_ylim()[0] for axes in row)
        high = max(axes.get_ylim()[1] for axes in row)
        for axes in row:
            axes.set_ylim(low, high)
    return to_svg(drawing)


def _caption() -> str:
    return (
        "Same motion (above) and same start (below), only the clock differs. Labelled reading,"
        f" b = 50 µm, E = 5 µm, ring rate corrected; below zeta = {RUN_ZETA:g}, first"
        f" {RUN_S:g} s, min-max bands. Under angle the four curves are one."
    )
