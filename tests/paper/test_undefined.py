"""What is not known decides nothing: no verdict falls over it, and none is made of it."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from crosscheck.paper.claims import chapter as claims
from crosscheck.paper.claims.cells import FULL, experiments
from crosscheck.paper.claims.judged import judged
from crosscheck.paper.claims.quantities import (
    BACKLASH,
    ERROR,
    PD,
    STATIC,
    Known,
    NotSimulatedError,
    Quantity,
    Source,
)
from crosscheck.paper.claims.rule import (
    LAWS,
    Answer,
    Cell,
    Claim,
    answers,
    difference,
    rank,
    ratio,
    spread,
    verdict,
)
from crosscheck.paper.claims.section4 import default_over_least, edges_over_least
from crosscheck.paper.claims.statics import Statics
from crosscheck.paper.claims.table import table_html
from crosscheck.paper.figures import verdicts as figures
from crosscheck.paper.hypotheses import (
    accumulation,
    controller,
    damping_fit,
    floating_base,
    ladder_records,
)
from crosscheck.paper.hypotheses.controller_records import Flutter, growth_agrees
from crosscheck.paper.hypotheses.ladder_rungs import GROUPS
from crosscheck.paper.phase import verdict as phase
from crosscheck.paper.planets import verdict as planets
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import UNDEFINED, all_of, any_of, recorded, shown
from crosscheck.studies.study import Numbers
from tests.paper.measuring import numbers_of

ODD = (None, math.nan, math.inf, -math.inf, 0.0, -0.0)
BRIEF = Scale(longest_s=0.002)
UNHURRIED = settings(deadline=None)


@cache
def measured() -> dict[Source, Numbers]:
    """Every experiment of the full chapter with the numbers that its measure gives."""
    cells = [Cell("angle", "paper-labelled", zeta) for zeta in (0.006, 0.05)]
    wanted = {e.source: e for cell in cells for e in experiments(FULL, cell)}
    brief = {e.measure: BRIEF.cut(e.variant) for e in wanted.values()}
    numbers = {measure: numbers_of(variant, measure) for measure, variant in brief.items()}
    found = {source: numbers[experiment.measure] for source, experiment in wanted.items()}
    default = dict.fromkeys((BACKLASH(50), ERROR(5)), found[PD])
    return {**found, **default, STATIC: Statics("paper-labelled").answer()}


def _drawn(generator: np.random.Generator) -> Known:
    """Numbers of a cell: an experiment in four is missing, one diverged, a number in four odd."""
    known = Known()
    for name, numbers in measured().items():
        fate = generator.integers(4)
        if fate == 1:
            known.add(name, {"diverged_s": float(generator.uniform(0, 3))})
        elif fate > 1:
            known.add(name, {quantity: _number(generator) for quantity in numbers})
    return known


def _number(generator: np.random.Generator) -> float | None:
    if generator.integers(4) == 0:
        return ODD[generator.integers(len(ODD))]
    return float(generator.choice([-1, 1]) * 10 ** generator.uniform(-6, 6))


@settings(max_examples=25, deadline=None, print_blob=True, phases=(Phase.reuse, Phase.generate))
@given(seed=st.integers(0, 2**63))
def test_every_claim_gets_a_verdict_whatever_is_missing(seed: int) -> None:
    generator = np.random.default_rng(seed)
    where = product(LAWS, ("paper-labelled", "paper-swapped"), (0.006, 0.05))
    cells = [Cell(*place, _drawn(generator)) for place in where]
    found = []
    for name, claim in zip(claims._names(), claims.CLAIMS, strict=True):
        given_answers = answers(claim, cells)
        for answer in given_answers:
            assert (answer.yes is None) == (not math.isfinite(answer.value))
        found.append(judged(name, claim, given_answers))
        counted = sum(group.undefined for group in found[-1].groups)
        assert found[-1].verdict.undefined == counted
    json.dumps([one.to_dict() for one in found], allow_nan=False)
    html = table_html(found, (0.006, 0.05), claims._left(cells))
    assert html.count("<tr id=") == len(claims.CLAIMS)


@pytest.mark.parametrize("fate", ["diverged_s", "other"])
def test_a_cell_without_any_number_supports_nothing(fate: str) -> None:
    """Every run diverged, or none has anything to tell: nothing but the arm's data is left."""
    known = Known()
    for name, numbers in measured().items():
        if name == STATIC:
            known.add(name, numbers)
        else:
            known.add(name, {fate: 0.1} if fate == "diverged_s" else dict.fromkeys(numbers))
    for claim in claims.CLAIMS:
        found = answers(claim, [Cell("angle", "x", 0.05, known)])
        assert found
        if STATIC not in _sources_of(claim) and "diverge" not in claim.statement:
            assert {answer.yes for answer in found} == {None}
            assert verdict(found).verdict == UNDEFINED


