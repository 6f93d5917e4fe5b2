"""Evidence 4: the mesh modes linearised along the motion, and the onset that they predict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from scipy.ndimage import maximum_filter1d

from crosscheck import signals
from crosscheck.paper.fluctuation import THIRD_S
from crosscheck.paper.phase.experiments import (
    FILTER_EDGE_S,
    HIGH_PASS_HZ,
    SETTINGS,
    Experiment,
    Response,
    Setting,
    responses,
    vibration,
)
from crosscheck.paper.phase.linear import (
    Base,
    Interval,
    Modes,
    base_motion,
    jacobian_error,
    mesh_modes,
    predicted_amplitude,
    unstable_intervals,
)
from crosscheck.paper.phase.verdict import ONSET_RAD_PER_S2, Evidence, onset_is_predicted
from crosscheck.paper.record import JsonObject, Record
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import UNDEFINED, all_of, extreme, known, shown, word
from crosscheck.report.figures import draw, legend, new_figure, to_svg
from crosscheck.report.fragments import COLOURS, figure, heading, paragraph, table
from crosscheck.studies.study import Study, Variant

LAWS = ("omega_t", "angle")
DURATION_S = 1.2
BEGIN_S = 0.45  # after the teeth have changed sides; from here on contact is assumed
BETWEEN_MODES_HZ = 3000.0  # each joint has a mesh mode below and one above
ENVELOPE_S = 4e-3  # window of the running maximum
WORTH_TELLING = 2.0  # e-folds
SAMPLES = 12  # of the Jacobian's comparison with differences


class Case(NamedTuple):
    """One setting under one law: linearised and simulated.

    envelope, predicted (times,): vibration of the shoulder [rad/s^2], simulated on the run's grid
    and predicted on the base motion's from BEGIN_S on; floor (modes,): below which none falls.
    """

    setting: Setting
    law: str
    base: Base
    modes: Modes
    run: Response
    envelope: np.ndarray
    predicted: np.ndarray
    floor: np.ndarray
    error: float


@dataclass(frozen=True)
class LargestGrowth:
    """The least stable moment of 0.5 to 1.2 s, and the e-folds of its longest growth.

    None in a run that diverged or ends before.
    """

    largest_growth_per_s: float | None = None
    at_s: float | None = None
    frequency_Hz: float | None = None
    largest_folds: float | None = None


@dataclass(frozen=True)
class Onset(Record):
    """When a vibration begins, as predicted and simulated; None: never."""

    phase: str
    ring_rate: str
    zeta: float
    growth: LargestGrowth
    noise_floor_rad_per_s2: tuple[float, ...]
    predicted_onset_s: float | None
    simulated_onset_s: float | None
    as_predicted: bool | None
    jacobian_error: float

    @property
    def id(self) -> str:
        return f"stability/{self.phase}/{self.ring_rate}/{self.zeta:g}"

    def to_dict(self) -> JsonObject:
        record = super().to_dict()
        del record["growth"]
        return {**record, **asdict(self.growth)}


def stability(study: Study, scale: Scale) -> Evidence:
    """LargestGrowth rates against time under both laws; predicted and simulated onset."""
    every = 20 if scale.quick else 5
    experiments = {
        (setting, law): Experiment(scale.cut(_variant(setting, law)))
        for setting in SETTINGS
        for law in LAWS
    }
    runs = responses(study, list(experiments.values()), "phase: runs to linearise")
    cases = [
        _case(*name, runs[experiment], experiment, every)
        for name, experiment in experiments.items()
    ]
    records = [_record(case) for case in cases]
    text = [
        heading("4. Stability of the mesh modes along the motion"),
        paragraph(_method(cases)),
        table(_HEAD, [_row(record) for record in records]),
        table(
            _INTERVAL_HEAD,
            [row for case in cases for row in _interval_rows(case)],
            "Unstable intervals",
        ),
        figure(_figure(cases), _caption()),
        paragraph(_statement(records)),
    ]
    supports = all_of([*(record.as_predicted for record in records), _only_omega_t(records)])
    return Evidence("\n".join(text), records, supports)


def _variant(setting: Setting, law: str) -> Variant:
    zeta, ring = setting
    return Variant(phase=law, ring_rate=ring, zeta=zeta, duration_s=DURATION_S)


def _case(setting: Setting, law: str, run: Response, experiment: Experiment, every: int) -> Case:
    plant = experiment.plant()
    base = base_motion(experiment.variant.case(), plant, every)
    modes = mesh_modes(plant, base)
    first, floor = _first_and_floor(run, modes)
    part = signals.window(base.time, BEGIN_S, DURATION_S)
    predicted = predicted_amplitude(base.time[part], modes.growth[part], first, floor)
    envelope = vibration_envelope(run.time, run.theta_ddot[:, 0])
    error = jacobian_error(plant, base, SAMPLES)
    return Case(setting, law, base, modes, run, envelope, predicted, floor, error)


def _first_and_floor(run: Response, modes: Modes) -> tuple[np.ndarray, np.ndarray]:
    """What every mode, (modes,) [rad/s^2], starts from and never falls below.

    The simulated vibration at BEGIN_S and its smallest value after; that above 3 kHz for the modes
    above 3 kHz, which decay faster. nan if the run diverged or ends before.
    """
    part = signals.window(run.time, BEGIN_S, DURATION_S - FILTER_EDGE_S)
    if part.stop <= part.start:
        nothing = np.full(modes.growth.shape[1], np.nan)
        return nothing, nothing
    fast = modes.frequency.mean(axis=0) > BETWEEN_MODES_HZ
    bands = [
        vibration_envelope(run.time, run.theta_ddot[:, 0], above)[part]
        for above in (HIGH_PASS_HZ, BETWEEN_MODES_HZ)
    ]
    first, floor = ([take(band) for band in bands] for take in (lambda b: b[0], np.min))
    return np.where(fast, first[1], first[0]), np.where(fast, floor[1], floor[0])


def vibration_envelope(
    time: np.ndarray, values: np.ndarray, above_hz: float = HIGH_PASS_HZ
) -> np.ndarray:
    """Running maximum, over 4 ms, of the magnitude of a signal's fast part, (times,)."""
    size = round(ENVELOPE_S / (time[1] - time[0]))
    return maximum_filter1d(np.abs(vibration(time, values, above_hz)), size)


