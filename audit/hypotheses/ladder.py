"""Hypothesis H2: what makes the rigid baseline of Figs. 6-7 deviate from the detailed arm."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

from markupsafe import Markup

from crosscheck.audit.claims.catalogue import BY_ID
from crosscheck.audit.claims.rule import Claim
from crosscheck.audit.experiments.cells import READINGS
from crosscheck.audit.hypotheses.evidence.attribution import (
    CLAIMS,
    TORQUE,
    Deviation,
    LadderVerdict,
    RigidResidual,
    by_level,
    deviations,
    ladder_verdict,
    left,
    said,
)
from crosscheck.audit.hypotheses.evidence.rungs import (
    INERTIA,
    MESHES,
    QUANTITIES,
    SLIPPED,
    Ladder,
    climb,
)
from crosscheck.audit.hypotheses.ladder_views import baselines, waterfall
from crosscheck.audit.hypotheses.words import GROUPS, LEVELS, RUNGS, SCENARIOS, SYMBOLS
from crosscheck.audit.measures.undefined import recorded, word
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.record import JsonObject
from crosscheck.audit.page.said import StatedNumber
from crosscheck.audit.page.text import html, text

ID, TITLE = "ladder", "What separates the rigid arm from the detailed one (H2)"
# (scenario, reading, order): both scenarios in both orders, the other reading where the paper
# prints numbers.
CLIMBS = (
    *((scenario, arm, "A") for arm in READINGS for scenario in (TORQUE,)),
    ("pd", next(iter(READINGS)), "A"),
    *((scenario, next(iter(READINGS)), "B") for scenario in SCENARIOS),
)
QUICK_CLIMBS = CLIMBS[:1]


class Climbed(NamedTuple):
    """levels: what every baseline leaves; whole: all of every ladder; verdict: of both."""

    ladders: list[Ladder]
    levels: list[Deviation]
    whole: list[Deviation]
    left: list[RigidResidual]
    verdict: LadderVerdict


def claims() -> dict[str, Claim]:
    """The paper's three numbers, by quantity."""
    return {quantity: BY_ID[name] for quantity, name in CLAIMS.items()}


def climbed(material: Material) -> Climbed:
    """All ladders; quick: constant torque in one order, labelled reading."""
    climbs = QUICK_CLIMBS if material.scale.quick else CLIMBS
    ladders = [climb(material.study, *which, material.scale) for which in climbs]
    levels = by_level(ladder for ladder in ladders if ladder.order == "A")
    whole = [one for ladder in ladders for one in deviations(ladder)]
    stated = claims()
    verdict = ladder_verdict(levels, whole, stated["theta_2"].limits)
    return Climbed(ladders, levels, whole, left(levels, stated), verdict)


def picture(found: Climbed) -> str:
    """What every baseline leaves, beside what the paper says, as svg."""
    return baselines(found.left, {name: claim.limits for name, claim in claims().items()})


def chapter(material: Material) -> AuditChapter:
    """The ladder."""
    found = climbed(material)
    page = text(
        "hypotheses/ladder",
        verdict=found.verdict,
        levels=[LEVELS[level] for level in found.verdict.fitting],
        limits={name: str(claim.limits) for name, claim in claims().items()},
        all_three=[LEVELS[one.level] for one in found.left if all(one.fits.values())],
        links_factor=_most(found.left, "links") / claims()["theta_2"].limits.high,
        coupled_rad=_most(found.left, "coupled"),
        fitting=[one for one in found.left if one.fits["theta_2"]],
        names=LEVELS,
        causes=[GROUPS.get(cause, cause) for cause in found.verdict.causes],
        groups={"inertia": INERTIA, "meshes": MESHES, "slips": SLIPPED},
        rungs=len(found.ladders[0].names),
        picture=html(picture(found)),
        left=html(LEFT.html(found.left)),
        scenarios=[_scenario(found.ladders, name) for name in SCENARIOS],
        shares=html(SHARES.html([one for one in found.whole if one.instant == "largest"])),
    )
    records = [
        _verdict_record(found.verdict),
        *LEFT.json(found.left),
        *SHARES.json(_unlike([*found.whole, *found.levels])),
        *(record for ladder in found.ladders for record in _rungs(ladder)),
    ]
    outcome = text("hypotheses/ladder_outcome", verdict=found.verdict, inertia=INERTIA)
    numbers = [
        StatedNumber(TITLE, f"{name} left by {one.level}", one.arm, abs(deviation.total))
        for one in found.left
        for name, deviation in one.found.items()
    ]
    return AuditChapter(ID, TITLE, page, records, outcome, said(found.left, claims()), numbers)


def _most(found: Sequence[RigidResidual], level: str) -> float:
    """Largest deviation of theta_2 [rad] that a level leaves."""
    return max(abs(one.found["theta_2"].total) for one in found if one.level == level)


def _unlike(found: Sequence[Deviation]) -> list[Deviation]:
    """A whole ladder is also what its lowest level leaves."""
    return list({(one.where, one.quantity): one for one in found}.values())


