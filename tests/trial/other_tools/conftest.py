"""What a trial of tables asks is worked out once in a module, which takes half of its time."""

from collections.abc import Callable
from typing import Any

import pytest

from crosscheck.trial.tables.state_requests import TableTrial


@pytest.fixture(scope="module")
def asked_already() -> dict[str, Any]:
    """What was asked in a module's trials."""
    return {}


@pytest.fixture
def asked_once(
    few_states: None, asked_already: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is asked in one trial, of its states and of other arms, is kept."""

    def keep(work_out: Callable[..., Any]) -> Callable[..., Any]:
        def once(*of: object) -> Any:
            key = f"{work_out.__name__} {of}"
            if key not in asked_already:
                asked_already[key] = work_out(*of)
            return asked_already[key]

        return once

    for name in ("collect_request", "collect_probe_requests"):
        monkeypatch.setattr(TableTrial, name, keep(getattr(TableTrial, name)))
