"""Hypothesis H2: what makes the rigid baseline of Figs. 6-7 deviate from the detailed arm."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from crosscheck.audit.claims.catalogue import BY_ID
from crosscheck.audit.claims.rule import Claim
from crosscheck.audit.experiments.paper_conditions import READINGS
from crosscheck.audit.hypotheses.evidence import level_ablation
from crosscheck.audit.hypotheses.labels import GROUPS, LEVELS, MODEL_CHANGES, SCENARIOS, SYMBOLS
from crosscheck.audit.measures.undefined import JsonObject, format_answer, to_json
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.page.context import AuditContext
from crosscheck.audit.page.text import render_template, to_markup
from crosscheck.registry import RIGID_LEVELS
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import draw_legend, make_figure, to_svg

ID, TITLE = "ladder", "What separates the rigid arm from the detailed one (H2)"
# (scenario, reading, order): both scenarios in both orders, the other reading where the paper
# prints numbers.
FIRST_READING = next(iter(READINGS))
ABLATIONS = (
    *((level_ablation.TORQUE, arm, "A") for arm in READINGS),
    ("pd", FIRST_READING, "A"),
    *((scenario, FIRST_READING, "B") for scenario in SCENARIOS),
)
QUICK_ABLATIONS = ABLATIONS[:1]
# A rung, and its parts of the deviations by quantity.
Line = tuple[str, dict[str, level_ablation.Contribution]]
MILLI = 1e3
_SMALLEST = 1e-13  # a contribution of rounding size still gets a mark


class AblationSummary(NamedTuple):
    """All ablations.

    levels: what baselines leave; whole: all of every ablation; verdict: of both.
    """

    ablations: list[level_ablation.LevelAblation]
    levels: list[level_ablation.Deviation]
    whole: list[level_ablation.Deviation]
    residuals: list[level_ablation.RigidResidual]
    verdict: level_ablation.AblationVerdict


def claims() -> dict[str, Claim]:
    """The claims of the paper's three numbers, by quantity."""
    return {quantity: BY_ID[name] for quantity, name in level_ablation.CLAIMS.items()}


def run_ablations(context: AuditContext) -> AblationSummary:
    """The ladders that are climbed; quick: constant torque in one order, labelled reading."""
    selections = QUICK_ABLATIONS if context.scale.quick else ABLATIONS
    ablations = [
        level_ablation.run_ablation(context.study, *which, context.scale) for which in selections
    ]
    levels = level_ablation.compute_baseline_deviations(
        ablation for ablation in ablations if ablation.order == "A"
    )
    whole = [
        deviation
        for ablation in ablations
        for deviation in level_ablation.compute_deviations(ablation)
    ]
    stated = claims()
    verdict = level_ablation.judge_ablation(levels, whole, stated["theta_2"].limits)
    return AblationSummary(
        ablations, levels, whole, level_ablation.compute_residuals(levels, stated), verdict
    )


def build_chapter(context: AuditContext) -> AuditChapter:
    """The chapter on the levels from the rigid arm to the detailed one."""
    summary, stated = run_ablations(context), claims()
    verdict = summary.verdict

    def largest_deviation(level: str) -> float:
        """Largest deviation of theta_2 [rad] that a level leaves."""
        return max(
            abs(residual.deviations["theta_2"].total)
            for residual in summary.residuals
            if residual.level == level
        )

    page = render_template(
        "hypotheses/ladder",
        verdict=verdict,
        levels=[LEVELS[level] for level in verdict.fitting],
        limits={name: str(claim.limits) for name, claim in stated.items()},
        all_three=[LEVELS[entry.level] for entry in summary.residuals if all(entry.fits.values())],
        links_factor=largest_deviation("links") / stated["theta_2"].limits.high,
        coupled_rad=largest_deviation("coupled"),
        fitting=[entry for entry in summary.residuals if entry.fits["theta_2"]],
        names=LEVELS,
        causes=[GROUPS.get(cause, cause) for cause in verdict.causes],
        groups={
            "inertia": level_ablation.INERTIA,
            "meshes": level_ablation.MESHES,
            "slips": level_ablation.SLIPPED,
        },
        rungs=len(summary.ablations[0].names),
        picture=to_markup(draw_baselines(summary.residuals)),
        left=LEFT.html(summary.residuals),
        scenarios=[_describe_scenario(summary.ablations, name) for name in SCENARIOS],
        shares=SHARES.html(entry for entry in summary.whole if entry.instant == "largest"),
    )
    # A whole ladder is also what its lowest level leaves.
    unlike = {(entry.where, entry.quantity): entry for entry in (*summary.whole, *summary.levels)}
    records: list[JsonObject] = [
        {
            "id": "H2",
            "verdict": format_answer(verdict.holds, "holds", "does not hold"),
            "fitting_levels": list(verdict.fitting),
            "shares_of_what_these_leave": to_json(verdict.rest),
            "from_links": format_answer(verdict.holds_from_links, "holds", "does not hold"),
            "shares_of_the_whole": to_json(verdict.whole),
            "nearly_all_of_the_whole": list(verdict.causes),
            "paper": format_answer(verdict.papers, "holds", "does not hold"),
        },
        *LEFT.json(summary.residuals),
        *SHARES.json(unlike.values()),
        *(
            record
            for ablation in summary.ablations
            for instant in ("end", "largest")
            for record in _contribution_columns(ablation, f"/{instant}").json(
                _lines(ablation, instant)
            )
        ),
    ]
    outcome = render_template(
        "hypotheses/ladder_outcome", verdict=verdict, inertia=level_ablation.INERTIA
    )
    return AuditChapter(ID, TITLE, page, records, outcome)


