"""Views of trials of an arm's and of a robot's equations."""

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crosscheck import testing
from crosscheck.report.records import format_json
from crosscheck.report.trials import output
from crosscheck.trial.input.source_lines import find_source
from crosscheck.trial.result import Trial
from tests.trial.trial_views import kept_arm, kept_robot
from tests.views.agreements import COUNTED, TICK, list_findings
from tests.views.walker import WORDS, Fact, View, vary
from tools.annotate_trial import format_annotations

RECORDS: dict[str, Callable[[], Any]] = {"arm": kept_arm, "robot": kept_robot}
TITLES = {"mass_matrix": "M", "rate_terms": "bias"}


def make_trial(record: Callable[[], Any], seed: int) -> Any:
    """The trial with other numbers; of an arm every product of rates is off."""
    made = vary(record(), seed)
    errors = dict(made.relative_errors)
    if "rate_terms" in errors:
        errors["rate_terms"] = np.random.default_rng(seed).uniform(size=errors["rate_terms"].shape)
    return replace(made, relative_errors=errors)


def list_facts(trial: Trial) -> Iterator[Fact]:
    """Facts of entries, levels, parts and findings."""
    yield from list_findings(trial.agreement)
    wrong, names = list(list_wrong(trial)), trial.problem.names
    for name, share, row, column, part in wrong:
        places = {
            "row": row,
            "column": column,
            "line": find_source(trial.problem.equations, part).first,
        }
        shares = {"share": share, "off by": share}
        yield from (Fact(value, key, (name,)) for key, value in {**shares, **places}.items())
    yield Fact(len(wrong) - 1, "others")
    for each in trial.diagnosis.entries:
        yield from (Fact(float(term.coefficient), "difference") for term in each.difference)
    yield Fact(max(share for _, share, *_ in wrong), "largest share")
    for each in trial.distances:
        for owner in (each.level, f"beside level {each.level}"):
            yield Fact(each.entries, "entries", (owner,))
            yield Fact(each.largest, "largest", (owner,))
            yield Fact(each.mean, "mean", (owner,))
    for part, errors in trial.relative_errors.items():
        title = TITLES.get(part, part)
        yield Fact(trial.allowed[part], f"allowed {title}")
        for number, rows in enumerate(errors if errors.ndim == 3 else [errors]):
            own = f"bias of {names[number]}, by rates" if errors.ndim == 3 else title
            rows = np.maximum(rows, rows.T) if errors.ndim == 3 else rows  # of v1 v2 and v2 v1
            for place, value in np.ndenumerate(rows):
                head = names[place[1]] if len(place) > 1 else "column 1"
                shown = TICK if value <= trial.allowed[part] else value
                yield Fact(shown, head, (own, names[place[0]]))
            yield Fact(int((rows > trial.allowed[part]).sum()), "cells that differ", (own,))
            yield Fact(rows.size, "cells", (own,))


def list_wrong(trial: Trial) -> Iterator[tuple[str, float, int, int | None, str]]:
    """Name, share, row, column and part of each entry that is wrong."""
    names = trial.problem.names
    for each in trial.diagnosis.entries:
        row, column, part = each.place.row, each.place.column, each.part
        places = ", ".join(names[n] for n in (row, column) if n is not None)
        yield f"{TITLES.get(part, part)}[{places}]", each.share, row, column, part


def list_rows(trial: Trial) -> Iterator[Fact]:
    """Facts of the table of entries."""
    yield from (fact for fact in list_facts(trial) if fact.field == "difference")
    names = trial.problem.names
    for part, errors in trial.relative_errors.items():
        title = TITLES.get(part, part)
        for place, value in np.ndenumerate(errors):
            if errors.ndim == 3 and place[1] > place[2]:
                continue
            row, *others = (names[n] for n in place)
            entry = f"{title}[{', '.join([row, *others])}]"
            if errors.ndim == 3:
                entry = f"{title}[{row}] of " + (
                    f"{others[0]}'^2" if others[0] == others[1] else f"{others[0]}' {others[1]}'"
                )
            yield Fact(value, "relative", (entry,))
            yield Fact(trial.allowed[part], "tolerance", (entry,))


def fail_assertion(trial: Trial) -> str:
    """What a test says."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(testing, "try_equations", lambda *given, **more: trial)
        with pytest.raises(AssertionError) as raised:
            testing.assert_agrees(None)
    return str(raised.value)


def annotate(trial: Trial) -> str:
    """What a workflow says."""
    return "\n".join(
        format_annotations(json.loads(output.format_trial_json(trial)), Path("mine.py"))
    )


PHRASES = {
    **COUNTED,
    "{} of {} checks? agree": "agreeing, checks",
    "and {} more": "others",
    "wrong, by up to {} of": "largest share",
    "differs?, by up to {}": "largest",
    "{} entr(?:y|ies) differs?": "entries",
    "of {} entries differ": "cells",
    "{} of {} entries differ": "cells that differ, cells",
    "yours minus right is {}": "difference",
    "measured {}, allowed {}": "measured, tolerance",
    "at most {}(?: times)? of a tolerance": "most",
    "All {} findings": "findings",
    **{f"{title} {{}}(?=[,)])": f"allowed {title}" for title in ("M", "bias", "force", "gravity")},
}
RENDER: dict[str, Callable[[Any], str]] = {
    "terminal": repr,
    "JSON": lambda trial: output.format_trial_json(trial),
    "page": lambda trial: output.render_trial_page(trial),
    "notebook": lambda trial: trial._repr_html_(),
    "assertion": fail_assertion,
    "annotations": annotate,
    "table": lambda trial: format_json({"rows": trial.rows}),
}
VIEWS = {
    f"{name} of a trial of {kind}": View(
        make=partial(make_trial, record),
        render=render,
        facts=list_rows if name == "table" else list_facts,
        phrases=PHRASES,
        wording={r"\b[12]\. (?=[A-Z])": "numbers of sections"},
        shown={"page": ("off by", "measured"), "table": ("relative",)}.get(name, ()),
        given=lambda trial: trial.problem.description,
        sorted=(*WORDS, "measured", "tolerance", "share", "verdict", "most"),
    )
    for (name, render), (kind, record) in product(RENDER.items(), RECORDS.items())
}
