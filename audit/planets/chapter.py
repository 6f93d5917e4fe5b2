"""Hypothesis H7: does counting three planets as one change the paper's third fluctuation?"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import fields

import numpy as np

from crosscheck.audit.experiments.paper_conditions import LAWS, READINGS
from crosscheck.audit.measures.third_fluctuation import PARTING_SPREAD_M
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.measures.twosamples import SIGNIFICANT
from crosscheck.audit.measures.undefined import JsonObject
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.page.context import AuditContext
from crosscheck.audit.page.text import render_template
from crosscheck.audit.phase.engines import compare_engines
from crosscheck.audit.phase.page.drawings import law_name
from crosscheck.audit.phase.page.tables import cell_columns, third_columns
from crosscheck.audit.planets import parting, verdict
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import draw_legend, make_figure, mark_not_reached, to_svg

MOSTLY = 0.5  # of the starts
ID, TITLE = "planets", "Three planets counted as one (H7)"
LIMITS = {"omega_t": (1.0, 2e3), "angle": (1e-5, 1e3)}  # rad/s^2, by phase law
SHIFTS = (-0.17, 0.17)  # of a damping ratio: lumped, free
# Of a start: each course with its name, line and width.
COURSES = (
    ("measured", "measured", "-", 1.6),
    ("by_lumped", "Hill, along the lumped run", "--", 1.1),
    ("by_free", "Hill, along the free run", ":", 1.4),
    ("pressed", "Hill, no mesh ever apart", "-.", 1.0),
)
LOWEST, HIGHEST = -20.5, -2.0  # log10 of metres: what is drawn


def build_chapter(context: AuditContext) -> AuditChapter:
    """The chapter on H7: samples, growth of differences, another engine, the figures' claims."""
    sampled, grown = (
        verdict.compare_planets(context),
        parting.compare_partings(context.study, context.scale),
    )
    compared, seen = compare_engines(context), verdict.compare_claims(context)
    effects = [entry.effect for entry in sampled]
    h7: JsonObject = {
        "id": "H7",
        "verdict": verdict.judge_h7(effects),
        "settings": len(effects),
        "weaker": effects.count(verdict.PlanetsEffect.WEAKER),
        "stronger": effects.count(verdict.PlanetsEffect.STRONGER),
        "foretold": grown.free.all_right,
        "engines_agree": compared.same,
        "claims_changed": sum(entry.changed is True for entry in seen),
    }
    pressed = [entry.pressed_largest_m for entry in grown.joints]
    largest = max((size for size in pressed if size is not None), default=None)
    changed = [entry for entry in seen if entry.changed]
    shown = [
        render_template("planets/introduction", verdict=h7),
        render_template(
            "planets/sizes",
            starts=context.scale.most_starts,
            significant=SIGNIFICANT,
            drawing=draw_sizes(sampled),
            table=FREED.html(sampled),
            effects={law.id: counts for law, counts in verdict.count_effects(sampled).items()},
            PlanetsEffect=verdict.PlanetsEffect,
        ),
        render_template(
            "planets/parting",
            planets=parting,
            starts=context.scale.limit_starts(parting.STARTS),
            apart_um=1e6 * PARTING_SPREAD_M,
            breaking=BREAKING.html(grown.breaking),
            early=list(
                dict.fromkeys(b.cell.zeta for b in grown.breaking if b.early.value > MOSTLY)
            ),
            drawing=draw_partings(grown.starts),
            table=PREDICTIONS.html(grown.joints),
            grown=grown,
            pressed=largest,
            by_contact=None if largest is None else largest < PARTING_SPREAD_M,
        ),
        render_template("planets/engines", compared=compared.compared, same=compared.same),
        render_template(
            "planets/features",
            table=FEATURE.html(seen),
            turned=FEATURE.html(changed),
            changed=len(changed),
            asked=len(seen),
            counts=Counter(entry.survives for entry in seen),
            Survival=verdict.Survival,
        ),
    ]
    records = [
        h7,
        *FREED.json(sampled),
        *BREAKING.json(grown.breaking),
        *FORETOLD.json([grown.lumped, grown.free]),
        *PREDICTIONS.json(grown.joints),
        *FEATURE.json(seen),
    ]
    return AuditChapter(
        ID, TITLE, "\n".join(shown), records, render_template("planets/outcome", verdict=h7)
    )


