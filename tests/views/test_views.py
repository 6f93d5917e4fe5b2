"""What views say, with names for the numbers of their records."""

import pytest
from syrupy.assertion import SnapshotAssertion

from tests.views.views import VIEWS, tell_numbers


@pytest.mark.parametrize("name", VIEWS)
def test_a_view_says(name: str, snapshot: SnapshotAssertion):
    assert tell_numbers(name) == snapshot