def _describe_scenario(
    ablations: Sequence[level_ablation.LevelAblation], name: str
) -> dict[str, object] | None:
    """The title, drawing and tables of a scenario; None where it was not climbed."""
    scenario_ablations = [x for x in ablations if (x.scenario, x.arm) == (name, FIRST_READING)]
    if not scenario_ablations:
        return None
    tables = [
        _contribution_columns(x).html(_lines(x, "largest"), f"Order {x.order}")
        for x in scenario_ablations
    ]
    return {
        "title": SCENARIOS[name],
        "drawing": to_markup(draw_contributions(scenario_ablations)),
        "tables": tables,
    }


def _lines(ablation: level_ablation.LevelAblation, instant: str) -> list[Line]:
    at = [
        deviation
        for deviation in level_ablation.compute_deviations(ablation)
        if deviation.instant == instant
    ]
    parts = zip(*(deviation.contributions for deviation in at), strict=True)
    return [
        (name, dict(zip(level_ablation.QUANTITIES, some, strict=True)))
        for name, some in zip(ablation.names, parts, strict=True)
    ]


def _contribution_columns(
    ablation: level_ablation.LevelAblation, instant: str = ""
) -> Columns[Line]:
    """The columns of a level's contributions, shown if above their uncertainty; both are kept."""

    def quantity_columns(name: str, unit: str) -> tuple[TableColumn[Line], ...]:
        def significant_part(line: Line) -> float | None:
            part = line[1][name]
            return part.contribution if abs(part.contribution) > part.uncertainty else None

        def part_and_uncertainty(line: Line) -> tuple[float, float]:
            return line[1][name].contribution, line[1][name].uncertainty

        return (
            TableColumn(f"{name}_{unit}", f"{SYMBOLS[name]} [{unit}]", significant_part),
            TableColumn(f"{name}_with_uncertainty", None, part_and_uncertainty),
        )

    return Columns(
        f"ladder/{ablation.arm}/{ablation.scenario}/{ablation.order}{instant}/{{0[0]}}",
        [
            TableColumn("rung", "model change", lambda line: MODEL_CHANGES[line[0]]),
            *(
                column
                for quantity in level_ablation.QUANTITIES.items()
                for column in quantity_columns(*quantity)
            ),
        ],
    )


def _share(group: str) -> Callable[[level_ablation.Deviation], float]:
    return lambda row: 100 * row.shares[group]


SHARES = Columns[level_ablation.Deviation](
    "ladder/{0.where}/{0.quantity}",
    [
        TableColumn("reading", "reading", lambda row: READINGS[row.arm]),
        TableColumn("scenario", "experiment"),
        TableColumn("order", "order"),
        TableColumn("level", None),
        TableColumn("quantity", "of", lambda row: SYMBOLS[row.quantity]),
        TableColumn("instant", None),
        TableColumn("time_s", "at [s]"),
        TableColumn("total", "deviation [rad, m]"),
        *(
            TableColumn(f"{group}_percent", f"{name} [%]", _share(group))
            for group, name in GROUPS.items()
        ),
        TableColumn(
            "dominant", "nearly all of it", lambda row: GROUPS.get(row.dominant, row.dominant)
        ),
    ],
)


def _residual_columns(
    name: str, unit: str
) -> tuple[TableColumn[level_ablation.RigidResidual], ...]:
    """The two columns of a quantity: what is left of it, and whether that is as in the paper."""
    title = f"left of {SYMBOLS[name]} [{unit}]"
    return (
        TableColumn(f"{name}_{unit}", title, lambda row: abs(row.deviations[name].total)),
        TableColumn(f"{name}_fits", "as in the paper", lambda row: row.fits[name]),
    )


