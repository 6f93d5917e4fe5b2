"""A baseline of a user's own equations: the record names them, and never runs them."""

import json
import shutil
from pathlib import Path

import pytest

from tests.baselines.conftest import Command
from tests.tool.supplied import model_file

pytestmark = pytest.mark.slow

RUN = ("--scenario", "constant-torque", "--set", "scenario.duration_s=0.002")
SLIPPED = """
def slipped(arm):
    return replace(two_link(arm), bias=lambda q, v: 0 * v)
"""


@pytest.fixture
def baseline(command: Command, tmp_path: Path):
    """``baseline("accept", name)`` of a model in mine.py: the exit code."""
    model_file(tmp_path, SLIPPED)

    def baseline(what: str, name: str = "two_link", *more: str) -> int:
        given = ("--model", f"mine.py:{name}", "--quick", "--jobs", "1")
        return command("baseline", what, "paper-labelled", *given, *more)

    return baseline


def records() -> list[Path]:
    """In the current folder, by name."""
    return sorted(Path("baselines").glob("*.json"))


def test_trial_with_a_run_repeats(baseline, capsys):
    assert baseline("accept", "two_link", *RUN) == 0
    (file,) = records()
    content = json.loads(file.read_text())
    assert file.name.startswith("paper-labelled+constant-torque@mine.py-two_link~")
    assert content["provenance"]["model"] == "mine.py:two_link"
    assert {*content["runs"]} == {
        "constant-torque/mine.py:two_link",
        "constant-torque/analytic:links",
    }
    capsys.readouterr()
    assert baseline("check", "two_link", *RUN) == 0
    assert "0 of " in capsys.readouterr().out


def test_what_moved_is_named(baseline, tmp_path, capsys):
    assert baseline("accept") == 0
    file = tmp_path / "mine.py"
    moved = file.read_text().replace("return [-s * (2", "return [-s * (2 + 1e-6) / 2 * (2")
    file.write_text(moved)
    capsys.readouterr()
    assert baseline("check") == 1
    out = capsys.readouterr().out
    assert "trial-states/paper-labelled/bias/mine.py:two_link~analytic:links" in out
    assert "agree -> differ" in out


def test_red_trial_is_not_recorded_unless_wanted(baseline, capsys):
    assert baseline("accept", "slipped") == 1
    assert records() == []
    assert "nothing recorded" in capsys.readouterr().out
    assert baseline("accept", "slipped", "--with-differences") == 0
    assert baseline("check", "slipped") == 0


def test_record_of_another_model_is_refused(baseline, command, capsys):
    assert baseline("accept") == 0
    (file,) = records()
    capsys.readouterr()
    assert baseline("check", "slipped") == 2
    assert "--model mine.py:slipped" in capsys.readouterr().err
    shutil.copy(file, "baselines/paper-labelled-quick.json")
    assert command("baseline", "check", "paper-labelled", "--quick") == 2
    told = capsys.readouterr().err
    assert "provenance.model = 'mine.py:two_link': a record of all models is needed here" in told


def test_no_record_runs_code(baseline, command, tmp_path, capsys):
    """Without --model a record of a trial is never looked at, and its code never run."""
    assert baseline("accept") == 0
    (tmp_path / "mine.py").write_text("open('ran', 'w')\n")
    command("baseline", "check", "paper-labelled", "--quick")
    assert not (tmp_path / "ran").exists()
    assert "baseline accept paper-labelled --quick" in capsys.readouterr().err
