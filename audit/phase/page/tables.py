"""What the chapter on the phase records and tabulates: one spec for JSON and page."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from crosscheck.audit.experiments.cells import Cell, Law
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.third import Quantiles, Third, quantiles
from crosscheck.audit.measures.thresholds import EVIDENT
from crosscheck.audit.measures.twosamples import WithAndWithout
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.phase.clock import Delayed
from crosscheck.audit.phase.dampers import Ablated, Runaway
from crosscheck.audit.phase.engines import Apart, TwoModels
from crosscheck.audit.phase.handover import Fate
from crosscheck.audit.phase.maps import Mapped, RepairedSetting
from crosscheck.audit.phase.objections import Objected, Rates
from crosscheck.audit.phase.resonance import FloquetRates, Peak
from crosscheck.audit.phase.runs.linear import Interval
from crosscheck.audit.phase.stability import Linearised

Row = TypeVar("Row")
Raised = TypeVar("Raised", bound=WithAndWithout)
VISIBLE_TITLE = f"raised above {EVIDENT:g} rad/s² by E"


def share_column(
    name: str, title: str | None, of: Callable[[Row], Share | None]
) -> TableColumn[Row]:
    """So many of so many starts."""

    def counted(row: Row) -> str | None:
        share = of(row)
        return None if share is None else f"{share.yes} of {share.of}"

    return TableColumn(name, title, counted)


def interval_column(
    name: str, title: str | None, of: Callable[[Row], Share | None]
) -> TableColumn[Row]:
    """Clopper and Pearson's 95 % interval of the share."""

    def interval(row: Row) -> tuple[float | None, ...] | None:
        share = of(row)
        return None if share is None else share.interval

    return TableColumn(name, title, interval, ".2f")


def cell_columns(of: Callable[[Row], Cell]) -> list[TableColumn[Row]]:
    """A setting."""
    return [
        TableColumn("law", "law, ring rate", lambda row: of(row).law.id),
        TableColumn("reading", "reading", lambda row: of(row).reading),
        TableColumn("zeta", "ζ", lambda row: of(row).zeta, "g"),
        TableColumn("planets", None, lambda row: of(row).planets),
    ]


def third_columns(
    of: Callable[[Row], Third], prefix: str = "", word: str = ""
) -> list[TableColumn[Row]]:
    """Share, size and defined starts of a third fluctuation."""
    return [
        share_column(f"{prefix}severe", f"{word}severe in", lambda row: of(row).share),
        interval_column(f"{prefix}interval", None, lambda row: of(row).share),
        TableColumn(
            f"{prefix}size_rad_per_s2",
            f"{word}size [rad/s²], 0.1, 0.5 and 0.9 of the starts",
            lambda row: of(row).quantiles,
        ),
        TableColumn(f"{prefix}diverged", None, lambda row: of(row).diverged),
        TableColumn(f"{prefix}run", None, lambda row: of(row).size.size - of(row).not_run),
    ]


def raised_columns(of: type[Raised]) -> list[TableColumn[Raised]]:
    """A third fluctuation, the same without tooth error, and what that makes."""
    return [
        *third_columns(lambda row: row.third),
        TableColumn(
            "without_error_rad_per_s2",
            "the same with E = 0",
            lambda row: row.without.quantiles,
            ".2g",
        ),
        share_column("made_severe", "made severe by E", lambda row: row.made.share),
        share_column("made_visible", VISIBLE_TITLE, lambda row: row.made_visible.share),
    ]


class OfClock(NamedTuple):
    """What a law makes of one delay."""

    law: Law
    delay: Delayed


CLOCK: Columns[OfClock] = Columns(
    lambda row: f"clock/{row.law.id}/{row.delay.clock_s:g}",
    [
        TableColumn("law", "law, ring rate", lambda row: row.law.id),
        TableColumn("clock_s", "clock at start [s]", lambda row: row.delay.clock_s, "g"),
        TableColumn(
            "largest_change_N",
            "largest change of a mesh force, same motion [N]",
            lambda row: row.delay.largest_change_N,
            ".4g",
        ),
        TableColumn("largest_force_N", None, lambda row: row.delay.largest_force_N),
        TableColumn(
            "vibration_rad_per_s2",
            "vibration in runs from rest [rad/s²], 0.1, 0.5, 0.9 of the starts",
            lambda row: vibrations(row.delay),
            ".2g",
        ),
        TableColumn("same_as_clock_0", "bit for bit the runs at 0", lambda row: row.delay.same),
    ],
)


def vibrations(one: Delayed) -> Quantiles:
    """Over the starts."""
    return quantiles(np.array(one.vibration_rad_per_s2, dtype=float))


MAPPED: Columns[Mapped] = Columns(
    lambda row: (
        f"map/{row.setting.cell.id}/E {row.setting.error_um:g} um/b {row.setting.backlash_um:g} um"
    ),
    [
        *cell_columns(lambda row: row.setting.cell),
        TableColumn("E_um", None, lambda row: row.setting.error_um, "g"),
        TableColumn("b_um", None, lambda row: row.setting.backlash_um, "g"),
        *raised_columns(Mapped),
    ],
)

