"""What several tests of the paper's page look at, made once."""

from __future__ import annotations

import pytest

from crosscheck.paper import report
from tests.paper.published import BRIEF, Noting, Published


@pytest.fixture(scope="session")
def published(tmp_path_factory: pytest.TempPathFactory) -> Published:
    """The whole page."""
    folder = tmp_path_factory.mktemp("published")
    study, out = Noting(folder / "kept", 2), folder / "out"
    out.mkdir()
    made = report.write_paper(study, out, BRIEF)
    return Published(study, out, {chapter.id: chapter for chapter in made})
