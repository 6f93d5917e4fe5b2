"""Every statement of the paper that asserts a number or a direction, in the paper's order."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from pydantic import TypeAdapter

from crosscheck.audit.claims.statements import section2, section3, section4
from crosscheck.audit.judging.rule import Claim, ClaimCriteria

SENTENCES = Path(__file__).with_name("sentences.toml")
STATEMENTS = Path(__file__).with_name("statements") / "statements.toml"


class Statement(NamedTuple):
    """What the paper says in one claim, and which figure shows it."""

    statement: str
    figure: int | None = None


class Statements(NamedTuple):
    """The statements' texts by claim id, fields as in ``Claim``; retired: why an id is not used."""

    said: Mapping[str, Statement]
    free: Mapping[str, str]
    reading: Mapping[str, str]
    retired: Mapping[str, str]


_TEXTS = TypeAdapter(Statements).validate_python(
    tomllib.loads(STATEMENTS.read_text(encoding="utf-8"))
)
SECTIONS = (section2, section3, section4)
_DECIDED: ClaimCriteria = {name: how for part in SECTIONS for name, how in part.DECIDED.items()}
CLAIMS = tuple(
    Claim(
        name,
        said.figure,
        said.statement,
        *_DECIDED[name],
        free=_TEXTS.free.get(name, ""),
        reading=_TEXTS.reading.get(name, ""),
    )
    for name, said in _TEXTS.said.items()
)
RETIRED = tuple(_TEXTS.retired)
BY_ID = {claim.id: claim for claim in CLAIMS}
