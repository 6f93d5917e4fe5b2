"""A changed caption or template makes no result anew."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from crosscheck.studies import sources
from models.files import HERE
from tests.paper import edited_views
from tests.paper.published import Name, Published
from tests.paper.views import is_view
from tests.processes import command_line

pytestmark = pytest.mark.slow
ROOT = HERE.parent


@pytest.fixture
def names(published: Published) -> list[Name]:
    """Of all that a page is made from."""
    return sorted(published.study.names)


def test_no_result_hangs_on_a_view(names: list[Name]) -> None:
    assert len(names) > 5
    hanging = {
        (name, path.relative_to(ROOT).as_posix())
        for name in names
        for path in sources.walked(name).files
        if path.is_relative_to(ROOT) and is_view(path.relative_to(ROOT))
    }
    assert hanging == set()


def test_an_edit_of_every_text_and_drawing_changes_no_key(
    names: list[Name], tmp_path: Path
) -> None:
    for package in (*sources.OWN, "tests"):
        without = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / package, tmp_path / package, ignore=without)
    listed = tmp_path / "names.json"
    listed.write_text(json.dumps(names), encoding="utf-8")
    env = {"PYTHONPATH": str(tmp_path), "PYTHONDONTWRITEBYTECODE": "1"}
    script = str(Path(edited_views.__file__))
    answer = command_line(listed, python=(script,), env=env, timeout=300)
    assert answer.returncode == 0, answer.stderr
    assert json.loads(answer.stdout) == []