def _sources_of(claim: Claim) -> set[Source]:
    """What its formulas read."""
    asked: set[Source] = set()

    class Spy(Known):
        def __getitem__(self, quantity: Quantity) -> float:
            asked.add(quantity.source)
            return 1.0

    spy = Spy()
    for formula in claim.formulas.values():
        with suppress(NotSimulatedError):
            formula(spy)
    return asked


def _sweep() -> Known:
    known = Known()
    for b in (5, 50, 500):
        numbers = {"third": 1.0 / b, "second_force_N": float(b), "third_force_N": 2.0}
        known.add(BACKLASH(b), numbers)
    known.add(BACKLASH(3000), {"diverged_s": 0.7})
    return known


@pytest.mark.parametrize(
    "formula", [rank(BACKLASH, "third"), spread(BACKLASH, "third"), edges_over_least]
)
def test_a_diverged_member_leaves_a_sweep_undefined(formula: Callable[[Known], float]) -> None:
    whole = Known({q: value for q, value in _sweep().items() if q.source != BACKLASH(3000)})
    assert math.isfinite(formula(whole))
    assert math.isnan(formula(_sweep()))


@pytest.mark.parametrize("diverged", [BACKLASH(50), BACKLASH(5)])
def test_the_suitable_backlash_is_undefined_with_any_of_them(diverged: Source) -> None:
    known = Known({q: v for q, v in _sweep().items() if q.source != diverged})
    known.add(diverged, {"diverged_s": 0.3})
    assert math.isnan(default_over_least(known))


def test_ratios_and_differences_with_nothing_are_undefined() -> None:
    a, b = Source("a"), Source("b")
    known = Known({a("x"): 1.0, a("zero"): 0.0, a("none"): math.nan, b("diverged_s"): 0.1})
    with np.errstate(divide="ignore", invalid="ignore"):
        for formula in (ratio, difference):
            assert math.isfinite(formula(a("x"), a("x"))(known))
            for other in (a("none"), b("x")):
                assert math.isnan(formula(a("x"), other)(known))
        assert not math.isfinite(ratio(a("x"), a("zero"))(known))


def _answer(phase_law: str, yes: bool | None) -> Answer:
    return Answer(phase_law, "a", 0.05, "", 0.0, yes)


@pytest.mark.parametrize(
    ("angle", "omega_t", "expected"),
    [
        ([True, None], [False], ("holds", 1)),
        ([False, None], [True, None], ("only with omega_t", 2)),
        ([False, None], [None], ("does not hold", 2)),
        ([None], [True], (UNDEFINED, 1)),
        ([None], [None], (UNDEFINED, 2)),
        ([None, None], [False], (UNDEFINED, 2)),
    ],
)
def test_undefined_cells_are_counted_and_have_no_say(
    angle: list[bool | None], omega_t: list[bool | None], expected: tuple[str, int]
) -> None:
    given_answers = [_answer("angle", yes) for yes in angle]
    given_answers += [_answer("omega_t", yes) for yes in omega_t]
    found = verdict(given_answers)
    assert (found.verdict, found.undefined) == expected


NUMBER = st.one_of(st.none(), st.floats())
NUMBERS = st.lists(NUMBER, min_size=4, max_size=4)
SIZES = [1.0, 2.0, 3.0, 4.0]
YES = st.sampled_from([True, False, None])
SCALARS: list[tuple[Callable[..., Any], int]] = [
    (figures.near, 3),
    (figures.accurate, 2),
    (figures.same, 2),
    (figures.explains, 2),
    (figures.fluctuates, 1),
    (figures.restrained, 1),
    (figures.in_range, 3),
    (figures.stands_out, 1),
    (figures.larger, 2),
    (figures.visible, 2),
    (figures.proportional, 1),
    (figures.continuous, 1),
    (figures.accumulates, 2),
    (phase.dies, 2),
    (phase.is_present, 1),
    (phase.is_quiet, 1),
    (planets.is_large, 1),
    (planets.told_apart, 1),
    (planets.one_distribution, 2),
    (accumulation.is_linear, 1),
    (accumulation.is_ordered, 1),
    (growth_agrees, 2),
]


