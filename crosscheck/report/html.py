"""The Agreement as one self-contained page."""

from __future__ import annotations

from pathlib import Path

from crosscheck.checks.trajectories import MIDWAY_S
from crosscheck.findings import Finding
from crosscheck.mechanisms import supply
from crosscheck.output import write_files
from crosscheck.registry import second_engine
from crosscheck.report.answers import (
    answer_questions,
    find_tip_ends,
    find_wrong_entries,
    format_agreement_json,
    is_without_contact,
)
from crosscheck.report.finding_groups import list_findings, make_row, sort_findings
from crosscheck.report.heat_map import make_entry_maps
from crosscheck.report.matrix import collect_cells, group_models
from crosscheck.report.plots.charts import draw_pictures
from crosscheck.report.plots.figures import fix_links
from crosscheck.report.plots.signals import format_signals
from crosscheck.report.rendering import render_page
from crosscheck.report.vendor import read_vendored
from crosscheck.run import CrossCheck

HEADLINE, HEADLINE_CASES = (f"at-{MIDWAY_S:g}-s", "same-step"), ("pd", "pd-motion")


def write_report(result: CrossCheck, folder: Path) -> tuple[Path, Path]:
    """Write index.html and agreement.json; returns their paths. Raises InputError."""
    page, data = folder / "index.html", folder / "agreement.json"
    text = format_agreement_json(result.agreement, result.mechanism)
    write_files({page: render_report_page(result), data: text})
    return page, data


def render_report_page(result: CrossCheck) -> str:
    """HTML text of the report, figures inlined."""
    agreement, mechanism, pictures = result.agreement, result.mechanism, draw_pictures(result.runs)
    answers = answer_questions(agreement, mechanism)
    matrix_cells = collect_cells(agreement.findings)
    # By experiment and rigid model, how far that is from the geared arm.
    deviations: dict[str, dict[str, list[Finding]]] = {}
    for finding in agreement.findings:
        key = finding.about.key
        if key.family == "deviation":
            deviations.setdefault(key.case, {}).setdefault(key.left, []).append(finding)
    made = render_page(
        mechanism.section,  # whose template fills the page's own sentences in
        outline=answers.outline,
        mechanism=mechanism,
        agreement=agreement,
        answers=answers,
        maps=make_entry_maps(agreement.entries),
        wrong=find_wrong_entries(agreement.entries),
        tips=find_tip_ends(agreement),
        is_without_contact=is_without_contact,
        cells=matrix_cells,
        groups=group_models([cell for cell in matrix_cells if cell.between_models]),
        listed=list_findings(agreement.findings),
        failures=[make_row(f) for f in sort_findings(agreement.disagreeing)],
        headline=[
            make_row(f)
            for f in agreement.checks
            if f.about.key.case in HEADLINE_CASES and f.about.key.family in HEADLINE
        ],
        deviations=deviations,
        pictures=pictures,
        signals=format_signals(pictures.signals),
        plot_style=read_vendored("uPlot.min.css"),
        plot_script=read_vendored("uPlot.iife.min.js"),
        scheme=supply("draw", mechanism.section)(mechanism),
        preliminary=supply("describe_quick_limits", mechanism.section)(result.request),
        second=second_engine(),
        provenance=agreement.to_dict()["provenance"],
    )
    return fix_links(made)