def _after(time: np.ndarray, values: np.ndarray) -> float | None:
    """First time [s] from 0.5 s on at which a vibration counts as begun."""
    part = signals.window(time, THIRD_S[0], DURATION_S - FILTER_EDGE_S)
    return signals.first_above(time[part], values[part], ONSET_RAD_PER_S2)


def _record(case: Case) -> Onset:
    third = signals.window(case.base.time, *THIRD_S)
    reached = third.stop > third.start and known(case.run.theta_ddot)
    part = signals.window(case.base.time, BEGIN_S, DURATION_S)
    predicted = _after(case.base.time[part], case.predicted)
    simulated = _after(case.run.time, case.envelope)
    return Onset(
        phase=case.law,
        ring_rate=case.setting.ring_rate,
        zeta=case.setting.zeta,
        growth=_largest_growth(case, third) if reached else LargestGrowth(),
        noise_floor_rad_per_s2=tuple(float(f) for f in np.unique(case.floor) if known(f)),
        predicted_onset_s=predicted,
        simulated_onset_s=simulated,
        as_predicted=onset_is_predicted(predicted, simulated) if reached else None,
        jacobian_error=case.error,
    )


def _largest_growth(case: Case, part: slice) -> LargestGrowth:
    growth = case.modes.largest[part]
    peak = int(np.argmax(growth))
    mode = int(np.argmax(case.modes.growth[part][peak]))
    return LargestGrowth(
        largest_growth_per_s=float(growth[peak]),
        at_s=float(case.base.time[part][peak]),
        frequency_Hz=float(case.modes.frequency[part][peak, mode]),
        largest_folds=max((interval.folds for interval in _intervals(case)), default=0.0),
    )


def _intervals(case: Case) -> list[Interval]:
    found = unstable_intervals(case.base.time, case.modes, WORTH_TELLING)
    return [interval for interval in found if interval.end > THIRD_S[0]]


def _only_omega_t(records: Sequence[Onset]) -> bool | None:
    """Whether a vibration begins in every case of `omega_t` and in none of `angle`."""
    if any(record.as_predicted is None for record in records):
        return None
    begun = {
        law: [r.predicted_onset_s is not None for r in records if r.phase == law] for law in LAWS
    }
    return all(begun["omega_t"]) and not any(begun["angle"])


_HEAD = (
    "law",
    "ring rate",
    "zeta",
    "largest growth rate, 0.5-1.2 s [1/s]",
    "at [s]",
    "mode [Hz]",
    "noise floor [rad/s²]",
    "onset predicted [s]",
    "onset simulated [s]",
    "agree",
)
_INTERVAL_HEAD = (
    "law",
    "ring rate",
    "zeta",
    "from [s]",
    "to [s]",
    "mean frequency [Hz]",
    "∫ growth dt [e-folds]",
    "amplification",
)


def _row(record: Onset) -> tuple[str, ...]:
    never = UNDEFINED if record.as_predicted is None else "never"
    growth = record.growth
    return (
        record.phase,
        record.ring_rate,
        f"{record.zeta:g}",
        shown(growth.largest_growth_per_s, ".1f"),
        shown(growth.at_s, ".3f"),
        shown(growth.frequency_Hz, ".0f"),
        ", ".join(f"{floor:.1e}" for floor in record.noise_floor_rad_per_s2),
        shown(record.predicted_onset_s, ".3f", never),
        shown(record.simulated_onset_s, ".3f", never),
        word(record.as_predicted),
    )


def _interval_rows(case: Case) -> list[tuple[str, ...]]:
    return [
        (
            case.law,
            case.setting.ring_rate,
            f"{case.setting.zeta:g}",
            f"{i.begin:.3f}",
            f"{i.end:.3f}",
            f"{i.frequency:.0f}",
            f"{i.folds:.1f}",
            f"10^{i.folds / np.log(10):.0f}",
        )
        for i in _intervals(case)
    ]


