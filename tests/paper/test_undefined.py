"""What is not known decides nothing: no verdict falls over it, and none is made of it."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.paper.figures import verdicts as figures
from crosscheck.paper.hypotheses import controller, flights, shaking
from crosscheck.paper.hypotheses.attribution import LadderVerdict
from crosscheck.paper.hypotheses.linear_limits import growth_agrees
from crosscheck.paper.hypotheses.rungs import GROUPS, INERTIA
from crosscheck.paper.phase import verdict as phase
from crosscheck.paper.planets import verdict as planets
from crosscheck.paper.undefined import UNDEFINED, all_of, any_of, recorded, shown

UNHURRIED = settings(deadline=None)


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
    (shaking.is_linear, 1),
    (shaking.is_ordered, 1),
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
    assert shaking.is_own(*values[:3]) in (True, False, None)
    spans = {group: (value, value) for group, value in zip(GROUPS, values, strict=True)}
    verdict = LadderVerdict((), spans, spans, ())
    assert (verdict.holds is None) == (not np.isfinite(spans[INERTIA]).all())
    assert verdict.papers in (True, False, None)
    errors = np.abs(values) + 1e-9
    needed = flights.needed_ratio(np.array(SIZES), errors, 0.03)
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
