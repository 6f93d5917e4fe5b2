"""Every view of a trial shows the numbers of what is wrong: the terminal, JSON, page and JUnit."""

import pytest

from tests.trial.trial_views import GUARDS


@pytest.mark.parametrize("name", ["arm", "robot"])
def test_every_view_shows_the_numbers_of_what_is_wrong(name):
    assert list(GUARDS[name]()) == []
