"""What a command says while it works, and how long it thinks that it still takes."""

import re
import subprocess
import sys
from dataclasses import dataclass
from types import SimpleNamespace

import pytest

from crosscheck.checks.answers import bias
from crosscheck.models.loading import load_case
from crosscheck.run import describe_task, run_tasks
from crosscheck.runner import progress
from crosscheck.runner.progress import show_progress
from crosscheck.runner.progress_update import TimeEstimate
from crosscheck.runner.tasks import RunKey, ask_model
from crosscheck.runner.workers import Workers

CASE = load_case("paper-labelled", "constant-torque")


@dataclass(frozen=True)
class Piece:
    """A task that takes no time."""

    key: object
    cost: float = 1.0
    model: str = "none"

    def perform(self) -> str:
        return f"did {self.key}"


def test_the_time_left_is_that_of_what_was_seen_once_a_tenth_is_done(clock):
    """Ten times as slow as declared: half is done, the other half takes as long again."""
    expected = TimeEstimate([Piece("a", 1.0), Piece("b", 4.0), Piece("c", 5.0)])
    assert expected.left_s is None
    clock[0] += 10.0
    expected.finish("a")
    assert expected.left_s is None
    clock[0] += 40.0
    expected.finish("b")
    assert expected.left_s == pytest.approx(50.0)
    expected.finish("c")
    assert expected.left_s == 0.0


def test_work_tells_every_task_as_it_begins():
    tasks = [Piece(RunKey("pd", f"model-{n}"), cost=n) for n in range(5)]
    updates = []
    with Workers(2) as workers:
        results = run_tasks(workers, tasks, lambda *of: updates.append(of))
    assert results.outcomes == {task.key: task.perform() for task in tasks}
    names, counts, totals, left = map(list, zip(*updates, strict=True))
    assert names == [f"simulating pd, model-{n}" for n in (4, 3, 2, 1, 0)]
    assert totals == [5] * 5
    assert counts == sorted(counts)
    assert counts[-1] >= 3
    assert left[0] is None  # before any is done


def test_what_is_done_is_said_in_words():
    assert describe_task(RunKey("pd", "exudyn:tree", "coarse")) == "simulating pd, exudyn:tree"
    asked = ask_model("exudyn:tree", CASE, bias, 3)
    assert describe_task(asked.key) == "evaluating bias, exudyn:tree"


def test_where_there_is_no_terminal_a_line_comes_now_and_then(clock, capsys):
    with show_progress("cross-checking mine", quiet_s=20.0) as update:
        update("preparing the experiments")
        clock[0] += 19.0
        update("simulating pd, exudyn:tree", 1, 9, 50.0)
        assert capsys.readouterr() == ("", "")
        clock[0] += 2.0
        update("simulating pd, exudyn:tree", 3, 9, 25.4)
        clock[0] += 1.0
        update("simulating pd, exudyn:bodies", 4, 9, 20.0)
        clock[0] += 20.0
        update("simulating pd, exudyn:bodies", 5, 9, 600.0)
        clock[0] += 20.0
        update("comparing")
    assert capsys.readouterr().err.splitlines() == [
        "cross-checking mine: 3 of 9 tasks done, about 25 s left, simulating pd, exudyn:tree",
        "cross-checking mine: 5 of 9 tasks done, about 10 min left, simulating pd, exudyn:bodies",
        "cross-checking mine: comparing",
    ]


def test_on_a_terminal_there_is_a_bar_that_goes(monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TTY_INTERACTIVE", "1")
    with show_progress("cross-checking mine") as update:
        update("simulating pd, exudyn:tree", 3, 9, 25.4)
    shown = capsys.readouterr().err
    assert re.search(r"3/9.*about 25 s left.*simulating pd, exudyn:tree", shown)
    assert shown.rstrip().endswith("\x1b[2K")


def test_bars_show_the_time_that_is_left(clock):
    clock[0] += 7.0
    left = {None: "", 137.4: "about 30 s left", 107.2: "about 1 s left", 257.0: "about 2 min left"}
    for until, shown in left.items():
        task = SimpleNamespace(fields={"until": until})
        assert str(progress._TimeLeft().render(task)) == shown
    assert progress._format_duration(99.0) == "about 99 s"
    assert progress._format_duration(100.0) == "about 2 min"


@pytest.mark.system
def test_a_whole_check_says_at_once_what_it_does(tmp_path):
    """Also where there is no terminal."""
    often = "import crosscheck.runner.progress as p; p.EVERY_S = 1.0"
    script = f"{often}; import crosscheck.__main__ as c; c.main()"
    program = subprocess.Popen(
        [sys.executable, "-c", script, "validate"],
        cwd=tmp_path,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert program.stderr is not None
    try:
        said = [program.stderr.readline() for _ in range(2)]
    finally:
        program.terminate()
        program.communicate(timeout=20)
    assert said[0] == "cross-checking paper-labelled: preparing the experiments\n"
    left = r"(about \d+ (s|min) left, )?"
    counted = rf"cross-checking paper-labelled: \d+ of \d+ tasks done, {left}simulating .*\n"
    assert re.fullmatch(counted, said[1])