def _method(cases: list[Case]) -> str:
    gain = 99 * DURATION_S
    return (
        "Question: where does the vibration come from, and does linear theory foretell it? The"
        " equations of motion are linearised about the vibration-free motion of the controlled arm"
        " with every tooth in contact. Under omega_t the phase contains the current speed: its"
        " derivative with respect to theta_c' is c t, which reaches"
        f" {gain:.0f} rad per rad/s at {DURATION_S:g} s for c = 99. A tooth error so becomes a"
        " velocity feedback, k E c t cos(phi), whose gain grows with the clock and whose sign"
        " changes with the phase; no damper can keep up with a gain without bound. Under angle"
        " this term does not exist. The Jacobian agrees with fourth-order central differences"
        f" of the equations within {max(case.error for case in cases):.1e} of its columns' size."
        f" Vibration at {BEGIN_S:g} s is taken from the simulation; from there every mode follows"
        " the integral of its growth rate, never falling below the noise floor, which is the"
        " smallest vibration of the same simulation (for the modes above 3 kHz, that above 3 kHz)."
        f" Onset: {ONSET_RAD_PER_S2:g} rad/s² after"
        f" {THIRD_S[0]:g} s. Labelled reading, E = 5 µm, b = 50 µm."
    )


def _statement(records: Sequence[Onset]) -> str:
    largest = {
        law: extreme((r.growth.largest_growth_per_s for r in records if r.phase == law), max)
        for law in LAWS
    }
    return (
        f"Between 0.5 and 1.2 s the largest growth rate is {shown(largest['omega_t'], '.0f')}"
        f" 1/s under omega_t and {shown(largest['angle'], '.1f')} 1/s under angle. Frozen"
        " eigenvalues alone would call many short intervals unstable; what counts is the integral"
        " against the noise floor."
        " The onset is that of the first burst; the largest vibration may follow in a later"
        " interval, and its size, set by the loss of contact, is beyond linear theory."
        " Verdict: the vibration is foretold under omega_t and ruled out under angle in every"
        f" case: {word(all_of(r.as_predicted for r in records))}."
    )


def _figure(cases: list[Case]) -> str:
    drawing, grid = new_figure(4, len(SETTINGS), 2.2)
    for column, setting in enumerate(SETTINGS):
        axes = grid[:, column]
        axes[0].set_title(f"zeta = {setting.zeta:g}, ring rate {setting.ring_rate}")
        chosen = [case for case in cases if case.setting == setting]
        for case, colour in zip(chosen, COLOURS, strict=False):
            axes[0].plot(case.base.time, case.modes.largest, color=colour, label=case.law)
            unstable = np.where(case.modes.growth > 0, case.modes.frequency, np.nan)
            axes[1].plot(case.base.time, case.modes.frequency, color=colour, lw=0.5, alpha=0.6)
            axes[1].plot(case.base.time, unstable, color=colour, lw=2.2)
            _draw_envelope(axes[2], case, colour)
            draw(axes[3], case.run.time, case.run.theta_ddot[:, 0], case.law, colour)
            _mark_onset(axes[2:], case)
        axes[0].axhline(0.0, color="black", lw=0.6)
        axes[0].set_ylim(-500, None)
        axes[2].set(yscale="log", ylim=(1e-13, 1e5))
        axes[3].set_xlabel("time [s]")
    labels = (
        "largest growth rate [1/s]",
        "mode frequency [Hz]",
        "vibration [rad/s²]",
        "shoulder acc. [rad/s²]",
    )
    for axes, label in zip(grid[:, 0], labels, strict=True):
        axes.set_ylabel(label)
    legend(drawing, grid[0, 0])
    return to_svg(drawing)


def _draw_envelope(axes: Axes, case: Case, colour: str) -> None:
    part = signals.window(case.base.time, BEGIN_S, DURATION_S)
    step = round(ENVELOPE_S / 2 / (case.run.time[1] - case.run.time[0]))  # a running maximum
    axes.plot(case.run.time[::step], case.envelope[::step], color=colour, label=case.law)
    axes.plot(case.base.time[part], case.predicted, color=colour, ls=":", lw=1.4)


def _mark_onset(axes: np.ndarray, case: Case) -> None:
    part = signals.window(case.base.time, BEGIN_S, DURATION_S)
    onset = _after(case.base.time[part], case.predicted)
    if onset is not None:
        for one in axes:
            one.axvline(onset, color="black", ls="--", lw=0.9)


def _caption() -> str:
    return (
        "From above: growth rate of the least stable mesh mode (blue omega_t, orange angle);"
        " frequencies of the four mesh modes, thick where unstable; vibration of the shoulder"
        " above 600 Hz, simulated (solid) and predicted from the growth rates (dotted, without any"
        " limit by loss of contact); simulated acceleration as a min-max band. Dashed: predicted"
        " onset."
    )
