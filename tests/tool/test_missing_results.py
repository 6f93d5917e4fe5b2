"""What becomes of comparisons whose results are missing, in part or altogether."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from crosscheck.findings import (
    Agreement,
    ComparisonKey,
    EntryDifferences,
    Finding,
    Subject,
    make_check,
    make_failed_check,
    make_measurement,
    make_unfinished_check,
)
from crosscheck.models.loading import load_arm
from crosscheck.planning import comparison
from crosscheck.provenance import record_provenance
from crosscheck.report.formatting import describe_tally
from crosscheck.report.summary import CheckResult
from crosscheck.runner.outcomes import Failure
from tests.schemas import assert_follows


@dataclass(frozen=True)
class Asked:
    """A task of a model."""

    model: str
    cost: float = 1.0

    @property
    def key(self) -> str:
        return f"key of {self.model}"

    def perform(self) -> Any:
        return None


FINE, FAILED, STOPPED, LOST = map(Asked, ("fine", "failed", "stopped", "lost"))
RESULTS = comparison.Results(
    {
        FINE.key: np.array([3.0, 4.0]),
        FAILED.key: Failure("ValueError", "of its own"),
        STOPPED.key: Failure("TooSlow", "stopped", unfinished=True),
    }
)


def about(quantity: str) -> Subject:
    return Subject(ComparisonKey("states", "arm", quantity, "one", "other"), "1", "largest")


def test_a_missing_result_says_whose_it_is_and_why():
    assert RESULTS.need(FINE).tolist() == [3.0, 4.0]
    why = {
        FAILED: ("failed: ValueError: of its own", False),
        STOPPED: ("stopped: TooSlow: stopped", True),
        LOST: ("lost: Lost: no result came back", False),
    }
    for task, (said, unfinished) in why.items():
        with pytest.raises(comparison.MissingResult) as error:
            RESULTS.need(task)
        assert (str(error.value), error.value.unfinished) == (said, unfinished)
        assert RESULTS.get(task) is None
    assert [each is not None for each in map(RESULTS.get, (FAILED, FINE, STOPPED))] == [0, 1, 0]


def test_each_comparison_is_one_finding_whatever_comes_back():
    def judge(about: Subject, left: np.ndarray, right: np.ndarray) -> Finding:
        return make_check(about, measured=float(left @ [1, 0]), tolerance=3.0, basis="")

    planned = [
        comparison.make_comparison(about(name), tasks, judge)
        for name, tasks in (
            ("fine", (FINE, FINE)),
            ("failed", (FINE, FAILED)),
            ("stopped", (STOPPED, FAILED)),
            ("of one", (FINE,)),
        )
    ]
    found = list(comparison.judge_comparisons(planned, RESULTS))
    assert [finding.verdict for finding in found] == ["agree", "failed", "unfinished", "failed"]
    assert found[1] == make_failed_check(about("failed"), "failed: ValueError: of its own")
    assert found[2] == make_unfinished_check(about("stopped"), "stopped: TooSlow: stopped")
    assert found[3].note.startswith("TypeError: ")
    assert comparison.collect_tasks(planned) == [FINE, FAILED, STOPPED]
    with pytest.raises(ValueError, match="planned twice: states/arm/fine/one~other"):
        list(comparison.judge_comparisons([*planned, planned[0]], RESULTS))


def test_entries_are_the_largest_of_any_engine():
    first = np.array([[[0.0, 1e-3], [2e-3, 0.0]], [[0.0, 5e-3], [1e-3, np.nan]]])
    second = np.array([[[1e-9, 0.0], [0.0, 0.0]]])
    found = comparison.summarise_entries(
        "mass_matrix", "mine", "ab", {"x": first, "y": second}, 1e-8
    )
    assert found == EntryDifferences(
        "mass_matrix", "mine", ("x", "y"), ("a", "b"), ((1e-9, 5e-3), (2e-3, np.inf)), 1e-8
    )
    wrong = [(each.name, each.places, each.relative) for each in found.wrong_entries()]
    assert wrong == [("M[b, b]", ((1, 1),), np.inf), ("M[a, b]", ((0, 1), (1, 0)), 5e-3)]
    rows = comparison.summarise_entries("bias", "mine", "ab", {"x": np.array([[2.0, 1e-9]])}, 1e-8)
    assert rows.relative == ((2.0,), (1e-9,))
    assert [each.name for each in rows.wrong_entries()] == ["bias[a]"]
    lower = EntryDifferences("mass_matrix", "m", (), ("a", "b"), ((0.0, 0.0), (1.0, 2.0)), 1e-8)
    assert [each.name for each in lower.wrong_entries()] == ["M[b, b]", "M[b, a]"]


def test_an_agreement_counts_its_checks_and_lists_the_first():
    red = [make_failed_check(about(str(n)), "so") for n in range(5)]
    fine = make_check(about("fine"), measured=0.0, tolerance=1.0, basis="")
    size = make_measurement(about("size"), measured=1.0)
    whole = Agreement([fine, *red, size])
    listed = [f"failed states/arm/{n}/one~other" for n in range(3)]
    more = "... and 2 more"
    assert repr(whole).splitlines() == ["Agreement: 1 of 6 checks agree", *listed, more]
    said = [f"{each}: so" for each in listed]
    assert repr(CheckResult([fine, *red])).splitlines()[2:] == [*said, more]
    assert repr(Agreement([fine, size, *red[:3]])).count("\n") == 3
    stopped = make_unfinished_check(about("late"), "so")
    late = Agreement([fine, stopped], record_provenance(load_arm("probe"), 0, True))
    assert describe_tally(late) == "1 of 2 checks agree; 1 unfinished, not judged"
    assert_follows(late.to_dict(), "agreement")
    codes = {0: [[fine, size]], 1: [[fine, stopped, red[0]], [size], []], 3: [[fine, stopped]]}
    for code, several in codes.items():
        assert {Agreement(findings).exit_code for findings in several} == {code}
    assert [finding.about.key.joint for finding in whole.checks] == [None] * 6
    joint = ComparisonKey("deviation", "pd", "theta", "one", joint=2)
    assert joint.id == "deviation/pd/joint2/theta/one"
