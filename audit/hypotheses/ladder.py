"""Hypothesis H2: what makes the rigid baseline of Figs. 6-7 deviate from the detailed arm."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from crosscheck.audit.claims.catalogue import BY_ID
from crosscheck.audit.claims.rule import Claim
from crosscheck.audit.experiments.cells import READINGS
from crosscheck.audit.hypotheses.evidence import rungs
from crosscheck.audit.hypotheses.words import GROUPS, LEVELS, RUNGS, SCENARIOS, SYMBOLS
from crosscheck.audit.measures.undefined import JsonObject, recorded, word
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.text import html, text
from crosscheck.registry import RIGID_LEVELS
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import legend, new_figure, to_svg

ID, TITLE = "ladder", "What separates the rigid arm from the detailed one (H2)"
# (scenario, reading, order): both scenarios in both orders, the other reading where the paper
# prints numbers.
FIRST_READING = next(iter(READINGS))
CLIMBS = (
    *((rungs.TORQUE, arm, "A") for arm in READINGS),
    ("pd", FIRST_READING, "A"),
    *((scenario, FIRST_READING, "B") for scenario in SCENARIOS),
)
QUICK_CLIMBS = CLIMBS[:1]
# A rung, and its parts of the deviations by quantity.
Line = tuple[str, dict[str, rungs.LevelPart]]
MILLI = 1e3
_SMALLEST = 1e-13  # a contribution of rounding size still gets a mark


class Climbed(NamedTuple):
    """All ladders. levels: what baselines leave; whole: all of every ladder; verdict: of both."""

    ladders: list[rungs.Ladder]
    levels: list[rungs.Deviation]
    whole: list[rungs.Deviation]
    left: list[rungs.RigidResidual]
    verdict: rungs.LadderVerdict


def claims() -> dict[str, Claim]:
    """The claims of the paper's three numbers, by quantity."""
    return {quantity: BY_ID[name] for quantity, name in rungs.CLAIMS.items()}


def climbed(material: Material) -> Climbed:
    """The ladders that are climbed; quick: constant torque in one order, labelled reading."""
    climbs = QUICK_CLIMBS if material.scale.quick else CLIMBS
    ladders = [rungs.climb(material.study, *which, material.scale) for which in climbs]
    levels = rungs.by_level(ladder for ladder in ladders if ladder.order == "A")
    whole = [one for ladder in ladders for one in rungs.deviations(ladder)]
    stated = claims()
    verdict = rungs.ladder_verdict(levels, whole, stated["theta_2"].limits)
    return Climbed(ladders, levels, whole, rungs.left(levels, stated), verdict)


def chapter(material: Material) -> AuditChapter:
    """The chapter on the ladder from the rigid arm to the detailed one."""
    found, stated = climbed(material), claims()
    verdict = found.verdict

    def most(level: str) -> float:
        """Largest deviation of theta_2 [rad] that a level leaves."""
        return max(abs(one.found["theta_2"].total) for one in found.left if one.level == level)

    page = text(
        "hypotheses/ladder",
        verdict=verdict,
        levels=[LEVELS[level] for level in verdict.fitting],
        limits={name: str(claim.limits) for name, claim in stated.items()},
        all_three=[LEVELS[one.level] for one in found.left if all(one.fits.values())],
        links_factor=most("links") / stated["theta_2"].limits.high,
        coupled_rad=most("coupled"),
        fitting=[one for one in found.left if one.fits["theta_2"]],
        names=LEVELS,
        causes=[GROUPS.get(cause, cause) for cause in verdict.causes],
        groups={"inertia": rungs.INERTIA, "meshes": rungs.MESHES, "slips": rungs.SLIPPED},
        rungs=len(found.ladders[0].names),
        picture=html(baselines(found.left)),
        left=LEFT.html(found.left),
        scenarios=[_scenario(found.ladders, name) for name in SCENARIOS],
        shares=SHARES.html(one for one in found.whole if one.instant == "largest"),
    )
    # A whole ladder is also what its lowest level leaves.
    unlike = {(one.where, one.quantity): one for one in (*found.whole, *found.levels)}
    records: list[JsonObject] = [
        {
            "id": "H2",
            "verdict": word(verdict.holds, "holds", "does not hold"),
            "fitting_levels": list(verdict.fitting),
            "shares_of_what_these_leave": recorded(verdict.rest),
            "from_links": word(verdict.holds_from_links, "holds", "does not hold"),
            "shares_of_the_whole": recorded(verdict.whole),
            "nearly_all_of_the_whole": list(verdict.causes),
            "paper": word(verdict.papers, "holds", "does not hold"),
        },
        *LEFT.json(found.left),
        *SHARES.json(unlike.values()),
        *(
            record
            for ladder in found.ladders
            for instant in ("end", "largest")
            for record in _rung_columns(ladder, f"/{instant}").json(_lines(ladder, instant))
        ),
    ]
    outcome = text("hypotheses/ladder_outcome", verdict=verdict, inertia=rungs.INERTIA)
    return AuditChapter(ID, TITLE, page, records, outcome)


