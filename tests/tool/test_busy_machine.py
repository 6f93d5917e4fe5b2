"""What a cross-check finds does not hang on how busy the machine is, nor on what was lost."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import jsonschema
import pytest

import crosscheck as package
from crosscheck.checks.answers import Setting, bias
from crosscheck.findings import Agreement, ComparisonKey, Finding, Subject, make_check
from crosscheck.models.errors import Unfinished
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.loading import Case, load_scenario
from crosscheck.planning import preparation
from crosscheck.planning.arms import plan_comparisons
from crosscheck.planning.comparison import Comparison, Results, collect_tasks, judge_comparisons
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.planning.preparation import prepare_experiments
from crosscheck.provenance import ROOT, record_provenance
from crosscheck.report.formatting import describe_tally
from crosscheck.report.junit import format_junit
from crosscheck.run import run_tasks
from crosscheck.runner import cpu_limit
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.progress_update import ignore_progress
from crosscheck.runner.tasks import Evaluation
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


@pytest.mark.slow
@pytest.mark.parametrize("lost", ["refine_until_resolved", "find_growing_mode", "compute_sizes"])
@pytest.mark.parametrize(("work", "why"), [(_never, "TooSlow: stopped"), (_dying, "SIGKILL")])
def test_a_preparation_that_did_not_come_back_ends_the_command(monkeypatch, lost, work, why):
    monkeypatch.setattr(preparation, lost, work)
    monkeypatch.setattr(cpu_limit, "IDLE_S", 2.0)
    monkeypatch.setattr(cpu_limit, "LEAST_S", 0.01)
    monkeypatch.setattr(cpu_limit, "LOOK_S", 0.1)
    quantity = {
        "refine_until_resolved": "step",
        "find_growing_mode": "growth-rate",
        "compute_sizes": "sizes",
    }[lost]
    with Workers(2) as crew, pytest.raises(Unfinished) as error:
        prepare_experiments(CrossCheckRequest(arm_of(1), quick=True), crew)
    assert f": {quantity} by analytic:physical: " in str(error.value)
    assert why in str(error.value)


@pytest.mark.slow
@pytest.mark.parametrize("lost", ["refine_until_resolved", "find_growing_mode", "compute_sizes"])
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


ABOUT = Subject(ComparisonKey("states", "arm", "bias", "one", "other"), "1", "largest difference")


def _stopped(task: Evaluation) -> Agreement:
    """Of one check that needs a task whose worker was stopped, and of one that agrees."""

    def judged(about: Subject, results: Results) -> Finding:
        results.get_if_finished(task)
        return make_check(about, measured=0.0, tolerance=0.0, basis="none needed")

    other = replace(ABOUT, key=replace(ABOUT.key, quantity="force"))
    comparisons = [
        Comparison(ABOUT, (task,), judged),
        Comparison(
            other, (), lambda about, _: make_check(about, measured=0, tolerance=0, basis="")
        ),
    ]
    results = Results({task.key: Failure("TooSlow", "stopped", unfinished=True)})
    return Agreement([*judge_comparisons(comparisons, results)])


def test_what_was_stopped_is_neither_an_agreement_nor_a_difference():
    case = Case(arm_of(1), load_scenario("constant-torque"), switches())
    agreement = _stopped(Evaluation("one", Setting(case, False), bias))
    assert [finding.verdict for finding in agreement.findings] == ["unfinished", "agree"]
    assert agreement.exit_code == 3
    assert describe_tally(agreement) == "1 of 2 checks agree; 1 unfinished, not judged"
    assert 'failures="0" errors="1"' in format_junit(agreement)
    whole = replace(agreement, provenance=record_provenance(arm_of(1), 0, True)).to_dict()
    jsonschema.validate(whole, SCHEMA, jsonschema.Draft202012Validator)
    differing = make_check(ABOUT, measured=1.0, tolerance=0.0, basis="none")
    assert replace(agreement, findings=[*agreement.findings, differing]).exit_code == 1
