"""Hypothesis H3: the error that accumulates in Fig. 15 is the rigid arm's own sensitivity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from crosscheck import signals
from crosscheck.paper.numbers import finite, quotient
from crosscheck.paper.reductions import angles
from crosscheck.paper.rigid import COUPLED, rigid_model
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import all_of, percent, shown, where_known, word
from crosscheck.report.chapter import Chapter, rendered
from crosscheck.report.figures import legend, new_figure, to_svg
from crosscheck.report.fragments import COLOURS, figure, heading, paragraph, table
from crosscheck.studies.study import Study, Variant

ID, TITLE = "accumulation", "Errors that accumulate back and forth (H3)"
ARGUMENTS = {"sqrt_time": "2000 sin(20π√t), as printed", "time": "2000 sin(20πt), likely meant"}
BACKLASHES_M = (5e-6, 1e-5, 2.5e-5, 5e-5, 5e-4, 1e-3, 3e-3)  # the paper's set for b
REFERENCE_M = 5e-5
NUDGE = 1e-7  # of the rigid arm's start [rad, rad/s]: its error grows a thousandfold, still small
SMALL_S = (0.3, 1.2)  # where errors are small and the start's transients over
LEARNT_S = (0.1, 0.6)  # where the coefficients of the rigid prediction are fitted
SAME_RATE, SAME_SIZE, LINEAR, ORDERED = 0.25, 0.1, 0.05, 0.95
GEARED, RIGID = Variant().model, rigid_model(COUPLED)
EVERY = 100  # records 1 ms apart


@dataclass(frozen=True)
class Accumulation:
    """One drive law. time (times,) [s]; errors {b: (times, 2)} [rad] from the arm without backlash;

    sensitivity (times, 2, 4): d theta / d (theta_1, theta_2, theta_1', theta_2') at the start, of
    the rigid arm; rest (times, 2) [rad]: the arm without backlash less the rigid one.
    """

    argument: str
    time: np.ndarray
    errors: dict[float, np.ndarray]
    sensitivity: np.ndarray
    rest: np.ndarray


def chapter(study: Study, scale: Scale) -> Chapter:
    """Growth, prediction, linearity and order of the backlash error, for both drive laws."""
    cases = [_run(study, argument, scale) for argument in ARGUMENTS]
    found = [_found(case) for case in cases]
    html = [
        _introduction(*found),
        figure(_drawing(cases), _CAPTION),
        _summary(found),
        *(_sizes(case) for case in cases),
    ]
    records = rendered((SensitivityVerdict(found[0]), *found))
    return Chapter(ID, TITLE, "\n".join(html), records, _outcome(found[0]))


def _outcome(printed: Found) -> str:
    return (
        f"H3 {printed.verdict}; misfit of what the rigid arm's own sensitivity foretells of"
        f" b = 50 µm up to {SMALL_S[1]:g} s: {percent(printed.prediction_misfit)}."
    )


_CAPTION = (
    "Shoulder angle with backlash b less that without (solid), and what the rigid arm's"
    f" sensitivity alone makes of b = 50 µm (dashed; four coefficients fitted in {LEARNT_S[0]:g} to"
    f" {LEARNT_S[1]:g} s). Running maxima; right: the same errors over b. ζ = 0.05, E = 5 µm."
)


def _run(study: Study, argument: str, scale: Scale) -> Accumulation:
    rigid = scale.cut(_variant(argument, RIGID))
    nudged = [scale.cut(_variant(argument, RIGID, *_nudge(cause))) for cause in range(4)]
    geared = {b: scale.cut(_geared(argument, b)) for b in (0.0, *BACKLASHES_M)}
    runs = study.runs([rigid, *nudged, *geared.values()], f"H3, back and forth, {argument}", angles)
    theta = {variant: run["theta"].values for variant, run in runs.items()}
    plain = theta[geared[0.0]]
    return Accumulation(
        argument,
        _time(runs[rigid]),
        {b: theta[geared[b]] - plain for b in BACKLASHES_M},
        np.stack([(theta[variant] - theta[rigid]) / NUDGE for variant in nudged], axis=2),
        plain - theta[rigid],
    )


def _time(run: xr.Dataset) -> np.ndarray:
    return run["time"].values


def _variant(argument: str, model: str, *settings: str) -> Variant:
    drive = f"scenario.drive.argument={argument}"
    return Variant("back-and-forth", model=model, settings=(drive, *settings), record_every=EVERY)


def _geared(argument: str, backlash_m: float) -> Variant:
    return _variant(argument, GEARED, f"arm.joints.*.backlash_m={backlash_m!r}")


def _nudge(cause: int) -> list[str]:
    """The start of the rigid arm moved in one of its four states."""
    values = [0.0, 0.0]
    values[cause % 2] = NUDGE
    name = "theta_rad" if cause < 2 else "theta_dot_rad_per_s"
    return [f"scenario.start.{name}={values}"]


def growth_rate(time: np.ndarray, values: np.ndarray) -> float:
    """Exponential rate [1/s] of the running maximum of |values| within SMALL_S; nan if not run."""
    part = (time >= SMALL_S[0]) & (time < SMALL_S[1])
    if part.sum() < 2:
        return np.nan
    return float(np.polyfit(time[part], np.log(_running(values)[part]), 1)[0])


def _running(values: np.ndarray) -> np.ndarray:
    return np.maximum.accumulate(np.abs(values)) + 1e-300


def rigid_prediction(time: np.ndarray, error: np.ndarray, sensitivity: np.ndarray) -> np.ndarray:
    """The combination (times, 2) of sensitivities that fits the error (times, 2) in LEARNT_S.

    nan if the run ends before.
    """
    part = (time >= LEARNT_S[0]) & (time < LEARNT_S[1])
    causes = sensitivity.shape[2]
    if 2 * part.sum() < causes:
        return np.full(error.shape, np.nan)
    fit = np.linalg.lstsq(sensitivity[part].reshape(-1, causes), error[part].ravel(), rcond=None)
    return sensitivity @ fit[0]


def linearity(time: np.ndarray, errors: dict[float, np.ndarray]) -> float:
    """Largest departure of error / b from that of REFERENCE_M before SMALL_S ends, relative."""
    part = time < SMALL_S[1]
    scaled = {b: error[part, 0] / b for b, error in errors.items()}
    reference = scaled[REFERENCE_M]
    gap = max(np.abs(values - reference).max() for values in scaled.values())
    return quotient(gap, np.abs(reference).max())


def ordered_share(
    time: np.ndarray, errors: dict[float, np.ndarray], begin: float, end: float
) -> float:
    """Part of the time in [begin, end] in which a larger b means a larger |error|; nan for none."""
    part = (time >= begin) & (time <= end)
    if not part.any():
        return np.nan
    sizes = np.abs([errors[b][part, 0] for b in sorted(errors)])
    return float((np.diff(sizes, axis=0) > 0).all(axis=0).mean())


@dataclass(frozen=True)
class Found:
    """What one drive does with the backlash error of the shoulder; nan where a run ends before.

    Growth rates [1/s], of the error and of the rigid arm nudged at the elbow, and sensitivities
    d theta_1 / d theta_2(0); the error and what the rigid arm foretells of it [rad] for
    REFERENCE_M; largest and end errors [rad] by b [m]; shares of time in which they are ordered.
    """

    argument: str
    error_growth_per_s: float
    rigid_growth_per_s: float
    sensitivity_small: float
    largest_sensitivity: float
    prediction_misfit: float
    error_small_rad: float
    predicted_small_rad: float
    nonlinearity: float
    ordered_before: float
    ordered_after: float
    largest_rad: dict[float, float]
    end_rad: dict[float, float]
    rest_rad: float

    @property
    def own_sensitivity(self) -> bool | None:
        """Whether the error's growth is the rigid arm's own."""
        return is_own_sensitivity(
            self.error_growth_per_s, self.rigid_growth_per_s, self.prediction_misfit
        )

    @property
    def verdict(self) -> str:
        """H3 in words."""
        return word(self.own_sensitivity, "holds", "does not hold")

    @property
    def linear(self) -> bool | None:
        """Whether the error is proportional to b while small."""
        return is_linear(self.nonlinearity)

    @property
    def ordered(self) -> bool | None:
        """Whether a larger b means a larger error later."""
        return is_ordered(self.ordered_after)

    def to_dict(self) -> dict[str, object]:
        """For JSON; None for what is undefined."""
        numbers = {
            "error_growth_per_s": self.error_growth_per_s,
            "rigid_growth_per_s": self.rigid_growth_per_s,
            "rigid_sensitivity_at_1.2_s": self.sensitivity_small,
            "largest_rigid_sensitivity": self.largest_sensitivity,
            "prediction_misfit": self.prediction_misfit,
            "error_at_1.2_s_rad": self.error_small_rad,
            "predicted_at_1.2_s_rad": self.predicted_small_rad,
            "nonlinearity": self.nonlinearity,
            "ordered_before": self.ordered_before,
            "ordered_after": self.ordered_after,
            "geared_minus_rigid_without_backlash_rad": self.rest_rad,
        }
        return {
            "id": f"accumulation/{self.argument}",
            **finite(numbers),
            "largest_rad": finite({f"{b:g}": value for b, value in self.largest_rad.items()}),
            "end_rad": finite({f"{b:g}": value for b, value in self.end_rad.items()}),
            "own_sensitivity": self.own_sensitivity,
            "linear": self.linear,
            "ordered": self.ordered,
        }


@dataclass(frozen=True)
class SensitivityVerdict:
    """H3 for the drive as printed, which Fig. 15 is about."""

    printed: Found

    def to_dict(self) -> dict[str, object]:
        """For JSON."""
        return {
            "id": "H3",
            "verdict": self.printed.verdict,
            "linear_in_b": self.printed.linear,
            "ordered_in_b_later": self.printed.ordered,
        }


def _found(case: Accumulation) -> Found:
    error, elbow = case.errors[REFERENCE_M], case.sensitivity[:, 0, 1]
    predicted = rigid_prediction(case.time, error, case.sensitivity)
    ahead = (case.time >= LEARNT_S[1]) & (case.time <= SMALL_S[1])
    misfit = quotient(
        signals.amplitude((predicted - error)[ahead, 0]), signals.amplitude(error[ahead, 0])
    )
    return Found(
        argument=case.argument,
        error_growth_per_s=growth_rate(case.time, error[:, 0]),
        rigid_growth_per_s=growth_rate(case.time, elbow),
        sensitivity_small=abs(_at(case.time, elbow, SMALL_S[1])),
        largest_sensitivity=float(np.abs(elbow).max()),
        prediction_misfit=misfit,
        error_small_rad=_at(case.time, error[:, 0], SMALL_S[1]),
        predicted_small_rad=_at(case.time, predicted[:, 0], SMALL_S[1]),
        nonlinearity=linearity(case.time, case.errors),
        ordered_before=ordered_share(case.time, case.errors, *SMALL_S),
        ordered_after=ordered_share(case.time, case.errors, SMALL_S[1], float(case.time[-1])),
        largest_rad={b: float(np.abs(e[:, 0]).max()) for b, e in case.errors.items()},
        end_rad={b: float(e[-1, 0]) for b, e in case.errors.items()},
        rest_rad=float(np.abs(case.rest[:, 0]).max()),
    )


def _at(time: np.ndarray, values: np.ndarray, instant: float) -> float:
    """The value (times,) at an instant [s]; nan if the run ends before."""
    if time[-1] < instant - 1e-9:
        return np.nan
    return float(values[np.searchsorted(time, instant - 1e-9)])


def is_own_sensitivity(error_growth: float, rigid_growth: float, misfit: float) -> bool | None:
    """The rigid arm foretells the backlash error, and both grow at one rate [1/s]."""
    return all_of((_same_rate(quotient(error_growth, rigid_growth)), _same_size(misfit)))


@where_known
def _same_rate(rates: float) -> bool:
    return abs(rates - 1) <= SAME_RATE


@where_known
def _same_size(misfit: float) -> bool:
    return misfit <= SAME_SIZE


@where_known
def is_linear(nonlinearity: float) -> bool:
    """The error is proportional to the backlash."""
    return nonlinearity <= LINEAR


@where_known
def is_ordered(share: float) -> bool:
    """A larger backlash means a larger error for nearly all the time."""
    return share >= ORDERED


def _introduction(printed: Found, meant: Found) -> str:
    question = (
        "Fig. 15 shows the shoulder's error growing as the joints are driven back and forth, more"
        " so with more backlash, and the paper says that backlash error accumulates. H3: backlash"
        " only disturbs the arm a little, and the rigid arm itself, sensitive to any disturbance"
        " under this drive, does the growing. The rigid arm's sensitivity to its start is found by"
        f" starting it {NUDGE:g} rad or rad/s off in each of its four states; a fixed combination"
        " of these four, fitted to the backlash error early on, is then all there is to foretell"
        " its later course."
    )
    answer = (
        f"H3 {printed.verdict} for the drive as printed."
        f" Between {SMALL_S[0]:g} and {SMALL_S[1]:g} s the error of b = 50 µm grows at"
        f" {shown(printed.error_growth_per_s, '.2f')} 1/s and the rigid arm's, nudged at the"
        f" elbow, at {shown(printed.rigid_growth_per_s, '.2f')} 1/s; the rigid prediction misses"
        f" by {percent(printed.prediction_misfit)} of the largest error up to {SMALL_S[1]:g} s"
        f" (error there {shown(printed.error_small_rad)} rad, foretold"
        f" {shown(printed.predicted_small_rad)} rad). Linear in b while small:"
        f" {word(printed.linear)} (error over b differs by at most"
        f" {percent(printed.nonlinearity)} from 5 to 3000 µm). Ordered in b later:"
        f" {word(printed.ordered)}, a larger b means a larger error in"
        f" {percent(printed.ordered_before, '.0f')} of the time before {SMALL_S[1]:g} s and in"
        f" {percent(printed.ordered_after, '.0f')} after."
    )
    other = _other_drive(printed, meant)
    return heading("Question and experiment") + "".join(map(paragraph, (question, answer, other)))


def _other_drive(printed: Found, meant: Found) -> str:
    return (
        "Without the square root, which may be a misprint, the rigid arm multiplies a nudge of the"
        f" elbow by {meant.largest_sensitivity:.2g} at most, against"
        f" {printed.largest_sensitivity:.2g} with it, and the error of b = 50 µm never"
        f" exceeds {meant.largest_rad[REFERENCE_M]:.2g} rad (with it"
        f" {printed.largest_rad[REFERENCE_M]:.2g} rad): the same backlash, another drive."
    )


def _summary(found: Sequence[Found]) -> str:
    rows = [
        [ARGUMENTS[f.argument],
         shown(f.error_growth_per_s, ".2f"), shown(f.rigid_growth_per_s, ".2f"),
         shown(f.sensitivity_small), shown(100 * f.prediction_misfit, ".1f"),
         shown(100 * f.nonlinearity, ".1f"), shown(100 * f.ordered_before, ".0f"),
         shown(100 * f.ordered_after, ".0f"), f"{f.rest_rad:.2g}"]
        for f in found
    ]  # fmt: skip
    head = ["drive [N m]", "growth of the error [1/s]", "of the nudged rigid arm [1/s]",
            "rigid: dθ₁/dθ₂(0) at 1.2 s", "prediction misfit [%]", "nonlinearity in b [%]",
            "ordered before 1.2 s [% of time]", "after [%]",
            "geared - rigid at b = 0 [rad]"]  # fmt: skip
    return table(head, rows, "Shoulder, labelled reading")


def _sizes(case: Accumulation) -> str:
    instants = (0.4, 0.8, 1.2, 1.6, 2.0)
    rows = [
        [f"{1e6 * b:g}", *(shown(_at(case.time, error[:, 0], t)) for t in instants)]
        for b, error in case.errors.items()
    ]
    head = ["b [µm]", *(f"Δθ₁ at {t:g} s [rad]" for t in instants)]
    return table(head, rows, ARGUMENTS[case.argument])


def _drawing(cases: list[Accumulation]) -> str:
    picture, grid = new_figure(len(cases), 2, 2.9)
    for row, case in zip(grid, cases, strict=True):
        for (b, error), colour in zip(case.errors.items(), COLOURS, strict=True):
            row[0].plot(case.time, _running(error[:, 0]), color=colour, label=f"b {1e6 * b:g} µm")
            row[1].plot(case.time, error[:, 0] / b, color=colour, lw=0.9)
        predicted = rigid_prediction(case.time, case.errors[REFERENCE_M], case.sensitivity)
        row[0].plot(case.time, _running(predicted[:, 0]), "k--", lw=1, label="rigid, b 50 µm")
        row[1].plot(case.time, predicted[:, 0] / REFERENCE_M, "k--", lw=1)
        bound = 1.3 * signals.amplitude(case.errors[REFERENCE_M][case.time <= SMALL_S[1], 0])
        row[0].set(yscale="log", ylim=(1e-10, 10), xlabel="time [s]", ylabel="|Δθ₁| [rad]",
                   title=f"T = {ARGUMENTS[case.argument]}")  # fmt: skip
        row[1].set(xlim=(0, SMALL_S[1]), ylim=np.array([-1, 1]) * bound / REFERENCE_M,
                   xlabel="time [s]", ylabel="Δθ₁ / b [rad/m]")  # fmt: skip
    legend(picture, grid[0, 0])
    return to_svg(picture)
