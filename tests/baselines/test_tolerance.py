"""A number on record may move by its tolerance and by no more."""

import pytest

from crosscheck.baseline.record import BoundedRecord
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
