"""Evidence 6: where tooth error would resonate, and where stiffness would open tongues, under
`angle`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from crosscheck.paper.phase.resonance import (
    FASTEST_RAD_PER_S,
    RAMP_S,
    RAMP_ZETAS,
    SPEEDS,
    ZETAS,
    FloquetRates,
    Resonances,
    RunUp,
    StageModes,
    Tongue,
    fastest,
    stage_modes,
)
from crosscheck.paper.phase.verdict import FAR, Evidence, is_far
from crosscheck.paper.record import JsonObject, Record, read
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import shown
from crosscheck.report.figures import legend, log_y, new_figure, to_svg
from crosscheck.report.fragments import COLOURS, figure, heading, paragraph, table
from crosscheck.studies.study import Study

TONGUE_PER_S = 1.0  # growth that counts


@dataclass(frozen=True)
class Speeds(Record):
    """The rigid arm's fastest joint speed [rad/s] in the paper's scenarios."""

    pd: float
    constant_torque: float
    back_and_forth: float

    @property
    def id(self) -> str:
        return "resonance/speeds"

    def to_dict(self) -> JsonObject:
        return {
            "id": self.id,
            "pd_rad_per_s": self.pd,
            "constant-torque_rad_per_s": self.constant_torque,
            "back-and-forth_rad_per_s": self.back_and_forth,
        }


@dataclass(frozen=True)
class RunUpPeaks(Record):
    """The largest vibration near every mode, and that below all of them; None: not that fast."""

    zeta: float
    peak_speeds_rad_per_s: tuple[float | None, ...]
    peaks_rad_per_s2: tuple[float | None, ...]
    below_resonance_rad_per_s2: float | None

    @property
    def id(self) -> str:
        return f"run-up/{self.zeta:g}"


@dataclass(frozen=True)
class TongueGrowth(Record):
    """Where and how fast the stiffness lets a mesh vibration grow; None: nowhere."""

    zeta: float
    largest_growth_per_s: float
    at_rad_per_s: float
    lowest_open_rad_per_s: float | None
    at_the_pd_runs_fastest_per_s: float

    @property
    def id(self) -> str:
        return f"tongue/{self.zeta:g}"


def resonance(study: Study, scale: Scale) -> Evidence:
    """A run-up of one stage, Floquet theory of the stiffness, and the paper's own speeds."""
    modes = stage_modes()
    speeds = Speeds(fastest("pd"), fastest("constant-torque"), fastest("back-and-forth"))
    ramps, growth = _answers(study, speeds, scale)
    peaks = [_ramp_record(zeta, ramp) for zeta, ramp in ramps.items()]
    tongues = [_tongue_record(zeta, rates) for zeta, rates in growth.items()]
    text = [
        heading("6. Where would tooth error resonate under angle?"),
        paragraph(_statement(speeds, modes, tongues)),
        table(_HEAD, [_row(n, modes, speeds, peaks) for n in range(len(modes.modes_Hz))]),
        table(_TONGUE_HEAD, [_tongue_row(tongue) for tongue in tongues]),
        figure(_figure(ramps, growth, modes, speeds), _caption()),
    ]
    records = [*peaks, *tongues, speeds, modes]
    return Evidence("\n".join(text), records, is_far(modes.speeds[0], speeds.pd))


def _answers(
    study: Study, speeds: Speeds, scale: Scale
) -> tuple[dict[float, Resonances], dict[float, FloquetRates]]:
    """Run-ups and growth rates, by damping ratio."""
    asked: list[RunUp | Tongue] = [RunUp(zeta, scale.seconds(RAMP_S)) for zeta in RAMP_ZETAS]
    asked += [Tongue(zeta, speeds.pd) for zeta in ZETAS]
    found = study.answers(asked, "phase: run-up and tongues")
    ramps = read(list[Resonances], found[: len(RAMP_ZETAS)])
    growth = read(list[FloquetRates], found[len(RAMP_ZETAS) :])
    return dict(zip(RAMP_ZETAS, ramps, strict=True)), dict(zip(ZETAS, growth, strict=True))


def _ramp_record(zeta: float, ramp: Resonances) -> RunUpPeaks:
    return RunUpPeaks(
        zeta=zeta,
        peak_speeds_rad_per_s=tuple(peak.speed for peak in ramp.peaks),
        peaks_rad_per_s2=tuple(peak.size for peak in ramp.peaks),
        below_resonance_rad_per_s2=ramp.away_rad_per_s2,
    )


def _tongue_record(zeta: float, rates: FloquetRates) -> TongueGrowth:
    growth = np.array(rates.growth)
    open_at = SPEEDS[growth > TONGUE_PER_S]
    return TongueGrowth(
        zeta=zeta,
        largest_growth_per_s=float(growth.max()),
        at_rad_per_s=float(SPEEDS[np.argmax(growth)]),
        lowest_open_rad_per_s=float(open_at[0]) if open_at.size else None,
        at_the_pd_runs_fastest_per_s=rates.slow,
    )


