"""Every statement of the paper that asserts a number or a direction, in the paper's order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from crosscheck.audit.claims.measured import CASES, FUNCTIONS, MEASURES, NAMED
from crosscheck.audit.claims.statements import TEXTS, Statement, find_threshold
from crosscheck.audit.experiments.experiments import find_experiment
from crosscheck.audit.experiments.paper_conditions import LAW, MODELS, PLANETS, GearModel
from crosscheck.audit.judging import quantities as q
from crosscheck.audit.judging import rule
from crosscheck.audit.judging.judgement import ClaimJudgement
from crosscheck.audit.judging.quantities import Choices, Quantity
from crosscheck.audit.judging.rule import Claim, Place, Verdict, VerdictKind
from crosscheck.audit.measures import thresholds


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


def find_quantity(statement: Statement) -> Quantity | Choices:
    """The quantity that decides a statement, or one for each of its cases."""
    if statement.cases:
        cases = {**CASES, **TEXTS.cases}[statement.cases]
        return {
            str(next(iter(c.values()))): read_quantity(fill(statement.quantity, c)) for c in cases
        }
    quantity = read_quantity(statement.quantity)
    if not statement.where_third:
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
