"""Hypothesis H5: how heavy must the base be for Section 2's fixed base?"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crosscheck.audit.hypotheses.evidence.flights import (
    LIMIT_M,
    RATIOS,
    SCENARIOS,
    SIDES_M,
    Flight,
    Flights,
    Need,
    larger_is_enough,
    need,
)
from crosscheck.audit.hypotheses.words import SCENARIOS as TITLES
from crosscheck.audit.measures.undefined import JsonObject
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.text import html, text
from crosscheck.models.loading import load_scenario
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import legend, new_figure, to_svg

ID, TITLE = "floating_base", "A base that is free to fly (H5)"


def chapter(material: Material) -> AuditChapter:
    """Tip error of the fixed base over the base's mass."""
    tasks = [
        Flights(name, side, material.scale.seconds(load_scenario(name).duration_s))
        for name in SCENARIOS
        for side in SIDES_M
    ]
    answers = material.study.answers(tasks, "H5, free-flying base")
    flights = [flight for rows in answers for flight in rows]
    needs = [need(flights, name, side) for name in SCENARIOS for side in SIDES_M]
    enough = larger_is_enough([one.ratio for one in needs])
    said = {
        "enough": enough,
        "needed": {TITLES[name]: _needed(needs, name) for name in SCENARIOS},
        "limit_m": LIMIT_M,
    }
    page = text(
        "hypotheses/floating_base",
        arm_kg=flights[0].base_mass_kg / flights[0].ratio,
        drift=max(flight.momentum_drift for flight in flights),
        ratios=RATIOS,
        lightest_turn_rad=max(abs(one.base_turn_rad) for one in flights if one.ratio == RATIOS[0]),
        lightest_joint_rad=max(one.joint_error_rad for one in flights if one.ratio == RATIOS[0]),
        picture=html(drawing(flights)),
        needs=html(NEEDS.html(needs)),
        flights=html(FLIGHTS.html([one for one in flights if one.side_m == SIDES_M[0]])),
        **said,
    )
    records = [_verdict(needs, enough), *NEEDS.json(needs), *FLIGHTS.json(flights)]
    return AuditChapter(ID, TITLE, page, records, text("hypotheses/floating_base_outcome", **said))


def _needed(needs: Sequence[Need], scenario: str) -> str:
    """Smallest and largest mass ratio over the cubes."""
    ratios = [one.ratio for one in needs if one.scenario == scenario]
    enough = [ratio for ratio in ratios if ratio is not None]
    if len(enough) < len(ratios):
        return f"more than {RATIOS[-1]:g}"
    ends = dict.fromkeys(f"{ratio:.3g}" for ratio in (min(enough), max(enough)))
    return " to ".join(ends) + (" or fewer" if max(enough) == RATIOS[0] else "")


def _verdict(needs: Sequence[Need], enough: bool) -> JsonObject:
    found = [one.ratio for one in needs if one.ratio is not None]
    return {
        "id": "H5",
        "verdict": "a larger base suffices" if enough else "a merely larger base does not suffice",
        "lowest_needed_ratio": min(found, default=None),
        "highest_needed_ratio": max(found) if len(found) == len(needs) else None,
    }


NEEDS: Columns[Need] = Columns(
    lambda one: f"floating_base/needed/{one.scenario}/cube {one.side_m:g} m",
    [
        TableColumn("scenario", "experiment", lambda one: TITLES[one.scenario]),
        TableColumn("side_m", "cube [m]", lambda one: one.side_m, "g"),
        TableColumn("ratio", "mass ratio needed, whole run", lambda one: one.ratio),
        TableColumn("ratio_at_end", "at the end", lambda one: one.ratio_at_end),
        TableColumn(
            "error_times_ratio_m",
            "error times ratio, heavy [m]",
            lambda one: one.error_times_ratio_m,
        ),
    ],
)
FLIGHTS: Columns[Flight] = Columns(
    lambda one: f"floating_base/{one.scenario}/cube {one.side_m:g} m/ratio {one.ratio:g}",
    [
        TableColumn("scenario", "experiment", lambda one: TITLES[one.scenario]),
        TableColumn("side_m", "cube [m]", lambda one: one.side_m, "g"),
        TableColumn("ratio", "mass ratio", lambda one: one.ratio, "g"),
        TableColumn("base_kg", "base [kg]", lambda one: one.base_mass_kg, ".4g"),
        TableColumn("largest_mm", "largest tip error [mm]", lambda one: 1e3 * one.largest_m),
        TableColumn("largest_at_s", "at [s]", lambda one: one.largest_at_s, ".2f"),
        TableColumn("end_mm", "at the end [mm]", lambda one: 1e3 * one.end_m),
        TableColumn("base_turn_rad", "base turned [rad]", lambda one: one.base_turn_rad),
        TableColumn(
            "joint_error_rad", "joint angles moved [rad]", lambda one: one.joint_error_rad, ".2g"
        ),
        TableColumn("momentum_drift", None, lambda one: one.momentum_drift),
    ],
)


def drawing(flights: Sequence[Flight]) -> str:
    """A panel for each experiment, a line for each cube."""
    picture, grid = new_figure(1, len(SCENARIOS), 2.9)
    for axes, scenario in zip(grid[0], SCENARIOS, strict=True):
        for side, colour in zip(SIDES_M, COLOURS, strict=False):
            mine = [f for f in flights if (f.scenario, f.side_m) == (scenario, side)]
            points = [(f.ratio, 1000 * f.largest_m) for f in mine]
            axes.plot(*np.array(points).T, "o-", color=colour, ms=3, label=f"cube {side:g} m")
        axes.axhline(1000 * LIMIT_M, color="#555555", linestyle=":")
        axes.set(xscale="log", yscale="log", xlabel="base mass / arm mass",
                 ylabel="largest tip error [mm]", title=TITLES[scenario])  # fmt: skip
    legend(picture, grid[0, 0])
    return to_svg(picture)
