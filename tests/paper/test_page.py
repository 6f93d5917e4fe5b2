"""The paper's page and its command."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from crosscheck.paper.command import paper_command
from crosscheck.paper.errata.notes import notes
from crosscheck.paper.errata.sheet import chapter, markdown
from crosscheck.paper.material import Material
from crosscheck.paper.report import page, records_json
from crosscheck.paper.scale import QUICK
from crosscheck.report.chapter import Chapter
from crosscheck.studies.study import Study
from models.errors import InputError


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path


@pytest.mark.parametrize("number", [3, 21, -1])
def test_unknown_figures_are_refused_before_anything_is_written(number: int, cache: Path):
    with pytest.raises(InputError, match="must be 4 to 20"):
        paper_command([4, number], cache / "out", 1)
    assert not (cache / "out").exists()


def test_one_figure_alone_makes_a_self_contained_page(cache: Path):
    paper_command([4], cache / "out", 1)
    html = (cache / "out" / "paper.html").read_text(encoding="utf-8")
    assert 'id="figure-4"' in html
    assert "<svg" in html
    assert "<script" not in html
    assert "src=" not in html


def test_records_are_identical_but_for_the_provenance(tmp_path: Path):
    made = [Chapter("x", "X", "<p>x</p>", [{"id": "x/1", "value": np.float64(1.5)}])]
    first, second = (json.loads(records_json(made, Study(tmp_path))) for _ in range(2))
    assert first["chapters"] == second["chapters"] == {"x": [{"id": "x/1", "value": 1.5}]}
    assert "X" in page(made, Study(tmp_path))


def test_errata_sheet_says_the_same_as_a_page_and_as_markdown(tmp_path: Path):
    sheet = chapter(Material(Study(tmp_path), QUICK))
    errata, text = [slip.erratum for slip in sheet.slips], markdown(sheet.slips)
    ids = [f"erratum/paper-labelled/{erratum.id}" for erratum in errata]
    assert [record["id"] for record in sheet.records][: len(ids)] == ids
    for note in (*notes().contradictions, *notes().gaps):
        assert any(str(record["id"]).endswith(f"/{note.id}") for record in sheet.records)
    for erratum in errata:
        assert erratum.where.replace("|", r"\|") in text
    assert sheet.html.count("<svg") == sum(
        bool(tex) for erratum in errata for tex in (erratum.printed_tex, erratum.derived_tex)
    )
