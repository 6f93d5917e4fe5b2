"""Cross-checks with every check in them, each of a few states and steps; tasks without workers."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from crosscheck.planning import arms, plan
from crosscheck.runner.outcomes import Task
from crosscheck.runner.workers import Workers

STATES = 4


def brief(patch: pytest.MonkeyPatch, experiment_s: float = 2e-3) -> None:
    """The quick plan; experiment_s: how long the paper's experiments are in it."""
    for name in plan.QUICK_S:
        patch.setitem(plan.QUICK_S, name, experiment_s)
    patch.setattr(plan, "QUICK_STEPS", 500)
    patch.setattr(plan, "PROBE_S", 1e-3)
    patch.setattr(plan, "SHORT_STEPS", 200)
    patch.setattr(plan, "ENERGY_STEPS", 200)
    patch.setattr(arms, "QUICK_COUNT", STATES)


def perform_here(patch: pytest.MonkeyPatch) -> None:
    """Tasks are performed in the test's own process, which so keeps models: a fifth of the time.

    Not where a source is searched, for which a worker enters a sandbox.
    """
    patch.setattr(Workers, "stream", stream_here)


def stream_here(
    workers: Workers, waiting: Iterator[Task], on_begin: Callable[[Any], None] = lambda key: None
) -> Iterator[tuple[Any, Any]]:
    """What ``Workers.stream`` yields."""
    for task in waiting:
        on_begin(task.key)
        yield task.key, task.perform()
