"""`crosscheck run`: the Agreement, its schema, the page, and what a broken engine does to them."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import jsonschema
import pytest

import crosscheck as package
from crosscheck import registry
from crosscheck.provenance import ROOT
from models.arm import Arm
from models.loading import HERE
from tests.arms import PAPER, arm_of, random_arm
from tests.paper.markup import SVG, axis_problems, page_problems

SCHEMA = json.loads((ROOT / "crosscheck" / "schema" / "agreement.schema.json").read_text())


class Report(NamedTuple):
    """What a cross-check left behind."""

    code: int
    out: str
    agreement: dict
    page: str


@pytest.fixture(scope="session")
def quick_report(tmp_path_factory: pytest.TempPathFactory) -> Report:
    """The paper's arm through ``crosscheck run --quick``."""
    folder = tmp_path_factory.mktemp("quick")
    command = [sys.executable, "-m", "crosscheck", "run", "--quick", "--out", str(folder)]
    answer = subprocess.run(command, capture_output=True, text=True, timeout=500, check=False)
    agreement = json.loads((folder / "agreement.json").read_text())
    assert sorted(path.name for path in folder.iterdir()) == ["agreement.json", "index.html"]
    return Report(answer.returncode, answer.stdout, agreement, (folder / "index.html").read_text())


@pytest.mark.slow
def test_every_check_of_the_papers_arm_agrees(quick_report):
    red = [
        f["id"]
        for f in quick_report.agreement["findings"]
        if f["verdict"] not in ("agree", "measured")
    ]
    assert red == []
    assert quick_report.code == 0
    count = sum(f["kind"] == "check" for f in quick_report.agreement["findings"])
    assert f"{count} of {count} checks agree" in quick_report.out


@pytest.mark.slow
def test_agreement_follows_its_schema(quick_report):
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    jsonschema.validate(quick_report.agreement, SCHEMA, jsonschema.Draft202012Validator)


@pytest.mark.slow
def test_the_page_is_well_formed_and_its_axes_have_units(quick_report):
    assert page_problems(quick_report.page) == []
    assert [axis for svg in SVG.findall(quick_report.page) for axis in axis_problems(svg)] == []


@pytest.mark.slow
def test_identifiers_are_unique_and_every_tolerance_has_a_basis(quick_report):
    findings = quick_report.agreement["findings"]
    assert len({finding["id"] for finding in findings}) == len(findings)
    bare = [f["id"] for f in findings if f["tolerance"] is not None and not f["basis"]]
    assert bare == []


@pytest.mark.slow
def test_all_models_take_part(quick_report):
    findings = quick_report.agreement["findings"]
    named = {side for f in findings if f["kind"] == "check" for side in (f["left"], f["right"])}
    rigid = {
        f"{engine}:{level}"
        for engine in ("analytic", "pinocchio")
        for level in registry.RIGID_LEVELS
    }
    assert named >= {*registry.names("geared"), *rigid}


@pytest.mark.slow
def test_provenance_holds_the_arm_and_no_path_of_this_machine(quick_report):
    provenance = quick_report.agreement["provenance"]
    assert Arm.model_validate(provenance["arm"]) == PAPER
    assert provenance["versions"].keys() >= {"pin", "exudyn", "numpy"}
    assert None not in provenance["versions"].values()
    assert str(ROOT) not in json.dumps(quick_report.agreement)
    assert str(HERE) not in quick_report.page


@pytest.mark.slow
def test_page_needs_nothing_from_elsewhere(quick_report):
    page = quick_report.page
    assert "<svg" in page
    # Names of XML vocabularies are no links: nothing is loaded from them.
    addresses = re.findall(
        r"""(?:src|href|action|url)\s*[=(]\s*["']?\s*(?!#|data:)([^"')\s>]+)""", page
    )
    assert [address for address in addresses if not address.startswith("#")] == []
    assert not re.search(r"<(script|link|iframe|img)[^>]+(src|href)=", page)
    assert "@import" not in page