def _scenario(ladders: Sequence[rungs.Ladder], name: str) -> dict[str, object] | None:
    """The title, drawing and tables of a scenario; None where it was not climbed."""
    mine = [x for x in ladders if (x.scenario, x.arm) == (name, FIRST_READING)]
    if not mine:
        return None
    tables = [_rung_columns(x).html(_lines(x, "largest"), f"Order {x.order}") for x in mine]
    return {"title": SCENARIOS[name], "drawing": html(waterfall(mine)), "tables": tables}


def _lines(ladder: rungs.Ladder, instant: str) -> list[Line]:
    at = [one for one in rungs.deviations(ladder) if one.instant == instant]
    parts = zip(*(one.rungs for one in at), strict=True)
    return [
        (name, dict(zip(rungs.QUANTITIES, some, strict=True)))
        for name, some in zip(ladder.names, parts, strict=True)
    ]


def _rung_columns(ladder: rungs.Ladder, instant: str = "") -> Columns[Line]:
    """The columns of a rung's contributions, shown if above their uncertainty; both are kept."""

    def of_quantity(name: str, unit: str) -> tuple[TableColumn[Line], ...]:
        def resolved(line: Line) -> float | None:
            part = line[1][name]
            return part.contribution if abs(part.contribution) > part.uncertainty else None

        def both(line: Line) -> tuple[float, float]:
            return line[1][name].contribution, line[1][name].uncertainty

        return (
            TableColumn(f"{name}_{unit}", f"{SYMBOLS[name]} [{unit}]", resolved),
            TableColumn(f"{name}_with_uncertainty", None, both),
        )

    return Columns(
        f"ladder/{ladder.arm}/{ladder.scenario}/{ladder.order}{instant}/{{0[0]}}",
        [
            TableColumn("rung", "model change", lambda line: RUNGS[line[0]]),
            *(column for quantity in rungs.QUANTITIES.items() for column in of_quantity(*quantity)),
        ],
    )


def _share(group: str) -> Callable[[rungs.Deviation], float]:
    return lambda one: 100 * one.shares[group]


SHARES = Columns[rungs.Deviation](
    "ladder/{0.where}/{0.quantity}",
    [
        TableColumn("reading", "reading", lambda one: READINGS[one.arm]),
        TableColumn("scenario", "experiment"),
        TableColumn("order", "order"),
        TableColumn("level", None),
        TableColumn("quantity", "of", lambda one: SYMBOLS[one.quantity]),
        TableColumn("instant", None),
        TableColumn("time_s", "at [s]"),
        TableColumn("total", "deviation [rad, m]"),
        *(
            TableColumn(f"{group}_percent", f"{name} [%]", _share(group))
            for group, name in GROUPS.items()
        ),
        TableColumn(
            "dominant", "nearly all of it", lambda one: GROUPS.get(one.dominant, one.dominant)
        ),
    ],
)


def _left_of(name: str, unit: str) -> tuple[TableColumn[rungs.RigidResidual], ...]:
    """The two columns of a quantity: what is left of it, and whether that is as in the paper."""
    title = f"left of {SYMBOLS[name]} [{unit}]"
    return (
        TableColumn(f"{name}_{unit}", title, lambda one: abs(one.found[name].total)),
        TableColumn(f"{name}_fits", "as in the paper", lambda one: one.fits[name]),
    )


