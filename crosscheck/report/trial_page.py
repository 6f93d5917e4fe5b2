"""A trial as one page, which draws and typesets: Matplotlib is for whoever asks for one."""

from __future__ import annotations

import io
from collections.abc import Iterator

from matplotlib.figure import Figure

from crosscheck.report.heat_map import HeatMap, entry_map, heat_map
from crosscheck.report.plots.scheme import described
from crosscheck.report.rendering import WrongRow, page
from crosscheck.report.trial import notes, summary, verdicts, why
from crosscheck.trial.diagnose.words import told
from crosscheck.trial.judge.places import named
from crosscheck.trial.trial import Trial

PART_NAMES = {"mass_matrix": "M", "rate_terms": "bias", "force": "force"}
POINTS = 11


def trial_page(trial: Trial) -> str:
    """The page on a trial: HTML text, figures inlined."""
    names = trial.problem.frame.names
    return page(
        "trial",
        name=trial.problem.name,
        subject=trial.problem.case.arm.name,
        agreement=trial.agreement,
        traces=trial.traces,
        summary=list(summary(trial)),
        wrong=[
            WrongRow(named(w.place, names), w.relative, why(w), w.latex, w.explanation)
            for w in trial.wrong
        ],
        verdicts=verdicts(trial),
        notes=list(notes(trial)),
        maps=list(_maps(trial)),
        allowed={PART_NAMES.get(name, name): value for name, value in trial.allowed.items()},
        described=list(described(trial.problem.case.arm)),
        typeset=typeset,
        words=lambda errors: " and ".join(map(told, errors)),
        provenance=trial.agreement.to_dict()["provenance"],
    )


def _maps(trial: Trial) -> Iterator[HeatMap]:
    """A heat map of each part; of the bias one for each row that deviates."""
    names = trial.problem.frame.names
    for quantity, apart in trial.apart.items():
        title, allowed = PART_NAMES.get(quantity, quantity), trial.allowed[quantity]
        if apart.ndim == 3:
            for row, name in enumerate(names):
                if not (apart[row] <= allowed).all():
                    said = f"{title} of {name}, by rates"
                    yield heat_map(said, names, names, apart[row].tolist(), allowed)
        else:
            yield entry_map(title, names, apart, allowed)


def typeset(latex: str) -> str:
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
