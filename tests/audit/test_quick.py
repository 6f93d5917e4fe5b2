"""Runs as long as the page's, in one setting of each law: the answers that are on record."""

from pathlib import Path

import pytest

from crosscheck.audit.claims.catalogue import BY_ID
from crosscheck.audit.experiments.experiments import CONSTANT, NO_ERROR, PD
from crosscheck.audit.experiments.paper_conditions import (
    INTEGRAL,
    LAWS,
    PRINTED,
    REPAIRED_RATE,
    Condition,
)
from crosscheck.audit.experiments.samples import Scale, collect_samples
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.judging.quantities import ConditionResults
from crosscheck.audit.judging.rule import State, evaluate_claim

SETTINGS = [Condition(law, 0.02) for law in LAWS]
EXPERIMENTS = (PD, NO_ERROR, CONSTANT)
ALL_YES, ALL_NO = dict.fromkeys(LAWS, State.YES), dict.fromkeys(LAWS, State.NO)


@pytest.fixture(scope="module")
def results(kept: Path) -> list[tuple[Condition, ConditionResults]]:
    requests = [(setting, source) for setting in SETTINGS for source in EXPERIMENTS]
    found = collect_samples(Study(kept), Scale(most_starts=8), requests, "test")
    return [
        (each, ConditionResults({source: found[each, source] for source in EXPERIMENTS}))
        for each in SETTINGS
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("claim", "said"),
    [
        ("3.1-09", ALL_YES),  # x_sp converges to 52 um
        ("3.2-16", ALL_YES),  # the teeth change sides after 0.3 s
        ("3.2-01", ALL_NO),  # no considerable overshoot
        ("3.2-11", {PRINTED: State.NO, REPAIRED_RATE: State.YES, INTEGRAL: State.NO}),  # severe
        ("5-04", {PRINTED: State.YES, REPAIRED_RATE: State.YES, INTEGRAL: State.NO}),  # at all
    ],
)
def test_claims_have_the_answers_on_record(results, claim, said):
    found = evaluate_claim(BY_ID[claim], results)
    assert {law: answer.state for law, answer in zip(LAWS, found, strict=True)} == said