def _span(group: str) -> Callable[[rungs.RigidResidual], tuple[float, ...]]:
    return lambda one: tuple(100 * end for end in one.span(group))


LEFT = Columns[rungs.RigidResidual](
    "{0.id}",
    [
        TableColumn("reading", "reading", lambda one: READINGS[one.arm]),
        TableColumn("level", "the baseline has", lambda one: LEVELS[one.level]),
        *(column for quantity in rungs.QUANTITIES.items() for column in _left_of(*quantity)),
        *(
            TableColumn(f"{g}_percent", f"{GROUPS[g]} [%]", _span(g))
            for g in (rungs.INERTIA, rungs.MESHES, rungs.SLIPPED)
        ),
    ],
)


def baselines(found: Sequence[rungs.RigidResidual]) -> str:
    """The sizes of what every baseline leaves, beside what the paper says, as svg."""
    limits = {name: claim.limits for name, claim in claims().items()}
    figure, grid = new_figure(1, len(rungs.QUANTITIES), 2.6)
    for axes, (name, factor) in zip(grid[0], rungs.IN_UNIT_OF_CLAIM.items(), strict=True):
        axes.axvspan(limits[name].low, limits[name].high, color="#999999", alpha=0.3, label="paper")
        for arm, marker, colour in zip(READINGS, "os", COLOURS, strict=False):
            mine = [one for one in found if one.arm == arm]
            sizes = [factor * abs(one.found[name].total) for one in mine]
            rows = [RIGID_LEVELS.index(one.level) for one in mine]
            axes.plot(sizes, rows, marker, color=colour, ms=5, label=READINGS[arm])
        axes.set(xscale="log", xlabel=f"left of {SYMBOLS[name]} [1]", yticks=[])
        axes.set_ylim(len(RIGID_LEVELS) - 0.5, -0.5)
    grid[0, 0].set_yticks(range(len(RIGID_LEVELS)), [LEVELS[level] for level in RIGID_LEVELS])
    legend(figure, grid[0, 0])
    return to_svg(figure)


def waterfall(ladders: list[rungs.Ladder]) -> str:
    """Contributions in the first order, stacked; below, their sizes in every order; as svg.

    Each column at the time of its own largest deviation. Bars begin where the one above ended, the
    total is a line; numerical uncertainties are grey crosses.
    """
    figure, grid = new_figure(2, len(rungs.QUANTITIES), 3.0)
    first, names = ladders[0], ladders[0].names
    rows = np.arange(len(names))
    for quantity, (name, unit) in enumerate(rungs.QUANTITIES.items()):
        above, below = grid[:, quantity]
        index = first.largest(quantity)
        steps = MILLI * first.fine[:, index, quantity]
        ends, colours = np.cumsum(steps), [COLOURS[0] if s >= 0 else COLOURS[1] for s in steps]
        above.barh(rows, steps, left=ends - steps, color=colours)
        above.vlines(ends, rows - 0.4, rows + 1.4, color="k", lw=0.6)
        above.set(xlabel=f"{SYMBOLS[name]} [m{unit}]", yticks=[], ylim=(len(names) - 0.4, -0.6),
                  title=f"at t = {first.time[index]:.3f} s, order A")  # fmt: skip
        for ladder, marker, colour in zip(ladders, "os", COLOURS, strict=False):
            at = ladder.largest(quantity)
            own = [names.index(rung) for rung in ladder.names]
            size = np.maximum(np.abs(ladder.fine[:, at, quantity]), _SMALLEST)
            doubt = np.maximum(ladder.uncertainty[:, at, quantity], _SMALLEST)
            below.plot(size, own, marker, color=colour, label=f"order {ladder.order}", ms=4)
            below.plot(doubt, own, "x", color="#999999", ms=3, label="numerical uncertainty")
        below.set(xscale="log", ylim=(len(names) - 0.4, -0.6), yticks=[],
                  xlabel=f"|contribution to {SYMBOLS[name]}| [{unit}]")  # fmt: skip
    for axes in grid[:, 0]:
        axes.set_yticks(rows, [RUNGS[name] for name in names])
    legend(figure, grid[1, 0])
    return to_svg(figure)
