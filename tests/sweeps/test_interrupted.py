"""A study that is killed or interrupted loses nothing and does nothing twice."""

from __future__ import annotations

import os
import shutil
import signal
from pathlib import Path

import pytest

from tests.sweeps.studies import (
    batches_kept,
    content,
    finished,
    kill,
    slow_study,
    sweeping,
    wait_for_batches,
)


def _workers(program: int) -> list[int]:
    """Of its children those that run batches."""
    children = Path(f"/proc/{program}/task/{program}/children").read_text().split()
    lines = {int(child): Path(f"/proc/{child}/cmdline").read_text() for child in children}
    return [c for c, line in lines.items() if "loky" in line and "resource_tracker" not in line]


def test_several_processes_make_what_one_makes(undisturbed, tmp_path):
    file, expected = undisturbed
    out = tmp_path / "out.nc"
    code, said, err = finished(sweeping(file, out, "--jobs", 2))
    assert (code, err) == (0, "")
    assert "320 members" in said
    assert content(out) == content(expected)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.nc"]


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_killed_study_goes_on_where_it_was(undisturbed, tmp_path, jobs):
    file, expected = undisturbed
    out = tmp_path / "out.nc"
    program = sweeping(file, out, "--jobs", jobs)
    wait_for_batches(out, 3, program)
    kill(program)
    assert not out.exists()
    done = batches_kept(out)
    before = {path: path.stat().st_mtime_ns for path in tmp_path.glob("out.nc.batches/*.kept")}

    code, _, err = finished(sweeping(file, out, "--jobs", jobs))
    assert code == 2
    assert err.count("\n") == 1
    assert "--resume" in err

    again = sweeping(file, out, "--jobs", jobs, "--resume")
    wait_for_batches(out, done + 1, again)
    assert {path: path.stat().st_mtime_ns for path in before} == before
    code, said, err = finished(again)
    assert (code, err) == (0, "")
    assert " 320 run" not in said
    assert content(out) == content(expected)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.nc"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["INT", "TERM"])
@pytest.mark.parametrize("whom", ["group", "program"])
def test_an_interrupted_study_says_how_to_go_on(undisturbed, tmp_path, whom, number):
    file, expected = undisturbed
    out = tmp_path / "out.nc"
    program = sweeping(file, out, "--jobs", 2)
    wait_for_batches(out, 2, program)
    send = os.killpg if whom == "group" else os.kill
    send(program.pid, number)
    code, _, err = finished(program)
    assert code == 128 + number
    assert err.count("\n") == 1
    assert "--resume" in err
    assert not out.exists()
    assert not list(tmp_path.glob(".crosscheck-*"))
    assert batches_kept(out) >= 2
    code, _, err = finished(sweeping(file, out, "--jobs", 2, "--resume"))
    assert (code, err) == (0, "")
    assert content(out) == content(expected)


def test_a_damaged_batch_is_made_again(undisturbed, tmp_path):
    file, expected = undisturbed
    out = tmp_path / "out.nc"
    program = sweeping(file, out, "--jobs", 1)
    wait_for_batches(out, 3, program)
    kill(program)
    victim = sorted(tmp_path.glob("out.nc.batches/*.kept"))[0]
    victim.write_bytes(victim.read_bytes()[:-7])
    code, _, err = finished(sweeping(file, out, "--jobs", 1, "--resume"))
    assert code == 0
    assert "made again" in err
    assert content(out) == content(expected)


def test_a_worker_that_dies_costs_its_batch_alone(undisturbed, tmp_path):
    file, expected = undisturbed
    out = tmp_path / "out.nc"
    program = sweeping(file, out, "--jobs", 2)
    wait_for_batches(out, 1, program)
    os.kill(_workers(program.pid)[0], signal.SIGKILL)
    code, _, err = finished(program)
    assert code == 0, err
    assert content(out) == content(expected)


def test_another_studys_batches_and_result_are_left_alone(undisturbed, tmp_path):
    file, expected = undisturbed
    out = tmp_path / "out.nc"
    other = slow_study(tmp_path / "other")
    other.write_text(other.read_text().replace("count = 160", "count = 161"))
    shutil.copy(expected, out)
    before = out.read_bytes()
    code, _, err = finished(sweeping(other, out, "--resume"))
    assert (code, err.count("\n")) == (2, 1)
    assert "another study" in err
    assert out.read_bytes() == before
    out.unlink()

    program = sweeping(file, out, "--jobs", 1)
    wait_for_batches(out, 2, program)
    kill(program)
    for more in ([], ["--resume"]):
        code, _, err = finished(sweeping(other, out, *more))
        assert (code, err.count("\n")) == (2, 1)
        assert "another study" in err
    assert batches_kept(out) >= 2


def test_what_is_complete_is_not_made_again(undisturbed, tmp_path):
    file, expected = undisturbed
    out = tmp_path / "out.nc"
    shutil.copy(expected, out)
    before = out.read_bytes()
    code, said, err = finished(sweeping(file, out, "--resume"))
    assert (code, err) == (0, "")
    assert "complete" in said
    code, _, err = finished(sweeping(file, out))
    assert (code, err.count("\n")) == (2, 1)
    assert "exists already" in err
    assert out.read_bytes() == before
