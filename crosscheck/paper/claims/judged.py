"""A claim with its values by group of cells and its verdict."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from crosscheck.paper.claims.rule import DEFAULT_ZETA, Answer, Claim, Verdict, verdict


class Place(NamedTuple):
    """The cells of one phase law and one reading of Table I."""

    phase: str
    reading: str

    def __str__(self) -> str:
        return f"{self.phase}, {self.reading}"


@dataclass(frozen=True)
class Group:
    """A claim's values in the cells of a place, over damping and free parameter.

    default: at DEFAULT_ZETA and the first choice; None for what is not known. yes, undefined: in
    how many of the cells.
    """

    place: Place
    default: float | None
    least: float | None
    greatest: float | None
    zetas: tuple[float, ...]
    yes: int
    undefined: int
    cells: int

    def to_dict(self) -> dict[str, object]:
        """For JSON, without the place."""
        return {
            "default": self.default,
            "min": self.least,
            "max": self.greatest,
            "zetas": list(self.zetas),
            "yes": self.yes,
            "undefined": self.undefined,
            "cells": self.cells,
        }


@dataclass(frozen=True)
class Judged:
    """A claim by its number in the paper's order, what was found, and its verdict."""

    name: str
    claim: Claim
    groups: tuple[Group, ...]
    verdict: Verdict

    @property
    def cells(self) -> int:
        """In how many cells it was asked."""
        return sum(group.cells for group in self.groups)

    def to_dict(self) -> dict[str, object]:
        """For JSON."""
        return {
            "id": self.name,
            "section": self.claim.section,
            "figure": self.claim.figure,
            "statement": self.claim.statement,
            "quantity": self.claim.quantity,
            "unit": self.claim.unit,
            "threshold": str(self.claim.decide),
            "free_parameter": self.claim.free or None,
            "values": {str(group.place): group.to_dict() for group in self.groups},
            "verdict": self.verdict.verdict,
            "depends_on": list(self.verdict.depends_on),
            "undefined": self.verdict.undefined,
        }


def judged(name: str, claim: Claim, given: Sequence[Answer]) -> Judged:
    """The claim with its answers grouped and the verdict over all of them."""
    places: dict[Place, list[Answer]] = {}
    for answer in given:
        places.setdefault(Place(answer.phase, answer.reading), []).append(answer)
    first = next(iter(claim.formulas))
    groups = tuple(_group(place, answers, first) for place, answers in places.items())
    return Judged(name, claim, groups, verdict(given, claim.free))


def _group(place: Place, given: Sequence[Answer], first_choice: str) -> Group:
    finite = [answer.value for answer in given if math.isfinite(answer.value)]
    default = [a.value for a in given if a.zeta == DEFAULT_ZETA and a.choice == first_choice]
    return Group(
        place,
        default[0] if default and math.isfinite(default[0]) else None,
        min(finite, default=None),
        max(finite, default=None),
        tuple(sorted({answer.zeta for answer in given})),
        sum(answer.yes is True for answer in given),
        sum(answer.yes is None for answer in given),
        len(given),
    )