class ScenarioSection(NamedTuple):
    """For the page: a scenario with its drawing and tables."""

    title: str
    drawing: Markup
    tables: list[Markup]


def _scenario(ladders: Sequence[Ladder], name: str) -> ScenarioSection | None:
    """None where it was not climbed."""
    mine = [x for x in ladders if x.scenario == name and x.arm == next(iter(READINGS))]
    if not mine:
        return None
    tables = [html(_rung_columns(x).html(_lines(x, "largest"), f"Order {x.order}")) for x in mine]
    return ScenarioSection(SCENARIOS[name], html(waterfall(mine)), tables)


Line = tuple[str, dict[str, Deviation]]  # a rung, and the deviations that it is a part of


def _lines(ladder: Ladder, instant: str) -> list[Line]:
    at = {one.quantity: one for one in deviations(ladder) if one.instant == instant}
    return [(name, at) for name in ladder.names]


def _rungs(ladder: Ladder) -> list[JsonObject]:
    return [
        record
        for instant in ("end", "largest")
        for record in _rung_columns(ladder, f"/{instant}").json(_lines(ladder, instant))
    ]


def _rung_columns(ladder: Ladder, instant: str = "") -> Columns[Line]:
    place = f"ladder/{ladder.arm}/{ladder.scenario}/{ladder.order}{instant}"
    columns: list[TableColumn[Line]] = [
        TableColumn("rung", "model change", lambda line: RUNGS[line[0]])
    ]
    for name, unit in QUANTITIES.items():
        columns += [
            TableColumn(f"{name}_{unit}", f"{SYMBOLS[name]} [{unit}]", partial(_resolved, name)),
            TableColumn(f"{name}_with_uncertainty", None, partial(_both, name)),
        ]
    return Columns(lambda line: f"{place}/{line[0]}", columns)


def _both(quantity: str, line: Line) -> tuple[float, float]:
    """A rung's contribution and its uncertainty."""
    (rung,) = (rung for rung in line[1][quantity].rungs if rung.name == line[0])
    return rung.contribution, rung.uncertainty


def _resolved(quantity: str, line: Line) -> float | None:
    """The contribution, None if it is below its uncertainty."""
    value, doubt = _both(quantity, line)
    return value if abs(value) > doubt else None


def _share(group: str) -> Callable[[Deviation], float]:
    return lambda one: 100 * one.shares[group]


SHARES: Columns[Deviation] = Columns(
    lambda one: f"ladder/{one.where}/{one.quantity}",
    [
        TableColumn("reading", "reading", lambda one: READINGS[one.arm]),
        TableColumn("scenario", "experiment", lambda one: one.scenario),
        TableColumn("order", "order", lambda one: one.order),
        TableColumn("level", None, lambda one: one.level),
        TableColumn("quantity", "of", lambda one: SYMBOLS[one.quantity]),
        TableColumn("instant", None, lambda one: one.instant),
        TableColumn("time_s", "at [s]", lambda one: one.time_s),
        TableColumn("total", "deviation [rad, m]", lambda one: one.total),
        *(
            TableColumn(f"{group}_percent", f"{GROUPS[group]} [%]", _share(group))
            for group in GROUPS
        ),
        TableColumn(
            "dominant", "nearly all of it", lambda one: GROUPS.get(one.dominant, one.dominant)
        ),
    ],
)


def _size(quantity: str) -> Callable[[RigidResidual], float]:
    return lambda one: abs(one.found[quantity].total)


def _fits(quantity: str) -> Callable[[RigidResidual], bool]:
    return lambda one: one.fits[quantity]


def _span(group: str) -> Callable[[RigidResidual], tuple[float, float]]:
    def percent(one: RigidResidual) -> tuple[float, float]:
        low, high = one.span(group)
        return 100 * low, 100 * high

    return percent


LEFT: Columns[RigidResidual] = Columns(
    lambda one: one.id,
    [
        TableColumn("reading", "reading", lambda one: READINGS[one.arm]),
        TableColumn("level", "the baseline has", lambda one: LEVELS[one.level]),
        *(
            column
            for name, unit in QUANTITIES.items()
            for column in (
                TableColumn(f"{name}_{unit}", f"left of {SYMBOLS[name]} [{unit}]", _size(name)),
                TableColumn(f"{name}_fits", "as in the paper", _fits(name)),
            )
        ),
        *(
            TableColumn(f"{g}_percent", f"{GROUPS[g]} [%]", _span(g))
            for g in (INERTIA, MESHES, SLIPPED)
        ),
    ],
)


def _verdict_record(verdict: LadderVerdict) -> JsonObject:
    return {
        "id": "H2",
        "verdict": word(verdict.holds, "holds", "does not hold"),
        "fitting_levels": list(verdict.fitting),
        "shares_of_what_these_leave": recorded(verdict.rest),
        "from_links": word(verdict.holds_from_links, "holds", "does not hold"),
        "shares_of_the_whole": recorded(verdict.whole),
        "nearly_all_of_the_whole": list(verdict.causes),
        "paper": word(verdict.papers, "holds", "does not hold"),
    }
