"""What the chapter on the phase records and tabulates: one spec for JSON and page."""

from __future__ import annotations

from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from crosscheck.audit.experiments.paper_conditions import Condition, Law
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.third_fluctuation import Quantiles, ThirdFluctuation, quantiles
from crosscheck.audit.measures.thresholds import EVIDENT
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.phase import dampers, engines, handover, maps, objections, stability
from crosscheck.audit.phase.clock import DelayResult
from crosscheck.audit.phase.linear import Interval
from crosscheck.audit.phase.resonance import FloquetRates, Peak

Row = TypeVar("Row")
VISIBLE_TITLE = f"raised above {EVIDENT:g} rad/s² by E"
LAW: TableColumn[Any] = TableColumn("law", "law, ring rate", "law.id")


def cell_columns(cell: str = "cell") -> list[TableColumn[Any]]:
    """The columns that name a setting; cell: its path in a row."""
    return [
        TableColumn("law", "law, ring rate", f"{cell}.law.id"),
        TableColumn("reading", "reading", f"{cell}.reading"),
        TableColumn("zeta", "ζ", f"{cell}.zeta", "g"),
        TableColumn("planets", None, f"{cell}.planets"),
    ]


def third_columns(third: str = "third", prefix: str = "", word: str = "") -> list[TableColumn[Any]]:
    """The columns of a third fluctuation: share, size, starts; third: its path in a row."""
    size_title = f"{word}size [rad/s²], 0.1, 0.5 and 0.9 of the starts"
    return [
        TableColumn(f"{prefix}severe", f"{word}severe in", f"{third}.share"),
        TableColumn(f"{prefix}interval", None, f"{third}.share.interval", ".2f"),
        TableColumn(f"{prefix}size_rad_per_s2", size_title, f"{third}.quantiles"),
        TableColumn(f"{prefix}diverged", None, f"{third}.diverged"),
        TableColumn(f"{prefix}run", None, f"{third}.size.size"),
    ]


# A third fluctuation, the same without tooth error, and what that makes.
RAISED: list[TableColumn[Any]] = [
    *third_columns(),
    TableColumn("without_error_rad_per_s2", "the same with E = 0", "without.quantiles", ".2g"),
    TableColumn("made_severe", "made severe by E", "made.share"),
    TableColumn("made_visible", VISIBLE_TITLE, "made_visible.share"),
]


class SettingRow(NamedTuple, Generic[Row]):
    """A row: something found in a setting."""

    cell: Condition
    value: Row


class ClockRow(NamedTuple):
    """A row: what a law makes of one delay."""

    law: Law
    delay: DelayResult


def vibrations(delay: DelayResult) -> Quantiles:
    """The quantiles PARTS of the vibration [rad/s^2] over the starts."""
    return quantiles(np.array(delay.vibration_rad_per_s2, dtype=float))


CLOCK = Columns[ClockRow](
    "clock/{0.law.id}/{0.delay.clock_s:g}",
    [
        LAW,
        TableColumn("clock_s", "clock at start [s]", "delay.clock_s", "g"),
        TableColumn(
            "largest_change_N",
            "largest change of a mesh force, same motion [N]",
            "delay.largest_change_N",
            ".4g",
        ),
        TableColumn("largest_force_N", None, "delay.largest_force_N"),
        TableColumn(
            "vibration_rad_per_s2",
            "vibration in runs from rest [rad/s²], 0.1, 0.5, 0.9 of the starts",
            lambda row: vibrations(row.delay),
            ".2g",
        ),
        TableColumn("same_as_clock_0", "bit for bit the runs at 0", "delay.same"),
    ],
)
MAPPED = Columns[maps.MapPoint](
    "map/{0.setting.cell.id}/E {0.setting.error_um:g} um/b {0.setting.backlash_um:g} um",
    [
        *cell_columns("setting.cell"),
        TableColumn("E_um", None, "setting.error_um", "g"),
        TableColumn("b_um", None, "setting.backlash_um", "g"),
        *RAISED,
    ],
)
REPAIR = Columns[maps.RepairedSetting](
    "repair/{0.conservative.setting.cell.id}",
    [
        *cell_columns("conservative.setting.cell")[1:],
        *third_columns("plain.third", "angle_", "angle: "),
        *third_columns("conservative.third", "work_", "with that work: "),
        TableColumn("made_visible", VISIBLE_TITLE, "conservative.made_visible.share"),
    ],
)


