"""Hypothesis H4: what it costs that Eq. 18 leaves link 1's rotation out of the elbow's planets."""

from __future__ import annotations

from crosscheck.audit.experiments.paper_conditions import READINGS
from crosscheck.audit.hypotheses.evidence.spin import (
    CONSIDERABLE_M,
    Difference,
    SpinCost,
    is_considerable,
)
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.page.context import AuditContext
from crosscheck.audit.page.text import render_template

ID, TITLE = "planet_spin", "The elbow planets' spin (H4)"
DURATIONS_S = {"constant-torque": 0.5, "pd": 3.0}


def build_chapter(context: AuditContext) -> AuditChapter:
    """The chapter on the spin's cost in both readings and scenarios."""
    questions = [
        SpinCost(arm, scenario, context.scale.limit_duration(duration_s))
        for arm in READINGS
        for scenario, duration_s in DURATIONS_S.items()
    ]
    differences = context.study.answer_questions(questions, "H4, planet spin")
    largest = max(differences, key=lambda difference: difference.tip_m)
    summary = {
        "largest": largest,
        "matters": is_considerable(largest.tip_m),
        "limit_m": CONSIDERABLE_M,
    }
    page = render_template(
        "hypotheses/planet_spin", first=differences[0], table=COSTS.html(differences), **summary
    )
    verdict = {
        "id": "H4",
        "verdict": "considerable" if is_considerable(largest.tip_m) else "not considerable",
        "largest_tip_m": largest.tip_m,
        "where": f"{largest.arm}, {largest.scenario}",
    }
    outcome = render_template("hypotheses/planet_spin_outcome", **summary)
    return AuditChapter(ID, TITLE, page, [verdict, *COSTS.json(differences)], outcome)


COSTS = Columns[Difference](
    "H4/{0.arm}/{0.scenario}",
    [
        TableColumn("arm", "reading", lambda row: READINGS[row.arm]),
        TableColumn("scenario", "experiment"),
        TableColumn("duration_s", "[s]", form="g"),
        TableColumn("missing_kg_m2", "missing in M₃₃ [kg m²]"),
        TableColumn(
            "missing_percent",
            "of M₃₃ [%]",
            lambda row: None if row.relative is None else 100 * row.relative,
            ".2g",
        ),
        TableColumn("theta_rad", "Δθ [rad]"),
        TableColumn("tip_mm", "tip [mm]", lambda row: 1e3 * row.tip_m),
        TableColumn("mesh_force_N", "mesh force per planet [N]"),
    ],
)
