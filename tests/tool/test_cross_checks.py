"""Cross-checks of small arms: as they are, with engines that break, and without a preparation."""

import os
import signal
import time
from dataclasses import replace

import pytest

import crosscheck as package
from crosscheck import registry
from crosscheck.models.errors import Unfinished
from crosscheck.planning import preparation
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.planning.preparation import prepare_experiments
from crosscheck.runner.workers import Workers
from tests.arms import arm_of, random_arm

pytestmark = pytest.mark.system


@pytest.mark.usefixtures("brief_plan")
def test_an_arm_of_one_joint_passes_every_check_on_any_number_of_processes():
    one, two = (package.check(arm_of(1), quick=True, jobs=jobs) for jobs in (1, 2))
    assert [f"{f.id}: {f.measured} {f.note}" for f in one.disagreeing] == []
    assert one.to_dict()["findings"] == two.to_dict()["findings"]


@pytest.mark.usefixtures("brief_plan")
def test_arm_called_like_the_probe_is_distinguished_from_it(labelled):
    arm = labelled.model_copy(update={"name": "probe"})
    agreement = package.check(arm, quick=True, jobs=2)
    assert [f.id for f in agreement.disagreeing] == []
    assert len({f.id for f in agreement.findings}) == len(agreement.findings)


@pytest.mark.usefixtures("brief_plan")
@pytest.mark.parametrize("seed", [1, 8])
def test_an_arm_of_random_numbers_raises_no_false_alarm(seed):
    agreement = package.check(random_arm(seed, most_joints=2), quick=True, jobs=2, seed=seed)
    assert [f"{f.id}: {f.measured} {f.note}" for f in agreement.disagreeing] == []


def lose(monkeypatch: pytest.MonkeyPatch, model: str) -> None:
    """Of a model's module nothing is there."""
    entry = replace(registry.MODELS[model], module="crosscheck.no_such_engine", attribute="Nothing")
    monkeypatch.setitem(registry.MODELS, model, entry)


@pytest.mark.usefixtures("brief_plan")
def test_a_reference_model_that_cannot_be_imported_is_failed_checks(monkeypatch):
    lose(monkeypatch, "analytic:physical")
    agreement = package.check(arm_of(1), quick=True)
    assert agreement.exit_code == 1
    failures = [f for f in agreement.findings if f.verdict == "failed"]
    own = [f for f in failures if "analytic:physical" in (f.left, f.right)]
    assert own
    assert all(f.kind == "check" and "no_such_engine" in f.note for f in own)


def _crashing(*state: object) -> None:
    os.kill(os.getpid(), signal.SIGSEGV)


def _leaving(*state: object) -> None:
    raise SystemExit(0)


def _raising(*given: object) -> None:
    raise ValueError("singular")


@pytest.mark.usefixtures("brief_plan")
def test_engines_that_crash_leave_raise_or_are_missing_cost_their_own_checks_alone(monkeypatch):
    """And a model harmed in memory is harmed in every process."""
    harmed = {"exudyn:tree": _crashing, "pinocchio:gears": _leaving, "exudyn:bodies": _raising}
    for model, harm in harmed.items():
        monkeypatch.setattr(registry.load_model_class(model), "bias", harm)
    lose(monkeypatch, "pinocchio:coupled")
    agreement = package.check(arm_of(1), quick=True, jobs=2)
    assert agreement.exit_code == 1
    assert {f.verdict for f in agreement.disagreeing} == {"failed"}
    for name in harmed:
        assert any(f.note.startswith(f"{name}: ") for f in agreement.disagreeing)
        # Whatever needs no bias of the model is as before.
        own = [f for f in agreement.findings if name in (f.left, f.right)]
        agreeing = {f.quantity for f in own if f.verdict == "agree"}
        assert agreeing >= {"inertia", "mass_matrix", "abilities"}
    assert {f.verdict for f in agreement.findings if f.quantity == "locked-stage"} == {"agree"}
    lost = [f for f in agreement.disagreeing if "pinocchio:coupled" in (f.left, f.right)]
    assert any("no_such_engine" in f.note for f in lost)
    own = tuple(f"{name}: " for name in (*harmed, "pinocchio:coupled"))
    assert all(f.note.startswith(own) for f in agreement.disagreeing)
    assert all(f.kind == "check" for f in agreement.disagreeing)


def _never(*given: object) -> None:
    while True:
        time.sleep(1)


def _dying(*given: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


STEPS = {  # of a preparation, and what is lost without them
    "refine_until_resolved": "step",
    "find_growing_mode": "growth-rate",
    "compute_sizes": "sizes",
}


@pytest.mark.slow
@pytest.mark.parametrize("lost", STEPS)
@pytest.mark.parametrize(("work", "why"), [(_never, "TooSlow: stopped"), (_dying, "SIGKILL")])
def test_a_preparation_that_did_not_come_back_ends_the_command(
    monkeypatch, impatient, lost, work, why
):
    monkeypatch.setattr(preparation, lost, work)
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
        ("failed", "analytic:physical: ValueError: singular")
    }
    assert agreement.exit_code == 1
