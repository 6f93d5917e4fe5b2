"""Everything that is published, made for real from runs of a few milliseconds."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from crosscheck.audit.claims import study_plan
from crosscheck.audit.experiments.samples import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.page.chapter import AuditChapter
from tests.audit.markup import strict_json

BRIEF = Scale(longest_s=0.002, most_starts=2)
FEW = study_plan.StudyPlan(
    zetas=(0.005, 0.02),
    shaken=(0.02,),
    backlashes=(5.0, 500.0),
    errors=(1.6, 6.3),
    back=(0.0, 50.0, 500.0),
)


@contextmanager
def few_settings(*readings: str) -> Iterator[None]:
    """Every kind of experiment of the full plan, in few settings of each reading."""
    with pytest.MonkeyPatch.context() as patch:
        few = replace(FEW, readings=readings)
        patch.setattr(study_plan, "FULL", few)
        yield


class Published(NamedTuple):
    """What `crosscheck paper` leaves behind."""

    study: Study
    out: Path
    chapters: dict[str, AuditChapter]

    @property
    def html(self) -> str:
        return (self.out / "paper.html").read_text(encoding="utf-8")

    @property
    def json(self) -> dict[str, Any]:
        return strict_json((self.out / "claims.json").read_text(encoding="utf-8"))
