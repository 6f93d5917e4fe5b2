"""From starts to a verdict: shares, thresholds, laws, what a verdict depends on and turns at."""

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.audit.claims.catalogue import ModelJudgement
from crosscheck.audit.claims.chapter import build_answer_record, describe_verdict
from crosscheck.audit.experiments.experiments import NO_ERROR, PD
from crosscheck.audit.experiments.paper_conditions import (
    AS_GEARS,
    AS_MODELLED,
    DAMPING,
    INTEGRAL,
    LABELLED,
    LAW,
    LAWS,
    MODELS,
    PLANETS,
    READING,
    SWAPPED,
    Condition,
)
from crosscheck.audit.experiments.samples import judge_third_fluctuation
from crosscheck.audit.judging import rule
from crosscheck.audit.judging.quantities import (
    ConditionResults,
    Quantity,
    Sample,
    combine_quantities,
    rank_correlation,
)
from crosscheck.audit.judging.rule import Share, State, state, state_thresholds
from crosscheck.audit.measures.thresholds import SEVERE

ZETAS = (0.003, 0.005, 0.01, 0.05)
YES, NO, EITHER, NONE = rule.State.YES, rule.State.NO, rule.State.BISTABLE, rule.State.UNDEFINED
EVERY = [Condition(law, z, arm) for law, arm, z in product(LAWS, (LABELLED, SWAPPED), ZETAS)]
LUMPED_TOO = [*EVERY, *(replace(each, planets="lumped") for each in EVERY)]


def third(*sizes: float) -> rule.Answer:
    """The third fluctuation of starts of these sizes [rad/s^2]."""
    sample = Sample({"third": np.array(sizes)}, np.zeros(len(sizes), bool))
    return judge_third_fluctuation(sample)


def _place(condition: Condition) -> rule.Place:
    return rule.Place(tuple(condition.conditions.items()))


@pytest.mark.parametrize(
    ("said", "kind", "counts"),
    [
        ((YES, YES, YES), rule.VerdictKind.HOLDS, rule.Counts(yes=24)),
        ((NO, NO, NO), rule.VerdictKind.FAILS, rule.Counts(no=24)),
        ((YES, NO, NO), rule.VerdictKind.DEPENDS, rule.Counts(yes=8, no=16)),
        ((YES, YES, NONE), rule.VerdictKind.WHERE_DEFINED, rule.Counts(yes=16, undefined=8)),
        ((NO, NO, NONE), rule.VerdictKind.FAILS, rule.Counts(no=16, undefined=8)),
        ((NONE, NONE, NONE), rule.VerdictKind.UNDEFINED, rule.Counts(undefined=24)),
        ((YES, YES, EITHER), rule.VerdictKind.BISTABLE, rule.Counts(yes=16, bistable=8)),
        ((NO, EITHER, NO), rule.VerdictKind.BISTABLE, rule.Counts(no=16, bistable=8)),
        ((YES, EITHER, NO), rule.VerdictKind.DEPENDS, rule.Counts(yes=8, no=8, bistable=8)),
        ((EITHER, EITHER, EITHER), rule.VerdictKind.BISTABLE, rule.Counts(bistable=24)),
    ],
)
def test_settings_are_counted_and_decide_the_verdict(said, kind, counts):
    by_law = dict(zip(LAWS, said, strict=True))
    found = rule.verdict_of([(_place(each), by_law[each.law]) for each in EVERY])
    assert (found.kind, found.counts) == (kind, counts)


def test_no_setting_at_all_is_not_simulated():
    assert rule.verdict_of([]).kind == rule.VerdictKind.NOT_SIMULATED


