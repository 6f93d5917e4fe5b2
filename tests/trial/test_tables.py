"""A table of answers is judged as the functions that made it: the same checks, entries, words."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from crosscheck.report.trial import trial_json
from crosscheck.trial import trial
from crosscheck.trial.input.loading import handed_over
from crosscheck.trial.tables.answers import answered, equations_of
from crosscheck.trial.tables.asked import TableTrial
from crosscheck.trial.trial import Asked, tried
from models.loading import load_arm
from tests.trial.tables import sheets_of, write_csv

EXAMPLES = Path(__file__).parents[2] / "examples"
# sympy_map's coordinates are no linear map.
ARMS = {
    "plain_functions": "paper-labelled",
    "coriolis_matrix": "paper-labelled",
    "mass_matrix_alone": "paper-labelled",
    "absolute_angles": "paper-labelled",
    "sympy_mechanics": "paper-labelled",
    "casadi_two_link": "paper-labelled",
    "acceleration_alone": "paper-labelled",
    "inverse_dynamics_alone": "paper-labelled",
    "geared_lumped": "paper-labelled",
    "geared_free": "paper-labelled",
}
EXACT = {"model", "provenance", "command", "id", "left"}


def told(asked: Asked) -> dict:
    found = json.loads(trial_json(tried(asked)))
    del found["agreement"]["provenance"]
    return found


@pytest.fixture
def few_states(monkeypatch: pytest.MonkeyPatch) -> None:
    """As few as explanations need: more of them would show nothing else here."""
    monkeypatch.setattr(trial, "QUICK_STATES", 1)


@pytest.mark.usefixtures("few_states")
@pytest.mark.parametrize("example", ARMS)
def test_judged_as_the_functions_are(example: str, tmp_path: Path) -> None:
    arm = load_arm(ARMS[example])
    own = handed_over(f"{EXAMPLES / example}.py:model", arm, None)
    table = TableTrial(arm, own.coordinates, own.level, quick=True)
    file = write_csv(tmp_path / "answers.csv", sheets_of(table, own, own.any_arm))
    by_table = equations_of(answered(table, [file]))
    if own.symbolic is not None:  # which a table is not
        own = replace(own, symbolic=None)
    assert told(table.asked("yours", by_table)) == told(table.asked("yours", own))
