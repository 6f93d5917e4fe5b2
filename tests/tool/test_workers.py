"""Tasks in other processes: whatever one does, the others are done and nothing is left behind."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import psutil
import pytest

from crosscheck.runner import cpu_limit, process_tree, workers
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.process_tree import limit_resources
from crosscheck.runner.workers import Workers, perform_all
from tests.processes import ROOT, in_child


@dataclass(frozen=True)
class Job:
    """A task that does anything."""

    key: str
    work: Callable[[], object]
    cost: float = 0.0

    def perform(self) -> object:
        return self.work()


def good() -> str:
    return "done"


napping = partial(time.sleep, 0.05)
leaving, exiting = partial(os._exit, 0), partial(sys.exit, 0)


def crashing() -> None:
    os.kill(os.getpid(), signal.SIGSEGV)


def interrupting() -> None:
    raise KeyboardInterrupt


def unsendable() -> object:
    return lambda: None


class Awkward:
    """Cannot be made again from what it sends."""

    def __init__(self, one: str, other: str) -> None:
        self.both = one + other

    def __reduce__(self) -> tuple[type[object], tuple[str]]:
        return Awkward, (self.both,)


def awkward() -> object:
    return Awkward("a", "b")


def talking() -> str:
    os.write(1, b"engine: hello\n")
    os.write(2, b"engine: WARNING\n")
    print("hello")
    return "done"


def endless() -> None:
    while True:
        time.sleep(1)


def deaf_and_endless() -> None:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    endless()


def busy() -> None:
    while True:
        pass


def busy_in_a_child() -> None:
    if os.fork() == 0:
        busy()
    endless()


def forking() -> str:
    os.fork()
    return "done"


def multiplying() -> None:
    for _ in range(20):
        os.fork()
    endless()


def stopped() -> str:
    """For longer than the hasty wait for a task."""
    waker = f"sleep 1; kill -CONT {os.getpid()}"
    subprocess.Popen(["sh", "-c", waker], start_new_session=True)
    os.kill(os.getpid(), signal.SIGSTOP)
    return "done"


def sleeping_child() -> int:
    return subprocess.Popen(["sleep", "100"]).pid


def child_in_its_own_session() -> int:
    return subprocess.Popen(["sleep", "100"], start_new_session=True).pid


def orphan() -> int:
    said = subprocess.run(
        ["sh", "-c", "sleep 100 >&- 2>&- & echo $!"], capture_output=True, check=True
    )
    return int(said.stdout)


@pytest.mark.parametrize("jobs", [1, 2, 3])
@pytest.mark.parametrize(
    ("work", "kind", "message"),
    [
        (crashing, "Died", "SIGSEGV"),
        (leaving, "Died", "exit code 0"),
        (exiting, "SystemExit", "0"),
        (interrupting, "KeyboardInterrupt", ""),
        (unsendable, "", "pickle"),
        (awkward, "TypeError", "other"),
    ],
)
def test_a_task_that_breaks_its_process_costs_itself_alone(work, kind, message, jobs):
    tasks = [
        Job("before", good),
        Job("bad", work, 0.5),
        *(Job(f"after {n}", good) for n in range(4)),
    ]
    results = perform_all(tasks, jobs)
    bad = results.pop("bad")
    assert set(results.values()) == {"done"}
    assert isinstance(bad, Failure)
    assert kind in bad.kind
    assert message in str(bad)


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Seconds become hundredths."""
    monkeypatch.setattr(cpu_limit, "BASE_LIMIT_S", 0.6)
    monkeypatch.setattr(cpu_limit, "LOOK_S", 0.01)


@pytest.mark.parametrize(
    ("work", "idle_s", "said"),
    [
        (busy, 60.0, "s of processor time, about 0 s expected"),
        (busy_in_a_child, 60.0, "s of processor time, about 0 s expected"),
        (deaf_and_endless, 0.3, "s without any processor time"),
    ],
)
@pytest.mark.usefixtures("hasty")
def test_a_task_that_computes_or_waits_without_end_is_ended(monkeypatch, work, idle_s, said):
    monkeypatch.setattr(cpu_limit, "IDLE_S", idle_s)
    results = perform_all([Job("good", good), Job("slow", work)], 2)
    assert results["good"] == "done"
    assert results["slow"].unfinished
    assert results["slow"].kind == "TooSlow"
    assert said in results["slow"].message


@pytest.mark.usefixtures("hasty")
def test_a_task_that_forks_without_end_is_ended_with_its_forks(monkeypatch):
    """Twenty forks, each going on in both branches, would be a million processes."""
    monkeypatch.setattr(process_tree, "MOST_DESCENDANTS", 8)
    others = psutil.Process().children(recursive=True)
    results = perform_all([Job("good", good), Job("many", multiplying)], 1)
    assert results["good"] == "done"
    assert results["many"].unfinished
    assert "processes of its own; at most 8 may run at once" in results["many"].message
    started = int(results["many"].message.split("stopped with ")[1].split()[0])
    assert started <= 16  # unguarded forks are tens of thousands before anybody looks
    assert set(psutil.Process().children(recursive=True)) <= set(others)


