"""What is not known decides nothing: no verdict falls over it, and none is made of it."""

import math

from hypothesis import given
from hypothesis import strategies as st

from crosscheck.audit.measures.undefined import UNDEFINED, combine_answers, format_number

NUMBER = st.one_of(st.none(), st.floats())
YES = st.sampled_from([True, False, None])


@given(one=YES, other=YES, third=YES)
def test_open_decisions_leave_the_whole_open(one, other, third):
    answer = combine_answers((one, other, third))
    assert answer in (True, False, None)
    assert (answer is True) == (one is other is third is True)


@given(value=NUMBER)
def test_a_number_that_is_none_is_a_word(value):
    assert (format_number(value) == UNDEFINED) == (value is None or not math.isfinite(value))
