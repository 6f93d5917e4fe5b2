"""A changed caption or template makes no result anew."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from crosscheck.paper import report
from crosscheck.paper.material import Material
from crosscheck.paper.scale import Scale
from crosscheck.studies import sources
from crosscheck.studies.study import Asked, Comparison, Study
from models.loading import HERE
from tests.paper import edited_views
from tests.paper.views import is_view
from tests.processes import command_line

pytestmark = pytest.mark.slow
ROOT = HERE.parent
Name = tuple[str, str]


@dataclass
class Noting(Study):
    """A study that notes whose code its keys hang on: kinds of questions, measures, reductions."""

    names: set[Name] = field(default_factory=set)

    def note(self, makers: Iterable[Callable[..., object]]) -> None:
        self.names |= {(one.__module__, one.__qualname__.partition(".")[0]) for one in makers}

    def answers(self, questions, what):
        self.note(type(question) for question in questions)
        return super().answers(questions, what)

    def numbers(self, asked: Sequence[Asked], what: str):
        measures = {one.measure for one in asked}
        self.note(m.numbers if isinstance(m, Comparison) else m for m in measures)
        return super().numbers(asked, what)

    def runs(self, variants, what="runs", keep=None):
        self.note([] if keep is None else [keep])
        return super().runs(variants, what, keep)


@pytest.fixture(scope="module")
def names(tmp_path_factory: pytest.TempPathFactory) -> list[Name]:
    """Of all that a page is made from, but for the trajectories themselves."""
    study = Noting(tmp_path_factory.mktemp("kept"))
    material = Material(study, Scale(longest_s=0.002, most_starts=2))
    for name in report.CHAPTERS:
        report._chapter(material, name)
    return sorted(study.names)


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
