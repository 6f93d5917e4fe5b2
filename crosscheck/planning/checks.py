"""The checks that lie in their folder, each with its questions, its plan and its judgement."""

from __future__ import annotations

import pkgutil
from collections.abc import Callable, Iterator
from importlib import import_module

from crosscheck import checks
from crosscheck.checks.sampled import Subjects
from crosscheck.planning.comparison import Comparison


def plan_checks(subjects: Subjects) -> tuple[list[Comparison], list[str]]:
    """Every comparison of the subjects, and remarks on what could not be asked."""
    planned = [each for plan in find_plans() for each in plan(subjects)]
    comparisons = [each for each in planned if isinstance(each, Comparison)]
    return comparisons, [each for each in planned if isinstance(each, str)]


def find_plans() -> Iterator[Callable[[Subjects], Iterator[Comparison | str]]]:
    """The plan of each check that lies in the folder of checks."""
    for module in pkgutil.iter_modules(checks.__path__):
        plan = getattr(import_module(f"{checks.__name__}.{module.name}"), "plan", None)
        if plan is not None:
            yield plan
