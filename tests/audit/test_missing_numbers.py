"""Claims about numbers that are missing: no verdict falls over them, and none is made of them."""

import math

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from crosscheck.audit.claims.catalogue import CLAIMS, ModelJudgement, read_quantity
from crosscheck.audit.claims.chapter import build_claim_record, render_claims
from crosscheck.audit.claims.measured import MEASURED
from crosscheck.audit.claims.study_plan import FULL
from crosscheck.audit.experiments.experiments import (
    BACKLASH,
)
from crosscheck.audit.experiments.paper_conditions import LAWS, Condition
from crosscheck.audit.experiments.samples import Scale
from crosscheck.audit.judging.quantities import ConditionResults, Sample
from crosscheck.audit.judging.rule import State, VerdictKind, evaluate_claim, verdict
from crosscheck.report.records import format_json
from tests.audit.test_claims import sources
from tests.loops import require_items

pytestmark = pytest.mark.slow

ODD = (math.nan, math.nan, math.inf, -math.inf, 0.0, -0.0)
STARTS = 6


def _drawn(generator: np.random.Generator) -> Sample:
    """Numbers of an experiment: one in four diverged everywhere, a number in four is odd."""
    if generator.integers(4) == 0:
        return Sample({}, np.ones(STARTS, dtype=bool))
    return Sample({name: _numbers(generator) for name in MEASURED}, np.zeros(STARTS, dtype=bool))


def _numbers(generator: np.random.Generator) -> np.ndarray:
    sizes = generator.choice([-1, 1], STARTS) * 10 ** generator.uniform(-6, 6, STARTS)
    return np.where(generator.random(STARTS) < 0.25, generator.choice(ODD, STARTS), sizes)


def _known(generator: np.random.Generator) -> ConditionResults:
    """An experiment in four is missing."""
    return ConditionResults(
        {source: _drawn(generator) for source in sources() if generator.integers(4)}
    )


@settings(max_examples=2, print_blob=True, phases=(Phase.reuse, Phase.generate))
@given(seed=st.integers(0, 2**63))
def test_every_claim_gets_a_verdict_whatever_is_missing(seed):
    generator = np.random.default_rng(seed)
    cells = [Condition(law, zeta) for law in LAWS[:1] for zeta in (0.006, 0.05)]
    asked = [(cell, _known(generator)) for cell in cells]
    found = [ModelJudgement(claim, tuple(evaluate_claim(claim, asked))) for claim in CLAIMS]
    for judged in found:
        for answer in judged.answers:
            assert all(map(math.isfinite, answer.values))
            assert answer.undefined + len(answer.values) == answer.starts
            assert (answer.state == State.UNDEFINED) == (answer.share is None)
    format_json({"claims": [build_claim_record(judged) for judged in found]})
    html = render_claims(found, FULL, Scale())
    assert html.count('<tr id="claim-') == len(CLAIMS)


@pytest.mark.parametrize("fate", ["diverged", "nothing"])
def test_a_setting_without_any_number_supports_nothing(fate):
    """Every run diverged, or none has anything to tell: nothing but the arm's data is left."""
    nothing = {} if fate == "diverged" else {name: np.full(STARTS, math.nan) for name in MEASURED}
    sample = Sample(nothing, np.full(STARTS, fate == "diverged"))
    known = ConditionResults(dict.fromkeys(sources(), sample))
    for claim in require_items(CLAIMS):
        found = evaluate_claim(claim, [(Condition(law, 0.05), known) for law in LAWS])
        assert found
        if not claim.static and "diverge" not in next(iter(claim.choices.values())).id:
            assert {answer.state for answer in found} == {State.UNDEFINED}
            assert verdict(found).kind == VerdictKind.UNDEFINED


@pytest.mark.parametrize("fold", ["rank", "greatest"])
def test_a_diverged_member_leaves_that_starts_sweep_undefined(fold):
    """Of two starts, the second at the widest backlash."""
    known = ConditionResults()
    for b in (5, 50, 500, 3000):
        fate = np.array([False, b == 3000])
        known[BACKLASH(b)] = Sample({"third": np.where(fate, math.nan, 1.0 / b)}, fate)
    assert list(np.isfinite(read_quantity([fold, "backlash: third"])(known))) == [True, False]
