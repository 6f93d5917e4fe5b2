"""What is not known decides nothing: no verdict falls over it, and none is made of it."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.audit.measures.undefined import UNDEFINED, combine_answers, format_number, to_json

NUMBER = st.one_of(st.none(), st.floats())
NUMBERS = st.lists(NUMBER, min_size=4, max_size=4)
YES = st.sampled_from([True, False, None])


@given(one=YES, other=YES, third=YES)
def test_open_decisions_leave_the_whole_open(one, other, third):
    answer = combine_answers((one, other, third))
    assert answer in (True, False, None)
    assert (answer is True) == (one is other is third is True)


@given(value=NUMBER | NUMBERS | st.dictionaries(st.sampled_from("ab"), NUMBERS))
def test_records_are_json(value):
    assert json.loads(json.dumps(to_json(value), allow_nan=False)) == to_json(value)


@given(value=NUMBER)
def test_a_number_that_is_none_is_a_word(value):
    assert (format_number(value) == UNDEFINED) == (value is None or not math.isfinite(value))


def test_a_record_takes_numpys_numbers_and_nothing_foreign():
    numbers = {"a": np.float64(1.5), "b": np.bool_(True), "c": (np.int64(2), np.float32("nan"))}
    assert to_json(numbers) == {"a": 1.5, "b": True, "c": [2, None]}
    with pytest.raises(TypeError, match="not JSON"):
        to_json({"a": object()})
