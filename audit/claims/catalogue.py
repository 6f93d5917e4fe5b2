"""Every statement of the paper that asserts a number or a direction, in the paper's order."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Literal, NamedTuple

from pydantic import ConfigDict, TypeAdapter
from pydantic.dataclasses import dataclass

from crosscheck.audit.claims.claim_quantities import QUANTITIES, restrict_to_third
from crosscheck.audit.claims.measured import CASES, pd, static, torque
from crosscheck.audit.judging.quantities import Choices, Quantity
from crosscheck.audit.judging.rule import PLOT, READ_OFF, Claim, Limits
from crosscheck.audit.measures import thresholds
from crosscheck.models.files import read_toml

SENTENCES, STATEMENTS = (
    Path(__file__).with_name(f"{name}.toml") for name in ("sentences", "statements")
)
Threshold = float | Literal["SEVERE", "EVIDENT", "MINOR"]


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
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
        low, high = (
            getattr(thresholds, end) if isinstance(end, str) else end
            for end in (self.above, self.below)
        )
        return Limits(low, high, self.because)


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class Statement(LimitsText):
    """What the paper says in one claim, which figure shows it, and what decides it."""

    statement: str = ""
    figure: int | None = None
    pd: str = ""
    torque: str = ""
    static: str = ""
    cases: str = ""
    where_third: bool = False
    limits: str = ""


class Statements(NamedTuple):
    """The statements' texts by claim id, fields as in ``Claim``; retired: why an id is not used."""

    said: Mapping[str, Statement]
    limits: Mapping[str, LimitsText]
    free: Mapping[str, str]
    reading: Mapping[str, str]
    retired: Mapping[str, str]


TEXTS = TypeAdapter(Statements).validate_python(read_toml(STATEMENTS))


def find_quantity(name: str, said: Statement) -> Quantity | Choices:
    """The quantity that decides a statement. Raises KeyError if nothing does."""
    quantity = QUANTITIES.get(name)
    for find_number, number in ((pd, said.pd), (torque, said.torque), (static, said.static)):
        if said.cases and number:
            cases = CASES[said.cases]
            return {str(*case.values()): find_number(number.format(**case)) for case in cases}
        quantity = find_number(number) if number else quantity
    if quantity is None:
        raise KeyError(name)
    return (
        restrict_to_third(quantity)
        if isinstance(quantity, Quantity) and said.where_third
        else quantity
    )


CLAIMS = tuple(
    Claim(
        name,
        said.figure,
        said.statement,
        find_quantity(name, said),
        (TEXTS.limits[said.limits] if said.limits else said).build_limits(),
        free=TEXTS.free.get(name, ""),
        reading=TEXTS.reading.get(name, ""),
    )
    for name, said in TEXTS.said.items()
)
RETIRED = tuple(TEXTS.retired)
BY_ID = {claim.id: claim for claim in CLAIMS}
