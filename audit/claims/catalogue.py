"""Every statement of the paper that asserts a number or a direction, in the paper's order."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ConfigDict, JsonValue, TypeAdapter
from pydantic.dataclasses import dataclass as validated_dataclass

from crosscheck.audit.claims.measured import CASES, FUNCTIONS, MEASURES, NAMED
from crosscheck.audit.experiments.experiments import find_experiment
from crosscheck.audit.experiments.paper_conditions import LAW, MODELS, PLANETS, GearModel
from crosscheck.audit.judging import quantities as q
from crosscheck.audit.judging import rule
from crosscheck.audit.judging.judgement import ClaimJudgement
from crosscheck.audit.judging.quantities import Choices, Quantity
from crosscheck.audit.judging.rule import PLOT, READ_OFF, Claim, Limits, Place, Verdict, VerdictKind
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


def read_quantity(text: Any) -> Quantity:
    """The quantity that statements.toml writes so. Raises KeyError for a name of none."""
    match text:
        case str() if ": " in text:
            experiment, number = text.rsplit(": ", 1)
            if number == "diverged":
                return q.divergence(find_experiment(experiment))
            return MEASURES.quantity_of(find_experiment(experiment), number)
        case str():
            return NAMED[text] if text in NAMED else read_quantity(TEXTS.named[text])
        case ["times", factor, unit, part]:
            return q.scale_quantity(factor, unit, read_quantity(part))
        case ["where above" | "where below" as side, limit, *parts]:
            return q.restrict_quantity(side, find_threshold(limit), *map(read_quantity, parts))
        case ["rank", numbers]:
            return MEASURES.rank(*numbers.split(": "))
        case ["rank where above", limit, numbers, number]:
            kind, condition = numbers.split(": ")
            return MEASURES.rank_among(kind, number, condition, find_threshold(limit))
        case [fold, numbers] if fold in q.FOLDS:
            return MEASURES.fold_series(fold, *numbers.split(": "))
        case [function, *operands] if function in FUNCTIONS:
            return FUNCTIONS[function](*operands)
        case [operation, *parts]:
            return q.combine_quantities(operation, *map(read_quantity, parts))
    raise KeyError(text)


def find_quantity(said: Statement) -> Quantity | Choices:
    """The quantity that decides a statement, or one for each of its cases."""
    if said.cases:
        cases = {**CASES, **TEXTS.cases}[said.cases]
        return {str(next(iter(c.values()))): read_quantity(fill(said.quantity, c)) for c in cases}
    quantity = read_quantity(said.quantity)
    if not said.where_third:
        return quantity
    return q.restrict_quantity("where above", thresholds.EVIDENT, read_quantity("owed"), quantity)


def fill(text: Any, case: Mapping[str, object]) -> Any:
    """A quantity's text with what a case puts in place of the names in braces."""
    if isinstance(text, list):
        return [fill(part, case) for part in text]
    return text.format(**case) if isinstance(text, str) else text


CLAIMS = tuple(
    Claim(
        name,
        said.figure,
        said.statement,
        find_quantity(said),
        (TEXTS.limits[said.limits] if said.limits else said).build_limits(),
        free=TEXTS.free.get(name, ""),
        reading=TEXTS.reading.get(name, ""),
    )
    for name, said in TEXTS.said.items()
)
BY_ID = {claim.id: claim for claim in CLAIMS}


def model_of(place: Place) -> GearModel | None:
    """The model of the gears of the setting where an answer was found; None of a static claim."""
    values: dict[str, Any] = dict(place.conditions)
    return GearModel(values[LAW], *values[PLANETS]) if LAW in values else None


@dataclass(frozen=True)
class ModelJudgement(ClaimJudgement):
    """A claim and its answers in all settings of all models of the gears.

    variants: what those of VARIANTS say of it that were asked.
    """

    variants: Mapping[GearModel, VerdictKind] = field(default_factory=dict)

    @cached_property
    def by_model(self) -> dict[GearModel, Verdict]:
        """The verdict over the settings of each model of the gears; empty for a static claim."""
        if self.claim.static:
            return {}
        answers_by_model = {
            model: [a for a in self.answers if model_of(a.place) == model] for model in MODELS
        }
        return {
            model: rule.verdict(answers, self.claim.free)
            for model, answers in answers_by_model.items()
        }
