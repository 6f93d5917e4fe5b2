"""A number on record may move by its tolerance and by no more."""

import pytest

from crosscheck.baseline.record import BoundedRecord
from crosscheck.baseline.reduction import _round_up
from crosscheck.baseline.regression import _compare_numbers, _subject

TOLERANCE = 1e-6


@pytest.mark.parametrize(("share", "verdict"), [(0.99, "agree"), (1.01, "differ"), (9.0, "differ")])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_number_differs_just_beyond_its_tolerance(share, verdict, sign):
    record = BoundedRecord(unit="rad", tolerance=TOLERANCE, basis="as recorded")
    finding = _compare_numbers(
        _subject("finding", "made", None, "rad"), record, record, (0.0, sign * share * TOLERANCE)
    )
    assert (finding.verdict, finding.tolerance) == (verdict, TOLERANCE)


@pytest.mark.parametrize("value", [1.0, 1.234, 1.235, 9.996, 4.4441e-17, 8.0049e12])
def test_what_is_on_record_is_no_less_than_what_was_measured(value):
    """Three digits, upwards: by 1 % at most."""
    assert value <= _round_up(value) <= 1.0101 * value