FREED = Columns[verdict.PlanetsComparison](
    "planets/{0.cell.id}",
    [
        *cell_columns(),
        *third_columns("lumped", "alike_", "lumped: "),
        *third_columns("free", "free_", "free: "),
        TableColumn("apart_um", "free: planets differ by up to [µm]", "free.apart_um", ".2g"),
        TableColumn("p_of_shares", "p, shares", "tests.by_share", ".2g"),
        TableColumn("p_of_sizes", "p, sizes", "tests.by_size", ".2g"),
        TableColumn("effect", "freeing makes it", "effect.value"),
    ],
)
BREAKING = Columns[parting.BreakingTimes](
    "planets/breaking/{0.cell.id}",
    [
        *cell_columns(),
        TableColumn("parted", "planets 1 µm apart in"),
        TableColumn("early", "before 0.3 s in"),
        TableColumn(
            "time_s",
            "when [s], 0.1, 0.5, 0.9 of those",
            lambda row: row.time_s if row.parted.yes else None,
            ".3f",
        ),
    ],
)
PREDICTIONS = Columns[parting.JointPrediction](
    "planets/parting/{0.joint}",
    [
        TableColumn("joint", "joint"),
        TableColumn("starts", "starts"),
        TableColumn("parted", "symmetry breaks in"),
        TableColumn("first", "before the other joint's in"),
        TableColumn("median_s", "median time [s]", form=".4f"),
        TableColumn("lumped_right", "foretold along the lumped run in"),
        TableColumn("lumped_error", "largest error", "lumped_largest_error", ".1%"),
        TableColumn("free_right", "foretold along the free run in"),
        TableColumn("free_error", "largest error", "free_largest_error", ".1%"),
        TableColumn("growth_per_s", "largest growth rate [1/s]", "largest_growth_per_s", ".0f"),
        TableColumn(
            "pressed_m", "largest spread without loss of contact [m]", "pressed_largest_m", ".2g"
        ),
    ],
)
FORETOLD = Columns[parting.PartingPrediction](
    "planets/parting/first/{0.along}",
    [
        *(
            TableColumn(item.name, None)
            for item in fields(parting.PartingPrediction)
            if item.name != "along"
        ),
        TableColumn("predicted", None, "all_right"),
    ],
)
FEATURE = Columns[verdict.ClaimComparison](
    lambda row: (
        f"planets/claim/{row.claim.id}/{row.place.law.id if row.place.law else ''}"
        f"/{row.place.zeta}/{row.place.choice}"
    ),
    [
        TableColumn("figure", "figure", "claim.figure"),
        TableColumn("claim", "statement", "claim.id"),
        TableColumn("statement", "in short", "claim.statement"),
        TableColumn("law", "law, ring rate", "place.law.id"),
        TableColumn("zeta", "ζ", "place.zeta", "g"),
        TableColumn("choice", None, "place.choice"),
        TableColumn("alike", "lumped: true in", "lumped.share"),
        TableColumn("free", "free: true in", "free.share"),
        TableColumn("survives", "what becomes of it", "survives.value"),
        TableColumn("changed", "significantly different"),
    ],
)


def draw_sizes(comparisons: Sequence[verdict.PlanetsComparison]) -> str:
    """A dot for every start, a row for every law, a column for every reading, as svg."""
    arms = [
        arm for arm in READINGS if any(comparison.cell.arm == arm for comparison in comparisons)
    ]
    drawing, grid = make_figure(len(LAWS), len(arms), 2.1)
    for (row, column), axes in np.ndenumerate(grid):
        law, arm = LAWS[row], arms[column]
        chosen = [
            comparison
            for comparison in comparisons
            if (comparison.cell.law, comparison.cell.arm) == (law, arm)
        ]
        for place, comparison in enumerate(chosen):
            pairs = zip(
                SHIFTS,
                (comparison.lumped, comparison.free),
                COLOURS,
                ("lumped", "free"),
                strict=False,
            )
            for shift, third, colour, name in pairs:
                label = f"planets {name}" if place == 0 else None
                across = place + shift + np.linspace(-0.12, 0.12, third.sizes.size)
                clipped = np.clip(third.sizes, *LIMITS[law.phase])
                axes.plot(across, clipped, ".", color=colour, markersize=2.5, label=label)
        axes.axhline(SEVERE, color="black", lw=0.8, ls="--")
        axes.set_xticks(
            range(len(chosen)), [f"{comparison.cell.zeta:g}" for comparison in chosen], fontsize=6.5
        )
        axes.set_ylim(*LIMITS[law.phase])
        axes.set_yscale("log")
        axes.set_title(f"{READINGS[arm]}, {law_name(law)}", fontsize=8)
    for axes in grid[:, 0]:
        axes.set_ylabel("size [rad/s²]")
    for axes in grid[-1]:
        axes.set_xlabel("ζ")
    draw_legend(drawing, grid[0, 0])
    return to_svg(drawing)


def draw_partings(partings: Sequence[parting.SymmetryBreaking]) -> str:
    """The spread of a stage's planets, measured and as Hill's equation has it, as svg.

    Left one start; right median and range over the starts, measured and along the lumped run.
    """
    drawing, grid = make_figure(len(parting.JOINTS), 2, 2.4)
    for joint, (left, right) in enumerate(grid):
        left.set(title=f"{parting.JOINTS[joint]}, first start", ylabel="log10 of the spread [m]")
        right.set(title=f"{parting.JOINTS[joint]}, {len(partings)} starts")
        for (name, label, style, width), colour in zip(COURSES, COLOURS, strict=False):
            every = [parting.log_spread(getattr(start, name), joint) for start in partings]
            if every:
                time_s = partings[0].time_s
                left.plot(time_s, every[0], style, lw=width, color=colour, label=label)
                if name in ("measured", "by_lumped"):
                    low, high = np.min(every, axis=0), np.max(every, axis=0)
                    right.fill_between(time_s, low, high, color=colour, alpha=0.25)
                    right.plot(time_s, np.median(every, axis=0), color=colour, ls=style)
        for axes in (left, right):
            axes.axhline(np.log10(PARTING_SPREAD_M), color="black", lw=0.8, ls="--")
            axes.set_ylim(LOWEST, HIGHEST)
            if not partings:
                mark_not_reached(axes)
    for axes in grid[-1]:
        axes.set_xlabel("time [s]")
    if partings:
        draw_legend(drawing, grid[0, 0], grid[0, 1])
    return to_svg(drawing)