class ModelRow(NamedTuple):
    """A row: a sample of one model in a setting."""

    cell: Condition
    model: str
    third: ThirdFluctuation
    parted: Share


MODEL_SAMPLES = Columns[ModelRow](
    "engine/{0.cell.id}/{0.model}",
    [
        *cell_columns(),
        TableColumn("model", "model"),
        *third_columns(),
        TableColumn("parted", "planets 1 µm apart in"),
    ],
)
TESTS = Columns[engines.ModelComparison](
    "engine/{0.cell.id}",
    [
        TableColumn("p_of_shares", None, "tests.by_share"),
        TableColumn("p_of_sizes", None, "tests.by_size"),
        TableColumn("share_difference_90", None, "share_interval"),
        TableColumn("same", None),
    ],
)
BRANCHES = Columns[SettingRow[engines.BranchComparison]](
    "branch/{0.cell.id}/{0.value.branch}/{0.value.number}",
    [
        *cell_columns(),
        TableColumn("branch", "branch", "value.branch"),
        TableColumn("number", "median of", "value.number"),
        TableColumn("analytic", "analytic", "value.analytic", ".4g"),
        TableColumn("engine", "Exudyn", "value.engine", ".4g"),
        TableColumn("difference", "relative difference", "value.difference", "+.3f"),
        TableColumn("ratio_90", "90 % interval of the ratio", "value.interval", ".3f"),
        TableColumn("within", "margin", "value.within", "g"),
        TableColumn("met", "within it", "value.met"),
    ],
)


def _onsets(row: SettingRow[stability.LinearisationResult], which: int) -> Quantiles | None:
    """The quantiles of the predicted (0) or simulated (1) onsets [s]; None without any."""
    times = [begun[which] for begun in row.value.onsets if begun[which] is not None]
    return quantiles(np.array(times, dtype=float)) if times else None


LINEARISED = Columns[SettingRow[stability.LinearisationResult]](
    "stability/{0.cell.id}",
    [
        *cell_columns(),
        TableColumn(
            "largest_growth_per_s",
            "largest growth, 0.5-1.2 s [1/s]",
            "value.largest.growth_per_s",
            ".1f",
        ),
        TableColumn("at_s", "at [s]", "value.largest.at_s"),
        TableColumn("mode_Hz", "mode [Hz]", "value.largest.frequency_Hz", ".0f"),
        TableColumn(
            "predicted_s",
            "onset predicted [s], 0.1, 0.5, 0.9 of the starts",
            lambda row: _onsets(row, 0),
            ".3f",
        ),
        TableColumn("simulated_s", "simulated [s]", lambda row: _onsets(row, 1), ".3f"),
        TableColumn("begins", "begins in", "value.begins"),
        TableColumn("as_predicted", "as predicted in", "value.as_predicted"),
        TableColumn("jacobian_error", None, "value.jacobian_error"),
    ],
)
INTERVAL = Columns[SettingRow[Interval]](
    "unstable/{0.cell.id}/{0.value.begin:.3f}",
    [
        *cell_columns(),
        TableColumn("from_s", "from [s]", "value.begin", ".3f"),
        TableColumn("to_s", "to [s]", "value.end", ".3f"),
        TableColumn("frequency_Hz", "mean frequency [Hz]", "value.frequency", ".0f"),
        TableColumn("folds", "∫ growth dt [e-folds]", "value.folds", ".1f"),
    ],
)
FATE = Columns[handover.SwitchOutcome](
    "handover/{0.cell.id}/{0.heir.name}",
    [
        *cell_columns(),
        TableColumn("heir", "continued under", "heir.name"),
        TableColumn("starts", None, "asked"),
        TableColumn("before_rad_per_s2", "before [rad/s²]", "before"),
        TableColumn("soon_rad_per_s2", "after 0.03 s", "soon"),
        TableColumn("late_rad_per_s2", "after 0.33 s", "late", ".2g"),
        TableColumn("dies", "dies in", "dying"),
    ],
)


