"""A chapter of the paper's page: that of a report, and what it says that others may say too."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from audit.page.said import Said
from crosscheck.report import chapter

rendered = chapter.rendered


@dataclass(frozen=True)
class Chapter(chapter.Chapter):
    """said: every answer that it gives to a question that another chapter may answer, too."""

    said: Sequence[Said] = ()
