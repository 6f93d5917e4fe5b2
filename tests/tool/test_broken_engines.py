"""What an engine that is missing, raises or takes its process down does to a cross-check."""

import json
import os
import re
import signal
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest

import crosscheck as package
from crosscheck import registry
from crosscheck.models.files import HERE
from crosscheck.provenance import ROOT
from tests.arms import arm_of

SCHEMA = json.loads((ROOT / "crosscheck" / "schema" / "agreement.schema.json").read_text())

pytestmark = pytest.mark.system


@pytest.fixture
def arm_file(tmp_path: Path) -> Path:
    """A user's arm: the paper's shoulder alone."""
    head, shoulder, _, link, _ = re.split(
        r"(?=\[\[)", (HERE / "arms" / "paper-labelled.toml").read_text()
    )
    file = tmp_path / "mine.toml"
    file.write_text(head.replace('"paper-labelled"', '"mine"') + shoulder + link)
    return file


@pytest.mark.parametrize(
    "missing", [("pinocchio:gears", "exudyn:tree"), ("analytic:physical",)], ids=", ".join
)
@pytest.mark.usefixtures("brief_plan")
def test_engines_that_cannot_be_imported_are_failed_checks(monkeypatch, missing):
    for model in missing:
        entry = registry.MODELS[model]
        lost = replace(entry, module="crosscheck.models.no_such_engine", attribute="Nothing")
        monkeypatch.setitem(registry.MODELS, model, lost)
    agreement = package.check(arm_of(1), quick=True)
    assert agreement.exit_code == 1
    failures = [f for f in agreement.findings if f.verdict == "failed"]
    for model in missing:
        failed = [f for f in failures if model in (f.left, f.right)]
        assert failed
        assert all(f.kind == "check" for f in failed)
        assert all("no_such_engine" in f.note for f in failed)


@pytest.mark.usefixtures("brief_plan")
def test_engine_that_raises_is_a_failed_check_and_the_report_is_written(
    crosscheck, monkeypatch, tmp_path, arm_file
):
    from crosscheck.models.exudyn.tree.tree import ExudynTree

    def raising(*state: object) -> None:
        raise ValueError("singular")

    monkeypatch.setattr(ExudynTree, "acceleration", raising)
    answer = crosscheck("run", arm_file, "--quick", "--jobs", 1, "--out", tmp_path / "report")
    assert answer.code == 1
    assert "ValueError: singular" in answer.out
    agreement = json.loads((tmp_path / "report" / "agreement.json").read_text())
    jsonschema.validate(agreement, SCHEMA, jsonschema.Draft202012Validator)
    assert {f["verdict"] for f in agreement["findings"]} >= {"agree", "failed"}
    assert "singular" in (tmp_path / "report" / "index.html").read_text()


def _crashing(*state: object) -> None:
    os.kill(os.getpid(), signal.SIGSEGV)


def _leaving(*state: object) -> None:
    raise SystemExit(0)


@pytest.mark.usefixtures("brief_plan")
def test_engines_that_crash_or_leave_cost_their_own_checks_alone(monkeypatch):
    """And a model harmed in memory is harmed in every process."""
    from crosscheck.models.exudyn.tree.tree import ExudynTree
    from crosscheck.models.pinocchio.arm import PinocchioGears

    harmed = {"exudyn:tree": (ExudynTree, _crashing), "pinocchio:gears": (PinocchioGears, _leaving)}
    for model, harm in harmed.values():
        monkeypatch.setattr(model, "bias", harm)
    agreement = package.check(arm_of(1), quick=True, jobs=2)
    assert agreement.exit_code == 1
    assert {f.verdict for f in agreement.disagreeing} == {"failed"}
    for name in harmed:
        assert any(f.note.startswith(f"{name}: ") for f in agreement.disagreeing)
        # Whatever needs no bias of the model is as before.
        own = [f for f in agreement.findings if name in (f.left, f.right)]
        agreeing = {f.quantity for f in own if f.verdict == "agree"}
        assert agreeing >= {"inertia", "mass_matrix", "abilities"}
    assert {f.verdict for f in agreement.findings if f.quantity == "locked-stage"} == {"agree"}
    assert all({f.left, f.right} & {*harmed} for f in agreement.disagreeing)
    assert all(
        f.note.startswith(tuple(f"{name}: " for name in harmed)) for f in agreement.disagreeing
    )
