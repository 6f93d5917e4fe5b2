"""Everything that is published, made for real from runs of a few milliseconds."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from crosscheck.audit.claims.study_plan import StudyPlan
from crosscheck.audit.experiments.samples import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.page.chapter import AuditChapter
from tests.audit.markup import strict_json
from tests.views.shown_numbers import QUANTITY, Page, Token

BRIEF = Scale(longest_s=0.002, most_starts=2)
# Every kind of experiment of the full plan, in few settings of each reading.
FEW = StudyPlan(
    zetas=(0.02,), shaken=(0.02,), backlashes=(5.0, 500.0), errors=(6.3,), back=(0.0, 50.0)
)


class Published(NamedTuple):
    """What `crosscheck paper` leaves behind."""

    study: Study
    out: Path
    chapters: dict[str, AuditChapter]

    def records(self, chapter: str) -> dict[str, dict[str, Any]]:
        """A chapter's records by id."""
        return {record["id"]: record for record in self.chapters[chapter].records}

    @property
    def html(self) -> str:
        return (self.out / "paper.html").read_text(encoding="utf-8")

    @property
    def json(self) -> dict[str, Any]:
        return strict_json((self.out / "claims.json").read_text(encoding="utf-8"))


# Numbers of a page that are no results: conditions of runs, words of the paper, ends of a range.
CONDITIONS = (
    r"(?:\bb(?: of| =)?|E) [\d.]+(?: to [\d.]+)? µm|k_[ma] [\de+.]+ N/m|100 N m"
    r"|\d\.?\d* s\b|1e-\d+ m\b"
    r"|= 1000 N|25 %|[\d.]+ to [\d.]+ [µm]m|^The paper\. .*|The paper's smallest run is .*"
    r"|some 30 mm|\b52 µm|= 51\.94 µm"  # which statics give by the formula before it
)


def list_unrecorded(html: str, records: Any) -> Iterator[str]:
    """Quantities of a page's chapter that are in none of its records, as numbers or in words."""
    known = {*list_numbers(records)}
    for line in Page(html).lines:
        text = re.sub(CONDITIONS, "", line)
        for found in re.finditer(QUANTITY, text):
            token = Token.of(found)
            if token.unit and not any(token.shows(value) for value in known):
                yield f"{found[0]} in {text[max(found.start() - 60, 0) : found.end() + 20]}"


def list_numbers(value: Any) -> Iterator[float]:
    """All numbers of records, also those in words, without prefixes of their units."""
    if isinstance(value, dict | list | tuple):
        for each in value.values() if isinstance(value, dict) else value:
            yield from list_numbers(each)
    elif isinstance(value, str):
        for found in re.finditer(QUANTITY, value):
            yield Token.of(found).value
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield float(value)
