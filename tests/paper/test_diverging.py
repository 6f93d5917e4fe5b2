"""Chapters of which every run diverges: they say so, and are whole."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from crosscheck.paper import report
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import UNDEFINED
from crosscheck.studies.study import Study, Variant
from tests.paper.markup import page_problems, strict_json

pytestmark = pytest.mark.slow


def test_that_a_run_diverges_is_itself_an_answer(tmp_path: Path) -> None:
    made = report._chapter(Study(tmp_path), "claims.chapter", Unstable(longest_s=0.1))
    verdicts = {record["statement"]: record["verdict"] for record in made.records}
    assert verdicts["Eq. 5's corners may make the numerical solution diverge."] == "holds"
    assert verdicts["About 50 um is suitable for this arm."] == UNDEFINED
    assert verdicts["The shoulder's acceleration fluctuates severely."] == UNDEFINED


def _said(record: dict[str, Any]) -> tuple[str, ...]:
    return (record.get("verdict", ""), *record.get("verdicts", {}).values())


class Unstable(Scale):
    """Every run at a step that no integrator survives."""

    def cut(self, variant: Variant) -> Variant:
        shorter = super().cut(variant)
        return replace(shorter, settings=(*shorter.settings, "scenario.step_s=2e-4"))


@pytest.mark.parametrize(
    "name",
    [
        "claims.chapter",
        "phase.chapter",
        "planets.chapter",
        "hypotheses.ladder",
        "figures.chapter",
        "hypotheses.accumulation",
        "hypotheses.controller",
        "hypotheses.damping_fit",
    ],
)
def test_every_chapter_survives_runs_that_diverge(name: str, tmp_path: Path) -> None:
    study = Study(tmp_path)
    made = report._chapter(study, name, Unstable(longest_s=0.1))
    undefined = [record for record in made.records if UNDEFINED in _said(record)]
    assert undefined or all(fit["explained"] == 0 for fit in made.records if "misfits" in fit)
    strict_json(report.records_json([made], study))
    assert page_problems(report.page([made], study)) == []
