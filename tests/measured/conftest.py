"""Engines are asked about a record in the test's own process, but by commands."""

import pytest

from tests.brief import perform_here


@pytest.fixture(autouse=True)
def tasks_in_this_process(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two forks for every comparison take longer than what they ask the engines."""
    if "crosscheck" not in request.fixturenames:
        perform_here(monkeypatch)
