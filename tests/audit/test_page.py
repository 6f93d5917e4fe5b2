"""The paper's page and its command."""

import json
import re
from html import unescape
from pathlib import Path

import numpy as np
import pytest

from crosscheck.audit.experiments.study import Study
from crosscheck.audit.page.chapter import AUTHORS, TITLE, AuditChapter
from crosscheck.audit.page.report import format_records, render_page, run_paper_command
from crosscheck.models.errors import InputError


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path


@pytest.mark.parametrize("number", [3, 21, -1])
def test_unknown_figures_are_refused_before_anything_is_written(number, cache):
    with pytest.raises(InputError, match="must be 4 to 20"):
        run_paper_command([4, number], cache / "out", 1)
    assert not (cache / "out").exists()


def test_a_seed_that_cannot_be_one_is_refused_before_anything_is_written(crosscheck, cache):
    answer = crosscheck("paper", "--first-seed", "-1", "--out", cache / "out")
    assert (answer.code, answer.err.count("\n")) == (2, 1)
    assert "must be 0 or more" in answer.err
    assert not (cache / "out").exists()


@pytest.mark.slow
def test_one_figure_alone_makes_a_self_contained_page(cache):
    """Its script and its style are in it; nothing is asked of any other place."""
    run_paper_command([4], cache / "out", 1, 5)
    html = (cache / "out" / "paper.html").read_text(encoding="utf-8")
    assert 'id="figure-4"' in html
    assert "<svg" in html
    assert re.search(r"\bsrc=|<link\b|@import|url\(http|\bfetch\(", html) is None


def test_the_contents_name_every_chapter_in_order(tmp_path):
    made = [AuditChapter(name, name.upper(), f"<p>{name}</p>", outcome="So.") for name in "abc"]
    html = render_page(made, Study(tmp_path))
    contents, _, rest = html.partition("</nav>")
    assert re.findall(r'href="#(\w+)"', contents) == ["a", "b", "c", "provenance"]
    assert re.findall(r'<h2 id="(\w+)"', rest) == ["a", "b", "c", "provenance"]
    assert rest.count('<p class="outcome">So.</p>') == 3


def test_page_and_records_name_the_paper_and_what_was_read_of_it(tmp_path):
    """In their first lines, the sheet's too, and nothing that is not known of it is made up."""
    html = render_page([], Study(tmp_path)).partition("<main>")[2]
    first_lines = unescape(html).strip()[:1200]
    assert json.loads(format_records([], Study(tmp_path)))["paper"]["citation"] in first_lines
    for known in (AUTHORS, TITLE, "Robotica", "volume, pages, DOI: not known"):
        assert known in first_lines
    assert "figures were not seen" in first_lines


def test_records_are_identical_but_for_the_provenance(tmp_path):
    made = [AuditChapter("x", "X", "<p>x</p>", [{"id": "x/1", "value": np.float64(1.5)}])]
    first, second = (json.loads(format_records(made, Study(tmp_path))) for _ in range(2))
    assert first["chapters"] == second["chapters"] == {"x": [{"id": "x/1", "value": 1.5}]}
    assert "X" in render_page(made, Study(tmp_path))
