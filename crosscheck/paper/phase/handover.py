"""Evidence 5: the large vibration handed over to the other law."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from crosscheck import signals
from crosscheck.paper.fluctuation import THIRD_S
from crosscheck.paper.numbers import defined
from crosscheck.paper.phase.experiments import (
    FILTER_EDGE_S,
    Experiment,
    Response,
    Setting,
    responses,
    vibration,
)
from crosscheck.paper.phase.verdict import Evidence, dies
from crosscheck.paper.record import JsonObject, Record
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import all_of, known, shown, word
from crosscheck.report.figures import draw, new_figure, to_svg
from crosscheck.report.fragments import COLOURS, figure, heading, paragraph, table
from crosscheck.studies.study import Study, Variant

# At the smallest damping the controller itself flutters.
SETTINGS = (
    Setting(0.003, "eq13"),
    Setting(0.005, "eq13"),
    Setting(0.007, "eq13"),
    Setting(0.02, "corrected"),
)
SHOWN = SETTINGS[1]
AFTER_S = 0.4
# After the handover: what is handed over, what is left soon and late.
FIRST_S, SOON_S, LAST_S = (0.0, 0.01), (0.03, 0.04), (0.33, 0.38)
NO_ERROR = "arm.joints.*.tooth_error_m=0.0"


class Heir(NamedTuple):
    """A law under which the vibration goes on, with the tooth error or without."""

    law: str
    with_error: bool = True

    @property
    def name(self) -> str:
        """In words."""
        return self.law if self.with_error else f"{self.law}, E = 0"


PRINTED, INTEGRATED, ERROR_FREE = Heir("omega_t"), Heir("angle"), Heir("angle", with_error=False)
HEIRS = (PRINTED, INTEGRATED, ERROR_FREE)
Handovers = Mapping[tuple[Setting, Heir], Response]


@dataclass(frozen=True)
class Handover(Record):
    """A vibration [rad/s^2] handed over at a time, and what is left of it; None: undefined."""

    zeta: float
    ring_rate: str
    heir: Heir
    at_s: float
    before_rad_per_s2: float | None
    soon_rad_per_s2: float | None
    after_rad_per_s2: float | None
    dies: bool | None

    @property
    def id(self) -> str:
        return f"handover/{self.zeta:g}/{self.heir.name}"

    def to_dict(self) -> JsonObject:
        return {**super().to_dict(), "heir": self.heir.name}


def handover(study: Study, scale: Scale) -> Evidence:
    """The state at the height of the vibration, continued under each law."""
    before = {setting: _peak_s(study, setting, scale) for setting in SETTINGS}
    wanted = {
        (setting, heir): _continued(setting, heir, at_s, scale)
        for setting, at_s in before.items()
        if at_s is not None
        for heir in HEIRS
    }
    found = responses(study, list(wanted.values()), "phase: handover")
    runs = {name: found[experiment] for name, experiment in wanted.items()}
    records = [_record(*name, run) for name, run in runs.items()]
    text = [heading("5. The vibration handed over"), paragraph(_statement(records))]
    text.append(table(_HEAD, [_row(record) for record in records]))
    at_s = before[SHOWN]
    if at_s is not None:
        text.append(figure(_figure(runs), _caption(at_s)))
    return Evidence("\n".join(text), records, _supports(records))


def _variant(setting: Setting, duration_s: float) -> Variant:
    zeta, ring = setting
    return Variant(phase="omega_t", ring_rate=ring, zeta=zeta, duration_s=duration_s)


def _peak_s(study: Study, setting: Setting, scale: Scale) -> float | None:
    """When the shoulder's vibration under omega_t is largest, in whole milliseconds.

    None if the run diverged or ends before the third fluctuation.
    """
    experiment = Experiment(scale.cut(_variant(setting, THIRD_S[1])))
    run = responses(study, [experiment], "phase: handover")[experiment]
    part = signals.window(run.time, THIRD_S[0], THIRD_S[1] - FILTER_EDGE_S)
    if part.stop <= part.start or not known(run.theta_ddot):
        return None
    fast = np.abs(vibration(run.time, run.theta_ddot[:, 0])[part])
    return round(float(run.time[part][np.argmax(fast)]), 3)


def _continued(setting: Setting, heir: Heir, at_s: float, scale: Scale) -> Experiment:
    after = Experiment(_variant(setting, at_s))
    variant = replace(
        scale.cut(_variant(setting, AFTER_S)),
        phase=heir.law,
        ring_rate=setting.ring_rate if heir.law == "omega_t" else "corrected",
        settings=() if heir.with_error else (NO_ERROR,),
    )
    return Experiment(variant, after=after)


def _record(setting: Setting, heir: Heir, run: Response) -> Handover:
    elapsed = run.time - run.time[0]
    fast = vibration(run.time, run.theta_ddot[:, 0])
    before, soon, after = (
        signals.amplitude(fast[signals.window(elapsed, *window)])
        for window in (FIRST_S, SOON_S, LAST_S)
    )
    return Handover(
        zeta=setting.zeta,
        ring_rate=setting.ring_rate,
        heir=heir,
        at_s=float(run.time[0]),
        before_rad_per_s2=defined(before),
        soon_rad_per_s2=defined(soon),
        after_rad_per_s2=defined(after),
        dies=dies(before, after),
    )


def _supports(records: Sequence[Handover]) -> bool | None:
    """Dies under `angle` wherever the controller itself does not flutter without tooth error."""
    by = {(r.zeta, r.heir): r.dies for r in records}
    pairs = [(by.get((s.zeta, INTEGRATED)), by.get((s.zeta, ERROR_FREE))) for s in SETTINGS]
    return all_of(dead for dead, dead_without in pairs if dead_without is not False)


_HEAD = (
    "zeta",
    "ring rate of the start",
    "continued under",
    "at [s]",
    "handed over [rad/s²]",
    f"left after {SOON_S[0]:g} s [rad/s²]",
    f"left after {LAST_S[0]:g} s [rad/s²]",
    "dies",
)


def _row(record: Handover) -> tuple[str, ...]:
    return (
        f"{record.zeta:g}",
        record.ring_rate,
        record.heir.name,
        f"{record.at_s:.3f}",
        shown(record.before_rad_per_s2, ".4g"),
        shown(record.soon_rad_per_s2),
        shown(record.after_rad_per_s2),
        word(record.dies),
    )


def _statement(records: Sequence[Handover]) -> str:
    under_angle = [r for r in records if r.heir == INTEGRATED]
    dying = [f"{r.zeta:g}" for r in under_angle if r.dies]
    living = [
        f"zeta = {r.zeta:g}: {r.before_rad_per_s2:.0f} becomes"
        f" {r.after_rad_per_s2:.0f} rad/s²"
        f" (without tooth error {shown(_without(records, r.zeta), '.0f')})"
        for r in under_angle
        if r.dies is False
    ]
    exception = (
        f" It does not die at {'; '.join(living)}: with and without tooth error alike, the"
        " controller's flutter (H6), which a large kick releases."
        if living
        else ""
    )
    return (
        "Question: once there, does the large vibration keep itself alive under angle, so that only"
        " a small start hides it? The state at the height of the vibration under omega_t becomes"
        f" the start of a run under angle. Under angle it dies at zeta ="
        f" {', '.join(dying) or 'none'}."
        f"{exception} Under omega_t it stays as long as a mode is unstable (section 4) and decays"
        " when that interval is over. Verdict: is there"
        " a second, self-sustained state under angle that needs the tooth error?"
        f" {word(_supports(records), 'No', 'Yes')}."
    )


def _without(records: Sequence[Handover], zeta: float) -> float | None:
    return next(r.after_rad_per_s2 for r in records if (r.zeta, r.heir) == (zeta, ERROR_FREE))


def _figure(runs: Handovers) -> str:
    drawing, grid = new_figure(1, len(HEIRS), 2.4)
    for axes, heir, colour in zip(grid[0], HEIRS, COLOURS, strict=False):
        run = runs[SHOWN, heir]
        draw(axes, run.time, run.theta_ddot[:, 0], heir.name, colour)
        axes.set(title=f"continued under {heir.name}", xlabel="time [s]")
    low = min(axes.get_ylim()[0] for axes in grid[0])
    high = max(axes.get_ylim()[1] for axes in grid[0])
    for axes in grid[0]:
        axes.set_ylim(low, high)
    grid[0, 0].set_ylabel("shoulder acceleration [rad/s²]")
    return to_svg(drawing)


def _caption(at_s: float) -> str:
    return (
        f"One state, taken at {at_s:.3f} s from the run under omega_t (zeta = {SHOWN.zeta:g}, ring"
        f" rate {SHOWN.ring_rate}), continued under three laws; min-max bands."
    )
