"""A trial's questions are asked in the test's own process; an engine's answers are kept."""

from collections.abc import Callable, Hashable, Sequence
from functools import partial

import numpy as np
import pytest

from crosscheck.planning.comparison import ModelTask, Results
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.progress_update import ProgressCallback
from crosscheck.runner.tasks import build_model
from crosscheck.runner.workers import Workers
from crosscheck.trial.arms import questions, subject
from crosscheck.trial.arms.model import SuppliedModel
from crosscheck.trial.arms.questions import StateQuestion
from crosscheck.trial.changes.arms import waves

Answers = dict[Hashable, np.ndarray | Failure]
# Read before the fixture of all tests lowers them.
USUAL_NUMBERS = {name: getattr(waves, name) for name in ("SPARE_STATES", "STATES_PER_NUMBER")}


@pytest.fixture(scope="module")
def kept_answers() -> Answers:
    """Answers of the project's own models in a module's trials, which ask for the same ones."""
    return {}


@pytest.fixture(autouse=True)
def trial_in_this_process(monkeypatch: pytest.MonkeyPatch, kept_answers: Answers) -> None:
    """Workers take a third of a trial's time: forks, and models that each builds anew.

    A module whose equations never come back, or end their process, has a fixture of this name that
    leaves the workers.
    """
    for module in (subject, questions):
        monkeypatch.setattr(module, "run_tasks", partial(perform_tasks, kept_answers))


def perform_tasks(
    kept_answers: Answers, workers: Workers, tasks: Sequence[ModelTask], progress: ProgressCallback
) -> Results:
    """What ``crosscheck.run.run_tasks`` returns."""
    return Results({task.key: answer(task, kept_answers) for task in tasks})


def answer(task: ModelTask, kept_answers: Answers) -> object:
    """A task's outcome; of a model of the project, the one that was kept."""
    perform: Callable[[], object] = task.perform
    if not isinstance(task, StateQuestion) or task.model == task.asker:
        return perform()
    asker = build_model(task.asker, task.case)
    assert isinstance(asker, SuppliedModel)
    coordinates = asker.supplied.equations.coordinates
    asked = coordinates, task.model, task.case, task.quantity, task.count, task.seed
    try:
        hash(asked)
    except TypeError:  # coordinates by a matrix
        return perform()
    if asked not in kept_answers:
        kept_answers[asked] = perform()
    return kept_answers[asked]


@pytest.fixture
def usual_states(monkeypatch: pytest.MonkeyPatch) -> None:
    """Numbers are fitted at as many states as a user's trial fits them at."""
    for name, number in USUAL_NUMBERS.items():
        monkeypatch.setattr(waves, name, number)
