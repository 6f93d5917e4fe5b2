"""The checks that lie in their folder, each with its questions, its plan and its judgement."""

from __future__ import annotations

import pkgutil
from functools import lru_cache
from importlib import import_module

from crosscheck import checks
from crosscheck.checks.sampled import Subjects
from crosscheck.planning.comparison import Comparison


def plan_checks(subjects: Subjects) -> tuple[list[Comparison], list[str]]:
    """Every comparison of the subjects, and remarks on what could not be asked."""
    planned: list[Comparison | str] = []
    for name in list_modules():
        plan = getattr(import_module(f"{checks.__name__}.{name}"), "plan", None)
        planned += plan(subjects) if plan else ()
    comparisons = [each for each in planned if isinstance(each, Comparison)]
    return comparisons, [each for each in planned if isinstance(each, str)]


@lru_cache
def list_modules() -> list[str]:
    """Names of the modules in the folder of checks."""
    return [module.name for module in pkgutil.iter_modules(checks.__path__)]
