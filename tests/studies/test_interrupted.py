"""A study that is killed or interrupted loses nothing and does nothing twice."""

import os
import shutil
import signal
from pathlib import Path

import psutil
import pytest

from tests.studies import studies
from tests.tool.test_bad_input import assert_one_line

pytestmark = pytest.mark.system


def _killed(file: Path, out: Path, jobs: int, hold: studies.Hold) -> int:
    """Begin a study and kill it when three batches are kept; how many are."""
    program = studies.sweeping(file, out, "--jobs", jobs, hold=hold)
    studies.wait_for_batches(out, 3, program)
    studies.kill(program)
    assert not out.exists()
    return studies.batches_kept(out)


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_killed_study_goes_on_where_it_was(undisturbed, tmp_path, sweep, hold, jobs):
    file, expected = undisturbed
    out = tmp_path / "out.nc"
    done = _killed(file, out, jobs, hold(3, jobs))
    before = {path: path.stat().st_mtime_ns for path in tmp_path.glob("out.nc.batches/*.kept")}
    assert_one_line(sweep(file, "--run-code", "--jobs", jobs), "--resume")
    holding = hold(1, jobs)
    again = studies.sweeping(file, out, "--jobs", jobs, "--resume", hold=holding)
    studies.wait_for_batches(out, done + 1, again)
    assert {path: path.stat().st_mtime_ns for path in before} == before
    holding.release()
    code, said, err = studies.finished(again)
    assert (code, err) == (0, "")
    assert f" {studies.MEMBERS - done * studies.BATCH} run" in said
    assert studies.content(out) == studies.content(expected)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.nc"]


@pytest.mark.parametrize(
    ("whom", "number"), [("group", signal.SIGINT), ("program", signal.SIGTERM)], ids=["INT", "TERM"]
)
def test_an_interrupted_study_says_how_to_go_on(undisturbed, tmp_path, sweep, hold, whom, number):
    file, expected = undisturbed
    out = tmp_path / "out.nc"
    program = studies.sweeping(file, out, "--jobs", 2, hold=hold(2, 2))
    studies.wait_for_batches(out, 2, program)
    send = os.killpg if whom == "group" else os.kill
    send(program.pid, number)
    code, _, err = studies.finished(program)
    assert code == 128 + number
    assert err.count("\n") == 1
    assert "--resume" in err
    assert not out.exists()
    assert not list(tmp_path.glob(".crosscheck-*"))
    assert studies.batches_kept(out) >= 2
    code, _, err = sweep(file, "--run-code", "--jobs", 1, "--resume")
    assert (code, err) == (0, "")
    assert studies.content(out) == studies.content(expected)


def test_a_damaged_batch_is_made_again(undisturbed, tmp_path, sweep, hold):
    file, expected = undisturbed
    out = tmp_path / "out.nc"
    _killed(file, out, 1, hold(3, 1))
    victim = sorted(tmp_path.glob("out.nc.batches/*.kept"))[0]
    victim.write_bytes(victim.read_bytes()[:-7])
    answer = sweep(file, "--run-code", "--jobs", 1, "--resume")
    assert (answer.code, "made again" in answer.err) == (0, True)
    assert studies.content(out) == studies.content(expected)


def test_a_worker_that_dies_costs_its_batch_alone(undisturbed, tmp_path, hold):
    file, expected = undisturbed
    out = tmp_path / "out.nc"
    holding = hold(1, 2)
    program = studies.sweeping(file, out, "--jobs", 2, hold=holding)
    studies.wait_for_batches(out, 1, program)
    commands = psutil.Process(program.pid).children()  # whose children run batches
    os.kill(next(child.pid for each in commands for child in each.children()), signal.SIGKILL)
    holding.release()
    code, _, err = studies.finished(program)
    assert code == 0, err
    assert studies.content(out) == studies.content(expected)


def test_another_studys_batches_and_result_are_left_alone(undisturbed, tmp_path, sweep, hold):
    file, expected = undisturbed
    out = tmp_path / "out.nc"
    other = studies.held_study(tmp_path / "other")
    text, count = other.read_text(), studies.MEMBERS // 2
    other.write_text(text.replace(f"count = {count}", f"count = {count + 1}"))
    assert other.read_text() != text
    shutil.copy(expected, out)
    before = out.read_bytes()
    assert_one_line(sweep(other, "--run-code", "--resume"), "another study")
    assert out.read_bytes() == before
    out.unlink()

    done = _killed(file, out, 1, hold(3, 1))
    for more in ([], ["--resume"]):
        assert_one_line(sweep(other, "--run-code", *more), "another study")
    assert studies.batches_kept(out) == done >= 2
