"""The same study on the workers of a Dask scheduler, over TCP on this machine."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from distributed import Client

from crosscheck.provenance import ROOT
from tests.processes import wait_for
from tests.studies.studies import MEMBERS, Hold, content, finished, sweeping, wait_for_batches

pytestmark = pytest.mark.system


def _free_port() -> int:
    with socket.socket() as any_port:
        any_port.bind(("127.0.0.1", 0))
        return int(any_port.getsockname()[1])


class Cluster:
    """A scheduler, and the workers of one test, each a process."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.processes = folder, list[subprocess.Popen[bytes]]()
        self.place = host, port = "127.0.0.1", _free_port()
        self.address = f"tcp://{host}:{port}"
        self.start("scheduler", "--host", host, "--port", str(port), "--no-dashboard")

    def start(
        self, *arguments: str, path: Path = ROOT, hold: Hold | None = None
    ) -> subprocess.Popen[bytes]:
        """`dask` with these, on the project's code at a path."""
        held = hold.environment if hold else {}
        log = (self.folder / f"{len(self.processes)}.log").open("wb")
        process = subprocess.Popen(
            [sys.executable, "-m", "dask", *arguments],
            cwd=self.folder,
            env={**os.environ, **held, "PYTHONPATH": str(path)},
            stdout=log,
            stderr=log,
        )
        self.processes.append(process)
        return process

    def worker(self, path: Path = ROOT, hold: Hold | None = None) -> subprocess.Popen[bytes]:
        """One of one thread, which nobody starts again."""
        more = ("--nthreads", "1", "--no-nanny", "--no-dashboard")
        return self.start("worker", self.address, *more, path=path, hold=hold)

    def wait(self, workers: int) -> None:
        """Until so many are there."""
        wait_for(lambda: self._count_workers() == workers, *self.processes)

    def _count_workers(self) -> int:
        return len(self.client.scheduler_info()["workers"])

    def listens(self) -> bool:
        """Whether the scheduler can be reached."""
        with socket.socket() as caller:
            return caller.connect_ex(self.place) == 0

    def stop(self, of: int = 0) -> None:
        """All processes but the first ``of``."""
        while len(self.processes) > of:
            process = self.processes.pop()
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """One for all tests; each brings its own workers."""
    made = Cluster(tmp_path_factory.mktemp("cluster"))
    wait_for(made.listens, *made.processes)
    with Client(made.address, timeout=60, set_as_default=False) as made.client:
        yield made
    made.stop()


@pytest.fixture
def cluster(scheduler: Cluster) -> Iterator[Cluster]:
    """With no worker, before and after."""
    yield scheduler
    scheduler.stop(of=1)
    scheduler.wait(0)


def test_a_worker_killed_in_mid_study_changes_nothing(undisturbed, cluster, tmp_path, hold):
    file, expected = undisturbed
    holding = hold(3, 2)
    victim, _ = cluster.worker(hold=holding), cluster.worker(hold=holding)
    cluster.wait(2)
    out = tmp_path / "out.nc"
    program = sweeping(file, out, "--scheduler", cluster.address)
    wait_for_batches(out, 3, program)
    victim.send_signal(signal.SIGKILL)
    holding.release()
    code, said, err = finished(program)
    assert (code, err) == (0, "")
    assert f"{MEMBERS} run" in said
    assert content(out) == content(expected)


def test_a_study_whose_workers_are_all_killed_says_so_and_ends(
    undisturbed, cluster, tmp_path, hold
):
    file, _ = undisturbed
    holding = hold(2, 1)
    victim = cluster.worker(hold=holding)
    cluster.wait(1)
    program = sweeping(file, tmp_path / "out.nc", "--scheduler", cluster.address)
    wait_for_batches(tmp_path / "out.nc", 2, program)
    victim.send_signal(signal.SIGKILL)
    code, _, err = finished(program)
    assert (code, err.count("\n")) == (3, 1)
    assert "no worker is left" in err
    assert f"dask worker {cluster.address}" in err


def test_an_interrupted_study_goes_on_with_the_scheduler(undisturbed, cluster, tmp_path, hold):
    file, expected = undisturbed
    holding = hold(2, 1)
    cluster.worker(hold=holding)
    cluster.wait(1)
    out = tmp_path / "out.nc"
    program = sweeping(file, out, "--scheduler", cluster.address)
    wait_for_batches(out, 2, program)
    program.send_signal(signal.SIGINT)
    holding.release()
    code, _, err = finished(program)
    assert (code, err.count("\n")) == (130, 1)
    assert "--resume" in err
    code, _, err = finished(sweeping(file, out, "--scheduler", cluster.address, "--resume"))
    assert (code, err) == (0, "")
    assert content(out) == content(expected)


def test_workers_of_another_version_are_refused(undisturbed, cluster, tmp_path):
    copy = tmp_path / "copy"
    without = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "crosscheck", copy / "crosscheck", ignore=without)
    with (copy / "crosscheck" / "analytic" / "model.py").open("a", encoding="utf-8") as source:
        source.write("\nLATER = 1\n")
    cluster.worker(copy)
    cluster.wait(1)
    out = tmp_path / "out.nc"
    code, _, err = finished(sweeping(undisturbed[0], out, "--scheduler", cluster.address))
    assert (code, err.count("\n")) == (2, 1)
    assert "another version" in err
    assert [path.name for path in tmp_path.iterdir()] == ["copy"]


def test_no_scheduler_is_said_within_ten_seconds(undisturbed, tmp_path):
    address = f"tcp://127.0.0.1:{_free_port()}"
    began = time.monotonic()
    code, _, err = finished(sweeping(undisturbed[0], tmp_path / "out.nc", "--scheduler", address))
    assert (code, err.count("\n")) == (2, 1)
    assert "dask scheduler" in err
    assert address in err
    assert time.monotonic() - began < 60  # ten, and what a busy machine takes more
    assert not list(tmp_path.iterdir())


def test_a_scheduler_without_workers_says_how_to_get_one(undisturbed, cluster, tmp_path):
    cluster.wait(0)
    out = tmp_path / "out.nc"
    code, _, err = finished(sweeping(undisturbed[0], out, "--scheduler", cluster.address))
    assert (code, err.count("\n")) == (2, 1)
    assert f"dask worker {cluster.address}" in err
    assert not out.exists()
