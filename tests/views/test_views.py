"""Every number of every view is that of its record, and of no other; its words are on record."""

from functools import lru_cache
from typing import Any

import pytest
from syrupy.assertion import SnapshotAssertion

from tests.views import agreements
from tests.views.plain import list_lines, mask_numbers
from tests.views.views import VIEWS
from tests.views.walker import list_tokens, trace, walk

MANY = 40  # numbers of a view, of which most are then measured ones


@lru_cache
def rendered(name: str) -> tuple[Any, str]:
    """The record of the first seed, and its view."""
    record = VIEWS[name].make(1)
    return record, VIEWS[name].render(record)


@pytest.mark.parametrize("name", VIEWS)
def test_every_number_of_a_view_is_that_of_its_record(name):
    view, (record, text) = VIEWS[name], rendered(name)
    assert list(trace(view, record, text, view.facts(record))) == []
    assert list(walk(view, 2)) == []


@pytest.mark.parametrize("name", VIEWS)
def test_numbers_of_another_record_do_not_fit_by_chance(name):
    view, (record, text) = VIEWS[name], rendered(name)
    fields = {fact.field for fact in view.facts(record)}
    count = len(list(list_tokens(view, record, text, fields)))
    misses = trace(view, record, text, view.facts(view.make(2)))
    assert count <= MANY or len(list(misses)) > 0.45 * count


FILES = ("JSON", "JUnit", "table")  # for programs: their schemas say what they hold
WRAPPED = ("run", "validate", "terminal of a study", "terminal of changes")  # on a terminal
TEXTS = [name for name in VIEWS if not name.startswith(FILES)]


@pytest.mark.parametrize("name", TEXTS)
def test_a_view_says(name: str, snapshot: SnapshotAssertion, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(agreements, "COLUMNS", "80")
    view = VIEWS[name]
    text = view.render(rendered(name)[0]) if name.startswith(WRAPPED) else rendered(name)[1]
    is_worked_out = name.endswith(("of cost", "of compare")) or "of a trial" in name
    lines = list_lines(text)
    assert (mask_numbers(lines) if is_worked_out else lines) == snapshot
