"""Hypothesis H6: the controller pushes the sun and looks at the link, so the teeth can flutter."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from crosscheck import signals
from crosscheck.paper.hypotheses.controller_records import Flutter, GrowthCheck, Threshold
from crosscheck.paper.hypotheses.controller_views import (
    drawing,
    growth_text,
    survey_tables,
    sweep_table,
)
from crosscheck.paper.hypotheses.feedback import (
    LINK,
    PAPER_GAINS,
    SUN,
    Point,
    growth,
    threshold,
)
from crosscheck.paper.numbers import finite
from crosscheck.paper.reading import excess_acceleration, first_mesh
from crosscheck.paper.rigid import beside_coupled
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import word
from crosscheck.report.chapter import Chapter, rendered
from crosscheck.report.fragments import figure, heading, paragraph
from crosscheck.studies.study import Comparison, Numbers, Study, Variant

ID, TITLE = "controller", "The controller's own flutter (H6)"
READINGS = ("paper-labelled", "paper-swapped")
ELBOWS_DEG = (0, 30, 60, 90, 120, 150, 180)
GAINS = ((1000.0, 0.0), (500.0, 400.0), (4000.0, 400.0), (1000.0, 100.0), (1000.0, 200.0),
         (1000.0, 400.0), (1000.0, 800.0), (1000.0, 1600.0))  # fmt: skip
STIFFNESSES = (0.8, 1.0, 1.2)  # (k_m - k_a, k_m, k_m + k_a) / k_m
ZETAS = (0.003, 0.004, 0.005, 0.006, 0.01, 0.02)
SETTLED_S = (0.9, 1.2)  # well after the impacts of the side change
GROWTH_S, GROWTH_ZETA = (0.1, 0.4), 0.003


def chapter(study: Study, scale: Scale) -> Chapter:
    """Thresholds from eigenvalues and the growth check; full: also the sweep over zeta and E."""
    survey = _survey(scale.quick)
    check = _growth_check(study, scale)
    sweep = [] if scale.quick else _sweep(study, scale)
    verdict = _verdict(survey, check, sweep)
    html = [_introduction(verdict), *survey_tables(survey), growth_text(check)]
    if sweep:
        html += [figure(drawing(survey, sweep), _CAPTION), sweep_table(sweep)]
    outcome = (
        f"H6 {verdict.verdict}; in contact the loop is unstable below"
        f" zeta = {verdict.lowest_zeta:.4f} to"
        f" {verdict.highest_zeta:.4f}, depending on pose and reading."
    )
    records = rendered((verdict, check, *survey, *sweep))
    return Chapter(ID, TITLE, "\n".join(html), records, outcome)


_CAPTION = (
    "Left: damping ratio at which a mesh mode turns unstable in contact, P = 1000, D = 400;"
    " middle: the same against D with the arm stretched; right: simulated shoulder vibration"
    f" (detailed minus rigid) in {SETTLED_S[0]:g} to {SETTLED_S[1]:g} s of the PD run, angle law."
)


def _survey(quick: bool) -> list[Threshold]:
    """Thresholds over poses, gains, stiffness and where the controller looks."""
    arms, elbows = (READINGS[:1], ELBOWS_DEG[:2]) if quick else (READINGS, ELBOWS_DEG)
    points = [Point(a, elbow_rad=np.radians(e), sensed=s) for a in arms for e in elbows
              for s in (LINK, SUN)]  # fmt: skip
    points += [Point(arm, gains) for arm in arms for gains in GAINS]
    points += [Point(arm, stiffness=stiffness) for arm in arms for stiffness in STIFFNESSES]
    return [_threshold(point) for point in dict.fromkeys(points)]


def _threshold(point: Point) -> Threshold:
    edge = threshold(point)
    rate, frequency = growth(point, edge)
    return Threshold(point, edge, frequency, growth(point, 0.0)[0], rate)


def growth_rate(run: xr.Dataset) -> Numbers:
    """Exponential growth [1/s] of the shoulder's mesh vibration within GROWTH_S, and its mean pose.

    From the peaks of x_sp1 less its running mean over 5 ms. None in a run that ends before.
    """
    time, x = run["time"].values, first_mesh(run, "x_sp")
    width = round(5e-3 / (time[1] - time[0]))
    part = signals.window(time, *GROWTH_S)
    blocks = time[part].size // width
    if blocks < 2:
        return {"growth_per_s": None, "elbow_rad": None}
    vibration = np.abs(x - np.convolve(x, np.ones(width) / width, mode="same"))
    peaks = vibration[part][: blocks * width].reshape(blocks, width).max(axis=1)
    middles = time[part][: blocks * width].reshape(blocks, width).mean(axis=1)
    return {
        "growth_per_s": float(np.polyfit(middles, np.log(peaks), 1)[0]),
        "elbow_rad": float(run["theta"].values[part, 1].mean()),
    }


def _growth_check(study: Study, scale: Scale) -> GrowthCheck:
    """The same feedback simulated without play, tooth error and stiffness variation."""
    smooth = ("backlash_m", "tooth_error_m", "mesh_stiffness_amplitude_N_per_m")
    variant = Variant(
        zeta=GROWTH_ZETA,
        duration_s=GROWTH_S[1] + 0.05,
        settings=tuple(f"arm.joints.*.{name}=0.0" for name in smooth),
    )
    (measured,) = study.measures([scale.cut(variant)], growth_rate, "H6, growth without play")
    elbow, rate = (measured.get(name) for name in ("elbow_rad", "growth_per_s"))
    if elbow is None:
        return GrowthCheck(GROWTH_ZETA, None, rate, None, None)
    predicted, frequency = growth(Point(elbow_rad=elbow), GROWTH_ZETA)
    return GrowthCheck(GROWTH_ZETA, elbow, rate, predicted, frequency)


def sustained(run: xr.Dataset, others: tuple[xr.Dataset, ...]) -> Numbers:
    """Shoulder vibration [rad/s^2], less the rigid arm, and its frequency [Hz] in SETTLED_S."""
    (rigid,) = others
    time = run["time"].values
    part = signals.window(time, *SETTLED_S)
    excess = excess_acceleration(run, rigid)[part, 0]
    return finite(
        {
            "amplitude_rad_per_s2": signals.amplitude(excess),
            "frequency_Hz": signals.dominant_frequency(time[part], excess),
        }
    )


SUSTAINED = Comparison(sustained, beside_coupled)


def _sweep(study: Study, scale: Scale) -> list[Flutter]:
    """Simulated vibration over zeta for both damping switches, with and without tooth error."""
    cells = [(zeta, damping, E) for damping in ("always", "contact") for zeta in ZETAS
             for E in (0.0, 5e-6)]  # fmt: skip
    variants = [
        scale.cut(
            Variant(
                zeta=zeta,
                duration_s=SETTLED_S[1],
                meshes=(f"arm.joints.*.tooth_error_m={E!r}", f"switches.damping={damping}"),
            )
        )
        for zeta, damping, E in cells
    ]
    found = study.measures(variants, SUSTAINED, "H6, flutter against damping")
    names = ("amplitude_rad_per_s2", "frequency_Hz", "diverged_s")
    return [
        Flutter(damping, zeta, E, *(numbers.get(name) for name in names))
        for (zeta, damping, E), numbers in zip(cells, found, strict=True)
    ]


def independent_of_error(sweep: Sequence[Flutter]) -> bool | None:
    """The signature: the same settings flutter with and without tooth error, and some do."""
    if any(run.flutters is None for run in sweep):
        return None
    places = [
        {
            (run.damping, run.zeta)
            for run in sweep
            if run.flutters and (run.tooth_error_m > 0) == with_error
        }
        for with_error in (False, True)
    ]
    return bool(places[0]) and places[0] == places[1]


def cured_at_the_sun(survey: Sequence[Threshold]) -> bool:
    """No threshold at all once the controller looks at the sun, where there is one otherwise."""
    sun = [found.zeta for found in survey if found.point.sensed == SUN]
    link = [f.zeta for f in survey if f.point.sensed != SUN and f.point.gains[1] > 0]
    return max(sun) == 0.0 and min(link) > 0.0


@dataclass(frozen=True)
class FlutterVerdict:
    """H6: what it rests on, and the range of thresholds [1] with the paper's gains."""

    parts: Mapping[str, bool | None]
    lowest_zeta: float
    highest_zeta: float

    @property
    def verdict(self) -> str:
        """In words."""
        return _in_words(self.parts.values())

    def to_dict(self) -> dict[str, object]:
        """For JSON."""
        return {
            "id": "H6",
            "verdict": self.verdict,
            "parts": dict(self.parts),
            "lowest_threshold_zeta": self.lowest_zeta,
            "highest_threshold_zeta": self.highest_zeta,
        }


