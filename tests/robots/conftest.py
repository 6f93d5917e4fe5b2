"""Equations on trial and engines are asked in the test's own process, but by commands."""

import pytest

from tests.brief import perform_here


@pytest.fixture
def workers() -> None:
    """Asks for worker processes, which functions need that never come back or end their process."""


@pytest.fixture(autouse=True)
def tasks_in_this_process(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers take a fifth of a trial's time: forks of a process that has imported everything."""
    if not {"workers", "crosscheck"} & set(request.fixturenames):
        perform_here(monkeypatch)
