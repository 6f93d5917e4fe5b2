"""`crosscheck run`: the Agreement, its schema, the page, and what a broken engine does to them."""

import io
import json
import re
import sys
from contextlib import redirect_stdout
from typing import NamedTuple

import pytest

from crosscheck import registry
from crosscheck.cli.app import main
from crosscheck.models.arm.arm import Arm
from crosscheck.models.files import HERE
from crosscheck.provenance import ROOT
from tests.arms import PAPER
from tests.audit.markup import axis_problems, page_problems
from tests.brief import brief, perform_here
from tests.schemas import assert_follows

pytestmark = pytest.mark.slow


class Report(NamedTuple):
    """What a cross-check left behind."""

    code: int
    out: str
    agreement: dict
    page: str


@pytest.fixture(scope="session")
def quick_report(tmp_path_factory: pytest.TempPathFactory) -> Report:
    """The paper's arm through ``crosscheck run --quick``, every experiment of it cut short."""
    folder = tmp_path_factory.mktemp("quick")
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(io.StringIO()) as out:
        brief(patch, 0.005)
        perform_here(patch)
        patch.setattr(sys, "argv", ["crosscheck", "run", "--quick", "--out", str(folder)])
        with pytest.raises(SystemExit) as left:
            main()
    agreement = json.loads((folder / "agreement.json").read_text())
    assert sorted(path.name for path in folder.iterdir()) == ["agreement.json", "index.html"]
    code = int(left.value.code or 0)
    return Report(code, out.getvalue(), agreement, (folder / "index.html").read_text())


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


def test_agreement_follows_its_schema(quick_report):
    assert_follows(quick_report.agreement, "agreement")


def test_the_page_is_well_formed_and_its_axes_have_units(quick_report):
    assert page_problems(quick_report.page) == []
    assert axis_problems(quick_report.page) == []


def test_identifiers_are_unique_and_every_tolerance_has_a_basis(quick_report):
    findings = quick_report.agreement["findings"]
    assert len({finding["id"] for finding in findings}) == len(findings)
    bare = [f["id"] for f in findings if f["tolerance"] is not None and not f["basis"]]
    assert bare == []


def test_all_models_take_part(quick_report):
    findings = quick_report.agreement["findings"]
    named = {side for f in findings if f["kind"] == "check" for side in (f["left"], f["right"])}
    rigid = {
        f"{engine}:{level}"
        for engine in ("analytic", "pinocchio")
        for level in registry.RIGID_LEVELS
    }
    assert named >= {*registry.model_names("geared"), *rigid}


def test_provenance_holds_the_arm_and_no_path_of_this_machine(quick_report):
    provenance = quick_report.agreement["provenance"]
    assert Arm.model_validate(provenance["arm"]) == PAPER
    assert provenance["versions"].keys() >= {"pin", "exudyn", "numpy"}
    assert None not in provenance["versions"].values()
    assert str(ROOT) not in json.dumps(quick_report.agreement)
    assert str(HERE) not in quick_report.page


def test_the_papers_equations_are_said_to_differ(quick_report):
    row = re.search(r"^ *analytic:printed +(\w+)", quick_report.out, flags=re.M)
    assert row is not None
    assert row[1] == "differ"
    verdict = quick_report.agreement["answers"]["verdict"]
    assert "wrong in 4 entries (largest M[theta_1, x_pr2]" in verdict
    lines = quick_report.out.splitlines()
    assert len(lines) <= 17
    assert quick_report.out.count(verdict) == 1
    # A number and its unit are one word on the page.
    assert quick_report.page.count(verdict.partition(",")[0]) == 1


def test_page_needs_nothing_from_elsewhere(quick_report):
    page = quick_report.page
    assert "<svg" in page
    # Names of XML vocabularies are no links: nothing is loaded from them.
    addresses = re.findall(
        r"""(?:src|href|action|url)\s*[=(]\s*["']?\s*(?!#|data:)([^"')\s>]+)""", page
    )
    assert [address for address in addresses if not address.startswith("#")] == []
    assert "@import" not in page


def test_the_papers_figures_and_claims_are_another_commands(quick_report):
    assert quick_report.page.count("<code>crosscheck paper</code>") == 1
    assert "<summary id=" not in quick_report.page  # as each chapter of the paper's page has
