"""Views of trials of an arm's and of a robot's equations."""

import json
from collections.abc import Callable
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
from crosscheck.trial.result import Trial
from tests.trial.trial_views import kept_arm, kept_robot
from tests.views.agreements import derive_numbers
from tests.views.shown_numbers import View, mark
from tools.annotate_trial import format_annotations

RECORDS: dict[str, Callable[[], Any]] = {"arm": kept_arm, "robot": kept_robot}


def make_trial(record: Callable[[], Trial]) -> Trial:
    """The trial with other numbers; of an arm every product of rates is off."""
    made = record()
    errors = dict(made.relative_errors)
    if "rate_terms" in errors:
        errors["rate_terms"] = np.full(errors["rate_terms"].shape, 0.1)
    return mark(replace(made, relative_errors=errors))


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
        partial(make_trial, record), render, lambda trial: derive_numbers(trial.agreement)
    )
    for (name, render), (kind, record) in product(RENDER.items(), RECORDS.items())
}