def test_a_task_that_forks_and_goes_on_in_both_branches_ends_once():
    ended = perform_all([Job("two", forking), Job("b", good)], 1)
    assert ended == {"two": "done", "b": "done"}


@pytest.mark.usefixtures("hasty")
def test_time_in_which_a_task_had_no_processor_does_not_count():
    assert perform_all([Job("stopped", stopped)], 1) == {"stopped": "done"}


@pytest.mark.parametrize("work", [sleeping_child, child_in_its_own_session, orphan])
def test_what_a_task_has_started_ends_with_its_worker(work, tmp_path):
    with Workers(1) as crew:
        (number,) = crew.perform([Job("parent", work)]).values()
        assert _runs(number)
    assert not _runs(number)


@pytest.mark.parametrize("stricter", [True, False])
def test_a_limit_of_the_users_own_is_not_exceeded(stricter):
    def work() -> None:
        used, psutil.Process.cpu_times = 100, lambda process: (60.0, 40.0)
        own = used + (100 if stricter else 10_000)
        resource.setrlimit(resource.RLIMIT_CPU, (own, own))
        limit_resources(10**9, 300)
        allowed, _ = resource.getrlimit(resource.RLIMIT_CPU)
        assert allowed == own if stricter else used + 300 <= allowed <= used + 302

    assert in_child(work)


def test_what_a_task_says_is_not_the_programs_word(capfd):
    assert perform_all([Job("talk", talking)], 1) == {"talk": "done"}
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("work", "wait_s", "count"), [(good, 60.0, 1), (napping, 0.1, 2)])
def test_others_join_a_worker_that_is_long_at_work(monkeypatch, work, wait_s, count):
    monkeypatch.setattr(workers, "WAITED_S", 0.0)
    with Workers(2) as crew:
        crew.looks = time.monotonic() + wait_s
        crew.perform([Job(str(number), work) for number in range(9)])
        assert len(crew.crew) == count


@pytest.mark.parametrize("lists_children", {process_tree.LISTS_CHILDREN, False})
def test_processes_are_found_with_and_without_the_systems_lists(monkeypatch, lists_children):
    monkeypatch.setattr(process_tree, "LISTS_CHILDREN", lists_children)
    with Workers(1) as crew, ThreadPoolExecutor(1) as thread:  # which starts the worker
        thread.submit(crew.perform, [Job("a", good)]).result()
        assert crew.crew[0].number in process_tree.measure_processor_times()


def test_no_process_is_left_behind():
    with Workers(2) as crew:
        crew.most = 2
        crew.perform([Job("a", good), Job("b", good)])
        alive = [worker.process for worker in crew.crew]
        assert len(alive) == 2
    assert not any(process.is_alive() for process in alive)


def test_workers_end_with_their_parent(tmp_path):
    script = tmp_path / "parent.py"
    script.write_text(
        "import os, sys, time\n"
        "from tests.tool.test_workers import Job, endless\n"
        "from crosscheck.runner.workers import Workers\n"
        "with Workers(2) as crew:\n"
        "    crew.most = 2\n"
        "    tasks = [Job('a', endless), Job('b', endless)]\n"
        "    crew._employ(iter(tasks))\n"
        "    print(*(worker.process.pid for worker in crew.crew), flush=True)\n"
        "    time.sleep(60)\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    words = [sys.executable, str(script)]
    parent = subprocess.Popen(words, stdout=subprocess.PIPE, env=environment)
    assert parent.stdout is not None
    children = [int(pid) for pid in parent.stdout.readline().split()]
    assert len(children) == 2
    parent.kill()
    parent.wait()
    until = time.monotonic() + 10
    while any(map(_runs, children)) and time.monotonic() < until:
        time.sleep(0.1)
    assert not any(map(_runs, children))


def _runs(pid: int) -> bool:
    """Whether a process exists and is no zombie."""
    with suppress(psutil.NoSuchProcess):
        return bool(psutil.Process(pid).status() != psutil.STATUS_ZOMBIE)
    return False


def test_coverage_sees_what_workers_run(tmp_path, monkeypatch):
    """An idle worker leaves by its own exit, at which its traces are written."""
    monkeypatch.chdir(tmp_path)
    Path("work.py").write_text(
        "from dataclasses import dataclass\n"
        "from crosscheck.runner.workers import perform_all\n"
        "@dataclass\n"
        "class Job:\n"
        "    key: str\n"
        "    cost = 0.0\n"
        "    def perform(self):\n"
        "        return self.key\n"
        "perform_all([Job('a'), Job('b')], 2)\n"
    )
    Path("settings").write_text(
        "[run]\nparallel = true\nconcurrency = multiprocessing, thread\npatch = fork, _exit\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    for words in (("run", "--rcfile=settings", "work.py"), ("combine", "-q"), ("json", "-q")):
        command = [sys.executable, "-m", "coverage", *words]
        subprocess.run(command, check=True, capture_output=True, env=environment)
    measured = json.loads(Path("coverage.json").read_text())["files"]["work.py"]
    assert measured["missing_lines"] == []
