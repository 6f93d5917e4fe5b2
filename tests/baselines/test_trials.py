"""A baseline of a user's own equations: the record names them, and never runs them."""

import json
import shutil
from pathlib import Path

import pytest

from tests.processes import Answer, Command
from tests.tool.supplied import model_file
from tests.tool.test_bad_input import assert_one_line

pytestmark = pytest.mark.slow

RUN = ("--scenario", "constant-torque", "--set", "scenario.duration_s=0.002")
SLIPPED = """
def slipped():  # of one arm, so that no probe arms take the same time again
    from crosscheck import load_arm
    return replace(two_link(load_arm("paper-labelled")), bias=lambda q, v: 0 * v)
"""


@pytest.fixture
def baseline(command: Command, tmp_path: Path):
    """``baseline("accept", name)`` of a model in mine.py."""
    model_file(tmp_path, SLIPPED)

    def baseline(what: str, name: str = "two_link", *more: str) -> Answer:
        given = ("--model", f"mine.py:{name}", "--quick", "--jobs", "1")
        return command("baseline", what, "paper-labelled", *given, *more)

    return baseline


def records() -> list[Path]:
    """In the current folder, by name."""
    return sorted(Path("baselines").glob("*.json"))


def test_trial_with_a_run_repeats(baseline):
    assert baseline("accept", "two_link", *RUN).code == 0
    (file,) = records()
    content = json.loads(file.read_text())
    assert file.name.startswith("paper-labelled+constant-torque@mine.py-two_link~")
    assert content["provenance"]["model"] == "mine.py:two_link"
    assert {*content["runs"]} == {
        "constant-torque/mine.py:two_link",
        "constant-torque/analytic:links",
    }
    again = baseline("check", "two_link", *RUN)
    assert (again.code, "0 of " in again.out) == (0, True)


def test_what_moved_is_named(baseline, tmp_path):
    assert baseline("accept").code == 0
    file = tmp_path / "mine.py"
    moved = file.read_text().replace("return [-s * (2", "return [-s * (2 + 1e-6) / 2 * (2")
    file.write_text(moved)
    answer = baseline("check")
    assert answer.code == 1
    assert "trial-states/paper-labelled/bias/mine.py:two_link~analytic:links" in answer.out
    assert "agree -> differ" in answer.out


def test_red_trial_is_not_recorded_unless_wanted(baseline):
    answer = baseline("accept", "slipped")
    assert (answer.code, "nothing recorded" in answer.out, records()) == (1, True, [])
    assert baseline("accept", "slipped", "--with-differences").code == 0
    assert baseline("check", "slipped").code == 0


def test_record_of_another_model_is_refused(baseline, command):
    assert baseline("accept").code == 0
    (file,) = records()
    assert_one_line(baseline("check", "slipped"), "--model mine.py:slipped")
    shutil.copy(file, "baselines/paper-labelled-quick.json")
    said = "provenance.model = 'mine.py:two_link': a record of all models is needed here"
    assert_one_line(command("baseline", "check", "paper-labelled", "--quick"), said)


def test_no_record_runs_code(baseline, command, tmp_path):
    """Without --model a record of a trial is never looked at, and its code never run."""
    assert baseline("accept").code == 0
    (tmp_path / "mine.py").write_text("open('ran', 'w')\n")
    answer = command("baseline", "check", "paper-labelled", "--quick")
    assert not (tmp_path / "ran").exists()
    assert "baseline accept paper-labelled --quick" in answer.err
