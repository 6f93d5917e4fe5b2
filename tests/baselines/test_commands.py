"""`crosscheck validate` and `crosscheck baseline`: exit codes, output, files."""

import json
import os
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import pytest

from crosscheck import provenance
from crosscheck.findings import Agreement, make_check, make_failed_check
from crosscheck.models.loading import load_arm
from crosscheck.provenance import record_provenance
from crosscheck.report import terminal
from crosscheck.report.junit import format_junit
from crosscheck.run import CrossCheck
from crosscheck.runner.outcomes import Failure
from crosscheck.trial.tables.folder import format_arm_toml
from tests.arms import arm_of
from tests.baselines import short
from tests.processes import Answer
from tests.tool.test_bad_input import assert_one_line

ACCEPT, CHECK = ("baseline", "accept", "--quick"), ("baseline", "check", "--quick")
RECORD = Path("baselines/paper-labelled-quick.json")


@pytest.mark.parametrize("joints", range(1, 8))
def test_an_arm_of_any_number_of_joints_does_not_move(command, joints):
    """Of four a row of time and a value per joint has as many columns as one of extremes."""
    arm = arm_of(joints)
    Path("arm.toml").write_text(format_arm_toml(arm), encoding="utf-8")
    result = short.invented_check(arm)
    assert command(*ACCEPT, "arm.toml", result=result).code == 0
    recorded = json.loads(Path(f"baselines/{arm.name}-quick.json").read_text())
    run = recorded["runs"][str(short.ANALYTIC)]
    assert {len(row) for row in run["sampled"]["theta"]["rows"]} == {1 + joints}
    assert len(run["extremes"]["F_sp"]["rows"]) == joints
    assert command(*CHECK, "arm.toml", result=result).code == 0


# Red checks


@pytest.fixture
def broken(result: CrossCheck) -> CrossCheck:
    """The short cross-check with a check that differs, one that failed and a lost run."""
    lost = short.with_run(result, short.EXUDYN, Failure("RuntimeError", "no engine"))
    return short.with_findings(lost, [*result.agreement.findings, short.red()])


@pytest.mark.parametrize("before", ["no record", "a record"])
def test_red_checks_are_not_accepted(command, request, broken, before):
    old = request.getfixturevalue("recorded").read_bytes() if before == "a record" else None
    answer = command(*ACCEPT, "--junit", "red.xml", result=broken)
    assert answer.code == 1
    assert "differ refined/pd/theta/a~b" in answer.out
    said = "1 differing check: nothing recorded (--with-differences records known differences)\n"
    assert answer.out.endswith(said)
    assert (RECORD.read_bytes() if RECORD.exists() else None) == old
    assert Path("red.xml").is_file()


def test_nothing_checked_is_not_accepted(command, result):
    nothing = short.with_findings(result, [])
    assert command(*ACCEPT, "--with-differences", result=nothing).code == 1
    assert not RECORD.exists()


def test_a_run_that_cannot_be_recorded_is_not_accepted(command, result):
    half = result.runs[short.ANALYTIC].isel(time=slice(0, 100))
    code, out, _ = command(*ACCEPT, result=short.with_run(result, short.ANALYTIC, half))
    assert code == 1
    assert f"{short.ANALYTIC} cannot be recorded: " in out
    assert f"must be times that rise from 0 to {short.DURATION_S} s" in out
    assert "0 differing checks, 1 lost run: nothing recorded" in out


@pytest.fixture
def accepted(command, broken) -> Answer:
    """The answer that accepts the broken one's differences."""
    answer = command(*ACCEPT, "--with-differences", result=broken)
    assert answer.code == 0
    return answer


def test_known_differences_are_shown_on_every_run(command, broken, accepted):
    assert "1 known difference" in accepted.out
    for _ in range(2):
        code, out, _ = command(*CHECK, "--junit", "known.xml", result=broken)
        assert code == 0
        said = "known difference, differ: measured 0.003, allowed 1e-10 rad"
        assert f"recorded-verdict/refined/pd/theta/a~b: {said}" in out
        assert "\n0 of " in out
        assert out.endswith("changed; 1 known difference left as accepted\n")
        suite = ElementTree.fromstring(Path("known.xml").read_text(encoding="utf-8"))
        assert said in ElementTree.tostring(suite, encoding="unicode")
        named = {item.get("name"): item.get("value") for item in suite.iter("property")}
        assert "recorded-verdict/refined/pd/theta/a~b" in (named["known"] or "")
        assert suite.get("failures") == "0"


@pytest.mark.parametrize(
    ("measured", "said", "not_said"),
    [
        (4e-3, "recorded-verdict/refined/pd/theta/a~b: changed by 0.001 rad", "better"),
        (1e-12, "better: differ -> agree: measured 1e-12, allowed 1e-10 rad", "known difference"),
    ],
    ids=["its number does", "it has gone"],
)
@pytest.mark.usefixtures("accepted")
def test_a_known_difference_moves_when(command, broken, measured, said, not_said):
    others = broken.agreement.findings[:-1]
    now = short.with_findings(broken, [*others, short.red(measured=measured)])
    code, out, _ = command(*CHECK, result=now)
    assert (code, said in out, not_said in out) == (1, True, False)
    assert "\n1 of " in out


