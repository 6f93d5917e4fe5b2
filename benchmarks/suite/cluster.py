"""A Dask scheduler and workers on this machine, each a process, over TCP."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from benchmarks.suite.machine import ROOT

START_TIMEOUT_S = 60


@contextmanager
def start_cluster(workers: int) -> Iterator[str]:
    """Address of a scheduler that has so many workers of one thread. Raises ImportError."""
    from distributed import Client

    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    address, quiet = f"tcp://127.0.0.1:{port}", "--no-dashboard"
    started = [_dask("scheduler", "--host", "127.0.0.1", "--port", str(port), quiet)]
    try:
        worker = "worker", address, "--nthreads", "1", "--no-nanny", quiet
        started += [_dask(*worker) for _ in range(workers)]
        with Client(address, timeout=START_TIMEOUT_S, set_as_default=False) as client:
            client.wait_for_workers(workers, timeout=START_TIMEOUT_S)
        yield address
    finally:
        for process in reversed(started):
            process.kill()
            process.wait()


def _dask(*words: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "dask", *words],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
