"""A trial's questions are asked in the test's own process."""

import pytest

from crosscheck.trial.arms import questions, subject
from crosscheck.trial.changes.arms import waves
from crosscheck.trial.robots import answers
from tests.trial.mistakes.score import perform

# Read before the fixture of all tests lowers them.
USUAL_NUMBERS = {name: getattr(waves, name) for name in ("SPARE_STATES", "STATES_PER_NUMBER")}


@pytest.fixture(autouse=True)
def trial_in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers take a third of a trial's time: forks, and models that each builds anew.

    A module whose equations never come back, or end their process, has a fixture of this name that
    leaves the workers.
    """
    for module in (subject, questions, answers):
        monkeypatch.setattr(module, "run_tasks", lambda workers, tasks, progress: perform(tasks))


@pytest.fixture
def usual_states(monkeypatch: pytest.MonkeyPatch) -> None:
    """Numbers are fitted at as many states as a user's trial fits them at."""
    for name, number in USUAL_NUMBERS.items():
        monkeypatch.setattr(waves, name, number)
