"""Views of a record beside an arm's levels."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from crosscheck.identification import output
from crosscheck.identification.compare import RecordComparison
from tests.brief import perform_here
from tests.measured.guards import kept
from tests.views.shown_numbers import View, mark


def make_comparison() -> RecordComparison:
    """The comparison, with other numbers; its last run is shorter, so that no mean is right."""
    with pytest.MonkeyPatch.context() as patch:
        perform_here(patch)
        whole = kept().comparison
    window = whole.windows[0]
    rows = slice(2 * len(window.time) // 3)
    cut = type(window)(*(getattr(window, name)[rows] for name in vars(window)))
    return mark(replace(whole, windows=(*whole.windows, cut)))


def derive_numbers(comparison: RecordComparison) -> Iterator[tuple[str, float]]:
    """Of runs, of what a side leaves unexplained and of how likely its explanations are."""
    windows = comparison.windows
    lasts = np.array([float(each.time[-1] - each.time[0]) for each in windows])
    shares = np.array([each.stays_s for each in windows]) / lasts
    middle = float(np.quantile(shares, 0.5, method="higher"))
    yield "median length of runs", float(np.median(lasts))
    yield "median stay of runs", middle * float(np.median(lasts))
    yield "share of rows within", float(np.mean([each.within for each in windows]))
    for number, each in enumerate(windows):
        own = f"windows[{number}]"
        yield f"start of {own}", float(each.time[0])
        yield f"end of {own}", float(each.time[-1])
        yield f"stay of {own}", each.stays_s
        yield f"share within of {own}", each.within
        parts = np.square((each.numerical, each.data, each.inputs))
        for joint, value in enumerate(np.sqrt(parts.sum(axis=0))[-1]):
            yield f"u_val of {own}[{joint}]", float(value)
    yield "length of records", sum(each.time[-1] - each.time[0] for each in comparison.records)
    for number, side in enumerate((*comparison.sides, *comparison.gravities)):
        own = f"side {number}"
        yield f"distance of rows of {own}", side.samples.step
        for joint, share in zip(side.measured, side.unexplained, strict=True):
            yield f"unexplained by {own} at {joint}", float(share)
        for each in side.estimates:
            yield f"systematic share of {own}, {each.term.name}", each.systematic / each.error
        judged = side.judgement
        for each in (*judged.levels, *judged.changes) if judged else ():
            changed = "nothing" if each.parameter is None else each.parameter.path
            behind = judged.compare(each, judged.likeliest)
            yield f"likelihood ratio of {own}, {each.level}, {changed}", behind


def render_page(comparison: RecordComparison) -> str:
    """The page, without what is drawn."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(output, "draw_joints", lambda *given, **more: "<svg></svg>")
        return output.comparison_page(comparison)


RENDER = {
    "terminal": lambda comparison: "\n".join(output.describe_comparison(comparison)),
    "JSON": output.comparison_json,
    "page": render_page,
}
VIEWS = {
    f"{name} of compare": View(make_comparison, render, derive_numbers)
    for name, render in RENDER.items()
}