def _verdict(
    survey: Sequence[Threshold], check: GrowthCheck, sweep: Sequence[Flutter]
) -> FlutterVerdict:
    parts: dict[str, bool | None] = {
        "sensing at the sun removes it": cured_at_the_sun(survey),
        "growth as predicted": check.agrees,
    }
    if sweep:
        parts["independent of E"] = independent_of_error(sweep)
    paper = [f.zeta for f in survey if f.point.sensed != SUN and f.point.gains == PAPER_GAINS]
    return FlutterVerdict(parts, min(paper), max(paper))


def _in_words(parts: Collection[bool | None]) -> str:
    """Holds, in part, or not at all; undefined if that hangs on what is."""
    if True in parts and False in parts:
        return "holds in part"
    return word(None if None in parts else all(parts), "holds", "does not hold")


def _introduction(verdict: FlutterVerdict) -> str:
    parts = "; ".join(f"{name}: {word(holds)}" for name, holds in verdict.parts.items())
    return (
        heading("Question and experiment")
        + paragraph(
            "The torque acts on the sun while Eq. 23 looks at the link, with the teeth's springs"
            " between: feedback of that kind can feed a mesh mode. The arm is linearised with all"
            " teeth in contact, and the damping ratio found at which its least stable mesh mode"
            " stops growing; then the controller is made to look at the sun (angle and rate over"
            " the reduction ratio), which in the linear model replaces the sensed θ by the torque's"
            " own lever, so that feedback becomes symmetric and can only dissipate. With damping in"
            " contact alone the linear threshold is the same, since it is found in contact."
        )
        + paragraph(
            f"H6 {verdict.verdict} ({parts}). With the paper's gains the flutter needs ζ below"
            f" {verdict.lowest_zeta:.4f} to {verdict.highest_zeta:.4f},"
            " depending on pose and reading."
        )
    )
