"""A chapter of the paper's page: that of a report, and what it says that others may say too."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from crosscheck.audit.page.said import Said, StatedNumber
from crosscheck.report import chapter

rendered = chapter.rendered


@dataclass(frozen=True)
class AuditChapter(chapter.Chapter):
    """said, numbers: every answer and number that another chapter may give, too."""

    said: Sequence[Said] = ()
    numbers: Sequence[StatedNumber] = ()