REPAIR: Columns[RepairedSetting] = Columns(
    lambda row: f"repair/{row.conservative.setting.cell.id}",
    [
        *cell_columns(lambda row: row.conservative.setting.cell)[1:],
        *third_columns(lambda row: row.plain.third, "angle_", "angle: "),
        *third_columns(lambda row: row.conservative.third, "work_", "with that work: "),
        share_column(
            "made_visible", VISIBLE_TITLE, lambda row: row.conservative.made_visible.share
        ),
    ],
)


class OfModel(NamedTuple):
    """A sample of one model at a setting."""

    cell: Cell
    model: str
    third: Third
    parted: Share


OF_MODEL: Columns[OfModel] = Columns(
    lambda row: f"engine/{row.cell.id}/{row.model}",
    [
        *cell_columns(lambda row: row.cell),
        TableColumn("model", "model", lambda row: row.model),
        *third_columns(lambda row: row.third),
        share_column("parted", "planets 1 µm apart in", lambda row: row.parted),
    ],
)

TESTS: Columns[TwoModels] = Columns(
    lambda row: f"engine/{row.cell.id}",
    [
        TableColumn("p_of_shares", None, lambda row: row.tests.by_share),
        TableColumn("p_of_sizes", None, lambda row: row.tests.by_size),
        TableColumn("p_of_sizes_where_planets_part", None, lambda row: row.parted_size_p),
        TableColumn("same", None, lambda row: row.same),
    ],
)

APART: Columns[tuple[Cell, Apart]] = Columns(
    lambda row: f"branch/{row[0].id}/{'severe' if row[1].severe else 'small'}/{row[1].number}",
    [
        *cell_columns(lambda row: row[0]),
        TableColumn("branch", "branch", lambda row: "severe" if row[1].severe else "small"),
        TableColumn("number", "median of", lambda row: row[1].number),
        TableColumn("analytic", "analytic", lambda row: row[1].analytic, ".4g"),
        TableColumn("engine", "Exudyn", lambda row: row[1].engine, ".4g"),
        TableColumn("difference", "relative difference", lambda row: row[1].difference, "+.3f"),
        TableColumn("within", "limit", lambda row: row[1].within, "g"),
        TableColumn("met", "within it", lambda row: row[1].met),
    ],
)


class Found(NamedTuple, Generic[Row]):
    """Something found at a setting."""

    cell: Cell
    value: Row


LINEARISED: Columns[Found[Linearised]] = Columns(
    lambda row: f"stability/{row.cell.id}",
    [
        *cell_columns(lambda row: row.cell),
        TableColumn(
            "largest_growth_per_s",
            "largest growth, 0.5-1.2 s [1/s]",
            lambda row: row.value.largest.growth_per_s if row.value.largest else None,
            ".1f",
        ),
        TableColumn(
            "at_s", "at [s]", lambda row: row.value.largest.at_s if row.value.largest else None
        ),
        TableColumn(
            "mode_Hz",
            "mode [Hz]",
            lambda row: row.value.largest.frequency_Hz if row.value.largest else None,
            ".0f",
        ),
        TableColumn(
            "predicted_s",
            "onset predicted [s], 0.1, 0.5, 0.9 of the starts",
            lambda row: _onsets(row.value, 0),
            ".3f",
        ),
        TableColumn("simulated_s", "simulated [s]", lambda row: _onsets(row.value, 1), ".3f"),
        share_column("begins", "begins in", lambda row: row.value.begins),
        share_column("as_predicted", "as predicted in", lambda row: row.value.as_predicted),
        TableColumn("jacobian_error", None, lambda row: row.value.jacobian_error),
    ],
)


def _onsets(one: Linearised, which: int) -> Quantiles | None:
    times = [begun[which] for begun in one.begun if begun[which] is not None]
    return quantiles(np.array(times, dtype=float)) if times else None


INTERVAL: Columns[Found[Interval]] = Columns(
    lambda row: f"unstable/{row.cell.id}/{row.value.begin:.3f}",
    [
        *cell_columns(lambda row: row.cell),
        TableColumn("from_s", "from [s]", lambda row: row.value.begin, ".3f"),
        TableColumn("to_s", "to [s]", lambda row: row.value.end, ".3f"),
        TableColumn("frequency_Hz", "mean frequency [Hz]", lambda row: row.value.frequency, ".0f"),
        TableColumn("folds", "∫ growth dt [e-folds]", lambda row: row.value.folds, ".1f"),
    ],
)

