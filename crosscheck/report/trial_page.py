"""A trial as one page, which draws and typesets: Matplotlib is for whoever asks for one."""

from __future__ import annotations

import io

from matplotlib.figure import Figure

from crosscheck.models.arm.arm import describe_arm
from crosscheck.report.finding_groups import list_findings
from crosscheck.report.heat_map import PART_NAMES, make_trial_maps
from crosscheck.report.rendering import WrongRow, render_page
from crosscheck.report.trial import (
    describe_errors,
    describe_notes,
    describe_trial,
    explain_wrong_entry,
)
from crosscheck.trial.diagnose.messages import describe_term_error
from crosscheck.trial.judge.entries import format_entry
from crosscheck.trial.trial import Trial

POINTS = 11


def render_trial_page(trial: Trial) -> str:
    """The page on a trial: HTML text, figures inlined."""
    names = trial.problem.frame.names
    return render_page(
        "trial",
        name=trial.problem.name,
        subject=trial.problem.case.arm.name,
        agreement=trial.agreement,
        traces=trial.traces,
        summary=list(describe_trial(trial)),
        wrong=[
            WrongRow(
                format_entry(w.place, names),
                w.relative,
                explain_wrong_entry(w),
                w.latex,
                w.explanation,
            )
            for w in trial.wrong_entries
        ],
        verdicts=describe_errors(trial),
        notes=list(describe_notes(trial)),
        maps=list(make_trial_maps(trial)),
        allowed={PART_NAMES.get(name, name): value for name, value in trial.allowed.items()},
        described=list(describe_arm(trial.problem.case.arm)),
        typeset=render_formula,
        words=lambda errors: " and ".join(map(describe_term_error, errors)),
        listed=list_findings(trial.agreement.findings),
        provenance=trial.agreement.to_dict()["provenance"],
    )


def render_formula(latex: str) -> str:
    """A formula as SVG; '' for none, and for one that cannot be set."""
    if not latex:
        return ""
    figure = Figure(figsize=(0.1, 0.1))
    figure.text(0, 0, f"${latex}$", fontsize=POINTS)
    text = io.StringIO()
    try:
        figure.savefig(text, format="svg", bbox_inches="tight", pad_inches=0.02, transparent=True)
    except ValueError:  # what matplotlib's own TeX does not know
        return ""
    drawing = text.getvalue()
    return drawing[drawing.index("<svg") :]