@pytest.mark.parametrize(
    ("every", "denies", "expected"),
    [
        (EVERY, lambda c: c.zeta == 0.003, (DAMPING,)),
        (EVERY, lambda c: c.arm == SWAPPED, (READING,)),
        (EVERY, lambda c: c.law == INTEGRAL and c.zeta == 0.003, (LAW, DAMPING)),
        (EVERY, lambda c: c.arm == SWAPPED and c.zeta == 0.003, (READING, DAMPING)),
        (EVERY, lambda c: c.law == INTEGRAL or c.zeta == 0.003, (LAW, DAMPING)),
        # As 5-03 does: nearly all under the integral, few under the clock.
        (EVERY, lambda c: (c.law == INTEGRAL) == (c.arm == LABELLED and c.zeta == 0.003), (LAW,)),
        (LUMPED_TOO, lambda c: c.planets == "free", (PLANETS,)),
    ],
)
def test_dependence_names_what_decides(every, denies, expected):
    found = rule.verdict_of([(_place(each), NO if denies(each) else YES) for each in every])
    assert (found.kind, found.depends_on) == (rule.VerdictKind.DEPENDS, expected)


states = st.lists(st.sampled_from(list(rule.State)), min_size=6, max_size=6)


@settings(max_examples=300)
@given(said=states, at=st.integers(0, 5))
def test_between_clear_and_bistable_a_verdict_moves_only_to_or_from_bistable(said, at):
    """What other seeds can do to one setting moves no verdict between two clear ones."""
    if said[at] not in (YES, NO):
        return
    before = rule.kind_of(said)
    after = rule.kind_of([*said[:at], EITHER, *said[at + 1 :]])
    assert after == before or rule.VerdictKind.BISTABLE in (after, before)


@pytest.mark.parametrize(
    ("yes", "of", "said"),
    [
        (32, 32, YES),
        (25, 32, YES),  # of nine in ten, 25 or fewer come up in more than 2.5 % of the cases
        (24, 32, EITHER),
        (8, 32, EITHER),
        (7, 32, NO),
        (0, 32, NO),
        (1, 1, YES),
        (1, 2, EITHER),  # shows nothing
    ],
)
def test_a_share_has_three_answers(yes, of, said):
    assert rule.state(Share(yes, of)) == said


def _answer(values, low=10.0, condition=EVERY[0]):
    defined = tuple(sorted(v for v in values if math.isfinite(v)))
    return rule.Answer(_place(condition), defined, len(values), rule.Limits(low=low))


def test_undefined_starts_have_no_say():
    answer = _answer([20.0] * 18 + [1.0] * 2 + [math.nan] * 12)
    assert (answer.undefined, answer.share) == (12, Share(18, 20))
    assert answer.state == YES


def test_quantiles_are_values_of_starts_and_limits_themselves_are_outside():
    answer = _answer([*range(10, 0, -1)], low=4.0)
    assert (answer.quantiles, answer.median, answer.yes) == ((1.0, 5.0, 9.0), 5.0, 6)
    assert answer.share_at(rule.Limits(3.0, 10.0)) == Share(6, 10)


def test_an_event_of_few_starts_says_nothing():
    assert _answer([20.0] * 16 + [math.nan] * 16).state == YES
    assert _answer([20.0] * 15 + [math.nan] * 17).state == NONE
    assert _answer([math.nan] * 32).quantiles is None


def _claim(low: float) -> rule.Claim:
    quantity = Quantity("made", "1", lambda known: np.empty(0))
    return rule.Claim("0-01", None, "made up", quantity, rule.Limits(low=low))


def _judged(values_by_zeta, low=10.0):
    """The same numbers under all laws."""
    found = [
        _answer(values, low, Condition(law, zeta))
        for law, (zeta, values) in product(LAWS, values_by_zeta.items())
    ]
    return ModelJudgement(_claim(low), tuple(found))


@pytest.mark.parametrize(
    ("low", "values", "near"),
    [
        (10.0, [12.4] * 32, True),
        (10.0, [12.6] * 32, False),
        (10.0, [12.4] * 7 + [1000.0] * 25, False),  # enough are left for a yes
        (10.0, [12.4] * 8 + [1000.0] * 24, True),
        (-10.0, [-12.4] * 32, True),
        (-10.0, [-12.6] * 32, False),
        (-10.0, [-7.4] * 32, False),
    ],
)
def test_a_verdict_is_near_its_limit_where_a_quarter_of_that_turns_it(low, values, near):
    assert _judged({0.005: values}, low).is_limit_sensitive == near