_HEAD = (
    "mode [Hz]",
    "met at carrier speed 2π f / c [rad/s]",
    "times the PD run's fastest",
    *(f"run-up, zeta {zeta:g}: peak at [rad/s], [rad/s²]" for zeta in RAMP_ZETAS),
)
_TONGUE_HEAD = (
    "zeta",
    "largest growth, 15 to 600 rad/s [1/s]",
    "at [rad/s]",
    "lowest speed with growth [rad/s]",
    "growth at the PD run's fastest [1/s]",
)


def _row(
    number: int, modes: StageModes, speeds: Speeds, run_ups: Sequence[RunUpPeaks]
) -> tuple[str, ...]:
    speed = modes.speeds[number]
    peaks = [(r.peak_speeds_rad_per_s[number], r.peaks_rad_per_s2[number]) for r in run_ups]
    return (
        f"{modes.modes_Hz[number]:.1f}",
        f"{speed:.1f}",
        f"{speed / speeds.pd:.0f}",
        *(f"{shown(at, '.1f')}, {shown(size)}" for at, size in peaks),
    )


def _tongue_row(tongue: TongueGrowth) -> tuple[str, ...]:
    lowest = tongue.lowest_open_rad_per_s
    return (
        f"{tongue.zeta:g}",
        f"{tongue.largest_growth_per_s:.1f}",
        f"{tongue.at_rad_per_s:.1f}",
        "none" if lowest is None else f"{lowest:.1f}",
        f"{tongue.at_the_pd_runs_fastest_per_s:.1f}",
    )


def _statement(speeds: Speeds, modes: StageModes, tongues: Sequence[TongueGrowth]) -> str:
    lowest = modes.speeds[0]
    opened = [t.lowest_open_rad_per_s for t in tongues if t.lowest_open_rad_per_s is not None]
    tongue = f"{min(opened):.1f} rad/s" if opened else "no speed below 600 rad/s"
    return (
        "Question: tooth error does excite gears in earnest, when teeth pass at a mesh mode's"
        " frequency. Where is that for this arm? One stage with its link is run up by a constant"
        f" torque to {FASTEST_RAD_PER_S:g} rad/s in {RAMP_S:g} s (E = 5 µm, stiffness held"
        " constant so that nothing else excites); and for the time-variant stiffness Floquet"
        " theory gives the speeds at which a mesh vibration grows. The first resonance is at"
        f" {lowest:.1f} rad/s. The fastest joint speeds of the rigid arm are {speeds.pd:.2f}"
        f" rad/s in the PD run, {speeds.constant_torque:.1f} under constant torque and"
        f" {speeds.back_and_forth:.1f} back and forth: the PD run's teeth pass at"
        f" {modes.teeth * speeds.pd / (2 * np.pi):.1f} Hz at most,"
        f" {lowest / speeds.pd:.0f} times too slowly. The lowest speed at which k_a lets a"
        f" vibration grow, at the smallest damping, is {tongue}. Verdict: the PD run"
        f" {'stays far from' if is_far(lowest, speeds.pd) else 'comes near'} a resonance under"
        f" angle (limit: {FAR:g} times)."
    )


def _figure(
    ramps: Mapping[float, Resonances],
    growth: Mapping[float, FloquetRates],
    modes: StageModes,
    speeds: Speeds,
) -> str:
    drawing, grid = new_figure(2, 1, 2.3)
    above, below = grid[:, 0]
    colours = dict(zip(ZETAS, COLOURS, strict=False))
    for zeta, ramp in ramps.items():
        above.plot(ramp.drawn_speed, ramp.drawn_size, color=colours[zeta])
    log_y(above)
    for zeta, rates in growth.items():
        below.plot(SPEEDS, rates.growth, color=colours[zeta], label=f"zeta = {zeta:g}")
    legend(drawing, below)
    for speed in modes.speeds:
        above.axvline(speed, color="black", ls="--", lw=0.8)
    for axes in (above, below):
        axes.axvspan(0.0, speeds.pd, color="#b03050", alpha=0.8)
        axes.set_xlim(-5.0, None)
    below.axhline(0.0, color="black", lw=0.6)
    above.set_ylabel("vibration, run-up [rad/s²]")
    below.set(xlabel="carrier speed [rad/s]", ylabel="Floquet growth rate [1/s]")
    return to_svg(drawing)


def _caption() -> str:
    return (
        "Above: run-up of one stage under angle, largest vibration per bin, dashed: teeth pass at a"
        " mesh mode. Below: growth of a mesh vibration by k_a = 0.2 k_m alone. Red strip at the"
        " left edge: all speeds of the PD run."
    )