def _span(group: str) -> Callable[[level_ablation.RigidResidual], tuple[float, ...]]:
    return lambda row: tuple(100 * end for end in row.span(group))


LEFT = Columns[level_ablation.RigidResidual](
    "{0.id}",
    [
        TableColumn("reading", "reading", lambda row: READINGS[row.arm]),
        TableColumn("level", "the baseline has", lambda row: LEVELS[row.level]),
        *(
            column
            for quantity in level_ablation.QUANTITIES.items()
            for column in _residual_columns(*quantity)
        ),
        *(
            TableColumn(f"{g}_percent", f"{GROUPS[g]} [%]", _span(g))
            for g in (level_ablation.INERTIA, level_ablation.MESHES, level_ablation.SLIPPED)
        ),
    ],
)


def draw_baselines(residuals: Sequence[level_ablation.RigidResidual]) -> str:
    """The sizes of what every baseline leaves, beside what the paper says, as svg."""
    limits = {name: claim.limits for name, claim in claims().items()}
    figure, grid = make_figure(1, len(level_ablation.QUANTITIES), 2.6)
    for axes, (name, factor) in zip(grid[0], level_ablation.IN_UNIT_OF_CLAIM.items(), strict=True):
        axes.axvspan(limits[name].low, limits[name].high, color="#999999", alpha=0.3, label="paper")
        for arm, marker, colour in zip(READINGS, "os", COLOURS, strict=False):
            arm_residuals = [residual for residual in residuals if residual.arm == arm]
            sizes = [factor * abs(residual.deviations[name].total) for residual in arm_residuals]
            rows = [RIGID_LEVELS.index(residual.level) for residual in arm_residuals]
            axes.plot(sizes, rows, marker, color=colour, ms=5, label=READINGS[arm])
        axes.set(xscale="log", xlabel=f"left of {SYMBOLS[name]} [1]", yticks=[])
        axes.set_ylim(len(RIGID_LEVELS) - 0.5, -0.5)
    grid[0, 0].set_yticks(range(len(RIGID_LEVELS)), [LEVELS[level] for level in RIGID_LEVELS])
    draw_legend(figure, grid[0, 0])
    return to_svg(figure)


def draw_contributions(ablations: list[level_ablation.LevelAblation]) -> str:
    """Contributions in the first order, stacked; below, their sizes in every order; as svg.

    Each column at the time of its own largest deviation. Bars begin where the one above ended, the
    total is a line; numerical uncertainties are grey crosses.
    """
    figure, grid = make_figure(2, len(level_ablation.QUANTITIES), 3.0)
    first, names = ablations[0], ablations[0].names
    rows = np.arange(len(names))
    for quantity, (name, unit) in enumerate(level_ablation.QUANTITIES.items()):
        above, below = grid[:, quantity]
        index = first.largest_index(quantity)
        steps = MILLI * first.fine[:, index, quantity]
        ends, colours = np.cumsum(steps), [COLOURS[0] if s >= 0 else COLOURS[1] for s in steps]
        above.barh(rows, steps, left=ends - steps, color=colours)
        above.vlines(ends, rows - 0.4, rows + 1.4, color="k", lw=0.6)
        above.set(xlabel=f"{SYMBOLS[name]} [m{unit}]", yticks=[], ylim=(len(names) - 0.4, -0.6),
                  title=f"at t = {first.time[index]:.3f} s, order A")  # fmt: skip
        for ablation, marker, colour in zip(ablations, "os", COLOURS, strict=False):
            at = ablation.largest_index(quantity)
            row_indices = [names.index(change) for change in ablation.names]
            size = np.maximum(np.abs(ablation.fine[:, at, quantity]), _SMALLEST)
            doubt = np.maximum(ablation.uncertainty[:, at, quantity], _SMALLEST)
            below.plot(
                size, row_indices, marker, color=colour, label=f"order {ablation.order}", ms=4
            )
            below.plot(
                doubt, row_indices, "x", color="#999999", ms=3, label="numerical uncertainty"
            )
        below.set(xscale="log", ylim=(len(names) - 0.4, -0.6), yticks=[],
                  xlabel=f"|contribution to {SYMBOLS[name]}| [{unit}]")  # fmt: skip
    for axes in grid[:, 0]:
        axes.set_yticks(rows, [MODEL_CHANGES[name] for name in names])
    draw_legend(figure, grid[1, 0])
    return to_svg(figure)
