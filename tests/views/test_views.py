"""Every number of every view is that of its record, and of no other; its words are on record."""

import pytest
from syrupy.assertion import SnapshotAssertion

from tests.views import agreements
from tests.views.plain import list_lines, mask_numbers
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


FILES = ("JSON", "JUnit", "table")  # for programs: their schemas say what they hold
TEXTS = [name for name in VIEWS if not name.startswith(FILES)]


@pytest.mark.parametrize("name", TEXTS)
def test_a_view_says(name: str, snapshot: SnapshotAssertion, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(agreements, "COLUMNS", "80")
    view = VIEWS[name]
    text = list_lines(view.render(view.make(1)))
    is_worked_out = name.endswith(("of cost", "of compare")) or "of a trial" in name
    assert (mask_numbers(text) if is_worked_out else text) == snapshot
