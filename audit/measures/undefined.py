"""What a run does not tell: numbers that are not there, and decisions that stay open without them.

A number is undefined if it is None or not finite: the event did not happen within the run, or the
run diverged. Records hold None for it, texts the word.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from crosscheck.audit.experiments.variant import Numbers

UNDEFINED = "undefined"
JsonObject = dict[str, Any]


def combine_answers(answers: Iterable[bool | None]) -> bool | None:
    """False if one answer is False, else None if one is None, else True."""
    given = list(answers)
    if any(answer is False for answer in given):
        return False
    return None if None in given else True


def format_answer(answer: bool | None) -> str:
    """A decision in words."""
    return UNDEFINED if answer is None else "yes" if answer else "no"


def format_number(value: float | None, form: str = ".3g", otherwise: str = UNDEFINED) -> str:
    """A number in a format, or the word for one that is undefined."""
    return format(value, form) if value is not None and math.isfinite(value) else otherwise


def format_percent(share: float | None, form: str = ".1f") -> str:
    """A share as so many per cent, or the word for an undefined one."""
    return f"{100 * share:{form}} %" if share is not None and math.isfinite(share) else UNDEFINED


def extreme_value(values: Iterable[float | None], choose: Callable[[list[float]], float]) -> float:
    """The largest or smallest (``max``, ``min``) of the defined values; nan if none is."""
    defined_values = [value for value in values if value is not None and math.isfinite(value)]
    return choose(defined_values) if defined_values else math.nan


def quotient(numerator: float | None, denominator: float | None) -> float:
    """One number over another; nan if either is undefined or the other is 0."""
    if numerator is None or denominator is None or denominator == 0:
        return math.nan
    return numerator / denominator


def float_or_none(value: float | np.floating | None) -> float | None:
    """A plain float, or None for what is undefined."""
    return float(value) if value is not None and math.isfinite(value) else None


def floats_or_none(numbers: Mapping[str, float | None]) -> Numbers:
    """The numbers as plain floats, None for what is undefined."""
    return {name: float_or_none(value) for name, value in numbers.items()}