def test_both_models_have_a_verdict_of_their_own():
    """Of equal rank: what one says does not enter the other."""
    answers = [
        _answer(
            [20.0 if model == AS_MODELLED else 1.0] * 8,
            condition=Condition(model.law, 0.005, LABELLED, model.planets, model.equations),
        )
        for model in MODELS
    ]
    judged = ModelJudgement(_claim(10.0), tuple(answers))
    kinds = [judged.by_model[model].kind for model in (AS_MODELLED, AS_GEARS)]
    assert kinds == [rule.VerdictKind.HOLDS, rule.VerdictKind.FAILS]
    assert describe_verdict(judged.verdict) == "depends on planets and equations (1 yes, 3 no)"


def test_an_answer_says_how_many_of_its_starts_were_run():
    """Of 32 starts the first eight of one experiment stand for all; of the other all were run."""
    alike, unlike = (
        Sample({"made": np.full(32, 5.0)}, np.zeros(32, bool), not_run) for not_run in (24, 0)
    )
    known = ConditionResults({PD: alike, NO_ERROR: unlike})
    one, other = (
        Quantity(str(source), "1", lambda known, source=source: known[source]["made"])
        for source in (PD, NO_ERROR)
    )
    for quantity, ran in ((one, 8), (other, 32), (combine_quantities("over", one, other), 32)):
        claim = rule.Claim("3.2-29", 14, "made up", quantity, rule.Limits(low=0.0))
        setting = EVERY[1], known
        (answer,) = rule.evaluate_claim(claim, [setting])
        assert (build_answer_record(answer)["starts"], answer.share) == (ran, Share(ran, ran))


def test_a_trend_is_spearmans_rank_correlation():
    """Also where numbers are equal."""
    from scipy.stats import spearmanr  # slow to import, in every process that collects tests

    sizes, values = np.array([1.0, 2.0, 4.0, 4.0, 9.0]), np.array([3.0, 1.0, 7.0, 7.0, 7.0])
    (found,) = rank_correlation(sizes, values[:, None])
    assert found == pytest.approx(spearmanr(sizes, values).statistic, rel=1e-14)


def test_a_share_has_clopper_and_pearsons_interval():
    from scipy.stats import beta  # slow to import, in every process that collects tests

    low, high = Share(3, 10).interval
    assert low == pytest.approx(beta.ppf(0.025, 3, 8))
    assert high == pytest.approx(beta.ppf(0.975, 4, 7))
    assert (Share(0, 8).interval[0], Share(8, 8).interval[1]) == (0.0, 1.0)
    assert Share(32, 32).interval[0] == pytest.approx(0.025 ** (1 / 32), rel=1e-9)  # closed form


def test_a_third_fluctuation_is_severe_on_one_side_of_its_limit():
    assert third(*[1.01 * SEVERE] * 10).state == YES
    assert third(*[0.99 * SEVERE] * 10).state == NO


def test_starts_of_several_samples_count_where_they_were_run_and_are_defined():
    one = Sample({"third": np.array([1.0, math.nan])}, np.array([False, True]))
    joined = judge_third_fluctuation(one, one)
    assert (joined.starts, joined.values, joined.yes, joined.median) == (4, (1.0, 1.0), 0, 1.0)
    alike = Sample({"third": np.full(32, 2 * SEVERE)}, np.zeros(32, bool), not_run=24)
    assert judge_third_fluctuation(alike).share == Share(8, 8)


@pytest.mark.parametrize("starts", [2, 10, 40])
def test_thresholds_are_where_the_state_changes(starts):
    most_no, least_yes = state_thresholds(starts)
    states = [state(Share(yes, starts)) for yes in range(starts + 1)]
    between = states[most_no + 1 : least_yes]
    assert {*states[: most_no + 1]} == {State.NO}
    assert {*states[least_yes:]} == {State.YES}
    assert {*between} <= {State.BISTABLE}
