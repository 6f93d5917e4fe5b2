"""Chapters of which every run diverges: they say so, and are whole."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from crosscheck.audit.experiments.paper_conditions import LABELLED
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.undefined import UNDEFINED
from crosscheck.audit.page import report
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.context import AuditContext
from tests.audit.markup import page_problems, strict_json
from tests.audit.published import few_settings

pytestmark = pytest.mark.slow


class Unstable(Scale):
    """Every run at a step that no integrator survives for five milliseconds."""

    def cut(self, variant: Variant) -> Variant:
        shorter = super().cut(variant)
        return replace(shorter, settings=(*shorter.settings, "scenario.step_s=2e-4"))


@pytest.fixture(scope="module")
def material(kept: Path) -> Iterator[AuditContext]:
    """Of all chapters: what one has asked, the others read."""
    with few_settings(LABELLED):
        yield AuditContext(Study(kept), Unstable(longest_s=0.01, most_starts=2))


@pytest.fixture(scope="module")
def claims(material: AuditContext) -> AuditChapter:
    return report._build_chapter(material, "claims.chapter")


def test_that_a_run_diverges_is_itself_an_answer(claims):
    verdicts = {record["id"]: record["verdict"] for record in claims.records}
    assert verdicts["2.1-08"] == "holds"  # Eq. 5 may make a run diverge
    assert verdicts["4.1-27"] == UNDEFINED
    assert verdicts["3.2-11"] == UNDEFINED


def _undefined(record: dict[str, Any]) -> bool:
    """Of a verdict, of a figure that is not drawn, of a sample in which no start has a number.

    Or a fit that explains nothing.
    """
    if record.get("verdict") == UNDEFINED or record.get("drawn") is False:
        return True
    if record.get("mean") == 0.0:
        return True
    return "starts" in record and record["starts"] == record.get("undefined")


@pytest.mark.parametrize("name", ["findings.chapter", "figures.chapter", None])
def test_every_chapter_survives_runs_that_diverge(name, material, claims):
    made = report._build_chapter(material, name) if name else claims
    assert any(map(_undefined, made.records))
    strict_json(report.format_records([made], material.study))
    assert page_problems(report.render_page([made], material.study)) == []
