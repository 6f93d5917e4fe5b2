"""What a trial says of an error, in snapshots: level, wrong entries, laws that differ, causes."""

import json
from collections.abc import Iterator

import pytest
from syrupy.assertion import SnapshotAssertion

from crosscheck.report.trials.output import format_trial_json, make_trial_maps
from crosscheck.trial.result import Trial, TrialDiagnosis
from tests.robots.trials import run_robot_trial
from tests.schemas import assert_follows
from tests.trial import arm_errors, robot_errors


def list_findings(trial: Trial) -> Iterator[str]:
    """All that is found wrong."""
    found = trial.diagnosis
    own = {f.quantity for f in trial.agreement.disagreeing if f.about.key.family == "trial-own"}
    yield trial.headline
    yield f"level: {found.level}"
    yield f"wrong: {', '.join(sorted(entry.name for entry in found.entries))}"
    yield f"laws that differ: {', '.join(sorted(own))}"
    yield f"drawn: {', '.join(each.title for each in make_trial_maps(trial))}"
    yield from (f"right in: {reading}" for reading in found.readings)
    yield from trial.causes
    yield from (f"note: {line}" for line in trial.notes)


def assert_named(trial: Trial, snapshot: SnapshotAssertion) -> None:
    """What is found is as the snapshot has it, and the JSON file as its schema."""
    assert "\n".join(list_findings(trial)) == snapshot
    assert_follows(json.loads(format_trial_json(trial)), "trial")


@pytest.mark.parametrize("case", robot_errors.CASES)
def test_an_error_in_equations_of_a_robot_is_named(case, snapshot: SnapshotAssertion):
    trial = run_robot_trial(*robot_errors.CASES[case]()[::-1])
    assert_named(trial, snapshot)
    for entry in trial.diagnosis.entries:  # drawn as they are named
        assert trial.relative_errors[entry.part][entry.place.index] == entry.share


@pytest.mark.parametrize("case", arm_errors.CASES)
def test_an_error_in_equations_of_an_arm_is_named(case, snapshot: SnapshotAssertion):
    assert_named(arm_errors.CASES[case](), snapshot)


@pytest.mark.parametrize("case", robot_errors.RIGHT_ONES)
def test_right_equations_of_a_robot_are_never_blamed(case, snapshot: SnapshotAssertion):
    robot, own = robot_errors.RIGHT_ONES[case]
    trial = run_robot_trial(own, robot)
    assert trial.agrees
    assert trial.diagnosis == TrialDiagnosis(trial.diagnosis.level)
    assert "\n".join(trial.scope) == snapshot