@pytest.fixture
def arm_file(tmp_path: Path) -> Path:
    """A user's arm: the paper's shoulder alone."""
    head, shoulder, _, link, _ = re.split(
        r"(?=\[\[)", (HERE / "arms" / "paper-labelled.toml").read_text()
    )
    file = tmp_path / "mine.toml"
    file.write_text(head.replace('"paper-labelled"', '"mine"') + shoulder + link)
    return file


def agreement_of(crosscheck, folder: Path, *arguments: object) -> dict:
    """agreement.json of a run without its provenance."""
    crosscheck("run", *arguments, "--out", folder)
    agreement = json.loads((folder / "agreement.json").read_text())
    del agreement["provenance"]
    return agreement


@pytest.mark.usefixtures("brief")
def test_agreement_is_the_same_again_on_any_number_of_processes(arm_file):
    arm = package.load_arm(str(arm_file))
    one, two = (package.check(arm, quick=True, jobs=jobs).to_dict() for jobs in (1, 2))
    assert one["findings"] == two["findings"]


@pytest.mark.parametrize(
    ("model", "module"),
    [
        ("pinocchio:gears", "models.no_such_engine"),
        ("exudyn:tree", "models.no_such_engine"),
        ("analytic:physical", "models.no_such_engine"),
    ],
)
@pytest.mark.usefixtures("brief")
def test_engine_that_cannot_be_imported_is_a_failed_check(monkeypatch, model, module):
    entry = replace(registry.MODELS[model], module=module, attribute="Nothing")
    monkeypatch.setitem(registry.MODELS, model, entry)
    agreement = package.check(arm_of(1), quick=True)
    failed = [f for f in agreement.findings if f.verdict == "failed" and model in (f.left, f.right)]
    assert failed
    assert all(f.kind == "check" for f in failed)
    assert "no_such_engine" in failed[0].note
    assert agreement.exit_code == 1


@pytest.mark.usefixtures("brief")
def test_engine_that_raises_is_a_failed_check_and_the_report_is_written(
    crosscheck, monkeypatch, tmp_path, arm_file
):
    from models.exudyn_tree import ExudynTree

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


@pytest.mark.parametrize("harm", [_crashing, _leaving])
@pytest.mark.parametrize("jobs", [1, 2])
@pytest.mark.usefixtures("brief")
def test_engine_that_crashes_or_leaves_costs_its_own_checks_alone(monkeypatch, harm, jobs):
    """And a model harmed in memory is harmed in every process."""
    from models.exudyn_tree import ExudynTree

    monkeypatch.setattr(ExudynTree, "bias", harm)
    agreement = package.check(arm_of(1), quick=True, jobs=jobs)
    assert agreement.exit_code == 1
    assert {f.verdict for f in agreement.red} == {"failed"}
    assert all("exudyn:tree" in (f.left, f.right) for f in agreement.red)
    assert all(f.note.startswith("exudyn:tree: ") for f in agreement.red)
    # Whatever needs no bias of the tree is as before.
    agreeing = {f.quantity for f in agreement.findings if f.left == "exudyn:tree"}
    assert agreeing >= {"inertia", "locked-stage", "abilities"}


@pytest.mark.usefixtures("brief")
def test_arm_called_like_the_probe_is_told_from_it(labelled):
    arm = labelled.model_copy(update={"name": "probe"})
    agreement = package.check(arm, quick=True, jobs=2)
    assert [f.id for f in agreement.red] == []
    assert len({f.id for f in agreement.findings}) == len(agreement.findings)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 8])
@pytest.mark.usefixtures("brief")
def test_an_arm_of_random_numbers_raises_no_false_alarm(seed):
    agreement = package.check(random_arm(seed, most_joints=2), quick=True, jobs=2, seed=seed)
    assert [f"{f.id}: {f.measured} {f.note}" for f in agreement.red] == []


@pytest.mark.usefixtures("brief")
def test_arm_of_one_joint_passes_every_check():
    agreement = package.check(arm_of(1), quick=True)
    assert [f"{f.id}: {f.measured} {f.note}" for f in agreement.red] == []