def test_what_changed_most_stands_first_and_is_never_cut_off(capsys, monkeypatch):
    monkeypatch.setattr(terminal, "MOST", 3)
    changes = {"little": 2.0, "much": 900.0, "least": 1.1, "more": 30.0}
    own = {"tolerance": 1e-3, "basis": ""}
    found = [
        make_check(short.about("recorded-run", case), measured=times * 1e-3, **own)
        for case, times in changes.items()
    ]
    found.append(make_failed_check(short.about("recorded-run", "gone"), "disappeared"))
    terminal.print_changed(Agreement(found))
    lines = capsys.readouterr().out.splitlines()
    assert [line.split("/")[1] for line in lines[:3]] == ["gone", "much", "more"]
    assert "changed by 0.9 rad, 900 x the allowed 0.001; " in lines[1]
    assert lines[3] == "... and 2 smaller ones (all are in --junit)"


def git(*words: str) -> None:
    own = ("-c", "user.name=a", "-c", "user.email=a@b.example")
    subprocess.run(["git", *own, *words], check=True, capture_output=True)


def test_a_checkout_is_looked_at_and_not_written(tmp_path, monkeypatch):
    """Git refreshes its index by the way, and leaves a lock where that is cut short."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(provenance, "ROOT", tmp_path)
    git("init", "--quiet")
    Path("model.py").write_text("g = 9.8\n")
    git("add", ".")
    git("commit", "--quiet", "--message", "first")
    os.utime("model.py", (1e9, 1e9))  # the same content: only git's note of its age is old
    index = Path(".git", "index").read_bytes()
    assert provenance.list_changed_files() == []
    assert Path(".git", "index").read_bytes() == index


def test_a_revision_is_that_of_the_checkout_wherever_git_is_made_to_look(tmp_path, monkeypatch):
    """A hook of another repository sets GIT_DIR, and tests of its equations may run there."""
    revisions = []
    for name in ("mine", "other"):
        folder = tmp_path / name
        folder.mkdir()
        monkeypatch.chdir(folder)
        git("init", "--quiet")
        git("commit", "--quiet", "--allow-empty", "--message", name)
        head = subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, text=True)
        revisions.append(head.stdout)
    monkeypatch.setattr(provenance, "ROOT", tmp_path / "mine")
    monkeypatch.setenv("GIT_DIR", str(tmp_path / "other" / ".git"))
    mine, other = revisions
    assert mine != other
    assert mine.startswith(str(provenance._revision.__wrapped__()))


def test_a_checkout_with_uncommitted_changes_has_no_record(command, result, monkeypatch):
    monkeypatch.setattr(provenance, "ROOT", Path.cwd())
    git("init", "--quiet")
    Path("model.py").write_text("g = 9.8\n")
    Path(".gitignore").write_text("report/\n")
    git("add", ".")
    git("commit", "--quiet", "--message", "first")
    assert command(*ACCEPT, result=result).code == 0
    git("add", ".")
    git("commit", "--quiet", "--message", "record")
    RECORD.write_text("")  # as a record before it: no result comes from it
    assert command(*ACCEPT, result=result).code == 0
    Path("model.py").write_text("g = 9.81\n")
    said = "commit or stash first, or record elsewhere with --dir"
    assert_one_line(command(*ACCEPT), "uncommitted changes of model.py in this checkout", said)
    for folder in ("report", Path.cwd().parent / "elsewhere"):
        assert command(*ACCEPT, "--dir", folder, result=result).code == 0
    assert str(provenance._revision.__wrapped__()).endswith("-dirty")  # as it is now


# The JUnit view, read back as a build server reads it


def test_measurements_and_versions_are_properties():
    made = {"created": "2024-01-02T03:04:05+00:00", "versions": {"pin": "4\x1b"}}
    provenance = record_provenance(load_arm("probe"), 0, True).model_copy(update=made)
    root = ElementTree.fromstring(
        format_junit(Agreement([short.green(), short.measurement("pd", 0.1)], provenance))
    )
    found = {item.get("name"): item.get("value") for item in root.iter("property")}
    written = provenance.model_dump(mode="json")
    simple = {name: each for name, each in written.items() if not isinstance(each, list | dict)}
    assert {type(each) for each in simple.values()} >= {int, str, bool}
    assert {name: str(each) for name, each in simple.items()}.items() <= found.items()
    assert found["deviation/pd/theta/a~b"] == "0.1 rad"
    assert found["version pin"] == "4\N{REPLACEMENT CHARACTER}"
    assert root[0].get("timestamp") == "2024-01-02T03:04:05"
    assert not {"arm", "versions"} & set(found)  # no text or number


def test_a_check_is_a_test_whose_name_has_no_packages():
    assert ElementTree.fromstring(format_junit(Agreement([]))).get("tests") == "0"
    check = make_check(short.about("v1.0", ""), measured=0.0, tolerance=1.0, basis="")
    (case,) = ElementTree.fromstring(format_junit(Agreement([check]))).iter("testcase")
    assert case.get("classname") == "v1_0"
