"""Hypothesis H5: how heavy must the base be for Section 2's fixed base?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from crosscheck.audit.hypotheses.evidence import flights
from crosscheck.audit.hypotheses.evidence.flights import LIMIT_M, RATIOS, SCENARIOS, SIDES_M, Flight
from crosscheck.audit.hypotheses.labels import SCENARIOS as TITLES
from crosscheck.audit.measures.undefined import JsonObject
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.page.context import AuditContext
from crosscheck.audit.page.text import render_template, to_markup
from crosscheck.models.loading import load_scenario
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import draw_legend, make_figure, to_svg

ID, TITLE = "floating_base", "A base that is free to fly (H5)"


def build_chapter(context: AuditContext) -> AuditChapter:
    """The chapter on the fixed base's tip error over the mass of the free base."""
    cubes = [(name, side) for name in SCENARIOS for side in SIDES_M]
    tasks = {
        (name, side): flights.FlightSweep(
            name, side, context.scale.limit_duration(load_scenario(name).duration_s)
        )
        for name, side in cubes
    }
    flown = context.study.answer_by_key(tasks, "H5, free-flying base")
    every = [flight for rows in flown.values() for flight in rows]
    needs = [flights.find_required_ratio(rows) for rows in flown.values()]
    ratios = [row.ratio for row in needs]
    required_ratios = [ratio for ratio in ratios if ratio is not None]
    enough = flights.is_larger_base_enough(ratios)
    summary = {
        "enough": enough,
        "needed": {
            TITLES[name]: _format_required_ratios(
                [row.ratio for row in needs if row.scenario == name]
            )
            for name in SCENARIOS
        },
        "limit_m": LIMIT_M,
    }
    lightest = [row for row in every if row.ratio == RATIOS[0]]
    page = render_template(
        "hypotheses/floating_base",
        arm_kg=every[0].base_mass_kg / every[0].ratio,
        drift=max(flight.momentum_drift for flight in every),
        ratios=RATIOS,
        lightest_turn_rad=max(abs(row.base_turn_rad) for row in lightest),
        lightest_joint_rad=max(row.joint_error_rad for row in lightest),
        picture=to_markup(draw_tip_errors(flown)),
        needs=NEEDS.html(needs),
        flights=FLIGHTS.html(row for row in every if row.side_m == SIDES_M[0]),
        **summary,
    )
    verdict: JsonObject = {
        "id": "H5",
        "verdict": "a larger base suffices" if enough else "a merely larger base does not suffice",
        "lowest_needed_ratio": min(required_ratios, default=None),
        "highest_needed_ratio": max(required_ratios)
        if len(required_ratios) == len(needs)
        else None,
    }
    records = [verdict, *NEEDS.json(needs), *FLIGHTS.json(every)]
    return AuditChapter(
        ID, TITLE, page, records, render_template("hypotheses/floating_base_outcome", **summary)
    )


def _format_required_ratios(ratios: Sequence[float | None]) -> str:
    """The smallest and largest needed mass ratio over the cubes, in words."""
    enough = [ratio for ratio in ratios if ratio is not None]
    if len(enough) < len(ratios):
        return f"more than {RATIOS[-1]:g}"
    ends = dict.fromkeys(f"{ratio:.3g}" for ratio in (min(enough), max(enough)))
    return " to ".join(ends) + (" or fewer" if max(enough) == RATIOS[0] else "")


NEEDS = Columns[flights.RequiredMassRatio](
    "floating_base/needed/{0.scenario}/cube {0.side_m:g} m",
    [
        TableColumn("scenario", "experiment", lambda row: TITLES[row.scenario]),
        TableColumn("side_m", "cube [m]", form="g"),
        TableColumn("ratio", "mass ratio needed, whole run"),
        TableColumn("ratio_at_end", "at the end"),
        TableColumn("error_times_ratio_m", "error times ratio, heavy [m]"),
    ],
)
FLIGHTS = Columns[Flight](
    "floating_base/{0.scenario}/cube {0.side_m:g} m/ratio {0.ratio:g}",
    [
        TableColumn("scenario", "experiment", lambda row: TITLES[row.scenario]),
        TableColumn("side_m", "cube [m]", form="g"),
        TableColumn("ratio", "mass ratio", form="g"),
        TableColumn("base_kg", "base [kg]", "base_mass_kg", ".4g"),
        TableColumn("largest_mm", "largest tip error [mm]", lambda row: 1e3 * row.largest_m),
        TableColumn("largest_at_s", "at [s]", form=".2f"),
        TableColumn("end_mm", "at the end [mm]", lambda row: 1e3 * row.end_m),
        TableColumn("base_turn_rad", "base turned [rad]"),
        TableColumn("joint_error_rad", "joint angles moved [rad]", form=".2g"),
        TableColumn("momentum_drift", None),
    ],
)


def draw_tip_errors(flown: Mapping[tuple[str, float], Sequence[Flight]]) -> str:
    """Tip errors, a panel per experiment, a line per cube, as svg; by experiment and side [m]."""
    picture, grid = make_figure(1, len(SCENARIOS), 2.9)
    for axes, scenario in zip(grid[0], SCENARIOS, strict=True):
        for side, colour in zip(SIDES_M, COLOURS, strict=False):
            points = [(f.ratio, 1000 * f.largest_m) for f in flown[scenario, side]]
            axes.plot(*np.array(points).T, "o-", color=colour, ms=3, label=f"cube {side:g} m")
        axes.axhline(1000 * LIMIT_M, color="#555555", linestyle=":")
        axes.set(xscale="log", yscale="log", xlabel="base mass / arm mass",
                 ylabel="largest tip error [mm]", title=TITLES[scenario])  # fmt: skip
    draw_legend(picture, grid[0, 0])
    return to_svg(picture)
