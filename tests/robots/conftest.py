"""Equations on trial and engines are asked in the test's own process, but by commands."""

from collections.abc import Sequence

import pytest

from crosscheck.planning import robots
from crosscheck.planning.comparison import ModelTask, Results
from crosscheck.runner.progress_update import ProgressCallback
from crosscheck.runner.workers import Workers
from crosscheck.trial.robots import answers
from tests.robots.chains import perform_here


@pytest.fixture
def workers() -> None:
    """Asks for worker processes, which functions need that never come back or end their process."""


@pytest.fixture(autouse=True)
def tasks_in_this_process(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers take a fifth of a trial's time: forks of a process that has imported everything."""
    if not {"workers", "crosscheck"} & set(request.fixturenames):
        monkeypatch.setattr(answers, "run_tasks", perform_tasks)
        monkeypatch.setattr(robots, "perform_all", perform_here)


def perform_tasks(
    workers: Workers, tasks: Sequence[ModelTask], progress: ProgressCallback
) -> Results:
    """What ``crosscheck.run.run_tasks`` returns."""
    return Results({task.key: task.perform() for task in tasks})
