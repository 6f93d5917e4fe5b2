"""The texts of the paper's claims: what each says, and what decides it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from pydantic import ConfigDict, JsonValue, TypeAdapter
from pydantic.dataclasses import dataclass as validated_dataclass

from crosscheck.audit.judging.rule import PLOT, READ_OFF, Limits
from crosscheck.audit.measures import thresholds
from crosscheck.models.files import read_toml

SENTENCES, STATEMENTS = (
    Path(__file__).with_name(f"{name}.toml") for name in ("sentences", "statements")
)
Threshold = float | str  # a number, or the name of one of thresholds.py


@validated_dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class LimitsText:
    """Limits as statements.toml has them."""

    above: Threshold = -math.inf
    below: Threshold = math.inf
    around: float | None = None
    within: float = READ_OFF
    because: str = PLOT

    def build_limits(self) -> Limits:
        """The limits in numbers."""
        if self.around is not None:
            low, high = (self.around * (1 + side * self.within) for side in (-1, 1))
            return Limits(low, high, self.because)
        return Limits(find_threshold(self.above), find_threshold(self.below), self.because)


@validated_dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class Statement(LimitsText):
    """What the paper says in one claim, which figure shows it, and what decides it."""

    statement: str = ""
    figure: int | None = None
    quantity: JsonValue = None
    cases: str = ""
    where_third: bool = False
    limits: str = ""


class Statements(NamedTuple):
    """The statements' texts by claim id, fields as in ``Claim``.

    named: quantities of several; cases: choices of a free parameter; retired: why an id is not
    used.
    """

    named: Mapping[str, JsonValue]
    cases: Mapping[str, tuple[dict[str, str], ...]]
    said: Mapping[str, Statement]
    limits: Mapping[str, LimitsText]
    free: Mapping[str, str]
    reading: Mapping[str, str]
    retired: Mapping[str, str]


TEXTS = TypeAdapter(Statements).validate_python(read_toml(STATEMENTS))


def find_threshold(limit: Threshold) -> float:
    """A limit in numbers. Raises AttributeError for a name of none."""
    return float(getattr(thresholds, limit) if isinstance(limit, str) else limit)


def quote_claim(name: str) -> str:
    """A claim by its id, with what the paper says."""
    return f"{name}, {TEXTS.said[name].statement}"
