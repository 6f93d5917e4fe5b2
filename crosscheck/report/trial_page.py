"""A trial as one page, which draws and typesets: Matplotlib is for whoever asks for one."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from crosscheck.report.plots.figures import to_svg
from crosscheck.report.plots.scheme import described
from crosscheck.report.rendering import page
from crosscheck.report.trial import notes, summary, verdicts, why
from crosscheck.trial.diagnose.words import told
from crosscheck.trial.judge.places import named
from crosscheck.trial.trial import Trial

LEAST, MOST = 1e-16, 1.0  # of a heat map's scale
PART_NAMES = {"mass_matrix": "M", "rate_terms": "bias", "force": "force"}
POINTS = 11


@dataclass(frozen=True)
class HeatMap:
    """A heat map of one part's relative deviations; drawing: SVG text."""

    title: str
    drawing: str


def trial_page(trial: Trial) -> str:
    """The page on a trial: HTML text, figures inlined."""
    names = trial.problem.frame.names
    return page(
        "trial",
        trial=trial,
        summary=list(summary(trial)),
        wrong=[(named(each.place, names), each, why(each)) for each in trial.wrong],
        verdicts=verdicts(trial),
        notes=list(notes(trial)),
        maps=list(_maps(trial)),
        described=list(described(trial.problem.case.arm)),
        typeset=typeset,
        words=lambda errors: " and ".join(map(told, errors)),
        provenance=trial.agreement.to_dict()["provenance"],
    )


def _maps(trial: Trial) -> Iterator[HeatMap]:
    """A heat map of each part; of the bias one for each row that deviates."""
    names = trial.problem.frame.names
    for quantity, apart in trial.apart.items():
        title = PART_NAMES.get(quantity, quantity)
        if apart.ndim == 3:
            for row, name in enumerate(names):
                if (apart[row] > LEAST).any():
                    yield HeatMap(f"{title} of {name}, by rates", _drawn(apart[row], names, names))
        elif apart.ndim == 2:
            yield HeatMap(title, _drawn(apart, names, names))
        else:
            yield HeatMap(title, _drawn(apart[:, None], names, ("",)))


def _drawn(apart: np.ndarray, rows: tuple[str, ...], columns: tuple[str, ...]) -> str:
    """A heat map of relative deviations (rows, columns), as SVG."""
    size = 0.5
    figure = Figure(figsize=(1.8 + size * len(columns), 1.0 + size * len(rows)), layout="tight")
    axes = figure.subplots()
    shown = np.clip(np.nan_to_num(apart, nan=MOST, posinf=MOST), LEAST, None)
    image = axes.imshow(shown, norm=LogNorm(LEAST, MOST), cmap="viridis", aspect="equal")
    axes.set_xticks(range(len(columns)), columns, rotation=90)
    axes.set_yticks(range(len(rows)), rows)
    figure.colorbar(image, ax=axes, label="relative deviation")
    return to_svg(figure)


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
