"""Every number of every view is that of its record, and of no other."""

import pytest

from tests.views.views import VIEWS
from tests.views.walker import list_tokens, walk

MANY = 40  # numbers of a view, of which most are then measured ones


@pytest.mark.parametrize("name", VIEWS)
def test_every_number_of_a_view_is_that_of_its_record(name):
    assert list(walk(VIEWS[name], 1)) == []
    assert list(walk(VIEWS[name], 2)) == []


@pytest.mark.parametrize("name", VIEWS)
def test_numbers_of_another_record_do_not_fit_by_chance(name):
    view = VIEWS[name]
    record = view.make(1)
    fields = {fact.field for fact in view.facts(record)}
    tokens = list(list_tokens(view, record, view.render(record), fields))
    assert len(tokens) <= MANY or len(list(walk(view, 1, other=2))) > 0.45 * len(tokens)