@pytest.mark.parametrize(
    ("decide", "count"), SCALARS, ids=lambda value: getattr(value, "__qualname__", None)
)
@UNHURRIED
@given(data=st.data())
def test_a_decision_about_numbers_is_open_where_one_is_undefined(
    decide: Callable[..., Any], count: int, data: st.DataObject
) -> None:
    numbers = [data.draw(NUMBER) for _ in range(count)]
    known = [number is not None and math.isfinite(number) for number in numbers]
    found = decide(*numbers)
    assert found in (True, False, None)
    assert (found is None) == (not all(known))


SWEEPS = (
    figures.rises,
    figures.falls,
    figures.fluctuation_rises,
    figures.fluctuation_falls,
)


@pytest.mark.parametrize("decide", SWEEPS)
@UNHURRIED
@given(values=NUMBERS)
def test_a_trend_is_open_where_a_member_is_undefined(
    decide: Callable[..., Any], values: list[float | None]
) -> None:
    known = all(value is not None and math.isfinite(value) for value in values)
    assert (decide(SIZES, values) is None) == (not known)
    assert figures.grows(values) in (True, False, None)


@UNHURRIED
@given(one=YES, other=YES, third=YES)
def test_open_decisions_in_words(one: bool | None, other: bool | None, third: bool | None) -> None:
    word = figures.by_law({"omega_t": one, "angle": other})
    assert (word == UNDEFINED) == (None in (one, other))
    answer = phase.h1_verdict(phase.Presence.PRINTED, {"a": one, "b": other, "c": third})
    assert (answer == "holds") == (one is other is third is True)
    assert all_of((one, other, third)) in (True, False, None)
    assert any_of((one, other)) == (one if one == other else one or other or None)
    assert controller._in_words([one, other, third]) in (
        "holds",
        "holds in part",
        "does not hold",
        UNDEFINED,
    )


@UNHURRIED
@given(with_error=NUMBERS, without=NUMBERS)
def test_where_the_error_shows_is_told_from_what_is_known(
    with_error: list[float | None], without: list[float | None]
) -> None:
    def sizes(values: list[float | None]) -> list[float]:
        return [math.nan if value is None else abs(value) for value in values]

    parts = list(map(phase.error_part, sizes(with_error), sizes(without)))
    found = phase.where_present({"omega_t": parts, "angle": parts})
    assert (found == UNDEFINED) == all(map(math.isnan, parts))
    assert found in ("with both", "with neither", UNDEFINED)


@UNHURRIED
@given(data=st.data())
def test_nothing_else_falls_over_what_is_missing(data: st.DataObject) -> None:
    number = data.draw(NUMBER)
    values = [math.nan if value is None else value for value in data.draw(NUMBERS)]
    assert accumulation.is_own_sensitivity(*values[:3]) in (True, False, None)
    assert math.isfinite(damping_fit.STATEMENTS[0].misfit(number))
    assert Flutter("always", 0.01, 0.0, number).flutters in (True, False, None)
    assert Flutter("always", 0.01, 0.0, diverged_s=0.1).flutters is True
    shares = dict(zip(GROUPS, values, strict=True))
    assert (ladder_records.dominant(shares) == UNDEFINED) == (not np.isfinite(values).all())
    errors = np.abs(values) + 1e-9
    needed = floating_base.needed_ratio(np.array(SIZES), errors, 0.03)
    assert needed is None or np.isfinite(errors).any()
    yes = [data.draw(YES)]
    assert phase.second_engine_supports(yes, yes, [number]) in (True, False, None)
    assert planets.effect(values, values, *values[:2], 3) in planets.Effect
    assert planets.survival(number, values[0]) in planets.Survival


@UNHURRIED
@given(force=NUMBER, time=NUMBER)
def test_a_force_that_never_settles_does_not_converge(
    force: float | None, time: float | None
) -> None:
    found = figures.converges(force, time, 0.5)
    assert (found is None) == (force is None or not math.isfinite(force))


@UNHURRIED
@given(value=NUMBER | NUMBERS | st.dictionaries(st.sampled_from("ab"), NUMBERS))
def test_records_are_json_and_texts_words(value: Any) -> None:
    json.dumps(recorded(value), allow_nan=False)
    if value is None or isinstance(value, float):
        assert (shown(value) == UNDEFINED) == (value is None or not math.isfinite(value))


def test_a_record_takes_numpys_numbers_and_nothing_foreign() -> None:
    numbers = {"a": np.float64(1.5), "b": np.bool_(True), "c": (np.int64(2), np.float32("nan"))}
    assert recorded(numbers) == {"a": 1.5, "b": True, "c": [2, None]}
    with pytest.raises(TypeError, match="not JSON"):
        recorded({"a": object()})
