"""The damping that the paper leaves out: which settings explain the numbers that it prints?"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from crosscheck.audit.claims.catalogue import BY_ID
from crosscheck.audit.claims.rule import Claim, State
from crosscheck.audit.experiments.cells import LAWS, READINGS, Law
from crosscheck.audit.hypotheses.evidence.fit import (
    ALPHA,
    NUMBERS,
    PLANETS,
    DampingFit,
    Span,
    each_left_out,
    equally_good,
    fits,
    said,
    span,
    tells_nothing,
)
from crosscheck.audit.hypotheses.evidence.reversals import Reversals, reversals
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.text import html, text
from crosscheck.report.figures import legend, new_figure, to_svg
from crosscheck.report.fragments import COLOURS

ID, TITLE = "damping_fit", "The unknown damping"
LAW_WORDS = dict(
    zip(
        (law.id for law in LAWS),
        ("as printed", "printed, ring rate repaired", "integral"),
        strict=True,
    )
)


def chapter(material: Material) -> AuditChapter:
    """The set of settings that explain the printed numbers equally well."""
    claims = [BY_ID[name] for name in NUMBERS]
    found = fits(material, claims)
    chosen = equally_good(found)
    whole, left_out = span(chosen), each_left_out(found)
    silent = tells_nothing(found)
    table = _columns(claims, chosen)
    rigid = reversals(material.study, material.scale)
    given = {
        "claims": claims,
        "chosen": whole,
        "laws": [LAW_WORDS[law] for law in whole.laws],
        "most": {LAW_WORDS[law.id]: _most(found, law) for law in LAWS},
    }
    page = text(
        "hypotheses/damping_fit",
        always=[BY_ID[name] for name in silent[State.YES]],
        never=[BY_ID[name] for name in silent[State.NO]],
        settings=len(found),
        starts=len(material.scale.seeds),
        alpha=ALPHA,
        picture=html(drawing(found, chosen, LAW_WORDS)),
        best=html(table.html(chosen)),
        left_out=html(SPANS.html(left_out)),
        every=html(table.html(sorted(found, key=lambda fit: -fit.mean))),
        reversals=html(REVERSALS.html(rigid)),
        **given,
    )
    verdict: dict[str, object] = {
        "id": "damping",
        **_span_record(whole),
        "without": [_span_record(one) for one in left_out],
        "true_in_all": silent[State.YES],
        "false_in_all": silent[State.NO],
    }
    records: list[Mapping[str, object]] = [verdict, *REVERSALS.json(rigid), *table.json(found)]
    outcome = text("hypotheses/damping_fit_outcome", **given)
    return AuditChapter(ID, TITLE, page, records, outcome, said=said(found, claims))


def _span_record(one: Span) -> dict[str, object]:
    return {name: list(v) if isinstance(v, tuple) else v for name, v in vars(one).items()}


def _most(found: Sequence[DampingFit], law: Law) -> float:
    """Numbers that a law's best setting explains."""
    return max(fit.mean for fit in found if fit.cell.law == law)


def _share(claim: Claim) -> Callable[[DampingFit], float]:
    return lambda fit: float(np.mean(fit.explained[claim.id]))


def _columns(claims: Sequence[Claim], chosen: Sequence[DampingFit]) -> Columns[DampingFit]:
    """claims: whose shares of starts are shown."""
    return Columns(
        lambda fit: f"damping_fit/{fit.cell.id}",
        [
            TableColumn("law", "phase law", lambda fit: LAW_WORDS[fit.cell.law.id]),
            TableColumn("reading", "reading", lambda fit: fit.cell.reading),
            TableColumn("planets", "planets", lambda fit: fit.cell.planets),
            TableColumn("zeta", "ζ", lambda fit: fit.cell.zeta, "g"),
            TableColumn("explained", "numbers explained", lambda fit: fit.mean, ".2f"),
            *(TableColumn(claim.id, claim.id, _share(claim), ".2f") for claim in claims),
            TableColumn("equally_good", None, lambda fit: fit in chosen),
        ],
    )


SPANS: Columns[Span] = Columns(
    lambda one: f"damping_fit/without/{one.left_out}",
    [
        TableColumn("left_out", "without", lambda one: one.left_out),
        TableColumn("settings", "equally good", lambda one: one.settings),
        TableColumn("explained", "numbers explained, at most", lambda one: one.mean, ".2f"),
        TableColumn("laws", "phase law", lambda one: "; ".join(LAW_WORDS[law] for law in one.laws)),
        TableColumn("readings", "reading", lambda one: ", ".join(one.readings)),
        TableColumn("planets", "planets", lambda one: ", ".join(one.planets)),
        TableColumn("zetas", "ζ", lambda one: one.zetas, "g"),
    ],
)
REVERSALS: Columns[Reversals] = Columns(
    lambda one: f"damping_fit/rigid/{one.level}",
    [
        TableColumn("level", "rigid arm", lambda one: one.level),
        TableColumn(
            "side_change_s", "torque changes sign at [s]", lambda one: one.side_change_s, ".3f"
        ),
        TableColumn("return_s", "and again at [s]", lambda one: one.return_s, ".3f"),
    ],
)


def drawing(
    found: Sequence[DampingFit], chosen: Sequence[DampingFit], names: dict[str, str]
) -> str:
    """Over zeta, a panel for each reading and way of the planets; names: of the laws."""
    picture, grid = new_figure(len(PLANETS), len(READINGS), 2.4)
    for row, planets in zip(grid, PLANETS, strict=True):
        for axes, (arm, reading) in zip(row, READINGS.items(), strict=True):
            for law, colour in zip(LAWS, COLOURS, strict=False):
                mine = [
                    fit for fit in found
                    if (fit.cell.law, fit.cell.arm, fit.cell.planets) == (law, arm, planets)
                ]  # fmt: skip
                points = [(fit.cell.zeta, fit.mean) for fit in mine]
                best = [(fit.cell.zeta, fit.mean) for fit in mine if fit in chosen]
                axes.plot(*_coordinates(points), "o-", color=colour, ms=3, label=names[law.id])
                axes.plot(*_coordinates(best), "o", mfc="none", mec="k", ms=8, label="equally good")
            axes.set(xscale="log", ylim=(0, len(found[0].explained)),
                     title=f"{reading}, planets {_WORDS[planets]}")  # fmt: skip
    for axes in grid[-1]:
        axes.set_xlabel("ζ")
    for axes in grid[:, 0]:
        axes.set_ylabel("numbers explained [1]")
    legend(picture, grid[0, 0])
    return to_svg(picture)


_WORDS = {"free": "free", "lumped": "lumped"}


def _coordinates(points: Sequence[tuple[float, float]]) -> tuple[list[float], list[float]]:
    return [x for x, _ in points], [y for _, y in points]
