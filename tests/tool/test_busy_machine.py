"""What a cross-check finds does not hang on how busy the machine is, nor on what was lost."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

import crosscheck as package
from crosscheck.models.errors import Unfinished
from crosscheck.planning import preparation
from crosscheck.planning.arms import plan_comparisons
from crosscheck.planning.comparison import collect_tasks, judge_comparisons
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.planning.preparation import prepare_experiments
from crosscheck.provenance import ROOT
from crosscheck.run import run_tasks
from crosscheck.runner import cpu_limit
from crosscheck.runner.progress_update import ignore_progress
from crosscheck.runner.workers import Workers
from tests.arms import arm_of

pytestmark = pytest.mark.system

SCHEMA = json.loads((ROOT / "crosscheck" / "schema" / "agreement.schema.json").read_text())
OTHERS = 4
FAMILIES = ("same-step", "invariants")


@contextmanager
def others_at_work() -> Iterator[None]:
    """Processes that compute without end."""
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(OTHERS)]
    try:
        yield
    finally:
        for process in busy:
            process.kill()
            process.wait()


@pytest.mark.slow
@pytest.mark.usefixtures("brief_plan")
def test_the_same_is_found_alone_and_beside_busy_processes():
    wanted = CrossCheckRequest(arm_of(1, direct=[0]), quick=True)

    def found() -> list[dict[str, object]]:
        with Workers(2) as crew:
            comparisons = plan_comparisons(wanted, prepare_experiments(wanted, crew))
            some = [each for each in comparisons if each.about.key.family in FAMILIES]
            results = run_tasks(crew, collect_tasks(some), ignore_progress)
        return [finding.to_dict() for finding in judge_comparisons(some, results)]

    alone = found()
    assert {finding["verdict"] for finding in alone} == {"agree"}
    with others_at_work():
        assert found() == alone


def _never(*given: object) -> None:
    while True:
        time.sleep(1)


def _dying(*given: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def _raising(*given: object) -> None:
    raise ValueError("no such root")


STEPS = {  # of a preparation, and what is lost without them
    "refine_until_resolved": "step",
    "find_growing_mode": "growth-rate",
    "compute_sizes": "sizes",
}


@pytest.mark.slow
@pytest.mark.parametrize("lost", STEPS)
@pytest.mark.parametrize(("work", "why"), [(_never, "TooSlow: stopped"), (_dying, "SIGKILL")])
def test_a_preparation_that_did_not_come_back_ends_the_command(monkeypatch, lost, work, why):
    monkeypatch.setattr(preparation, lost, work)
    monkeypatch.setattr(cpu_limit, "IDLE_S", 2.0)
    monkeypatch.setattr(cpu_limit, "LEAST_S", 0.01)
    monkeypatch.setattr(cpu_limit, "LOOK_S", 0.1)
    with Workers(2) as crew, pytest.raises(Unfinished) as error:
        prepare_experiments(CrossCheckRequest(arm_of(1), quick=True), crew)
    assert f": {STEPS[lost]} by analytic:physical: " in str(error.value)
    assert why in str(error.value)


@pytest.mark.slow
@pytest.mark.parametrize("lost", STEPS)
@pytest.mark.usefixtures("brief_plan")
def test_a_preparation_that_fails_is_a_failed_check(monkeypatch, lost):
    monkeypatch.setattr(preparation, lost, _raising)
    agreement = package.check(arm_of(1, direct=[0]), quick=True, jobs=2)
    failed = [f for f in agreement.disagreeing if f.about.key.family == "preparation"]
    assert failed
    assert {(f.verdict, f.note) for f in failed} == {
        ("failed", "analytic:physical: ValueError: no such root")
    }
    assert agreement.exit_code == 1
