"""The Agreement as one self-contained page."""

from __future__ import annotations

from crosscheck.findings import Finding
from crosscheck.models.robot.robot import Robot
from crosscheck.planning import plan, robots
from crosscheck.planning.run_suite import MIDWAY_S
from crosscheck.planning.state_suite import COUNT, QUICK_COUNT
from crosscheck.registry import second_engine
from crosscheck.report.answers import (
    answer_questions,
    find_tip_ends,
    find_wrong_entries,
    is_without_contact,
)
from crosscheck.report.finding_groups import list_findings, make_row, sort_findings
from crosscheck.report.heat_map import make_entry_maps
from crosscheck.report.matrix import collect_cells, group_models
from crosscheck.report.plots.charts import Pictures
from crosscheck.report.plots.figures import fix_links
from crosscheck.report.plots.scheme import draw_scheme
from crosscheck.report.plots.signals import format_signals
from crosscheck.report.rendering import render_page
from crosscheck.report.vendor import read_vendored
from crosscheck.run import CrossCheck

HEADLINE, HEADLINE_CASES = (f"at-{MIDWAY_S:g}-s", "same-step"), ("pd", "pd-motion")


def render_report_page(result: CrossCheck, pictures: Pictures) -> str:
    """HTML text of the report, figures inlined."""
    agreement, mechanism = result.agreement, result.mechanism
    answers = answer_questions(agreement, mechanism)
    matrix_cells = collect_cells(agreement.findings)
    # By experiment and rigid model, how far that is from the geared arm.
    deviations: dict[str, dict[str, list[Finding]]] = {}
    for finding in agreement.findings:
        key = finding.about.key
        if key.family == "deviation":
            deviations.setdefault(key.case, {}).setdefault(key.left, []).append(finding)
    made = render_page(
        "page",
        outline=answers.outline,
        agreement=agreement,
        is_the_papers=answers.outline.is_the_papers,
        answers=answers,
        maps=make_entry_maps(agreement.entries),
        wrong=find_wrong_entries(agreement.entries),
        questions=answers.outline.questions,
        topics=answers.outline.topics,
        tips=find_tip_ends(agreement),
        is_without_contact=is_without_contact,
        quantities=answers.outline.quantities,
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
        scheme=draw_scheme(mechanism),
        preliminary=describe_quick_limits(result.request),
        second=second_engine(),
        provenance=agreement.to_dict()["provenance"],
    )
    return fix_links(made)


def describe_quick_limits(request: plan.CrossCheckRequest) -> str:
    """Sentences on what a quick cross-check leaves out."""
    if isinstance(request.mechanism, Robot):
        return (
            f"With --quick models are compared at {robots.QUICK_COUNT} random states, where a full"
            f" cross-check takes {robots.COUNT}, and free motions take at most"
            f" {robots.QUICK_STEPS} steps of {robots.MOST_STEPS}."
        )
    runs = f"at most {plan.QUICK_STEPS} steps of each experiment are simulated"
    if request.has_fixed_steps:
        short = (
            f"{each:g} of {plan.FULL_S[name]:g} s of {name}" for name, each in plan.QUICK_S.items()
        )
        runs = f"{' and '.join(short)} are simulated"
    elif request.needs_sizes:
        runs = f"{runs}, a full cross-check takes up to {plan.FULL_STEPS}"
    return (
        f"With --quick {runs}, and models are compared at {QUICK_COUNT} random states where a full"
        f" cross-check takes {COUNT}. What happens later in the runs is not judged here."
    )