class Mode(NamedTuple):
    """A row: a mesh mode [Hz] and the carrier speed [rad/s] that meets it.

    times: how many times the PD run's fastest speed; peaks: of the first start, by damping ratio.
    """

    mode_Hz: float
    speed: float
    times: float
    peaks: dict[float, Peak]


def mode_columns(zetas: tuple[float, ...]) -> Columns[Mode]:
    """The columns of a mesh mode, with a run-up at every damping ratio."""

    def peak(zeta: float) -> TableColumn[Mode]:
        title = f"run-up, ζ = {zeta:g}: peak at [rad/s], of [rad/s²]"
        return TableColumn(f"peak_{zeta:g}", title, lambda row: tuple(row.peaks[zeta]))

    return Columns(
        "resonance/{0.mode_Hz:.0f} Hz",
        [
            TableColumn("mode_Hz", "mode [Hz]", form=".1f"),
            TableColumn("speed_rad_per_s", "met at [rad/s]", "speed", ".1f"),
            TableColumn("times", "times the PD run's fastest", form=".0f"),
            *map(peak, zetas),
        ],
    )


TONGUE = Columns[tuple[float, FloquetRates]](
    "tongue/{0[0]:g}",
    [
        TableColumn("zeta", "ζ", "0", "g"),
        TableColumn("growth_per_s", "largest growth [1/s]", "1.largest.0", ".1f"),
        TableColumn("at_rad_per_s", "at [rad/s]", "1.largest.1", ".1f"),
        TableColumn("lowest_rad_per_s", "lowest speed [rad/s]", "1.lowest_open", ".1f"),
        TableColumn("slow_per_s", "growth at the PD run's fastest [1/s]", "1.slow", ".1f"),
    ],
)
OBJECTED = Columns[objections.ObjectionResult](
    "objection/{0.objection}/{0.change.name}/{0.cell.id}",
    [
        TableColumn("objection", "objection"),
        TableColumn("change", "what was changed", "change.name"),
        *cell_columns(),
        *RAISED,
    ],
)
RATES = Columns[SettingRow[objections.GrowthRates]](
    "growth/{0.cell.id}",
    [
        *cell_columns(),
        TableColumn("as_it_stands", "as it stands", "value.as_it_stands_per_s", ".0f"),
        TableColumn("no_feedback", "no feedback", "value.without_feedback_per_s", ".0f"),
        TableColumn("eq11", "Eq. 11 in full", "value.eq11_in_full_per_s", ".2g"),
        TableColumn("no_error", "E = 0", "value.without_tooth_error_per_s", ".0f"),
        TableColumn("steady", "k_a = 0", "value.constant_stiffness_per_s", ".0f"),
    ],
)


def _frequency_Hz(row: dampers.DamperAblation) -> Quantiles | None:
    """The quantiles of the frequency [Hz]; None where no vibration gives it a meaning."""
    return quantiles(row.third.frequency_Hz) if (row.third.quantiles[-1] or 0.0) > 1.0 else None


ABLATED = Columns[dampers.DamperAblation](
    "no error/{0.ablation.name}/{0.zeta:g}",
    [
        TableColumn("what", "E = 0, phase an integral", "ablation.name"),
        TableColumn("zeta", "ζ", form="g"),
        *third_columns(),
        TableColumn("frequency_Hz", "frequency [Hz]", _frequency_Hz, ".0f"),
    ],
)
RUNAWAY = Columns[dampers.Runaway](
    "runaway/{0.law.id}",
    [
        LAW,
        TableColumn("runs_away", "runs away in", "share"),
        TableColumn("interval", "95 % interval of the share", "share.interval", ".2f"),
        TableColumn("top_rad_per_s", "their top speeds [rad/s]"),
        TableColumn("calm_rad_per_s", "top speed of the others"),
        TableColumn("asked_rad_per_s", "of the rigid arm"),
        TableColumn("diverged", None),
    ],
)
