"""What a robot's trial says of what it found: each line, and JSON, from a made trial."""

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from syrupy.assertion import SnapshotAssertion

from crosscheck import findings
from crosscheck.runner.outcomes import Failure
from crosscheck.trial.changes.search import Cause, list_equals, name_causes
from crosscheck.trial.judge.entries import EntryMismatch, EntryPlace, LevelDistance
from crosscheck.trial.result import Trial, TrialDiagnosis
from crosscheck.trial.robots.explain import describe_ratio
from crosscheck.trial.robots.judge import RobotProblem
from tests.robots import two_link

ENTRIES = tuple(
    EntryMismatch(EntryPlace(part, int(name == "j2")), share, notes=("twice",) * (name == "j1"))
    for part, name, share in (
        ("bias", "j1", 0.345678),
        ("gravity", "j2", 0.25),
        *(("gravity", f"{n}", 0.01) for n in range(5)),
    )
)
DISTANCES = (
    LevelDistance("armature", 7, 0.345678, 0.1),
    LevelDistance("coupled", 8, 0.5, 0.2),
    LevelDistance("links", 0, 1.23e-15, 1e-16),
)


def finding(quantity: str, by: float, engine: str = "") -> Any:
    family = "trial-states" if engine else "trial-own"
    about = findings.Subject(
        findings.ComparisonKey(family, "tested", quantity, "yours", engine), "1", "largest"
    )
    return findings.make_check(about, measured=by, tolerance=1e-10, basis="")


NAMED = tuple(
    replace(entry, name=f"{entry.part}[{('j1', 'j2')[entry.place.row]}]") for entry in ENTRIES
)
PROBLEM: Any = RobotProblem("yours", two_link.robot(), None, {}, None, "")  # type: ignore[arg-type]


def trial(found: TrialDiagnosis, checks: Sequence[findings.Finding] = (), **changes: Any) -> Trial:
    plain: dict[str, Any] = {
        "request": None,
        "problem": PROBLEM,
        "cross_check": SimpleNamespace(agreement=findings.Agreement(list(checks))),
        "distances": DISTANCES,
        "diagnosis": found,
        "relative_errors": {"bias": np.array([0.345678, 0.0])},
        "allowed": {"bias": 1e-10},
        "failures": {},
        "self_checks": (),
        "scope": ("a remark",),
        "notes": (),
    }
    return Trial(**plain | changes)


FINE = TrialDiagnosis("links")
LOST = Failure("ValueError", "of its own", "line 1\nline 2")
AGREES = finding("bias", 0.0, "analytic")
FAILED = findings.make_failed_check(finding("gravity", 0.0).about, "it raised")
OTHER = finding("bias", 0.3, "exudyn")
EQUAL = DISTANCES[2], replace(DISTANCES[2], level="coupled"), DISTANCES[0]
CASES = {
    "right": trial(FINE, [AGREES]),
    "right at several levels": trial(FINE, [AGREES], distances=EQUAL),
    "by engines that differ": trial(FINE, [AGREES, OTHER]),
    "where a part raised": trial(FINE, [AGREES, FAILED], failures={"gravity": LOST}),
    "where a part raised, and others are wrong": trial(
        TrialDiagnosis("armature", NAMED), failures={"gravity": LOST}
    ),
    "without an answer": trial(FINE, relative_errors={}, failures={"bias": LOST}),
}


@pytest.mark.parametrize("name", CASES)
def test_a_trial_has_a_headline_and_causes(name, snapshot: SnapshotAssertion):
    made = CASES[name]
    lines = list(made.lines)
    assert lines[: 1 + len(made.causes)] == [made.headline, *made.causes]
    assert "\n".join(lines) == snapshot


def test_a_check_that_no_entry_accounts_for_is_a_line():
    (line,) = trial(FINE, [finding("symmetric", 0.5)]).failing_checks
    assert line.endswith("measured 0.5, allowed 1e-10")
    wrong = TrialDiagnosis("armature", NAMED)
    assert list(trial(wrong, [finding("bias", 0.3, "analytic")]).failing_checks) == []
    failed = findings.make_failed_check(finding("b", 0.0).about, "bias: it raised")
    lines = list(trial(wrong, [failed], failures={"bias": LOST}).lines)
    assert any(line.endswith("bias: it raised") for line in lines)
    assert lines[-4:-1] == ["bias raised:", "line 1", "line 2"]


def test_of_many_causes_the_terminal_has_the_first():
    causes = tuple(map(str, range(14)))
    shown = list(trial(TrialDiagnosis("armature", NAMED, causes)).lines)
    assert shown[1:6] == [*"0123", "and 10 more"]


def test_an_entry_is_beside_the_right_one():
    right, rounding = np.array([1.0, -2.0, 0.5]), np.full(3, 1e-9)
    words = {
        "the right value is 0": (right, 0.5 * rounding),
        "missing": (0.5 * rounding, right),
        "with the opposite sign": (-right, right),
        "yours is half as large": (right / 2, right),
        "yours is twice as large": (2 * right, right),
        "yours is 1.2345 times as large": (1.2345 * right, right),
        "": (right + np.array([0.0, 0.1, 0.0]), right),
    }
    for said, (yours, expected) in words.items():
        assert describe_ratio(yours, expected, rounding) == said
    assert describe_ratio((1 + 5e-6) * right, right, 1e-5 + 0 * rounding) == ""
    assert list_equals(["a"]) == "a"
    assert list_equals(["a", "b"]) == "a, or by b"
    assert list_equals([*"abcde"]) == "a, or by b"


def test_of_many_numbers_that_explain_a_constant_two_are_named():
    causes = [Cause(f"body: number {n}", usual=False) for n in range(4)]
    (words,) = name_causes(causes)
    assert words.startswith("another value of one of 4 numbers, such as body: number 0 or ")
    assert name_causes(causes[:3]) == [each.words for each in causes[:3]]
    assert len(name_causes([*causes, Cause("body: twice", usual=True)])) == 5
