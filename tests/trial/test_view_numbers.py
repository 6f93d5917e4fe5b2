"""A trial has the numbers of what is wrong."""

import pytest

from tests.trial.trial_views import GUARDS


@pytest.mark.parametrize("name", ["arm", "robot"])
def test_a_trial_has_the_numbers_of_what_is_wrong(name):
    assert list(GUARDS[name]()) == []