FATE: Columns[Fate] = Columns(
    lambda row: f"handover/{row.cell.id}/{row.heir.name}",
    [
        *cell_columns(lambda row: row.cell),
        TableColumn("heir", "continued under", lambda row: row.heir.name),
        TableColumn("starts", None, lambda row: row.asked),
        TableColumn("before_rad_per_s2", "before [rad/s²]", lambda row: row.before),
        TableColumn("soon_rad_per_s2", "after 0.03 s", lambda row: row.soon),
        TableColumn("late_rad_per_s2", "after 0.33 s", lambda row: row.late, ".2g"),
        share_column("dies", "dies in", lambda row: row.dying),
    ],
)


class Mode(NamedTuple):
    """A mesh mode [Hz], the speed [rad/s] that meets it, and how many times the PD run's that is.

    peaks: of the first start, by damping ratio.
    """

    mode_Hz: float
    speed: float
    times: float
    peaks: dict[float, Peak]


def modes(zetas: tuple[float, ...]) -> Columns[Mode]:
    """With a run-up at every damping ratio."""
    return Columns(
        lambda row: f"resonance/{row.mode_Hz:.0f} Hz",
        [
            TableColumn("mode_Hz", "mode [Hz]", lambda row: row.mode_Hz, ".1f"),
            TableColumn("speed_rad_per_s", "met at [rad/s]", lambda row: row.speed, ".1f"),
            TableColumn("times", "times the PD run's fastest", lambda row: row.times, ".0f"),
            *[_peak(zeta) for zeta in zetas],
        ],
    )


def _peak(zeta: float) -> TableColumn[Mode]:
    return TableColumn(
        f"peak_{zeta:g}",
        f"run-up, ζ = {zeta:g}: peak at [rad/s], of [rad/s²]",
        lambda row: tuple(row.peaks[zeta]),
    )


TONGUE: Columns[tuple[float, FloquetRates]] = Columns(
    lambda row: f"tongue/{row[0]:g}",
    [
        TableColumn("zeta", "ζ", lambda row: row[0], "g"),
        TableColumn("growth_per_s", "largest growth [1/s]", lambda row: row[1].largest[0], ".1f"),
        TableColumn("at_rad_per_s", "at [rad/s]", lambda row: row[1].largest[1], ".1f"),
        TableColumn(
            "lowest_rad_per_s", "lowest speed [rad/s]", lambda row: row[1].lowest_open, ".1f"
        ),
        TableColumn(
            "slow_per_s", "growth at the PD run's fastest [1/s]", lambda row: row[1].slow, ".1f"
        ),
    ],
)

OBJECTED: Columns[Objected] = Columns(
    lambda row: f"objection/{row.change.objection}/{row.change.name}/{row.cell.id}",
    [
        TableColumn("objection", "objection", lambda row: row.change.objection),
        TableColumn("change", "what was changed", lambda row: row.change.name),
        *cell_columns(lambda row: row.cell),
        *raised_columns(Objected),
    ],
)

RATES: Columns[Found[Rates]] = Columns(
    lambda row: f"growth/{row.cell.id}",
    [
        *cell_columns(lambda row: row.cell),
        TableColumn(
            "as_it_stands", "as it stands", lambda row: row.value.as_it_stands_per_s, ".0f"
        ),
        TableColumn(
            "no_feedback", "no feedback", lambda row: row.value.without_feedback_per_s, ".0f"
        ),
        TableColumn("eq11", "Eq. 11 in full", lambda row: row.value.eq11_in_full_per_s, ".2g"),
        TableColumn("no_error", "E = 0", lambda row: row.value.without_tooth_error_per_s, ".0f"),
        TableColumn("steady", "k_a = 0", lambda row: row.value.constant_stiffness_per_s, ".0f"),
    ],
)

ABLATED: Columns[Ablated] = Columns(
    lambda row: f"no error/{row.ablation.name}/{row.zeta:g}",
    [
        TableColumn("what", "E = 0, phase an integral", lambda row: row.ablation.name),
        TableColumn("zeta", "ζ", lambda row: row.zeta, "g"),
        *third_columns(lambda row: row.third),
        TableColumn(
            "frequency_Hz",
            "frequency [Hz]",
            lambda row: quantiles(row.third.frequency_Hz) if _seen(row.third) else None,
            ".0f",
        ),
    ],
)


def _seen(third: Third) -> bool:
    """Whether there is a vibration whose frequency means something."""
    return (third.quantiles[-1] or 0.0) > 1.0


RUNAWAY: Columns[Runaway] = Columns(
    lambda row: f"runaway/{row.law.id}",
    [
        TableColumn("law", "law, ring rate", lambda row: row.law.id),
        share_column("runs_away", "runs away in", lambda row: row.share),
        interval_column("interval", "95 % interval of the share", lambda row: row.share),
        TableColumn("top_rad_per_s", "their top speeds [rad/s]", lambda row: row.top_rad_per_s),
        TableColumn("calm_rad_per_s", "top speed of the others", lambda row: row.calm_rad_per_s),
        TableColumn("asked_rad_per_s", "of the rigid arm", lambda row: row.asked_rad_per_s),
        TableColumn("diverged", None, lambda row: row.diverged),
    ],
)
