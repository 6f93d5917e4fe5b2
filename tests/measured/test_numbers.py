"""Numbers of a comparison are those of a second program; every view has the same numbers."""

import pytest

from tests.measured import guards


@pytest.mark.parametrize(
    "wrong",
    [
        guards.wrong_estimates,
        guards.wrong_chances,
        guards.wrong_runs,
        guards.wrong_torques_of_a_drive,
        guards.wrong_choice,
    ],
)
def test_nothing_is_wrong(wrong):
    assert list(wrong()) == []
