"""What the page's chapters state of one quantity, each for itself: answers and numbers."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from crosscheck.audit.claims.measured import pd
from crosscheck.audit.errata.engine_comparison import EngineComparison
from crosscheck.audit.experiments.paper_conditions import MODELS, Condition
from crosscheck.audit.judging.judgement import ClaimJudgement
from crosscheck.audit.judging.rule import Limits, Place, State
from crosscheck.audit.measures.third_fluctuation import LARGE, ThirdFluctuation


@dataclass(frozen=True)
class Said:
    """where: the chapter and what in it; quantity: its id."""

    where: str
    quantity: str
    limits: Limits
    place: Place
    state: State


@dataclass(frozen=True)
class Taught:
    """A claim that a finding says is true or false, in its own words; None: it says neither."""

    where: str
    claim: str
    is_true: bool | None


def of_findings(printed: EngineComparison, drives: Mapping[str, State | None]) -> list[Taught]:
    """What the findings say of claims that have quantities of their own."""
    owns = drives["sqrt_time"] == State.YES
    return [
        Taught("finding 1", "2.4-02", printed.agrees),
        Taught("finding 5", "4.1-07", False if owns else None),
    ]


def of_third(where: str, found: Iterable[tuple[Condition, ThirdFluctuation]]) -> list[Said]:
    """What a chapter states of the third fluctuation, where the claims ask the same."""
    answers = [
        third.answer(Place(tuple(cell.conditions.items())))
        for cell, third in found
        if cell.model in MODELS
    ]
    return [Said(where, pd("third").id, LARGE, one.place, one.state) for one in answers]


def of_claims(every: Iterable[ClaimJudgement]) -> list[Said]:
    """What the claims say of their quantities."""
    return [
        Said(f"claim {one.claim.id}", choices[a.place.choice].id, a.limits, a.place, a.state)
        for one in every
        for choices in (one.claim.choices,)
        for a in one.answers
    ]
